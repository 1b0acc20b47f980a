// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/config/registry.hpp>
#include <dynfilter/core/filter.hpp>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/needs.hpp>
#include <dynfilter/core/span.hpp>
#include <dynfilter/core/verdict.hpp>
#include <dynfilter/core/votes.hpp>
#include <dynfilter/evidence/evidence.hpp>
#include <dynfilter/evidence/frame_evidence.hpp>
#include <functional>
#include <string>
#include <vector>

namespace fakes {

using namespace dynfilter;

/// A filter that runs a given function.
class Scripted final : public Filter {
 public:
  using Apply = std::function<void(const Evidence&, Votes&)>;
  Scripted(std::string name, Apply apply, Needs needs = {})
      : name_(std::move(name)), apply_(std::move(apply)), needs_(needs) {}
  std::string name() const override { return name_; }
  Needs needs() const override { return needs_; }
  void apply(const Evidence& evidence, Votes& votes) override { apply_(evidence, votes); }

 private:
  std::string name_;
  Apply apply_;
  Needs needs_;
};

/// Casts one letter per feature: S, D, U, and P for a prior suspect.
inline std::unique_ptr<Filter> says(const std::string& name, const std::string& letters) {
  return std::make_unique<Scripted>(name, [letters](const Evidence&, Votes& votes) {
    for (std::size_t i = 0; i < letters.size(); ++i) {
      if (letters[i] == 'S') votes.cast(i, Vote::Static);
      if (letters[i] == 'D') votes.cast(i, Vote::Dynamic);
      if (letters[i] == 'P') votes.mark_prior(i);
    }
  });
}

/// n features on a diagonal.
struct Features {
  explicit Features(std::size_t n) {
    for (std::size_t i = 0; i < n; ++i)
      keypoints.emplace_back(static_cast<float>(10 * i), static_cast<float>(10 * i), 1.0F);
  }
  FrameView view(std::int64_t id = 0) const {
    FrameView frame;
    frame.id = id;
    frame.timestamp_s = static_cast<double>(id) / 30;
    frame.keypoints = keypoints;
    return frame;
  }
  std::vector<cv::KeyPoint> keypoints;
};

inline std::string letters_of(const Verdict& verdict) {
  std::string text;
  for (const Vote vote : verdict.decision)
    text += vote == Vote::Static ? 'S' : vote == Vote::Dynamic ? 'D' : 'U';
  return text;
}

}  // namespace fakes
