// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/core/filter.hpp>
#include <dynfilter/plugin/export.hpp>
#include <string>

namespace bad {

/// A filter that abstains on all features. Each file of this folder names the fault of its plugin.
class Harmless : public dynfilter::Filter {
 public:
  struct Params {
    double limit_px = 1;
    static const dynfilter::FieldTable<Params>& fields() {
      static const dynfilter::FieldTable<Params> table{
          dynfilter::real("limit_px", &Params::limit_px, "px", {0, 10}, "unused")};
      return table;
    }
  };
  static constexpr const char* kName = "harmless";
  static constexpr const char* kSummary = "abstains";

  explicit Harmless(const Params& params) : params_(params) {}
  std::string name() const override { return kName; }
  dynfilter::Needs needs() const override { return {}; }
  void apply(const dynfilter::Evidence& /*evidence*/, dynfilter::Votes& /*votes*/) override {}

 private:
  Params params_;
};

/// The same under another name.
template <char kLetter>
class Named : public Harmless {
 public:
  static constexpr char kName[] = {'n', 'a', 'm', 'e', 'd', '_', kLetter, '\0'};
  using Harmless::Harmless;
  std::string name() const override { return kName; }
};

}  // namespace bad
