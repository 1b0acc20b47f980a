// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <deque>
#include <dynfilter/core/error.hpp>
#include <dynfilter/semantic/provider.hpp>
#include <dynfilter/semantic/runner.hpp>
#include <memory>
#include <optional>

namespace dynfilter {

/// The modes Sync, Late and Rate.
/// The provider runs inside submit(), and its results are held back according to the mode.
/// Time is that of the images' timestamps and their number.
/// The same images therefore give the same results at the same frames.
/// An image that arrives while the simulated provider is busy is skipped.
class SimulatedRunner final : public SemanticRunner {
 public:
  /// Throws ConfigError for mode Async and if a parameter is out of range.
  SimulatedRunner(std::unique_ptr<SemanticProvider> provider, const RunnerParams& params);

  void submit(const SemanticImage& image) override;

  Result latest() override { return latest_; }
  RunnerStatus status() override { return status_; }

  void reset() override;

 private:
  // A frame exactly at the end of an interval is in time.
  static constexpr double kSameTime_s = 1e-6;
  struct Waiting {
    std::int64_t submitted;
    Result result;
  };

  void look(const SemanticImage& image, std::int64_t now);
  void publish();
  void publish_all();

  std::unique_ptr<SemanticProvider> provider_;
  RunnerParams params_;
  RunnerStatus status_;
  std::deque<Waiting> waiting_;
  Result latest_;
  std::optional<double> busy_until_s_;
};

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/semantic/detail/simulated_runner-inl.hpp>
#endif
