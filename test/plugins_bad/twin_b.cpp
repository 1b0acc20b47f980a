// SPDX-License-Identifier: MIT
// See twin_a.
#include "harmless.hpp"

struct Twin : bad::Harmless {
  struct Params {
    int beta_px = 7;
    static const dynfilter::FieldTable<Params>& fields() {
      static const dynfilter::FieldTable<Params> table{
          dynfilter::integer("beta_px", &Params::beta_px, "px", {0, 10}, "of twin b")};
      return table;
    }
  };
  static constexpr const char* kName = "twin_b";
  explicit Twin(const Params& /*params*/) : Harmless(Harmless::Params()) {}
};

DYNFILTER_REGISTER_FILTERS(Twin);
