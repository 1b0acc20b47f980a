// SPDX-License-Identifier: MIT
#include <dynfilter/dense/dense_mask.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <dynfilter/cluster/clusters.hpp>
#include <map>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <utility>

namespace dynfilter {
namespace {

// Lengths are those of an image of 640x480.

/// Radius around a rejected feature of octave 0.
constexpr double kRadius_px = 8;
/// With depth the surface limits the mask, so discs reach further.
constexpr double kRadiusWithDepth_px = 48;
/// Radius around a kept feature that is not masked.
constexpr double kKeepRadius_px = 5;
/// Neighbours further apart than this are not of one group.
constexpr double kLink_px = 60;
/// Groups of fewer members are wrong matches.
constexpr int kLeastGroup = 4;
/// Depth difference to the nearest rejected feature: half a body, and the noise of a sensor, which grows.
constexpr double kSurface_m = 0.25, kSurface_share = 0.05;
/// Where either the feature or the pixel has no depth, the mask reaches only this far.
constexpr double kHole_px = 8;
/// Neighbours that a feature needs before they overrule its depth. An edge inside of a group counts twice.
constexpr std::size_t kLeastNeighbours = 3;
/// A feature at an outline may read the depth behind it. The nearest depth around it is the object's.
constexpr int kDepthPatch_px = 3;

using Corners = std::array<std::size_t, 3>;  ///< features

/// The Delaunay triangles between features.
std::vector<Corners> triangles_of(const std::vector<cv::KeyPoint>& keypoints, cv::Size size) {
  cv::Subdiv2D triangulation(cv::Rect({0, 0}, size));
  std::map<int, std::size_t> feature_of;  // by vertex
  for (std::size_t i = 0; i < keypoints.size(); ++i) feature_of[triangulation.insert(keypoints[i].pt)] = i;
  std::vector<cv::Vec6f> pixels;
  triangulation.getTriangleList(pixels);
  std::vector<Corners> triangles;
  for (const cv::Vec6f& t : pixels) {
    Corners corners{};
    std::size_t known = 0;
    for (const cv::Point2f p : {cv::Point2f(t[0], t[1]), cv::Point2f(t[2], t[3]), cv::Point2f(t[4], t[5])}) {
      int edge = 0, vertex = 0;
      triangulation.locate(p, edge, vertex);
      if (const auto found = feature_of.find(vertex); found != feature_of.end())
        corners[known++] = found->second;
    }
    if (known == 3) triangles.push_back(corners);
  }
  return triangles;
}

double scale_of(cv::Size size) {
  return std::hypot(size.width, size.height) / std::hypot(640, 480);
}

MaskedImageParams disc_params(double scale, double radius_px) {
  MaskedImageParams params;
  params.radius_px = std::min(radius_px * scale, MaskedImageParams::kMax_px);
  params.keep_radius_px = std::min(kKeepRadius_px * scale, MaskedImageParams::kMax_px);
  return params;
}

float metres_at(const DepthImage& depth, int x, int y) {
  const double units = depth.image.type() == CV_32FC1 ? static_cast<double>(depth.image.at<float>(y, x))
                                                      : depth.image.at<std::uint16_t>(y, x);
  return std::isfinite(units) && units > 0 ? static_cast<float>(units * depth.unit_m) : 0;
}

/// 0 without depth.
float nearest_metres(const DepthImage& depth, cv::Point p) {
  float nearest_m = 0;
  for (int y = std::max(0, p.y - kDepthPatch_px); y <= std::min(depth.image.rows - 1, p.y + kDepthPatch_px);
       ++y)
    for (int x = std::max(0, p.x - kDepthPatch_px); x <= std::min(depth.image.cols - 1, p.x + kDepthPatch_px);
         ++x) {
      const float z = metres_at(depth, x, y);
      if (z > 0 && (nearest_m == 0 || z < nearest_m)) nearest_m = z;
    }
  return nearest_m;
}

float tolerance_m(float depth_m) {
  return static_cast<float>(kSurface_m) + static_cast<float>(kSurface_share) * depth_m;
}

}  // namespace

DenseMask::DenseMask(MaskPolarity polarity) : polarity_(polarity) {}

const cv::Mat& DenseMask::image(Span<const cv::KeyPoint> keypoints, const Verdict& verdict,
                                const cv::Size& size, const DepthImage& depth) {
  const cv::Mat& mask = draw(keypoints, verdict, size, depth);
  if (polarity_ == MaskPolarity::NonzeroDrops) return mask;
  cv::bitwise_not(mask, inverted_);
  return inverted_;
}

const cv::Mat& DenseMask::depth(Span<const cv::KeyPoint> keypoints, const Verdict& verdict,
                                const DepthImage& depth) {
  MaskedImage::zero_depth(depth.image, draw(keypoints, verdict, depth.image.size(), depth), holes_);
  return holes_;
}

const cv::Mat& DenseMask::draw(Span<const cv::KeyPoint> keypoints, const Verdict& verdict,
                               const cv::Size& size, const DepthImage& depth) {
  if (size.empty()) return mask_ = cv::Mat();
  const bool has_depth =
      depth.image.size() == size && (depth.image.type() == CV_16UC1 || depth.image.type() == CV_32FC1);
  size_ = size, scale_ = scale_of(size);
  discs_ = MaskedImage(disc_params(scale_, has_depth ? kRadiusWithDepth_px : kRadius_px));
  split(keypoints, verdict);
  find_groups();
  discs_.mask(keypoints_, verdict_, size_).copyTo(mask_);
  leave_to_kept();
  for (const std::array<cv::Point, 3>& triangle : triangles_)
    cv::fillConvexPoly(mask_, triangle.data(), 3, cv::Scalar(255));
  if (has_depth) keep_surface(depth);
  return mask_;
}

void DenseMask::split(Span<const cv::KeyPoint> keypoints, const Verdict& verdict) {
  keypoints_.clear();
  verdict_.decision.clear();
  for (std::size_t i = 0; i < keypoints.size() && i < verdict.size(); ++i) {
    const cv::Point2f p = keypoints[i].pt;
    const bool inside = p.x >= 0 && p.y >= 0 && p.x < static_cast<float>(size_.width) &&
                        p.y < static_cast<float>(size_.height);
    const bool restored = i < verdict.restored.size() && verdict.restored[i] != 0;
    const Vote vote = restored ? Vote::Dynamic : verdict.decision[i];
    if (vote == Vote::Unknown || !inside) continue;
    keypoints_.push_back(keypoints[i]);
    keypoints_.back().octave = 0;  // its size says nothing about the object's
    verdict_.decision.push_back(vote);
  }
}

/// Groups of rejected features: neighbours in the triangulation that are near each other are of one group. A
/// group of a few is no object but wrong matches: its features are taken back.
/// Delaunay triangles have no feature inside, so one of a group covers no kept feature.
void DenseMask::find_groups() {
  const auto linked = [&](std::size_t i, std::size_t j) {
    return rejected(i) && rejected(j) && cv::norm(keypoints_[i].pt - keypoints_[j].pt) <= kLink_px * scale_;
  };
  links_.clear();
  detail::DisjointSets groups;
  groups.reset(keypoints_.size());
  std::vector<Corners> filled;
  for (const Corners& c : triangles_of(keypoints_, size_)) {
    const std::array<bool, 3> links{linked(c[0], c[1]), linked(c[1], c[2]), linked(c[2], c[0])};
    for (std::size_t k = 0; k < 3; ++k) {
      if (!links[k]) continue;
      groups.unite(static_cast<std::uint32_t>(c[k]), static_cast<std::uint32_t>(c[(k + 1) % 3]));
      links_.push_back({c[k], c[(k + 1) % 3]});
    }
    if (links[0] && links[1] && links[2]) filled.push_back(c);
  }
  std::vector<int> members(keypoints_.size(), 0);
  const auto group_of = [&](std::size_t i) { return groups.find(static_cast<std::uint32_t>(i)); };
  for (std::size_t i = 0; i < keypoints_.size(); ++i) ++members[group_of(i)];
  triangles_.clear();
  for (const Corners& c : filled)
    if (members[group_of(c[0])] >= kLeastGroup)
      triangles_.push_back({keypoints_[c[0]].pt, keypoints_[c[1]].pt, keypoints_[c[2]].pt});
  for (std::size_t i = 0; i < keypoints_.size(); ++i)
    if (rejected(i) && members[group_of(i)] < kLeastGroup) verdict_.decision[i] = Vote::Unknown;
}

bool DenseMask::rejected(std::size_t i) const {
  return verdict_.decision[i] == Vote::Dynamic;
}

/// 0 at the features of one decision, which is what distanceTransform() measures from.
const cv::Mat& DenseMask::seeds_of(Vote decision) {
  seeds_.create(size_, CV_8UC1);
  seeds_.setTo(255);
  for (std::size_t i = 0; i < keypoints_.size(); ++i)
    if (verdict_.decision[i] == decision) seeds_.at<std::uint8_t>(cv::Point(keypoints_[i].pt)) = 0;
  return seeds_;
}

/// Half of the way to a kept feature belongs to that.
void DenseMask::leave_to_kept() {
  cv::Mat& kept_px = nearest_;
  cv::distanceTransform(seeds_of(Vote::Dynamic), distance_px_, cv::DIST_L2, cv::DIST_MASK_5);
  cv::distanceTransform(seeds_of(Vote::Static), kept_px, cv::DIST_L2, cv::DIST_MASK_5);
  mask_.setTo(0, distance_px_ > kept_px);
}

/// Depth of each rejected feature [m], 0: unknown. One without depth, or behind most of its neighbours, is at
/// an outline: it gets theirs.
std::vector<float> DenseMask::depths_of_movers(const DepthImage& depth) const {
  std::vector<float> own_m(keypoints_.size(), 0);
  for (std::size_t i = 0; i < keypoints_.size(); ++i)
    if (rejected(i)) own_m[i] = nearest_metres(depth, cv::Point(keypoints_[i].pt));
  std::vector<std::vector<float>> around_m(keypoints_.size());
  for (const auto& [i, j] : links_)
    for (const auto& [self, other] : {std::pair(i, j), std::pair(j, i)})
      if (own_m[other] > 0) around_m[self].push_back(own_m[other]);
  std::vector<float> depths_m = own_m;
  for (std::size_t i = 0; i < keypoints_.size(); ++i) {
    std::vector<float>& around = around_m[i];
    if (around.empty()) continue;
    const auto middle = around.begin() + static_cast<std::ptrdiff_t>((around.size() - 1) / 2);
    std::nth_element(around.begin(), middle, around.end());
    const bool behind = around.size() >= kLeastNeighbours && own_m[i] > *middle + tolerance_m(*middle);
    if (own_m[i] == 0 || behind) depths_m[i] = *middle;
  }
  return depths_m;
}

void DenseMask::keep_surface(const DepthImage& depth) {
  if (cv::countNonZero(mask_) == 0) return;
  cv::distanceTransform(seeds_of(Vote::Dynamic), distance_px_, nearest_, cv::DIST_L2, cv::DIST_MASK_5,
                        cv::DIST_LABEL_PIXEL);
  const std::vector<float> depths_m = depths_of_movers(depth);
  std::vector<float> seed_m(keypoints_.size() + 2, 0);
  for (std::size_t i = 0; i < keypoints_.size(); ++i)
    if (rejected(i))
      seed_m[static_cast<std::size_t>(nearest_.at<int>(cv::Point(keypoints_[i].pt)))] = depths_m[i];
  for (int y = 0; y < size_.height; ++y) {
    for (int x = 0; x < size_.width; ++x) {
      if (mask_.at<std::uint8_t>(y, x) == 0) continue;
      const float here_m = metres_at(depth, x, y),
                  there_m = seed_m[static_cast<std::size_t>(nearest_.at<int>(y, x))];
      const bool other_surface =
          here_m > 0 && there_m > 0 && std::abs(here_m - there_m) > tolerance_m(there_m);
      const bool one_unknown =
          (here_m == 0) != (there_m == 0) && distance_px_.at<float>(y, x) > kHole_px * scale_;
      if (other_surface || one_unknown) mask_.at<std::uint8_t>(y, x) = 0;
    }
  }
}

}  // namespace dynfilter
