// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <dynfilter/core/camera.hpp>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
#include <vector>

#include "render/rasteriser.hpp"

namespace dynfilter::render {

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
            const Eigen::Isometry3d& T_world_camera, TruthImages& out);

 private:
  void judge(const ItemTruth& item, cv::Point at, double depth_m, const Eigen::Isometry3d& T_world_camera,
             const Eigen::Isometry3d& T_camera_world, TruthImages& out) const;

  void blank_silhouettes(TruthImages& out);

  Camera camera_;
  TruthRule rule_;
  cv::Mat outline_, band_;
};

}  // namespace dynfilter::render
