// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <dynfilter/cluster/cell_grid.hpp>
#include <dynfilter/cluster/clusters.hpp>
#include <dynfilter/cluster/density_clusters.hpp>
#include <dynfilter/cluster/depth_growth.hpp>
#include <dynfilter/core/camera.hpp>
#include <dynfilter/core/detection.hpp>
#include <dynfilter/core/span.hpp>
#include <dynfilter/mapping/box_body.hpp>
#include <dynfilter/mapping/map_frame.hpp>
#include <dynfilter/mapping/map_params.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace dynfilter::mapping {

/// Selects the pixels of a depth image that belong in a map. It removes:
///  - the mask of moving objects;
///  - detections of moving classes;
///  - dynamic features, clustered with DBSCAN and grown to depth pixels (Zhou et al. sec. 3.2.2);
///  - a rim around all of these;
///  - both sides of depth jumps, where a sensor measures points on neither surface.
/// Cost: linear in the pixels, about 0.6 ms for 640 x 480 without growth. Buffers are reused.
class DepthCut {
 public:
  explicit DepthCut(const CutParams& params = CutParams()) : params_(params) {}

  /// `depth_m`: CV_32FC1, 0: no depth, with the size of frame.depth.
  /// Pixels beyond `max_depth_m` are not usable.
  void run(const cv::Mat& depth_m, const MapFrame& frame, float max_depth_m = 1e6F);

  /// CV_8UC1, not 0: removed as moving, rim included.
  const cv::Mat& moving() const { return moving_; }
  /// CV_8UC1, 255: has depth and belongs in the map.
  const cv::Mat& usable() const { return usable_; }
  std::size_t pixels() const { return pixels_; }  ///< pixels with depth
  std::size_t cut_pixels() const { return cut_pixels_; }
  std::size_t edge_pixels() const { return edge_pixels_; }

 private:
  void add_mask(const cv::Mat& mask);

  void add_detection(const cv::Mat& depth_m, const Camera& camera, const Detection& detection);

  /// Also grows beyond the rim of the box without a depth jump, because an arm may reach out of it.
  /// Does not grow from the lower side, where the floor begins.
  void add_body(const cv::Mat& depth_m, const Camera& camera, const cv::Rect& box);

  void grow(const cv::Mat& depth_m, const Camera& camera, double reach_m,
            Span<const cv::Point2f> rivals = {});

  /// Features of a frame with depth, in 3-D and in pixels.
  struct Features {
    std::vector<cv::Point2f> px;
    std::vector<cv::Point3f> m;
  };

  void add_features(const cv::Mat& depth_m, const MapFrame& frame);
  static void locate(const cv::Mat& depth_m, const Camera& camera, Span<const cv::Point2f> pixels,
                     Features& out);

  /// Removes features with mostly opposite votes among the neighbours within the cluster radius.
  void outvote();
  template <class F>
  static void keep(Features& features, const F& kept);

  static void widen(cv::Mat& mask, int px) {
    if (px > 0) cv::dilate(mask, mask, cv::getStructuringElement(cv::MORPH_RECT, {2 * px + 1, 2 * px + 1}));
  }

  void find_edges(const cv::Mat& depth_m);
  void find_steps(const float* a, const float* b, int n);
  void mark_steps(int n, std::uint8_t* __restrict edge) const;

  void combine(const cv::Mat& depth_m, float max_depth_m);
  void combine_row(const float* __restrict z, const std::uint8_t* __restrict moves,
                   const std::uint8_t* __restrict edge, int n, float max_depth_m,
                   std::uint8_t* __restrict usable);

  CutParams params_;
  DepthGrowth growth_;
  BoxBody body_;
  GridDbscan dbscan_;
  Clusters clusters_;
  cv::Mat moving_, usable_, edges_, grown_, scaled_, in_box_;
  std::vector<std::uint8_t> steps_;  ///< of a row
  std::vector<cv::Point2f> seeds_;
  Features moving_features_, still_features_;
  dynfilter::detail::CellGrid neighbours_;
  std::vector<cv::Point3f> points_;
  std::vector<int> balance_;
  std::size_t pixels_ = 0, cut_pixels_ = 0, edge_pixels_ = 0;
};

}  // namespace dynfilter::mapping

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/mapping/detail/depth_cut-inl.hpp>
#endif
