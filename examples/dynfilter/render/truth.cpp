// SPDX-License-Identifier: MIT
#include "render/truth.hpp"

#include <cmath>
#include <opencv2/imgproc.hpp>

namespace dynfilter::render {

void TruthMaker::make(const GeometryImage& scene, const std::vector<ItemTruth>& items,
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

inline void TruthMaker::judge(const ItemTruth& item, cv::Point at, double depth_m,
                              const Eigen::Isometry3d& T_world_camera,
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

inline void TruthMaker::blank_silhouettes(TruthImages& out) {
  outline_.create(out.labels.size(), CV_8UC1);
  outline_.setTo(0);
  for (int y = 0; y < outline_.rows; ++y) {
    for (int x = 0; x < outline_.cols; ++x) {
      const std::uint8_t label = out.labels.at<std::uint8_t>(y, x);
      for (const cv::Point next : {cv::Point(x + 1, y), cv::Point(x, y + 1)}) {
        if (next.x >= outline_.cols || next.y >= outline_.rows || out.labels.at<std::uint8_t>(next) == label)
          continue;
        outline_.at<std::uint8_t>(y, x) = outline_.at<std::uint8_t>(next) = 255;
      }
    }
  }
  const int side = 2 * rule_.band_px + 1;
  cv::dilate(outline_, band_, cv::getStructuringElement(cv::MORPH_ELLIPSE, {side, side}));
  out.dynamic.setTo(kTruthDontCare, band_);
}

}  // namespace dynfilter::render
