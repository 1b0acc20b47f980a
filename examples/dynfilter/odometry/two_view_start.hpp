// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
#include <opencv2/core/eigen.hpp>
#include <optional>
#include <vector>

#include "feature_grid.hpp"
#include "frame_features.hpp"
#include "options.hpp"
#include "projection.hpp"
#include "triangulation.hpp"

namespace dynfilter::odometry {

/// The first map of a mono camera, from two views.
/// An essential matrix and a homography are fitted to the same matches. The one that explains more is
/// decomposed into motions. The motion with most points in front of both cameras wins (Mur-Artal et al., T-RO
/// 2015, sec. IV). Nothing is started if two motions do nearly as well, or if the points have little
/// parallax. Deterministic: OpenCV's RANSAC has a fixed seed.
class TwoViewStart {
 public:
  struct Point {
    std::int32_t reference;       ///< feature of the reference frame
    std::int32_t current;         ///< feature of the current frame, as it was extracted
    Eigen::Vector3d reference_m;  ///< in the frame of the reference camera
  };
  struct Start {
    FrameFeatures reference;
    std::int64_t reference_id = 0;
    Eigen::Isometry3d T_current_reference;
    std::vector<Point> points;
    int extracted = 0;    ///< features of the current frame
    bool planar = false;  ///< from the homography
  };

  TwoViewStart(const Pinhole& camera, const StartOptions& options) : camera_(camera), options_(options) {}

  /// Tries to start from the reference frame and this one. A frame with too few matches becomes the new
  /// reference. The median depth of the points is `options.median_depth`.
  std::optional<Start> add(std::int64_t frame_id, const FrameFeatures& features, cv::Size image) {
    if (reference_.size() == 0) {
      set_reference(frame_id, features);
      return std::nullopt;
    }
    grid_.build(features.keypoints_undistorted, image);
    match(features);
    if (static_cast<int>(pairs_.size()) < options_.min_matches) {
      set_reference(frame_id, features);
      return std::nullopt;
    }
    return solve(features);
  }

  void reset() { reference_ = FrameFeatures(); }

 private:
  struct Pair {
    std::int32_t reference, current;
  };
  struct Candidate {
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    std::vector<Point> points;
    double parallax_deg = 0;
  };

  void set_reference(std::int64_t frame_id, const FrameFeatures& features) {
    if (static_cast<int>(features.size()) < options_.min_matches) return reset();
    reference_ = features;
    reference_id_ = frame_id;
    expected_.clear();
    for (const cv::KeyPoint& keypoint : features.keypoints_undistorted) expected_.push_back(keypoint.pt);
  }

  /// Best descriptor within a window around the place where the feature was matched last.
  void match(const FrameFeatures& features) {
    struct Owner {
      std::int32_t reference = -1;
      int distance = 257;
    };
    std::vector<Owner> owner(features.size());
    for (std::size_t i = 0; i < reference_.size(); ++i) {
      std::int32_t best = -1;
      int least = 257, second = 257;
      grid_.visit(expected_[i].x, expected_[i].y, options_.radius_px, [&](std::int32_t k) {
        const cv::KeyPoint& keypoint = features.keypoints_undistorted[static_cast<std::size_t>(k)];
        if (std::abs(keypoint.octave - reference_.keypoints[i].octave) > 1) return;
        if (std::abs(keypoint.pt.x - expected_[i].x) > options_.radius_px) return;
        if (std::abs(keypoint.pt.y - expected_[i].y) > options_.radius_px) return;
        const int d = hamming(reference_.descriptors[i], features.descriptors[static_cast<std::size_t>(k)]);
        if (d < least) {
          second = least;
          least = d;
          best = k;
        } else if (d < second) {
          second = d;
        }
      });
      if (best < 0 || least > options_.max_distance || least > options_.max_ratio * second) continue;
      Owner& of = owner[static_cast<std::size_t>(best)];
      if (least < of.distance) of = {static_cast<std::int32_t>(i), least};
    }
    pairs_.clear();
    from_.clear(), to_.clear();
    for (std::size_t k = 0; k < owner.size(); ++k) {
      if (owner[k].reference < 0) continue;
      const auto i = static_cast<std::size_t>(owner[k].reference);
      pairs_.push_back({owner[k].reference, static_cast<std::int32_t>(k)});
      from_.push_back(reference_.keypoints_undistorted[i].pt);
      to_.push_back(features.keypoints_undistorted[k].pt);
      expected_[i] = to_.back();
    }
  }

  std::optional<Start> solve(const FrameFeatures& features) {
    const cv::Matx33d K(camera_.fx_px, 0, camera_.cx_px, 0, camera_.fy_px, camera_.cy_px, 0, 0, 1);
    const cv::Mat E = cv::findEssentialMat(from_, to_, K, cv::RANSAC, kConfidence, options_.ransac_px);
    const cv::Mat H = cv::findHomography(from_, to_, cv::RANSAC, options_.ransac_px);
    if (E.rows != 3 || H.empty()) return std::nullopt;
    const double score_F = score_of_lines(E), score_H = score_of_plane(H);
    const bool planar = score_H > options_.plane_share * (score_H + score_F);
    std::vector<Candidate> candidates;
    for (const Eigen::Isometry3d& T : planar ? motions_of_plane(H, K) : motions_of(E))
      candidates.push_back(judged(T, features));
    std::sort(candidates.begin(), candidates.end(),
              [](const Candidate& a, const Candidate& b) { return a.points.size() > b.points.size(); });
    if (candidates.empty()) return std::nullopt;
    const Candidate& best = candidates.front();
    const bool alone =
        candidates.size() < 2 || static_cast<double>(candidates[1].points.size()) <
                                     options_.max_rival_share * static_cast<double>(best.points.size());
    const bool enough = static_cast<int>(best.points.size()) >= options_.min_points;
    if (!alone || !enough || best.parallax_deg < options_.min_parallax_deg) return std::nullopt;
    Start start = scaled(best, planar);
    start.extracted = 1 + *std::max_element(features.extracted.begin(), features.extracted.end());
    return start;
  }

  /// Sum over matches of what an error leaves below the limit, in both images.
  double score_of_lines(const cv::Mat& E) const {
    Eigen::Matrix3d essential;
    cv::cv2eigen(E, essential);
    Eigen::Matrix3d K;
    K << camera_.fx_px, 0, camera_.cx_px, 0, camera_.fy_px, camera_.cy_px, 0, 0, 1;
    const Eigen::Matrix3d F = K.inverse().transpose() * essential * K.inverse();
    double score = 0;
    for (std::size_t i = 0; i < pairs_.size(); ++i) {
      const Eigen::Vector3d a(from_[i].x, from_[i].y, 1), b(to_[i].x, to_[i].y, 1);
      const Eigen::Vector3d line_b = F * a, line_a = F.transpose() * b;
      const double error = b.dot(line_b);
      score += rest(error * error / line_b.head<2>().squaredNorm(), kChi2Line) +
               rest(error * error / line_a.head<2>().squaredNorm(), kChi2Line);
    }
    return score;
  }
  double score_of_plane(const cv::Mat& plane) const {
    Eigen::Matrix3d H;
    cv::cv2eigen(plane, H);
    const Eigen::Matrix3d back = H.inverse();
    double score = 0;
    for (std::size_t i = 0; i < pairs_.size(); ++i) {
      const Eigen::Vector3d a(from_[i].x, from_[i].y, 1), b(to_[i].x, to_[i].y, 1);
      score += rest(((H * a).hnormalized() - b.head<2>()).squaredNorm(), kChi2Point) +
               rest(((back * b).hnormalized() - a.head<2>()).squaredNorm(), kChi2Point);
    }
    return score;
  }
  /// Both models share the point's limit, so that their scores compare.
  static double rest(double squared, double limit) { return squared < limit ? kChi2Point - squared : 0; }

  static std::vector<Eigen::Isometry3d> motions_of(const cv::Mat& E) {
    cv::Mat R1, R2, t;
    cv::decomposeEssentialMat(E, R1, R2, t);
    return {motion(R1, t), motion(R1, -t), motion(R2, t), motion(R2, -t)};
  }
  static std::vector<Eigen::Isometry3d> motions_of_plane(const cv::Mat& H, const cv::Matx33d& K) {
    std::vector<cv::Mat> R, t, normals;
    cv::decomposeHomographyMat(H, K, R, t, normals);
    std::vector<Eigen::Isometry3d> motions;
    for (std::size_t i = 0; i < R.size(); ++i)
      if (cv::norm(t[i]) > 0) motions.push_back(motion(R[i], t[i] / cv::norm(t[i])));
    return motions;
  }
  static Eigen::Isometry3d motion(const cv::Mat& R, const cv::Mat& t) {
    Eigen::Matrix3d rotation;
    Eigen::Vector3d translation;
    cv::cv2eigen(R, rotation);
    cv::cv2eigen(t, translation);
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    T.linear() = rotation;
    T.translation() = translation;
    return T;
  }

  Candidate judged(const Eigen::Isometry3d& T, const FrameFeatures& features) const {
    Candidate candidate;
    candidate.T = T;
    std::vector<double> cosines;
    for (std::size_t i = 0; i < pairs_.size(); ++i) {
      const Pair& pair = pairs_[i];
      const ViewOfPoint a{Eigen::Isometry3d::Identity(),
                          {from_[i].x, from_[i].y},
                          sigma_px(reference_.keypoints[static_cast<std::size_t>(pair.reference)].octave)};
      const ViewOfPoint b{T,
                          {to_[i].x, to_[i].y},
                          sigma_px(features.keypoints[static_cast<std::size_t>(pair.current)].octave)};
      const auto point = confirmed_point(camera_, a, b, kAnyParallax);
      if (!point) continue;
      candidate.points.push_back(
          {pair.reference, features.extracted[static_cast<std::size_t>(pair.current)], *point});
      cosines.push_back(cos_parallax(*point, a, b));
    }
    if (cosines.empty()) return candidate;
    // As in ORB-SLAM: that many points have more parallax.
    const std::size_t rank = std::min<std::size_t>(kParallaxRank, cosines.size() - 1);
    std::nth_element(cosines.begin(), cosines.begin() + static_cast<std::ptrdiff_t>(rank), cosines.end());
    candidate.parallax_deg = std::acos(std::clamp(cosines[rank], -1.0, 1.0)) * 180 / M_PI;
    return candidate;
  }
  double sigma_px(int octave) const { return std::pow(options_.scale_factor, octave); }

  Start scaled(const Candidate& best, bool planar) const {
    std::vector<double> depths;
    for (const Point& point : best.points) depths.push_back(point.reference_m.z());
    const auto middle = depths.begin() + static_cast<std::ptrdiff_t>(depths.size() / 2);
    std::nth_element(depths.begin(), middle, depths.end());
    const double scale = options_.median_depth / *middle;
    Start start;
    start.reference = reference_;
    start.reference_id = reference_id_;
    start.T_current_reference = best.T;
    start.T_current_reference.translation() *= scale;
    start.points = best.points;
    for (Point& point : start.points) point.reference_m *= scale;
    start.planar = planar;
    return start;
  }

  static constexpr double kConfidence = 0.999, kChi2Line = 3.841, kChi2Point = 5.991;
  static constexpr double kAnyParallax = 0.99998;  // 0.36 degrees: farther points have no reliable depth
  static constexpr std::size_t kParallaxRank = 50;

  Pinhole camera_;
  StartOptions options_;
  FrameFeatures reference_;
  std::int64_t reference_id_ = 0;
  std::vector<cv::Point2f> expected_;  ///< of the reference features, where they were matched last
  FeatureGrid grid_;
  std::vector<Pair> pairs_;
  std::vector<cv::Point2f> from_, to_;
};

}  // namespace dynfilter::odometry
