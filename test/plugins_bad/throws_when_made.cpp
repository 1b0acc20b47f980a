// SPDX-License-Identifier: MIT
// Registers correctly, but throws for a parameter when a pipeline creates it.
#include <stdexcept>

#include "harmless.hpp"

class Picky : public bad::Named<'p'> {
 public:
  explicit Picky(const Params& params) : Named(params) {
    if (params.limit_px == 7) throw std::runtime_error("no licence for 7");
    if (params.limit_px == 9) throw 9;
    if (params.limit_px > 5) throw dynfilter::ConfigError("limit_px", "too much for this machine");
  }
};

DYNFILTER_REGISTER_FILTERS(Picky);
