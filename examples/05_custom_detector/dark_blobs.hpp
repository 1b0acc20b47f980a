// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/config/parameters.hpp>
#include <dynfilter/semantic/provider.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <string>
#include <vector>

namespace mine {

struct DarkBlobsParams {
  int darkest = 60;
  int min_area_px = 500;

  static const dynfilter::FieldTable<DarkBlobsParams>& fields() {
    using P = DarkBlobsParams;
    static const dynfilter::FieldTable<P> table{
        dynfilter::integer("darkest", &P::darkest, "", {1, 255}, "a pixel below this grey level is dark"),
        dynfilter::integer("min_area_px", &P::min_area_px, "px", {1, 10000000}, "smaller blobs are left out"),
    };
    return table;
  }
};

/// Returns a box and a mask for each connected dark region.
/// This is an example of a provider, not a useful detector.
/// A provider that opens files has `const dynfilter::ProviderFiles&` as the second argument of its
/// constructor.
class DarkBlobs final : public dynfilter::SemanticProvider {
 public:
  using Params = DarkBlobsParams;
  static constexpr const char* kName = "dark_blobs";
  static constexpr const char* kSummary = "connected dark regions (an example)";

  explicit DarkBlobs(const Params& params) : params_(params) {}

  std::string name() const override { return kName; }

  std::optional<dynfilter::SemanticResult> infer(const dynfilter::SemanticImage& image) override {
    dynfilter::SemanticResult result;
    result.frame_id = image.frame_id;
    result.timestamp_s = image.timestamp_s;
    cv::Mat grey = image.pixels, labels, statistics, centres;
    if (grey.channels() == 3) cv::cvtColor(image.pixels, grey, cv::COLOR_BGR2GRAY);
    const int count = cv::connectedComponentsWithStats(grey < params_.darkest, labels, statistics, centres);
    result.detections.emplace();
    for (int i = 1; i < count; ++i) {
      const int* s = statistics.ptr<int>(i);
      if (s[cv::CC_STAT_AREA] < params_.min_area_px) continue;
      dynfilter::Detection blob;
      blob.box = cv::Rect2f(
          cv::Rect(s[cv::CC_STAT_LEFT], s[cv::CC_STAT_TOP], s[cv::CC_STAT_WIDTH], s[cv::CC_STAT_HEIGHT]));
      blob.class_name = "blob";
      blob.mask = labels == i;
      result.detections->push_back(blob);
    }
    return result;
  }

 private:
  Params params_;
};

}  // namespace mine
