// SPDX-License-Identifier: MIT
#include <cmath>
#include <cstdint>
#include <dynfilter/config/registry.hpp>
#include <dynfilter/config/yaml.hpp>
#include <dynfilter/core/frame_inputs.hpp>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/needs.hpp>
#include <dynfilter/core/point_grid.hpp>
#include <dynfilter/core/pose.hpp>
#include <dynfilter/core/span.hpp>
#include <dynfilter/core/verdict.hpp>
#include <dynfilter/core/votes.hpp>
#include <dynfilter/evidence/frame_evidence.hpp>
#include <dynfilter/pipeline/builtin_filters.hpp>
#include <dynfilter/pipeline/pipeline.hpp>
#include <dynfilter/pipeline/pipeline_yaml.hpp>
#include <filesystem>
#include <limits>
#include <opencv2/core.hpp>

#include "doctest/doctest.h"
#include "fakes.hpp"
#include "support/time_limit.hpp"

namespace odd_frames_test {

using namespace dynfilter;

namespace {

constexpr double kInf = std::numeric_limits<double>::infinity(),
                 kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kOdd[] = {kNan, kInf, -kInf, 1e30, -1e30, 3e9, -3e9, 2e6, -7, 0, 640, 1e-40};

/// Frames of noise that moves to the right, with all optional inputs.
/// `share` percent of their values are odd.
class OddFrames {
 public:
  explicit OddFrames(int share) : share_(share), noise_(480, 700, CV_8UC1) { cv::randu(noise_, 0, 255); }

  FrameView next(int k) {
    grey_ = noise_(cv::Rect(40 - 2 * k, 0, 640, 480)).clone();
    depth_ = cv::Mat(480, 640, CV_16UC1, cv::Scalar(10000));
    labels_ = cv::Mat::zeros(120, 160, CV_8UC1);
    labels_(cv::Rect(30, 20, 60, 80)).setTo(cv::Scalar(16));
    const cv::Mat instance = labels_ / 16;
    keypoints_.clear(), undistorted_.clear(), ids_.clear(), depths_.clear(), rights_.clear(), points_.clear(),
        matches_.clear();
    descriptors_ = cv::Mat(kFeatures, 32, CV_8UC1);
    cv::randu(descriptors_, 0, 255);
    for (int i = 0; i < kFeatures; ++i) {
      keypoints_.emplace_back(number(30 + 29 * (i % 20)), number(20 + 22 * (i / 20)), 31.0F, 0.0F, 1.0F,
                              i % 8);
      undistorted_.push_back(keypoints_.back());
      if (is_odd()) undistorted_.back().pt.x = static_cast<float>(odd());
      depths_.push_back(number(2));
      rights_.push_back(number(keypoints_.back().pt.x - 20));
      ids_.push_back(is_odd() ? static_cast<std::int64_t>(random()) - 1000 : i);
      points_.emplace_back(number(i % 20), number(1), number(2));
      matches_.push_back(is_odd() ? static_cast<std::int32_t>(random()) : i);
    }
    boxes_.clear();
    for (int b = 0; b < 6; ++b)
      boxes_.push_back({cv::Rect2f(number(100 * b), number(80), number(90), number(200)), b, "person",
                        number(0.9F), -1, b % 2 == 0 ? instance : cv::Mat()});
    keyframes_.assign(1, KeyframeView());
    keyframes_[0].keypoints_undistorted = keypoints_, keyframes_[0].depth_m = depths_;
    keyframes_[0].map_point_ids = ids_;
    return view(k);
  }

 private:
  static constexpr int kFeatures = 400;

  FrameView view(int k) {
    FrameView frame;
    frame.id = k, frame.timestamp_s = k / 30.0;
    frame.keypoints = keypoints_, frame.keypoints_undistorted = undistorted_;
    frame.descriptors = descriptors_, frame.depth_m = depths_;
    frame.right_u_px = rights_;
    frame.grey = grey_, frame.depth = depth_, frame.depth_unit_m = number(2e-4F);
    frame.camera.emplace();
    frame.camera->fx_px = number(500), frame.camera->fy_px = number(500);
    frame.camera->cx_px = number(320), frame.camera->cy_px = number(240);
    frame.camera->baseline_fx_px_m = number(40);
    for (double& k_i : frame.camera->distortion) k_i = number(0.01F);
    frame.pose_provenance = PoseProvenance::Estimated;
    frame.motion_prior.emplace();
    frame.motion_prior->has_translation = k % 2 == 0;
    frame.motion_prior->T_current_reference.rotation[1] = is_odd() ? odd() : 0;
    for (double& c : frame.motion_prior->covariance) c = number(1e-4F);
    frame.T_world_camera.translation_m[0] = number(0.01F);
    frame.map_point_ids = ids_, frame.map_points_world_m = points_;
    frame.covisible_keyframes = keyframes_;
    if (k % 3 == 1) frame.matches = HostMatches{k - 1, matches_};
    frame.detections = DetectionInput{k % 4 == 3 ? k - 2 : -1, boxes_};
    frame.mask = MaskInput{k % 4 == 2 ? k - 1 : -1, labels_};
    return frame;
  }
  std::uint32_t random() {
    state_ = state_ * 1664525U + 1013904223U;
    return state_ >> 8U;
  }
  bool is_odd() { return static_cast<int>(random() % 100) < share_; }
  double odd() { return kOdd[random() % std::size(kOdd)]; }
  float number(double usual) { return static_cast<float>(is_odd() ? odd() : usual); }

  int share_;
  std::uint32_t state_ = 7;
  cv::Mat noise_, grey_, depth_, labels_, descriptors_;
  std::vector<cv::KeyPoint> keypoints_, undistorted_;
  std::vector<float> depths_, rights_;
  std::vector<std::int64_t> ids_;
  std::vector<cv::Point3f> points_;
  std::vector<std::int32_t> matches_;
  std::vector<Detection> boxes_;
  std::vector<KeyframeView> keyframes_;
};

Registry registry() {
  Registry r = builtin_filters();
  r.add({{"oracle", "registered by the command", {}, {}},
         [](const YamlNode&) { return fakes::says("oracle", ""); }});
  return r;
}

PipelineConfig with_coverage(PipelineConfig config) {
  config.floor.min_grid_coverage = 0.9;
  return config;
}

FrameView with_places(const std::vector<cv::KeyPoint>& keypoints) {
  FrameView frame;
  frame.keypoints = keypoints;
  return frame;
}

}  // namespace

TEST_CASE("every preset takes frames in which anything may be odd, and every feature gets a verdict") {
  for (const auto& entry :
       std::filesystem::directory_iterator(std::string(DYNFILTER_SOURCE_DIR) + "/examples/pipelines")) {
    CAPTURE(entry.path());
    for (const int share : {1, 20}) {
      Pipeline pipeline(with_coverage(pipeline_from_file(entry.path().string(), registry())));
      OddFrames frames(share);
      for (int k = 0; k < 8; ++k) {
        const FrameView frame = frames.next(k);
        for (const CallPoint point : {CallPoint::BeforePose, CallPoint::AfterPose, CallPoint::AtKeyframe}) {
          const Verdict& verdict = pipeline.process(frame, point);
          REQUIRE(verdict.size() == frame.size());
          for (const StageReport& stage : verdict.report.stages) CHECK_FALSE(stage.failed);
          for (std::size_t i = 0; i < frame.size(); ++i)
            if (!PointGrid::usable(frame.keypoints[i].pt)) REQUIRE(verdict.decision[i] == Vote::Unknown);
        }
      }
    }
  }
}

TEST_CASE("10,000 boxes, late or not, take less than 2 s per frame") {
  for (const char* preset : {"rts_slam", "dynfilter"})
    for (const std::int64_t late : {0, 2}) {
      CAPTURE(preset);
      CAPTURE(late);
      Pipeline pipeline(pipeline_from_file(
          DYNFILTER_SOURCE_DIR "/examples/pipelines/" + std::string(preset) + ".yaml", registry()));
      OddFrames frames(0);
      for (int k = 0; k < 5; ++k) {
        FrameView frame = frames.next(k);
        // Every box of a person overlaps every other.
        std::vector<Detection> boxes(10'000, frame.detections->detections[0]);
        for (Detection& box : boxes) box.mask = cv::Mat(), box.box = {100, 80, 200, 300};
        frame.detections = DetectionInput{k - late, boxes};
        frame.mask.reset();
        std::size_t judged = 0;
        const double taken_s =
            dynfilter_test::seconds([&] { judged = pipeline.process(frame, CallPoint::BeforePose).size(); });
        CHECK(judged == frame.size());
        CHECK(taken_s < dynfilter_test::kMost_s);
      }
    }
}

TEST_CASE("filters see places within a million pixels, or NaN and not to be judged") {
  const std::vector<cv::KeyPoint> keypoints{{10, 20, 1},
                                            {1e30F, 5, 1},
                                            {static_cast<float>(kInf), 5, 1},
                                            {5, static_cast<float>(kNan), 1},
                                            {-3, 999999, 1}};
  FrameEvidence evidence;
  evidence.begin(with_places(keypoints), CallPoint::BeforePose);
  for (std::size_t i = 0; i < 5; ++i) {
    const bool there = i == 0 || i == 4;
    CHECK(evidence.judged(i) == there);
    CHECK(evidence.seed(i) == there);
    CHECK(std::isnan(evidence.pixels()[i].x) != there);
    CHECK(std::isnan(evidence.frame().keypoints[i].pt.y) != there);
  }
  CHECK(evidence.input_notes() == std::vector<std::string>{"3 keypoints are in no image: not judged"});
  CHECK(keypoints[1].pt.x == 1e30F);  // the host's own arrays do not change
  evidence.end(false);
}

TEST_CASE("boxes are clipped, those that are none are left out, sound ones are not even copied") {
  const cv::Mat wrong(4, 4, CV_32FC1, cv::Scalar(1));
  const auto inf = static_cast<float>(kInf), nan = static_cast<float>(kNan);
  const std::vector<Detection> boxes{{{10, 10, 20, 30}, 0, "person", 0.9F, -1, wrong},
                                     {{-10, 10, inf, 30}, 1, "person", 0.9F, -1, {}},
                                     {{-1e30F, -1e30F, 2e30F, 2e30F}, 2, "person", 0.9F, -1, {}},
                                     {{nan, 10, 20, 30}, 3, "person", 0.9F, -1, {}},
                                     {{10, 10, -20, 30}, 4, "person", 0.9F, -1, {}},
                                     {{10, 10, 20, 30}, 5, "person", nan, -1, {}}};
  FrameView frame;
  frame.detections = DetectionInput{-1, boxes};
  FrameEvidence evidence;
  evidence.begin(frame, CallPoint::BeforePose);
  const Span<const Detection> seen = evidence.frame().detections->detections;
  REQUIRE(seen.size() == 3);
  CHECK(seen[0].box == cv::Rect2f(10, 10, 20, 30));
  CHECK(seen[0].mask.empty());
  CHECK(seen[1].box.tl() == cv::Point2f(-10, 10));
  CHECK(seen[1].box.contains({5000, 20}));
  CHECK(seen[2].box.contains({0, 0}));
  CHECK(evidence.input_notes() == std::vector<std::string>{"3 of 6 boxes cannot be used"});
  const std::vector<Detection> sound(1, Detection{{10, 10, 20, 30}, 0, "person", 0.9F, -1, {}});
  frame.detections = DetectionInput{-1, sound};
  evidence.begin(frame, CallPoint::BeforePose);
  CHECK(evidence.frame().detections->detections.data() == sound.data());
  CHECK(evidence.input_notes().empty());
}

TEST_CASE("cameras and units of depth that are none are left out") {
  const cv::Mat depth(4, 4, CV_16UC1, cv::Scalar(1000));
  const auto inputs = [&](double fx, double k1, int width, double unit) {
    FrameView frame;
    frame.camera.emplace();
    frame.camera->fx_px = fx, frame.camera->fy_px = 500;
    frame.camera->distortion[0] = k1, frame.camera->width_px = width;
    frame.depth = depth, frame.depth_unit_m = unit;
    FrameEvidence evidence;
    evidence.begin(frame, CallPoint::BeforePose);
    return evidence.inputs() & (Input::Camera | Input::Depth);
  };
  CHECK(inputs(500, 0.1, 640, 1e-3) == (Input::Camera | Input::Depth));
  for (const double fx : {0.0, -500.0, 1e-300, 1e300, kInf, kNan})
    CHECK(inputs(fx, 0.1, 640, 1e-3) == Input::Depth);
  CHECK(inputs(500, kNan, 640, 1e-3) == Input::Depth);
  CHECK(inputs(500, 0.1, -640, 1e-3) == Input::Depth);
  for (const double unit : {0.0, -1.0, kInf, kNan}) CHECK(inputs(500, 0.1, 640, unit) == Input::Camera);
}

TEST_CASE("a camera of which only the image's size is known keeps it, without a distortion") {
  FrameView frame;
  frame.camera.emplace();
  frame.camera->width_px = 640, frame.camera->height_px = 480;
  FrameEvidence evidence;
  evidence.begin(frame, CallPoint::BeforePose);
  REQUIRE(evidence.frame().camera.has_value());
  CHECK(evidence.frame().camera->width_px == 640);
  CHECK(evidence.inputs() == Input::None);
  CHECK(evidence.input_notes().empty());
  frame.camera->distortion[0] = 0.1;
  evidence.begin(frame, CallPoint::BeforePose);
  CHECK_FALSE(evidence.frame().camera.has_value());
}

TEST_CASE("right columns are used if there is one per feature") {
  const std::vector<cv::KeyPoint> keypoints(3, cv::KeyPoint(50, 50, 31));
  const std::vector<float> right{40, std::numeric_limits<float>::quiet_NaN(), -1};
  FrameView frame;
  frame.keypoints = keypoints, frame.right_u_px = right;
  FrameEvidence evidence;
  evidence.begin(frame, CallPoint::BeforePose);
  CHECK(evidence.frame().right_u_px.data() == right.data());
  CHECK(evidence.input_notes().empty());
  CHECK(valid_right(right[0]));
  CHECK_FALSE(valid_right(right[1]));
  CHECK_FALSE(valid_right(right[2]));
  CHECK(valid_right(0));
  CHECK_FALSE(valid_right(static_cast<float>(kInf)));
  frame.right_u_px = Span<const float>(right.data(), 2);
  evidence.begin(frame, CallPoint::BeforePose);
  CHECK(evidence.frame().right_u_px.empty());
  CHECK(evidence.input_notes() == std::vector<std::string>{"right_u_px cannot be used: wrong size or type"});
}

}  // namespace odd_frames_test
