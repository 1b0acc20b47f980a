// SPDX-License-Identifier: MIT
// Registers correctly, but cannot say what it needs, or cannot be reset, with some parameters.
#include <stdexcept>

#include "harmless.hpp"

class Moody : public bad::Harmless {
 public:
  static constexpr const char* kName = "moody";
  explicit Moody(const Params& params) : Harmless(params), mood_(params.limit_px) {}
  std::string name() const override { return kName; }
  dynfilter::Needs needs() const override {
    if (mood_ == 7) throw std::runtime_error("ask me later");
    if (mood_ == 9) throw 9;
    return {};
  }
  void reset() override {
    if (mood_ == 5) throw std::runtime_error("I remember everything");
  }

 private:
  double mood_;
};

DYNFILTER_REGISTER_FILTERS(Moody);
