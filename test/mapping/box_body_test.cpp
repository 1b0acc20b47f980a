// SPDX-License-Identifier: MIT
#include <array>
#include <cmath>
#include <dynfilter/cluster/depth_split.hpp>
#include <dynfilter/mapping/box_body.hpp>
#include <dynfilter/mapping/depth_cut.hpp>
#include <random>
#include <vector>

#include "doctest/doctest.h"

namespace box_body_test {

using namespace dynfilter;
using namespace dynfilter::mapping;

namespace {

void put(cv::Mat& depth_m, const cv::Rect& where, float z) {
  depth_m(where).setTo(z);
}
bool all(const cv::Mat& body, const cv::Rect& where, int value) {
  return cv::countNonZero(body(where) != value) == 0;
}

/// A wall at 4 m, and a person at 2 m with one arm stretched forwards and one hand farther back.
/// The legs are visible below a desk 0.8 m in front. A shelf is half way to the wall.
const cv::Rect kPerson(60, 20, 40, 60), kDesk(20, 80, 120, 15), kLegs(62, 95, 34, 25), kArm(64, 40, 12, 8),
    kHand(104, 60, 6, 6), kShelf(20, 30, 30, 50);
cv::Mat office() {
  cv::Mat depth_m(120, 160, CV_32FC1, 4.0F);
  put(depth_m, kPerson, 2);
  put(depth_m, kDesk, 1.2F);
  put(depth_m, kLegs, 2.1F);
  put(depth_m, kArm, 1.6F);
  put(depth_m, kHand, 2.4F);
  put(depth_m, kShelf, 2.8F);
  return depth_m;
}

/// The definition, part by part with a flood fill.
class Twin {
 public:
  explicit Twin(const cv::Mat& depth_m) : depth_(depth_m) {}

  cv::Mat body() {
    const float first_m = nearer_side_m(0);
    for (float farthest_m = first_m;;) {
      if (fill_parts(farthest_m)) return with_what_is_near();
      farthest_m = nearer_side_m(farthest_m);
      if (std::isinf(farthest_m)) break;
    }
    fill_parts(first_m);
    return part_ != 0;
  }

 private:
  float nearer_side_m(float beyond_m) const {
    std::vector<float> inverse;
    for (int y = 0; y < depth_.rows; y += 4)
      for (int x = 0; x < depth_.cols; x += 4)
        if (depth_.at<float>(y, x) > beyond_m) inverse.push_back(1 / depth_.at<float>(y, x));
    return static_cast<float>(nearer_surface_m(inverse));
  }
  /// True if one of them fills enough of the middle. Sets core_.
  bool fill_parts(float farthest_m) {
    part_ = cv::Mat(depth_.size(), CV_32SC1, cv::Scalar(0));
    parts_.clear();
    for (int y = 0; y < depth_.rows; ++y)
      for (int x = 0; x < depth_.cols; ++x) {
        const float z = depth_.at<float>(y, x);
        if (z > 0 && z <= farthest_m && part_.at<int>(y, x) == 0) fill({x, y}, farthest_m);
      }
    std::size_t most = 0;
    for (std::size_t p = 0; p < parts_.size(); ++p) {
      std::size_t middle = 0;
      for (const cv::Point& at : parts_[p]) middle += in_the_middle(at) ? 1 : 0;
      if (middle > most) most = middle, core_ = p;
    }
    return most > 0 && most * 10 >= static_cast<std::size_t>(area_of_the_middle());
  }
  cv::Mat with_what_is_near() const {
    cv::Mat out = cv::Mat::zeros(depth_.size(), CV_8UC1);
    for (std::size_t p = 0; p < parts_.size(); ++p)
      if (std::abs(mean_m(p) - mean_m(core_)) <= 0.6)
        for (const cv::Point& at : parts_[p]) out.at<std::uint8_t>(at) = 255;
    for (int y = 0; y < depth_.rows; ++y)
      for (int x = 0; x < depth_.cols; ++x) {
        const auto z = static_cast<double>(depth_.at<float>(y, x));
        if (part_.at<int>(y, x) == 0 && z > 0 && z <= mean_m(core_) + 0.6) out.at<std::uint8_t>(y, x) = 255;
      }
    return out;
  }
  bool in_the_middle(cv::Point at) const {
    return at.x >= depth_.cols / 4 && at.x < depth_.cols - depth_.cols / 4 && at.y >= depth_.rows / 10 &&
           at.y < depth_.rows / 10 + depth_.rows / 2;
  }
  int area_of_the_middle() const { return (depth_.cols - 2 * (depth_.cols / 4)) * (depth_.rows / 2); }
  double mean_m(std::size_t p) const {
    double sum = 0;
    for (const cv::Point& at : parts_[p]) sum += static_cast<double>(depth_.at<float>(at));
    return sum / static_cast<double>(parts_[p].size());
  }
  void fill(cv::Point from, float farthest_m) {
    const DepthJump jump(0.02);
    parts_.emplace_back(1, from);
    std::vector<cv::Point>& open = parts_.back();
    const int number = static_cast<int>(parts_.size());
    part_.at<int>(from) = number;
    for (std::size_t i = 0; i < open.size(); ++i)
      for (const cv::Point& step : {cv::Point(1, 0), cv::Point(-1, 0), cv::Point(0, 1), cv::Point(0, -1)}) {
        const cv::Point at = open[i] + step;
        if (!cv::Rect({0, 0}, depth_.size()).contains(at) || part_.at<int>(at) != 0) continue;
        const float z = depth_.at<float>(at);
        if (!(z > 0 && z <= farthest_m) || jump(z, depth_.at<float>(open[i]))) continue;
        part_.at<int>(at) = number;
        open.push_back(at);
      }
  }

  cv::Mat depth_, part_;
  std::vector<std::vector<cv::Point>> parts_;
  std::size_t core_ = 0;
};

/// Rectangles at random depths before a wall, with noise and holes.
cv::Mat clutter(std::mt19937& source) {
  const auto below = [&](int n) { return static_cast<int>(source() % static_cast<unsigned>(n)); };
  cv::Mat depth_m(1 + below(60), 1 + below(60), CV_32FC1, 4.0F);
  const cv::Rect all({0, 0}, depth_m.size());
  for (int i = 0; i < 8; ++i)
    put(depth_m, cv::Rect(below(60), below(60), 1 + below(40), 1 + below(40)) & all,
        0.8F + 0.1F * static_cast<float>(below(30)));
  for (int y = 0; y < depth_m.rows; ++y)
    for (int x = 0; x < depth_m.cols; ++x) {
      depth_m.at<float>(y, x) += 0.0001F * static_cast<float>(below(300));
      if (below(30) == 0) depth_m.at<float>(y, x) = 0;
    }
  return depth_m;
}

}  // namespace

TEST_CASE(
    "the body in a box is what fills its middle and what is as far away, not what stands before or behind") {
  const cv::Mat depth_m = office();
  cv::Mat body;
  BoxBody().run(depth_m, {20, 10, 120, 110}, body);
  const cv::Point box(20, 10);
  CHECK(all(body, {kPerson.tl() - box, kPerson.size()}, 255));
  CHECK(all(body, {kLegs.tl() - box, kLegs.size()}, 255));
  CHECK(all(body, {kArm.tl() - box, kArm.size()}, 255));
  CHECK(all(body, {kHand.tl() - box, kHand.size()}, 255));
  CHECK(all(body, {kDesk.tl() - box, kDesk.size()}, 0));
  CHECK(all(body, {kShelf.tl() - box, kShelf.size()}, 0));
  CHECK(cv::countNonZero(body) == kPerson.area() + kLegs.area() + kHand.area());
}

TEST_CASE("where nothing fills the middle of a box, all of its nearer side is the body") {
  cv::Mat depth_m(100, 100, CV_32FC1, 4.0F), body;
  put(depth_m, {0, 0, 20, 100}, 1.5F);
  put(depth_m, {85, 0, 15, 100}, 2.2F);
  BoxBody().run(depth_m, {0, 0, 100, 100}, body);
  CHECK(all(body, {0, 0, 20, 100}, 255));
  CHECK(all(body, {85, 0, 15, 100}, 255));
  CHECK(all(body, {20, 0, 65, 100}, 0));
}

TEST_CASE("a box that one surface fills is all body, one without depth has none") {
  BoxBody finder;
  cv::Mat body;
  finder.run(cv::Mat(50, 40, CV_32FC1, 2.0F), {0, 0, 40, 50}, body);
  CHECK(cv::countNonZero(body) == 40 * 50);
  finder.run(cv::Mat(50, 40, CV_32FC1, 0.0F), {5, 5, 20, 20}, body);
  CHECK(body.size() == cv::Size(20, 20));
  CHECK(cv::countNonZero(body) == 0);
}

TEST_CASE("bodies equal those of a flood fill") {
  std::mt19937 source(6);
  BoxBody finder;
  int some = 0;
  for (int round = 0; round < 400; ++round) {
    const cv::Mat depth_m = clutter(source);
    cv::Mat body;
    finder.run(depth_m, {0, 0, depth_m.cols, depth_m.rows}, body);
    const cv::Mat expected = Twin(depth_m).body();
    REQUIRE(cv::countNonZero(body != expected) == 0);
    const int n = cv::countNonZero(body);
    some += n > 0 && n < body.rows * body.cols ? 1 : 0;
  }
  CHECK(some > 100);
}

TEST_CASE("a desk before a person stays in the map, and an arm that leaves his box does not") {
  cv::Mat depth_m = office();
  put(depth_m, {100, 44, 25, 6}, 2);  // an arm to the right
  Detection person;
  person.class_name = "person";
  person.box = cv::Rect2f(50, 15, 60, 105);
  const std::vector<Detection> detections{person};
  MapFrame frame;
  frame.camera.fx_px = frame.camera.fy_px = 130, frame.camera.cx_px = 80, frame.camera.cy_px = 60;
  frame.detections = detections;
  CutParams params;
  params.band_px = 0, params.edge_px = 0;
  DepthCut cut(params);
  cut.run(depth_m, frame);
  CHECK(all(cut.moving(), kPerson, 255));
  CHECK(all(cut.moving(), kLegs, 255));
  CHECK(all(cut.moving(), kDesk, 0));
  // 0.15 m are 9.75 pixels at 2 m; the rim of the box is at 109.
  CHECK(all(cut.moving(), {100, 44, 18, 6}, 255));
  CHECK(all(cut.moving(), {120, 44, 5, 6}, 0));
}

}  // namespace box_body_test
