// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <dynfilter/synth/rasteriser.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace dynfilter::synth {

constexpr std::uint8_t kTruthStatic = 0, kTruthDontCare = 128, kTruthDynamic = 255;

/// Definition of dynamic.
struct TruthRule {
  double min_motion_m = 0.010;  ///< motion of the surface point over `window_s`
  double min_miss_px = 1.0;     ///< error of the static prediction
  double window_s = 5 / 30.0;
  int band_px = 5;  ///< band around the silhouettes of movers that is don't care
};

/// A drawn item that may move. Item 0 contains all static objects.
struct ItemTruth {
  std::uint8_t label = 0;  ///< number of the mover, from 1
  bool person = false;
  Eigen::Isometry3d last_from_now =
      Eigen::Isometry3d::Identity();  ///< world point now -> its position one frame ago
  Eigen::Isometry3d window_from_now = Eigen::Isometry3d::Identity();  ///< the same one window ago
};

struct TruthImages {
  cv::Mat labels;  ///< CV_8UC1, 0 static, k = mover k
  /// CV_16UC1, 3-D displacement of the surface point since the last frame, 0.1 mm.
  cv::Mat motion;
  cv::Mat dynamic;  ///< CV_8UC1, kTruthStatic, kTruthDontCare or kTruthDynamic
  cv::Mat person;   ///< CV_8UC1, 255 on people
};

/// Computes the truth of one image. `T_world_camera`: current pose of the camera.
class TruthMaker {
 public:
  TruthMaker(const Camera& camera, const TruthRule& rule) : camera_(camera), rule_(rule) {}

  void make(const GeometryImage& scene, const std::vector<ItemTruth>& items,
            const Eigen::Isometry3d& T_world_camera, TruthImages& out) {
    const cv::Size size = scene.depth_m.size();
    for (cv::Mat* image : {&out.labels, &out.dynamic, &out.person}) {
      image->create(size, CV_8UC1);
      image->setTo(0);
    }
    out.motion.create(size, CV_16UC1);
    out.motion.setTo(0);
    const Eigen::Isometry3d T_camera_world = T_world_camera.inverse();
    for (int y = 0; y < size.height; ++y) {
      for (int x = 0; x < size.width; ++x) {
        const ItemTruth& item = items[scene.item.at<std::uint16_t>(y, x)];
        if (item.label != 0)
          judge(item, {x, y}, scene.depth_m.at<float>(y, x), T_world_camera, T_camera_world, out);
      }
    }
    blank_silhouettes(out);
  }

 private:
  void judge(const ItemTruth& item, cv::Point at, double depth_m, const Eigen::Isometry3d& T_world_camera,
             const Eigen::Isometry3d& T_camera_world, TruthImages& out) const {
    out.labels.at<std::uint8_t>(at) = item.label;
    out.person.at<std::uint8_t>(at) = item.person ? 255 : 0;
    const Eigen::Vector3d ray((at.x - camera_.cx_px) / camera_.fx_px, (at.y - camera_.cy_px) / camera_.fy_px,
                              1);
    const Eigen::Vector3d now = T_world_camera * (depth_m * ray).eval();
    const Eigen::Vector3d then = item.window_from_now * now;
    out.motion.at<std::uint16_t>(at) =
        cv::saturate_cast<std::uint16_t>(1e4 * (now - item.last_from_now * now).norm());
    const Eigen::Vector3d seen = T_camera_world * then;
    const double dx = camera_.fx_px * seen.x() / seen.z() + camera_.cx_px - at.x;
    const double dy = camera_.fy_px * seen.y() / seen.z() + camera_.cy_px - at.y;
    const bool misses = seen.z() <= 0 || std::hypot(dx, dy) > rule_.min_miss_px;
    const bool moved = (now - then).norm() > rule_.min_motion_m;
    out.dynamic.at<std::uint8_t>(at) = moved && misses ? kTruthDynamic : kTruthDontCare;
  }

  void blank_silhouettes(TruthImages& out) {
    outline_.create(out.labels.size(), CV_8UC1);
    outline_.setTo(0);
    for (int y = 0; y < outline_.rows; ++y) {
      for (int x = 0; x < outline_.cols; ++x) {
        const std::uint8_t label = out.labels.at<std::uint8_t>(y, x);
        for (const cv::Point next : {cv::Point(x + 1, y), cv::Point(x, y + 1)}) {
          if (next.x >= outline_.cols || next.y >= outline_.rows ||
              out.labels.at<std::uint8_t>(next) == label)
            continue;
          outline_.at<std::uint8_t>(y, x) = outline_.at<std::uint8_t>(next) = 255;
        }
      }
    }
    const int side = 2 * rule_.band_px + 1;
    cv::dilate(outline_, band_, cv::getStructuringElement(cv::MORPH_ELLIPSE, {side, side}));
    out.dynamic.setTo(kTruthDontCare, band_);
  }

  Camera camera_;
  TruthRule rule_;
  cv::Mat outline_, band_;
};

}  // namespace dynfilter::synth
