// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/core/filter.hpp>

namespace mine {

struct MyFilterParams {
  static const dynfilter::FieldTable<MyFilterParams>& fields() {
    static const dynfilter::FieldTable<MyFilterParams> table{};
    return table;
  }
};

/// The filter that docs/how-to/plugins.md exports.
class MyFilter final : public dynfilter::NamedFilter<MyFilter> {
 public:
  using Params = MyFilterParams;
  static constexpr const char* kName = "my_filter";
  static constexpr const char* kSummary = "votes on nothing";
  explicit MyFilter(Params) {}
  dynfilter::Needs needs() const override { return {}; }
  void apply(const dynfilter::Evidence&, dynfilter::Votes&) override {}
};

}  // namespace mine
