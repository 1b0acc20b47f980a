// SPDX-License-Identifier: MIT
#include <algorithm>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/pose.hpp>
#include <dynfilter/core/span.hpp>
#include <dynfilter/core/verdict.hpp>
#include <dynfilter/correspondence/match.hpp>
#include <dynfilter/evidence/feature_tracks.hpp>
#include <dynfilter/evidence/frame_evidence.hpp>
#include <dynfilter/evidence/history.hpp>
#include <dynfilter/geometry/depth_sampler.hpp>
#include <dynfilter/geometry/rigid_motion.hpp>
#include <dynfilter/testing/exact_scene.hpp>
#include <dynfilter/testing/exact_scene_frame.hpp>
#include <dynfilter/testing/exact_scene_presets.hpp>

#include "../correspondence/random_texture.hpp"
#include "doctest/doctest.h"

namespace frame_evidence_test {

using namespace dynfilter;

namespace {

void show(FrameEvidence& evidence, const testing::ExactFrame& frame) {
  evidence.begin(frame.view(), CallPoint::BeforePose);
}

}  // namespace

TEST_CASE("evidence is computed once per frame and seed set") {
  const testing::ExactScene scene = testing::preset(testing::Preset::General);
  FrameEvidence evidence;
  show(evidence, scene.frame(0));
  evidence.end(false);
  const testing::ExactFrame frame = scene.frame(1);
  show(evidence, frame);
  const Match& match = evidence.match({});
  CHECK(&match == &evidence.match({}));
  CHECK(match.correspondences.count() > 200);
  std::vector<int> seeds, fewer;
  evidence.collect_seeds(match, false, seeds);
  const RigidMotion& motion = evidence.rigid_motion(match, seeds);
  CHECK(&motion == &evidence.rigid_motion(match, seeds));
  fewer.assign(seeds.begin(), seeds.begin() + static_cast<std::ptrdiff_t>(seeds.size() / 2));
  CHECK(&motion != &evidence.rigid_motion(match, fewer));
  CHECK(&evidence.two_view(match, seeds) == &evidence.two_view(match, seeds));
  CHECK(motion.ok);
  // The true motion, from the scene's poses.
  const Pose truth = inverse(scene.T_world_camera(1)) * scene.T_world_camera(0);
  CHECK((motion.T_current_reference.t() - truth.t()).norm() < 1e-4);
}

TEST_CASE("a late mask is carried with the depth image, whether semantics were announced or not") {
  const testing::ExactScene scene = testing::preset(testing::Preset::General);
  cv::Mat depth(480, 640, CV_32FC1, cv::Scalar(4.0)), labels = cv::Mat::zeros(480, 640, CV_8UC1);
  depth(cv::Rect(200, 100, 200, 300)).setTo(cv::Scalar(2.0));
  labels(cv::Rect(180, 80, 240, 340)).setTo(cv::Scalar(1));  // with some background
  const auto carried = [&](bool told, const cv::Mat& image) {
    FrameEvidence evidence;
    evidence.set_semantics(told);
    cv::Mat result;
    for (int k = 0; k < 3; ++k) {
      const testing::ExactFrame exact = scene.frame(k);
      FrameView frame = exact.view();
      frame.depth = image;
      if (k > 0) frame.mask = MaskInput{exact.id - 1, labels};
      evidence.begin(frame, CallPoint::BeforePose);
      evidence.match({});
      if (k > 0)
        if (const cv::Mat* now = evidence.carried_labels()) result = now->clone();
      evidence.end(false);
    }
    return result;
  };
  const cv::Mat told = carried(true, depth), not_told = carried(false, depth),
                flat = carried(true, cv::Mat());
  REQUIRE_FALSE(told.empty());
  REQUIRE(not_told.size() == told.size());
  CHECK(cv::norm(told, not_told, cv::NORM_INF) == 0);
  CHECK((flat.empty() || cv::norm(told, flat, cv::NORM_INF) > 0));  // the depth image has an effect
}

// 90 px are more than flow finds by itself. Any two descriptors differ in about half of their bits.
TEST_CASE("after a long step flow finds features that jump far where their descriptors are, to 0.3 px") {
  constexpr int kJump_px = 90;
  const cv::Size size(640, 240);
  const test::WaveTexture texture(3);
  std::vector<cv::KeyPoint> then, now;
  for (int y = 40; y < 200; y += 20)
    for (int x = 40; x < 500; x += 20) {
      now.emplace_back(cv::Point2f(static_cast<float>(x), static_cast<float>(y)), 31.0F);
      then.emplace_back(now.back().pt + cv::Point2f(kJump_px + 0.8F, -0.6F), 31.0F);  // as corners are found
    }
  cv::Mat descriptors(static_cast<int>(now.size()), 32, CV_8UC1);
  cv::randu(descriptors, 0, 256);
  const auto found = [&](double step_s, const cv::Mat& described) {
    CorrespondenceParams params;
    params.flow = FlowParams::guided();
    FrameEvidence evidence(params);
    evidence.set_history(1);
    FrameView frame;
    frame.camera = freiburg3_camera();
    for (int k = 0; k < 2; ++k) {
      frame.id = k, frame.timestamp_s = k * step_s;
      frame.keypoints = k == 0 ? then : now;
      frame.descriptors = described;
      frame.grey = texture.image(size, cv::Point2d(k * kJump_px, 0));
      evidence.begin(frame, CallPoint::BeforePose);
      if (k == 0) evidence.end(false);
    }
    const Match& match = evidence.match({});
    std::size_t right = 0;
    for (std::size_t i = 0; i < now.size(); ++i) {
      const cv::Point2f off =
          match.correspondences.reference_px[i] - now[i].pt - cv::Point2f(static_cast<float>(kJump_px), 0);
      right += match.found(i) && off.dot(off) < 0.3F * 0.3F ? 1U : 0U;
    }
    evidence.end(false);
    return static_cast<double>(right) / static_cast<double>(now.size());
  };
  CHECK(found(0.1, descriptors) >= 0.95);
  CHECK(found(0.1, cv::Mat()) <= 0.3);
  CHECK(found(0.033, descriptors) <= 0.3);  // at 30 Hz nothing jumps so far: not searched
}

TEST_CASE("stereo: features without a column are searched in the right image") {
  constexpr double kDisparity_px = 20.4, kBaseline_px_m = 40.8;  // a wall at 2 m
  const cv::Size size(320, 120);
  const test::WaveTexture texture(4);
  std::vector<cv::KeyPoint> keypoints;
  for (int y = 20; y < 100; y += 20)
    for (int x = 60; x < 280; x += 20)
      keypoints.emplace_back(cv::Point2f(static_cast<float>(x), static_cast<float>(y)), 31.0F);
  std::vector<float> columns(keypoints.size(), -1.0F);
  columns[3] = keypoints[3].pt.x - 10;  // the host's counts
  FrameEvidence evidence;
  evidence.set_history(1);
  FrameView frame;
  frame.keypoints = keypoints;
  frame.camera = freiburg3_camera();
  frame.camera->baseline_fx_px_m = kBaseline_px_m;
  const auto deep = [&](const std::vector<float>& depths_m) {
    return std::count_if(depths_m.begin(), depths_m.end(), [](float z) { return std::abs(z - 2) < 0.05F; });
  };
  const auto all = static_cast<std::ptrdiff_t>(keypoints.size());
  for (const bool by_host : {true, false}) {
    CAPTURE(by_host);
    evidence.reset();
    cv::Mat left, right;
    for (int k = 0; k < 2; ++k) {
      frame.id = k;
      frame.right_u_px = by_host ? Span<const float>(columns) : Span<const float>();
      left = texture.image(size, cv::Point2d(3 * k, 0));
      right = texture.image(size, cv::Point2d(3 * k + kDisparity_px, 0));
      frame.grey = left, frame.right_grey = right;
      evidence.begin(frame, CallPoint::BeforePose);
      CHECK(evidence.input_notes().empty());
      CHECK(is_stereo(evidence.frame()));
      CHECK((evidence.inputs() & Input::Depth) == Input::Depth);
      CHECK(deep(evidence.depths_m()) >= all - (by_host ? 2 : 1));
      if (by_host) CHECK(evidence.depths_m()[3] == doctest::Approx(kBaseline_px_m / 10));
      evidence.end(false);
      left.setTo(0), right.setTo(0);  // the host's buffers
    }
  }
}

TEST_CASE(
    "stereo: a match that ends at none of the reference's features has a depth there, from its images") {
  constexpr double kDisparity_px = 20.4, kBaseline_px_m = 40.8;  // a wall at 2 m
  const cv::Size size(320, 120);
  const test::WaveTexture texture(4);
  FrameEvidence evidence;
  evidence.set_history(1);
  FrameView frame;
  frame.camera = freiburg3_camera();
  frame.camera->baseline_fx_px_m = kBaseline_px_m;
  for (const bool keeps_right : {true, false}) {
    CAPTURE(keeps_right);
    evidence.reset();
    std::vector<cv::KeyPoint> keypoints;
    std::vector<float> columns;
    for (int k = 0; k < 2; ++k) {
      keypoints.clear(), columns.clear();
      for (int y = 20; y < 100; y += 20)
        for (int x = 60 + 10 * k; x < 280; x += 20) {  // the first frame's are halfway between
          keypoints.emplace_back(cv::Point2f(static_cast<float>(x), static_cast<float>(y)), 31.0F);
          columns.push_back(static_cast<float>(x - kDisparity_px));
        }
      frame.id = k, frame.keypoints = keypoints, frame.right_u_px = columns;
      frame.grey = texture.image(size, cv::Point2d(2 * k, 0));
      frame.right_grey = keeps_right ? texture.image(size, cv::Point2d(2 * k + kDisparity_px, 0)) : cv::Mat();
      evidence.begin(frame, CallPoint::BeforePose);
      if (k == 0) evidence.end(false);
    }
    const Match& match = evidence.match({});
    std::ptrdiff_t found = 0, deep = 0;
    for (std::size_t i = 0; i < keypoints.size(); ++i)
      if (match.found(i)) ++found, deep += std::abs(match.reference_depth_m[i] - 2) < 0.05F ? 1 : 0;
    CHECK(found > 35);
    CHECK(deep >= (keeps_right ? found - 2 : 0));
    CHECK(deep <= (keeps_right ? found : 0));
    evidence.end(false);
  }
}

TEST_CASE("a right image that cannot be of this camera is not used, with a note") {
  const std::vector<cv::KeyPoint> keypoints(1, cv::KeyPoint(150, 50, 31));
  FrameEvidence evidence;
  FrameView frame;
  frame.keypoints = keypoints;
  frame.camera = freiburg3_camera();
  frame.camera->baseline_fx_px_m = 40;
  frame.grey = test::WaveTexture(4).image(cv::Size(320, 120), {});
  const auto notes = [&](const cv::Mat& right) {
    frame.right_grey = right;
    evidence.begin(frame, CallPoint::BeforePose);
    CHECK(is_stereo(evidence.frame()) == evidence.input_notes().empty());
    const std::vector<std::string> said = evidence.input_notes();
    evidence.end(false);
    return said;
  };
  const std::vector<std::string> wrong{"right_grey cannot be used: wrong size or type"};
  CHECK(notes(frame.grey).empty());
  CHECK(notes(frame.grey.colRange(0, 300)) == wrong);
  CHECK(notes(cv::Mat(frame.grey.size(), CV_8UC3, cv::Scalar())) == wrong);
  frame.camera->distortion[0] = 0.1;
  CHECK(notes(frame.grey) ==
        std::vector<std::string>{"right_grey cannot be used: the camera says that images are not rectified"});
}

TEST_CASE("what is kept does not depend on the host's buffers") {
  FrameEvidence evidence;
  evidence.set_history(1);
  std::vector<cv::KeyPoint> keypoints{{{20, 20}, 1.0F}};
  std::vector<float> depths{2.0F};
  cv::Mat grey(64, 64, CV_8UC1), depth(64, 64, CV_16UC1, cv::Scalar(10000));
  cv::randu(grey, 0, 255);
  const cv::Mat first_image = grey.clone();
  FrameView frame;
  frame.keypoints = keypoints;
  frame.depth_m = depths;
  frame.grey = grey;
  frame.depth = depth;
  frame.depth_unit_m = 1.0 / 5000;
  evidence.begin(frame, CallPoint::BeforePose);
  evidence.end(false);
  grey.setTo(0);
  depth.setTo(0);
  keypoints[0].pt = {1, 1};
  depths[0] = 9;
  frame.id = 1;
  evidence.begin(frame, CallPoint::BeforePose);
  const auto* stored = static_cast<const StoredFrame*>(evidence.match({}).reference);
  REQUIRE(stored != nullptr);
  CHECK(stored->keypoints[0].pt.x == 20.0F);
  CHECK(stored->depth_m[0] == 2.0F);
  CHECK(cv::countNonZero(stored->depth != 10000) == 0);
  CHECK(cv::countNonZero(stored->pyramid.image() != first_image) == 0);
  evidence.end(false);
}

TEST_CASE(
    "a depth image that was handed over is kept itself, and nobody else's memory is ever written into") {
  FrameEvidence evidence;
  evidence.set_history(1);
  const std::vector<cv::KeyPoint> keypoints{{{20, 20}, 1.0F}};
  std::vector<cv::Mat> given;
  for (int k = 0; k < 12; ++k) {
    given.emplace_back(64, 64, CV_32FC1, cv::Scalar(1 + k));
    FrameView frame;
    frame.id = k;
    frame.keypoints = keypoints;
    frame.depth = given.back();
    frame.depth_handed_over = k % 3 != 1;  // in turn, so that slots see both
    evidence.begin(frame, CallPoint::BeforePose);
    evidence.end(false);
    const PastFrame* stored = evidence.kept_frame(k);
    REQUIRE(stored != nullptr);
    CHECK((stored->depth.data == given.back().data) == frame.depth_handed_over);
    CHECK(cv::countNonZero(stored->depth != 1 + k) == 0);
    for (int j = 0; j <= k; ++j) CHECK(cv::countNonZero(given[static_cast<std::size_t>(j)] != 1 + j) == 0);
  }
}

TEST_CASE("a depth image gives no depth on silhouettes and fills holes inside of one surface") {
  cv::Mat depth(60, 60, CV_32FC1, cv::Scalar(3.0));
  depth(cv::Rect(30, 0, 30, 60)).setTo(cv::Scalar(1.5));  // a step at x = 30
  depth.at<float>(30, 10) = 0;                            // a hole in the wall
  depth(cv::Rect(26, 40, 8, 3)).setTo(cv::Scalar(0));     // a hole across the step
  const DepthSampler sampler(depth, 1.0, 0.06);
  CHECK(sampler.at({10, 20}) == doctest::Approx(3.0));
  CHECK(sampler.at({45, 20}) == doctest::Approx(1.5));
  CHECK(std::isnan(sampler.at({29, 20})));
  CHECK(std::isnan(sampler.at({31, 20})));
  CHECK(sampler.at({10, 30}) == doctest::Approx(3.0));
  CHECK(std::isnan(sampler.at({30, 41})));
  for (const cv::Point2f& outside :
       {cv::Point2f(-1, 5), cv::Point2f(5, -1), cv::Point2f(60, 5), cv::Point2f(5, 60),
        cv::Point2f(std::nanf(""), 5), cv::Point2f(5, std::nanf(""))})
    CHECK(std::isnan(sampler.at(outside)));
  CHECK(sampler.at({59.4F, 59.4F}) == doctest::Approx(1.5));
  CHECK(std::isnan(DepthSampler(cv::Mat(9, 9, CV_64FC1, cv::Scalar(1)), 1, 1).at({4, 4})));
}

TEST_CASE("references: k frames back, the oldest when there are fewer, the last keyframe, a frame by id") {
  const testing::ExactScene scene =
      testing::preset(testing::Preset::Rigid).without_matches().with_descriptors();
  FrameEvidence evidence;
  evidence.set_history(3);
  const auto reference_id = [&](const Reference& reference) {
    const Match& match = evidence.match(reference);
    return match.reference == nullptr ? -1 : match.reference->id;
  };
  for (int k = 0; k < 6; ++k) {
    const testing::ExactFrame frame = scene.frame(k);
    show(evidence, frame);
    CHECK(reference_id({false, 1}) == k - 1);
    CHECK(reference_id({false, 3}) == (k == 0 ? -1 : std::max(0, k - 3)));
    CHECK(reference_id({false, 30}) == (k == 0 ? -1 : std::max(0, k - 3)));
    CHECK(reference_id({true, 1}) == (k > 1 ? 1 : -1));
    if (k == 5)
      CHECK(evidence.match_with(1).reference != nullptr);  // no longer in the ring, kept as the keyframe
    if (k == 5) CHECK(evidence.match_with(0).reference == nullptr);
    if (k == 5)
      CHECK(evidence.match({false, 1}).correspondences.count() > frame.size() / 2);  // by descriptors
    evidence.end(k == 1);
  }
}

TEST_CASE("the host's matches are used for the frame that they are about, and for no other") {
  const testing::ExactScene scene = testing::preset(testing::Preset::Rigid).with_descriptors();
  FrameEvidence evidence;
  evidence.set_history(3);
  for (int k = 0; k < 4; ++k) {
    const testing::ExactFrame frame = scene.frame(k);
    show(evidence, frame);
    if (k == 3) {
      CHECK(evidence.match({false, 3}).reference->id == 2);  // independent of the requested gap
      const testing::ExactFrame first = scene.frame(0);
      const Match& late = evidence.match_with(0);
      REQUIRE(late.reference != nullptr);
      CHECK(late.correspondences.count() > frame.size() / 2);
      for (std::size_t i = 0; i < frame.size(); ++i)
        if (late.found(i))
          CHECK(first.point[static_cast<std::size_t>(late.correspondences.reference_index[i])] ==
                frame.point[i]);
    }
    evidence.end(false);
  }
}

TEST_CASE("a call point with a thinned frame does not break the tracks of another") {
  const testing::ExactScene scene = testing::ExactScene().points(60);
  FrameEvidence evidence;
  const TrackOptions options{4};
  int longest = 0;
  for (int k = 0; k < 3; ++k) {
    const testing::ExactFrame frame = scene.frame(k);
    FrameView view = frame.view();
    evidence.begin(view, CallPoint::BeforePose);
    const FeatureTracks& tracks = evidence.tracks(options);
    longest = 0;
    for (std::size_t i = 0; i < tracks.size(); ++i) longest = std::max(longest, tracks.length(i));
    evidence.end(false);
    FrameView thinned;
    thinned.id = view.id;
    thinned.timestamp_s = view.timestamp_s;
    thinned.keypoints = {view.keypoints.data(), view.keypoints.size() / 2};
    evidence.begin(thinned, CallPoint::AfterPose);
    CHECK(evidence.tracks(options).size() == thinned.size());
    evidence.end(false);
  }
  CHECK(longest == 2);
}

}  // namespace frame_evidence_test
