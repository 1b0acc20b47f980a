// SPDX-License-Identifier: MIT
#include "crowds.hpp"

#include <algorithm>
#include <dynfilter/core/limits.hpp>
#include <opencv2/imgproc.hpp>

namespace crowds {

using namespace dynfilter;

FrameView Crowd::view() {
  FrameView v;
  v.id = id, v.timestamp_s = static_cast<double>(id) / 30;
  v.keypoints = keypoints, v.keypoints_undistorted = undistorted;
  v.descriptors = descriptors, v.depth_m = depth_m;
  v.grey = grey, v.depth = depth, v.depth_unit_m = 0.001;
  v.camera = camera;
  v.T_world_camera.translation_m[0] = 0.01 * static_cast<double>(id);
  v.pose_provenance = PoseProvenance::Estimated;
  v.map_point_ids = map_point_ids, v.map_points_world_m = map_points;
  keyframes.assign(1, KeyframeView());
  keyframes[0].id = id - 1, keyframes[0].keypoints_undistorted = keypoints;
  keyframes[0].depth_m = depth_m, keyframes[0].map_point_ids = map_point_ids;
  v.covisible_keyframes = keyframes;
  if (!match_index.empty() && id > 0) v.matches = HostMatches{id - 1, match_index};
  if (!boxes.empty()) v.detections = DetectionInput{-1, boxes};
  if (!labels.empty()) v.mask = MaskInput{-1, labels};
  return v;
}

namespace {

constexpr float kStep_px = 2;  ///< of the camera from frame to frame

const cv::Mat& texture() {
  static const cv::Mat image = [] {
    cv::Mat noise(kHeight_px, kWidth_px + 100, CV_8UC1);
    Random random(7);
    for (int y = 0; y < noise.rows; ++y)
      for (int x = 0; x < noise.cols; ++x)
        noise.at<std::uint8_t>(y, x) = static_cast<std::uint8_t>(random.bits());
    cv::GaussianBlur(noise, noise, {5, 5}, 0);
    return noise;
  }();
  return image;
}

Detection person(const cv::Rect2f& box, float score = 0.9F) {
  return {box, 0, "person", score, -1, cv::Mat()};
}

using Place = std::function<cv::Point2f(std::size_t i, std::size_t n, Random& random)>;

void put(Crowd& crowd, int k, const Place& place) {
  Random random(11);
  const std::size_t n = crowd.keypoints.size();
  for (std::size_t i = 0; i < n; ++i) {
    const cv::Point2f at = place(i, n, random);
    crowd.keypoints[i].pt = {at.x - kStep_px * static_cast<float>(k % 8), at.y};
  }
}

cv::Point2f at_grid(std::size_t i, std::size_t n) {
  const auto columns = static_cast<std::size_t>(std::sqrt(static_cast<double>(n) * 4 / 3)) + 1;
  const float cell_px = (kWidth_px - 40.0F) / static_cast<float>(columns);
  return {30 + cell_px * static_cast<float>(i % columns), 10 + cell_px * static_cast<float>(i / columns)};
}

/// As dense as is accepted.
cv::Point2f at_dense_pixel(std::size_t i, std::size_t n) {
  constexpr std::size_t kMost = limits::kMaxCrowd, kSide = limits::kCrowd_px;
  const auto squares = static_cast<std::size_t>(std::sqrt(static_cast<double>(n) / kMost)) + 1;
  const std::size_t square = i / kMost, pixel = i % kMost;
  return {static_cast<float>(80 + kSide * (square % squares) + pixel % kSide),
          static_cast<float>(40 + kSide * (square / squares) + pixel / kSide)};
}

void add_places(std::vector<Arrangement>& all) {
  const std::vector<std::pair<std::string, Place>> places{
      {"one pixel", [](std::size_t, std::size_t, Random&) { return cv::Point2f(320, 240); }},
      {"within one pixel", [](std::size_t, std::size_t,
                              Random& r) { return cv::Point2f(r.within(320, 321), r.within(240, 241)); }},
      {"two pixels", [](std::size_t i, std::size_t,
                        Random&) { return i % 2 == 0 ? cv::Point2f(200, 100) : cv::Point2f(420, 300); }},
      {"one line", [](std::size_t, std::size_t, Random& r) { return cv::Point2f(r.within(30, 620), 240); }},
      {"one column", [](std::size_t, std::size_t, Random& r) { return cv::Point2f(320, r.within(10, 470)); }},
      {"grid", [](std::size_t i, std::size_t n, Random&) { return at_grid(i, n); }},
      {"as dense as accepted", [](std::size_t i, std::size_t n, Random&) { return at_dense_pixel(i, n); }},
      {"uniform", nullptr},
      {"clustered", [](std::size_t i, std::size_t, Random& r) {
         const auto cluster = static_cast<float>(i % 20);
         return cv::Point2f(40 + 28 * cluster + r.within(-6, 6), 240 + 10 * r.within(-1, 1) + 8 * cluster);
       }}};
  const std::vector<std::pair<std::string, Source>> sources{
      {"", Source::Flow}, {", descriptors", Source::Descriptors}, {", host's matches", Source::Host}};
  for (const auto& [name, place] : places)
    for (const auto& [suffix, source] : sources)
      all.push_back({name + suffix, source, [place = place](Crowd& crowd, int k) {
                       if (place) put(crowd, k, place);
                     }});
}

void add_depths(std::vector<Arrangement>& all) {
  const auto depth = [](float z) {
    return [z](Crowd& crowd, int) {
      std::fill(crowd.depth_m.begin(), crowd.depth_m.end(), z);
      crowd.depth.setTo(cv::Scalar(std::isnan(z) ? 0.0 : std::max(1.0, 1000.0 * static_cast<double>(z))));
    };
  };
  all.push_back({"one depth", Source::Flow, depth(2)});
  all.push_back({"one depth, host's matches", Source::Host, depth(2)});
  all.push_back({"no depth", Source::Flow, depth(kNan)});
  all.push_back({"all at the camera", Source::Host, depth(1e-6F)});
  all.push_back({"far apart", Source::Host, [](Crowd& crowd, int) {
                   Random random(3);
                   for (float& z : crowd.depth_m) z = std::exp(random.within(-10, 40));
                   crowd.depth.release();
                 }});
}

void add_cameras(std::vector<Arrangement>& all) {
  all.push_back({"undistorted to one pixel", Source::Host, [](Crowd& crowd, int) {
                   crowd.undistorted.assign(crowd.keypoints.size(), cv::KeyPoint(320, 240, 31));
                 }});
  for (const auto& [name, source] :
       {std::pair("a lens that draws all together", Source::Flow),
        std::pair("a lens that draws all together, host's matches", Source::Host)})
    all.push_back({name, source, [](Crowd& crowd, int) { crowd.camera.distortion = {1e5, 1e5, 0, 0, 0}; }});
}

void add_semantics(std::vector<Arrangement>& all) {
  const cv::Rect2f image(0, 0, kWidth_px, kHeight_px);
  all.push_back({"one box", Source::Flow, [image](Crowd& crowd, int) { crowd.boxes = {person(image)}; }});
  all.push_back({"boxes around all", Source::Flow,
                 [image](Crowd& crowd, int) { crowd.boxes.assign(10 * limits::kMaxBoxes, person(image)); }});
  all.push_back({"boxes with masks", Source::Flow, [image](Crowd& crowd, int) {
                   crowd.boxes.assign(limits::kMaxBoxes, person(image));
                   const cv::Mat mask(kHeight_px / 4, kWidth_px / 4, CV_8UC1, cv::Scalar(1));
                   for (Detection& box : crowd.boxes) box.mask = mask;
                 }});
  all.push_back({"a mask of points", Source::Flow, [](Crowd& crowd, int) {
                   crowd.labels = cv::Mat::zeros(kHeight_px, kWidth_px, CV_8UC1);
                   for (int y = 0; y < kHeight_px; y += 2)
                     for (int x = 0; x < kWidth_px; x += 2)
                       crowd.labels.at<std::uint8_t>(y, x) = static_cast<std::uint8_t>(1 + (x / 2 + y) % 255);
                 }});
}

void add_identities(std::vector<Arrangement>& all) {
  all.push_back({"equal descriptors", Source::Descriptors,
                 [](Crowd& crowd, int) { crowd.descriptors.setTo(cv::Scalar(85)); }});
  const auto one_octave = [](Crowd& crowd) {
    for (cv::KeyPoint& keypoint : crowd.keypoints) keypoint.octave = 0;
  };
  all.push_back(
      {"one octave, descriptors", Source::Descriptors, [=](Crowd& crowd, int) { one_octave(crowd); }});
  all.push_back({"one octave, dense, descriptors", Source::Descriptors, [=](Crowd& crowd, int k) {
                   put(crowd, k, [](std::size_t i, std::size_t n, Random&) { return at_dense_pixel(i, n); });
                   one_octave(crowd);
                 }});
  all.push_back({"one map point", Source::Flow, [](Crowd& crowd, int) {
                   std::fill(crowd.map_point_ids.begin(), crowd.map_point_ids.end(), 7);
                   std::fill(crowd.map_points.begin(), crowd.map_points.end(), cv::Point3f(0, 0, 2));
                 }});
  all.push_back({"all matched with one feature", Source::Host, [](Crowd& crowd, int) {
                   std::fill(crowd.match_index.begin(), crowd.match_index.end(), 0);
                 }});
  all.push_back({"each feature moves by itself", Source::Host, [](Crowd& crowd, int k) {
                   Random random(static_cast<std::uint32_t>(100 + k));
                   for (std::int32_t& m : crowd.match_index)
                     m = static_cast<std::int32_t>(random.bits() % crowd.match_index.size());
                 }});
  all.push_back({"spread over a million pixels", Source::Host, [](Crowd& crowd, int) {
                   Random random(5);
                   for (std::size_t i = 0; i < crowd.keypoints.size(); i += 100)
                     crowd.keypoints[i].pt = {random.within(-9e5F, 9e5F), random.within(-9e5F, 9e5F)};
                 }});
}

}  // namespace

std::vector<Arrangement> arrangements() {
  std::vector<Arrangement> all;
  add_places(all);
  add_depths(all);
  add_cameras(all);
  add_semantics(all);
  add_identities(all);
  return all;
}

Crowd crowd(const Arrangement& arrangement, std::size_t n, int k) {
  Crowd c;
  c.id = k;
  c.keypoints.assign(n, cv::KeyPoint(0, 0, 31, 0, 1, 0));
  put(c, k, [](std::size_t, std::size_t, Random& r) {
    const float x = r.within(30, kWidth_px - 10);
    return cv::Point2f(x, r.within(10, kHeight_px - 10));
  });
  Random random(13);
  c.descriptors = cv::Mat(static_cast<int>(n), 32, CV_8UC1);
  for (std::size_t i = 0; i < n; ++i) {
    for (int b = 0; b < 32; ++b)
      c.descriptors.at<std::uint8_t>(static_cast<int>(i), b) = static_cast<std::uint8_t>(random.bits());
    c.depth_m.push_back(random.within(1, 4));
    c.map_point_ids.push_back(static_cast<std::int64_t>(i));
    c.map_points.emplace_back(random.within(-2, 2), random.within(-1, 1), c.depth_m.back());
    c.match_index.push_back(static_cast<std::int32_t>(i));
    c.keypoints[i].octave = static_cast<int>(i % 8);
  }
  c.depth = cv::Mat(kHeight_px, kWidth_px, CV_16UC1);
  for (int y = 0; y < kHeight_px; ++y)
    for (int x = 0; x < kWidth_px; ++x)
      c.depth.at<std::uint16_t>(y, x) = static_cast<std::uint16_t>(1000 + 3 * x + 2 * y);
  if (arrangement.source == Source::Flow)
    c.grey = texture()(cv::Rect(static_cast<int>(kStep_px) * (k % 8), 0, kWidth_px, kHeight_px)).clone();
  c.camera.fx_px = c.camera.fy_px = 500;
  c.camera.cx_px = kWidth_px / 2.0, c.camera.cy_px = kHeight_px / 2.0;
  c.camera.width_px = kWidth_px, c.camera.height_px = kHeight_px;
  arrangement.change(c, k);
  if (arrangement.source != Source::Host) c.match_index.clear();
  return c;
}

}  // namespace crowds
