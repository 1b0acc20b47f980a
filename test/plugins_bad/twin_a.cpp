// SPDX-License-Identifier: MIT
// twin_a and twin_b define different classes with one name.
// Each must use its own virtual table.
#include "harmless.hpp"

struct Twin : bad::Harmless {
  struct Params {
    double alpha_m = 1;
    static const dynfilter::FieldTable<Params>& fields() {
      static const dynfilter::FieldTable<Params> table{
          dynfilter::real("alpha_m", &Params::alpha_m, "m", {0, 10}, "of twin a")};
      return table;
    }
  };
  static constexpr const char* kName = "twin_a";
  explicit Twin(const Params& /*params*/) : Harmless(Harmless::Params()) {}
};

DYNFILTER_REGISTER_FILTERS(Twin);
