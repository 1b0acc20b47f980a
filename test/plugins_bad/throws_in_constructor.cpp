// SPDX-License-Identifier: MIT
// Its second filter cannot be created: the first must not remain registered.
#include <stdexcept>

#include "harmless.hpp"

class Throwing : public bad::Named<'t'> {
 public:
  explicit Throwing(const Params& params) : Named(params) {
    throw std::runtime_error("no licence for today");
  }
};

DYNFILTER_REGISTER_FILTERS(bad::Harmless, Throwing);
