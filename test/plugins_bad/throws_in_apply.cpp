// SPDX-License-Identifier: MIT
// Throws on every frame: the pipeline reports the stage and continues.
#include <stdexcept>

#include "harmless.hpp"

class Throwing : public bad::Harmless {
 public:
  static constexpr const char* kName = "throws_in_apply";
  using Harmless::Harmless;
  std::string name() const override { return kName; }
  void apply(const dynfilter::Evidence& /*evidence*/, dynfilter::Votes& votes) override {
    if (votes.size() > 0) votes.cast(0, dynfilter::Vote::Dynamic);
    throw std::runtime_error("the sensor melted");
  }
};

DYNFILTER_REGISTER_FILTERS(Throwing);
