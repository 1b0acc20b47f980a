// SPDX-License-Identifier: MIT
// This and twin_b define different classes of one name, as two strangers may: each must keep its own table.
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
