// SPDX-License-Identifier: MIT
// Throws an exception that is not a std::exception.
#include "harmless.hpp"

class Throwing : public bad::Named<'t'> {
 public:
  explicit Throwing(const Params& params) : Named(params) { throw 42; }
};

DYNFILTER_REGISTER_FILTERS(Throwing);
