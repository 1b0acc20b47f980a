// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/config/parameters.hpp>
#include <dynfilter/core/filter.hpp>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace dynfilter {

/// A filter F with the parameters P.
template <class F, class P>
class ParametricFilter : public NamedFilter<F> {
 public:
  using Params = P;
  /// Throws ConfigError for a parameter out of range.
  explicit ParametricFilter(Params params = Params()) : params_(std::move(params)) {
    check_parameters(params_, F::kName);
  }

 protected:
  const Params params_;
};

/// Description of a filter, available without creating one. `dynfilter filters` and the docs print it.
struct FilterCard {
  std::string name, summary;
  Needs needs;
  std::vector<FieldInfo> parameters;
};

using FilterFactory = std::function<std::unique_ptr<Filter>(const YamlNode& parameters)>;

/// The filters that a pipeline may name. A plain value that the caller passes in.
/// No filter registers itself, and nothing is global.
class Registry {
 public:
  /// A filter's card, and what makes one.
  struct Entry {
    FilterCard card;
    FilterFactory make;
  };

  void add(Entry entry);  ///< throws ConfigError if the name is taken

  /// F has a struct F::Params with fields(), a constructor F(Params) and the constants F::kName and
  /// F::kSummary. Throws as above.
  template <class F>
  void add() {
    add({{F::kName, F::kSummary, F(typename F::Params()).needs(), describe_parameters<typename F::Params>()},
         [](const YamlNode& node) -> std::unique_ptr<Filter> {
           return std::make_unique<F>(read_parameters<typename F::Params>(node));
         }});
  }

  const Entry* find(const std::string& name) const;
  std::vector<std::string> names() const;

 private:
  std::map<std::string, Entry> entries_;
};

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/config/detail/registry-inl.hpp>
#endif
