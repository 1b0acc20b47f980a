// SPDX-License-Identifier: MIT
// The second of its filters cannot be made: the first must not stay registered.
#include <stdexcept>

#include "harmless.hpp"

class Throwing : public bad::Named<'t'> {
 public:
  explicit Throwing(const Params& params) : Named(params) {
    throw std::runtime_error("no licence for today");
  }
};

DYNFILTER_REGISTER_FILTERS(bad::Harmless, Throwing);
