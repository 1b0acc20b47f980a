// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <dynfilter/core/frame_inputs.hpp>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/limits.hpp>
#include <dynfilter/correspondence/match.hpp>
#include <dynfilter/late/box_tracker.hpp>
#include <dynfilter/late/carried_box.hpp>
#include <dynfilter/late/carried_mask.hpp>
#include <dynfilter/late/late_semantics.hpp>
#include <dynfilter/late/motion_history.hpp>
#include <limits>
#include <set>
#include <vector>

#include "doctest/doctest.h"
#include "support/time_limit.hpp"

namespace late_semantics_test {

using namespace dynfilter;

namespace {

constexpr int kWidth = 320, kHeight = 240;

/// A person at 2 m in front of a wall at 4 m, with a rotating camera.
/// The person moves by (4, 1) px per frame, the wall by (-3, 0) px.
/// Features every 10 px, depth images without noise.
struct Walk {
  cv::Rect2f person(int k) const {
    return {40.0F + 4 * static_cast<float>(k), 60.0F + static_cast<float>(k), 50, 120};
  }
  cv::Mat depth(int k) const {
    cv::Mat image(kHeight, kWidth, CV_32FC1, cv::Scalar(4.0));
    image(cv::Rect(person(k)) & cv::Rect(0, 0, kWidth, kHeight)).setTo(cv::Scalar(2.0));
    return image;
  }
  void add(int k, MotionHistory& motions, std::int64_t from = -2) const {
    PastFrame last;
    last.id = from == -2 ? k - 1 : from;
    Match match;
    match.reference = k > 0 ? &last : nullptr;
    std::vector<cv::Point2f> px;
    std::vector<float> depths_m;
    for (float y = 5; y < kHeight; y += 10)
      for (float x = 5; x < kWidth; x += 10) {
        px.emplace_back(x, y);
        depths_m.push_back(person(k).contains(px.back()) ? 2.0F : 4.0F);
      }
    match.correspondences.reset(px.size());
    match.reference_depth_m = depths_m;
    for (std::size_t i = 0; k > 0 && i < px.size(); ++i)
      match.correspondences.set(i, px[i] - (depths_m[i] < 3 ? cv::Point2f(4, 1) : cv::Point2f(-3, 0)));
    cv::Mat sparse_depth_m;
    MotionHistory::sparse_depth(depth(k), 1, sparse_depth_m);
    motions.add(k, match, px, depths_m, sparse_depth_m, {kWidth, kHeight});
  }
  Detection box(int k, const char* name = "person") const {
    Detection d;
    d.box = person(k);
    d.class_name = name;
    return d;
  }
};

double overlap(const cv::Rect2f& a, const cv::Rect2f& b) {
  const float both = (a & b).area();
  return static_cast<double>(both / (a.area() + b.area() - both));
}

}  // namespace

TEST_CASE("a thinned depth image has every fourth pixel, whatever the image's size") {
  for (const int type : {CV_32FC1, CV_16UC1})
    for (int rows = 1; rows <= 10; ++rows)
      for (int cols = 1; cols <= 14; ++cols) {
        cv::Mat depth(rows, cols, type);
        for (int y = 0; y < rows; ++y)
          for (int x = 0; x < cols; ++x) {
            const int z = (7 * y + 3 * x) % 5;  // 0: none
            if (type == CV_32FC1)
              depth.at<float>(y, x) = z == 4 ? std::numeric_limits<float>::infinity() : static_cast<float>(z);
            else
              depth.at<std::uint16_t>(y, x) = static_cast<std::uint16_t>(z);
          }
        cv::Mat sparse;
        MotionHistory::sparse_depth(depth, 0.5, sparse);
        REQUIRE(sparse.size() == cv::Size((cols + 3) / 4, (rows + 3) / 4));
        for (int r = 0; r < sparse.rows; ++r)
          for (int c = 0; c < sparse.cols; ++c) {
            const int z = (7 * std::min(4 * r + 2, rows - 1) + 3 * std::min(4 * c + 2, cols - 1)) % 5;
            const bool none = z == 0 || (z == 4 && type == CV_32FC1);
            CHECK(std::isnan(sparse.at<float>(r, c)) == none);
            if (!none) CHECK(sparse.at<float>(r, c) == 0.5F * static_cast<float>(z));
          }
      }
}

TEST_CASE("the motion history leads from frame to frame, not past its beginning or over a gap") {
  const Walk walk;
  MotionHistory motions;
  for (int k = 0; k < 100; ++k) walk.add(k, motions);
  std::vector<const MotionFrame*> path;
  REQUIRE(motions.path(90, 99, path));
  CHECK(path.size() == 9);
  CHECK(path.front()->id == 91);
  CHECK(path.back()->id == 99);
  CHECK(motions.path(99, 99, path));
  CHECK(path.empty());
  CHECK_FALSE(motions.path(99 - static_cast<int>(MotionHistory::kFrames) - 1, 99, path));
  CHECK_FALSE(motions.path(99, 98, path));
  CHECK_FALSE(motions.path(200, 210, path));
  walk.add(100, motions, 97);  // the host's match skips two frames
  CHECK(motions.path(97, 100, path));
  CHECK_FALSE(motions.path(98, 100, path));
  motions.reset();
  CHECK_FALSE(motions.path(97, 100, path));
}

TEST_CASE("a late box goes where the person went, not with the wall in it, and keeps its track") {
  const Walk walk;
  LateSemantics late;
  walk.add(0, late.motions());
  for (int k = 1; k <= 40; ++k) {
    walk.add(k, late.motions());
    // Results of every 10th frame, 10 frames late.
    const int of = k < 10 ? 0 : k / 10 * 10 - 10;
    Detection wide = walk.box(of);
    wide.box = {wide.box.x - 10, wide.box.y - 10, wide.box.width + 20, wide.box.height + 20};
    const std::vector<Detection> found{wide};
    const auto* boxes = late.boxes({of, found}, k);
    REQUIRE(boxes);
    REQUIRE(boxes->size() == 1);
    const cv::Rect2f truth = walk.person(k);
    CHECK(boxes->front().detection.box.x == doctest::Approx(truth.x - 10));
    CHECK(boxes->front().detection.box.y == doctest::Approx(truth.y - 10));
    CHECK(boxes->front().detection.box.width == doctest::Approx(70));
    CHECK(boxes->front().detection.track_id == 0);
    CHECK(boxes->front().found_id == of);
  }
}

TEST_CASE("what one result missed is bridged once two have shown it; nothing found is no new track") {
  const Walk walk;
  LateSemantics late;
  std::vector<Detection> found;
  const auto boxes_at = [&](int k, int of, std::vector<Detection> detections) {
    found = std::move(detections);
    const auto* boxes = late.boxes({of, found}, k);
    REQUIRE(boxes);
    return *boxes;
  };
  for (int k = 0; k <= 4; ++k) walk.add(k, late.motions());
  CHECK(boxes_at(4, 1, {walk.box(1)}).size() == 1);
  walk.add(5, late.motions());
  CHECK(boxes_at(5, 2, {}).empty());  // detected only once: a false alarm
  walk.add(6, late.motions());
  CHECK(boxes_at(6, 3, {walk.box(3), walk.box(3, "dog")}).size() == 2);  // classes do not mix
  walk.add(7, late.motions());
  const auto two = boxes_at(7, 4, {walk.box(4)});
  REQUIRE(two.size() == 1);
  CHECK(two[0].hits == 2);
  const int track = two[0].detection.track_id;
  walk.add(8, late.motions());
  const auto bridged = boxes_at(8, 5, {});
  REQUIRE(bridged.size() == 1);
  CHECK(bridged[0].found_id == 4);
  CHECK(bridged[0].detection.track_id == track);
  CHECK(overlap(bridged[0].detection.box, walk.person(8)) > 0.99);
  for (int k = 9; k < 50; ++k) walk.add(k, late.motions());
  CHECK(boxes_at(49, 40, {}).empty());  // too long without a detection
}

TEST_CASE("where no motion history leads there is no answer, and nothing of before a reset comes back") {
  const Walk walk;
  LateSemantics late;
  const std::vector<Detection> found{walk.box(0)};
  for (int k = 5; k < 8; ++k) walk.add(k, late.motions());
  CHECK(late.boxes({3, found}, 7) == nullptr);
  CHECK(late.mask({3, cv::Mat::ones(24, 32, CV_8UC1)}, 7) == nullptr);
  CHECK(late.boxes({6, found}, 7) != nullptr);
  late.reset();
  CHECK(late.boxes({6, found}, 7) == nullptr);
}

TEST_CASE("a late mask goes where the person went and lets the wall go") {
  const Walk walk;
  for (const int mask_scale : {1, 2}) {
    LateSemantics late;
    for (int k = 0; k <= 12; ++k) walk.add(k, late.motions());
    cv::Mat labels = cv::Mat::zeros(kHeight / mask_scale, kWidth / mask_scale, CV_8UC1);
    cv::Rect2f drawn = walk.person(2);
    drawn = {drawn.x - 4, drawn.y - 4, drawn.width + 8, drawn.height + 8};  // with some wall
    const float scale = 1.0F / static_cast<float>(mask_scale);
    labels(cv::Rect(cv::Rect2f(drawn.tl() * scale, drawn.br() * scale))).setTo(cv::Scalar(7));
    for (int k = 12; k <= 20; ++k) {
      if (k > 12) walk.add(k, late.motions());
      CarriedMask* mask = late.mask({2, labels}, k);
      REQUIRE(mask);
      const cv::Mat& now = mask->labels();
      REQUIRE(now.size() == cv::Size(kWidth / 4, kHeight / 4));
      int right = 0, both = 0, either = 0;
      for (int r = 0; r < now.rows; ++r)
        for (int c = 0; c < now.cols; ++c) {
          const bool is = walk.person(k).contains(
              cv::Point2f(4.0F * static_cast<float>(c) + 2, 4.0F * static_cast<float>(r) + 2));
          const bool said = now.at<std::uint8_t>(r, c) != 0;
          right += said && now.at<std::uint8_t>(r, c) == 7;
          both += is && said;
          either += is || said;
        }
      CHECK(right > 0);
      CHECK(both > 0.8 * either);
    }
  }
}

TEST_CASE("boxes without features coast, odd boxes do no harm") {
  MotionFrame empty;
  empty.image_px = {kWidth, kHeight};
  BoxCarrier carrier;
  Detection d;
  d.box = {10, 10, 20, 20};
  CarriedBox box = CarriedBox::from(d, 0);
  box.velocity_px = {10, 0};
  carrier.carry(empty, box);
  CHECK(box.detection.box.x == doctest::Approx(19));
  carrier.carry(empty, box);
  CHECK(box.detection.box.x == doctest::Approx(27.1));
  const Walk walk;
  MotionHistory motions;
  walk.add(0, motions);
  walk.add(1, motions);
  const float nan = std::nanf("");
  for (const cv::Rect2f& odd : {cv::Rect2f(nan, 0, 10, 10), cv::Rect2f(0, 0, -5, -5), cv::Rect2f(0, 0, 0, 0),
                                cv::Rect2f(-1e30F, 0, 1e30F, 5), cv::Rect2f(1e6F, 1e6F, 10, 10)}) {
    d.box = odd;
    CarriedBox strange = CarriedBox::from(d, 0);
    carrier.carry(*motions.find(1), strange);
    CHECK(strange.hits == 1);
  }
}

TEST_CASE("as many late boxes as allowed are carried and paired in time") {
  const Walk walk;
  constexpr int kFrames = 10;
  std::vector<Detection> boxes;
  for (std::size_t k = 0; k < limits::kMaxBoxes; ++k) boxes.push_back(walk.box(0));
  LateSemantics late;
  const double taken_s = dynfilter_test::seconds([&] {
    for (int k = 0; k < kFrames; ++k) {
      walk.add(k, late.motions());
      // Each frame has a new result, on the frame before.
      if (k > 0) REQUIRE(late.boxes({k - 1, boxes}, k) != nullptr);
    }
  });
  CHECK(late.boxes({kFrames - 2, boxes}, kFrames - 1)->size() == limits::kMaxBoxes);
  CHECK(taken_s < kFrames * dynfilter_test::kMost_s);
}

TEST_CASE("positions that fit no int are in no cell") {
  constexpr float kInf = std::numeric_limits<float>::infinity(),
                  kNan = std::numeric_limits<float>::quiet_NaN();
  CHECK(MotionHistory::cell_of({7.9F, 8.0F}) == cv::Point(1, 2));
  CHECK(MotionHistory::cell_of({-0.1F, -4.1F}) == cv::Point(-1, -2));
  for (const float at : {1e38F, -1e38F, kInf, -kInf, kNan}) {
    CAPTURE(at);
    const cv::Point cell = MotionHistory::cell_of({at, at});
    CHECK((cell.x < 0 && cell.y < 0));
  }
}

TEST_CASE("a mask whose features jump out of any int disappears") {
  const Walk walk;
  LateSemantics late;
  walk.add(0, late.motions());
  cv::Mat labels(kHeight, kWidth, CV_8UC1, cv::Scalar(1));
  for (const float jump : {1e30F, -3e9F, std::numeric_limits<float>::infinity()}) {
    CarriedMask mask;
    mask.start(labels, *late.motions().find(0));
    MotionFrame frame;
    frame.image_px = {kWidth, kHeight};
    for (float y = 5; y < kHeight; y += 10)
      for (float x = 5; x < kWidth; x += 10) frame.samples.push_back({{x, y}, {x + jump, y + jump}, 2, 2});
    mask.carry(frame);
    CHECK(cv::countNonZero(mask.labels()) == 0);
  }
}

TEST_CASE("instance masks are copies, whose memory is reused") {
  Walk walk;
  BoxTracker tracker;
  std::set<const std::uint8_t*> memory;
  constexpr std::int64_t kResults = 12;
  for (std::int64_t result = 0; result < kResults; ++result) {
    std::vector<Detection> boxes(3, walk.box(0));
    for (std::size_t b = 0; b < boxes.size(); ++b) {
      boxes[b].box.x += 60 * static_cast<float>(b);  // apart: each continues its own track
      boxes[b].mask = cv::Mat(kHeight, kWidth, CV_8UC1, cv::Scalar(static_cast<double>(10 + b)));
    }
    tracker.take(boxes, result, {});
    for (Detection& box : boxes) {
      CHECK(has_sole_owner(box.mask));
      box.mask.setTo(cv::Scalar(0));
    }
    REQUIRE(tracker.boxes().size() == boxes.size());
    for (std::size_t b = 0; b < boxes.size(); ++b) {
      const cv::Mat& mask = tracker.boxes()[b].detection.mask;
      CHECK(cv::countNonZero(mask != static_cast<double>(10 + b)) == 0);
      memory.insert(mask.data);
    }
  }
  CHECK(memory.size() <= 2 * 3);  // of the last result and of the one before
}

TEST_CASE("the instance mask of a box that is hardly wider than nothing") {
  Detection d;
  d.box = {10, 10, 20, 20};
  d.mask = cv::Mat(kHeight, kWidth, CV_8UC1, cv::Scalar(255));
  CarriedBox box = CarriedBox::from(d, 0);
  box.detection.box = {10.5F, 10.5F, 1e-30F, 1e-30F};
  cv::Mat instance;
  carried_instance(box, {kWidth, kHeight}, instance);
  CHECK(cv::countNonZero(instance) == 0);
  box.detection.box = {10, 10, 20, 20};  // unmoved: the mask itself, at a quarter
  carried_instance(box, {kWidth, kHeight}, instance);
  CHECK(cv::countNonZero(instance) == kWidth / 4 * kHeight / 4);
}

}  // namespace late_semantics_test
