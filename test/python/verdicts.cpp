// SPDX-License-Identifier: MIT
// Verdicts of C++, in the text that test_same_as_cpp.py compares its own with:
//   PIPELINE SCENE FRAME DECISIONS SUSPICIONS REASONS
// Suspicions are the bits of the floats, so that equal text means equal bits.
#include <cinttypes>
#include <cstdio>
#include <cstring>
#include <dynfilter/pipeline/builtin_filters.hpp>
#include <dynfilter/pipeline/presets.hpp>
#include <dynfilter/testing/exact_scene_presets.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "render/sequence_renderer.hpp"

namespace {

using namespace dynfilter;

constexpr int kExactFrames = 8, kRenderedFrames = 3, kGridPx = 16;

void print(const std::string& pipeline, const char* scene, int frame, const Verdict& verdict) {
  std::printf("%s %s %d ", pipeline.c_str(), scene, frame);
  for (const Vote vote : verdict.decision) std::printf("%d", static_cast<int>(vote));
  std::printf(" ");
  for (const float suspicion : verdict.suspicion) {
    std::uint32_t bits = 0;
    std::memcpy(&bits, &suspicion, sizeof bits);
    std::printf("%08" PRIx32, bits);
  }
  std::printf(" ");
  for (const std::uint64_t reasons : verdict.reasons) std::printf("%" PRIx64 ".", reasons);
  std::printf("\n");
}

void judge_exact(const std::string& name, const char* scene_name, const testing::ExactScene& scene) {
  Pipeline pipeline(load_pipeline(name, builtin_filters()));
  for (int k = 0; k < kExactFrames; ++k) {
    const testing::ExactFrame frame = scene.frame(k);
    print(name, scene_name, k, pipeline.before_pose(frame.view()));
  }
}

/// A lattice of features, so that both sides have the same without a detector.
std::vector<cv::KeyPoint> lattice(const cv::Size& size) {
  std::vector<cv::KeyPoint> keypoints;
  for (int y = kGridPx; y < size.height - kGridPx; y += kGridPx)
    for (int x = kGridPx; x < size.width - kGridPx; x += kGridPx)
      keypoints.emplace_back(static_cast<float>(x), static_cast<float>(y), 1.0F);
  return keypoints;
}

void judge_rendered(const std::string& name, const std::vector<render::RenderedFrame>& frames,
                    const Camera& camera) {
  Pipeline pipeline(load_pipeline(name, builtin_filters()));
  const std::vector<cv::KeyPoint> keypoints = lattice(frames[0].colour.size());
  for (std::size_t k = 0; k < frames.size(); ++k) {
    FrameView view;
    view.id = static_cast<std::int64_t>(k), view.timestamp_s = frames[k].timestamp_s;
    view.keypoints = keypoints;
    cv::cvtColor(frames[k].colour, view.grey, cv::COLOR_BGR2GRAY);
    view.depth = frames[k].depth, view.depth_unit_m = 1 / render::kDepthUnitsPerM;
    view.camera = camera;
    if (frames[k].detections)
      view.detections = DetectionInput{frames[k].detected_on_frame, *frames[k].detections};
    print(name, "rendered", static_cast<int>(k), pipeline.before_pose(view));
  }
}

}  // namespace

int main(int argc, char** argv) {
  render::SequenceOptions options;
  options.frames = kRenderedFrames;
  render::SequenceRenderer renderer(options);
  std::vector<render::RenderedFrame> frames;
  for (int k = 0; k < kRenderedFrames; ++k) frames.push_back(renderer.frame(k));
  const testing::ExactScene noisy =
      testing::preset(testing::Preset::General).pixel_noise(0.5).depth_noise(0.0014);
  const testing::ExactScene full = testing::preset(testing::Preset::SeveralMovers)
                                       .pixel_noise(0.3)
                                       .mismatches(0.05)
                                       .with_poses()
                                       .with_detections(1)
                                       .with_descriptors()
                                       .with_map_points();
  for (int i = 1; i < argc; ++i) {
    judge_exact(argv[i], "noisy", noisy);
    judge_exact(argv[i], "full", full);
    judge_rendered(argv[i], frames, renderer.calibration());
  }
}
