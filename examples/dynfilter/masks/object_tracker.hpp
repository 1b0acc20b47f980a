// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <dynfilter/correspondence/correspondences.hpp>
#include <dynfilter/correspondence/flow.hpp>
#include <dynfilter/correspondence/image_pyramid.hpp>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
#include <vector>

#include "masks/instances.hpp"
#include "masks/object_track.hpp"
#include "masks/run_mask.hpp"

namespace dynfilter::masks {

/// What the tracker sees of one image.
struct TrackedImage {
  std::size_t frame = 0;
  double time_s = 0;
  cv::Mat colour;  ///< CV_8UC3
  cv::Mat grey;    ///< CV_8UC1
  std::vector<Instance> instances;
  std::vector<JudgedFeature> features;
};

/// Follows objects through a clip.
/// The mask of each object is carried to the next image by the flow of points on it. The instance there that
/// overlaps it most is the same object. An object that is hidden moves on as it did, relative to the
/// background. It is recognised by place, class, size and colours.
class ObjectTracker {
 public:
  /// Images in the order of time, of one size.
  void add(const TrackedImage& image);

  /// All objects, in the order in which they appeared. The tracker is then empty.
  std::vector<ObjectTrack> finish();

 private:
  /// An object that is in the picture, or was a moment ago.
  struct Active {
    std::size_t track = 0;
    RunMask mask;                     ///< where it is now
    std::vector<cv::Point2f> points;  ///< on it, followed since it was last seen; empty: hidden
    std::size_t points_when_seen = 0;
    cv::Point2f drift_px_per_s;     ///< against the background
    double seen_s = 0;              ///< by the detector
    cv::Mat look;                   ///< histogram of its colours
    std::vector<Sighting> pending;  ///< carried masks, valid if it is seen again
  };
  struct Match {
    double score = 0;
    std::size_t active = 0, instance = 0;
  };

  void follow(const TrackedImage& image);
  cv::Point2f background_shift() const;
  void carry(Active& object, std::size_t first_point, cv::Point2f background_px, double dt_s, cv::Size size);

  std::vector<Match> candidates(const TrackedImage& image, const std::vector<cv::Mat>& looks) const;
  double score_of(const Active& object, const Instance& instance, const cv::Mat& look, double now_s) const;

  void see(Active& object, const TrackedImage& image, const Instance& instance, const cv::Mat& look);
  void miss(Active& object, const TrackedImage& image);
  void begin(const TrackedImage& image, const Instance& instance, const cv::Mat& look);
  void forget_old(double now_s);

  cv::Mat near_;  ///< number of instances at or near each pixel of the image
  FlowTracker flow_{FlowParams::guided()};
  ImagePyramid last_, now_;
  double last_s_ = 0;
  std::vector<cv::Point2f> background_;  ///< points of the last image that are on no object
  std::vector<cv::Point2f> points_;      ///< of the last image: `background_`, then those of each object
  Correspondences flowed_;
  std::vector<Active> active_;
  std::vector<ObjectTrack> tracks_;
};

}  // namespace dynfilter::masks
