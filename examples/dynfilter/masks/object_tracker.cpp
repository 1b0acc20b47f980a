// SPDX-License-Identifier: MIT
#include "masks/object_tracker.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "masks/object_look.hpp"

namespace dynfilter::masks {
namespace {

/// Points that are followed on each object, at most.
constexpr int kPoints = 64;
/// Points of the background, a grid of this many columns and rows.
constexpr int kGrid = 12;
/// Fewer points tell no motion.
constexpr std::size_t kLeastPoints = 4;
/// With fewer of its points left, an object is hidden.
constexpr double kVisible_share = 0.5;
/// A point further than this share of the object's size from the others' motion has left the object.
constexpr double kAstray_share = 0.15;
/// Change of size from one image to the next, at most.
constexpr float kMostScale = 1.15F;
/// Weight of the last image in the object's velocity.
constexpr float kNewDrift = 0.4F;

/// A carried mask and an instance that share less are not the same object.
constexpr double kSame_iou = 0.3;
/// Detectors take cars for trucks. Objects of different classes share at least this.
constexpr double kOtherClass_iou = 0.5;

/// An object that is hidden for longer is a new one when it comes back.
constexpr double kMostHidden_s = 2.0;
/// Without the detector a mask is carried for at most this time: it loses its outline.
constexpr double kMostCarried_s = 0.5;
/// How far from the expected place a hidden object is recognised, in its own size: at once, and for each
/// second that it was hidden.
constexpr double kReach = 0.6, kReachPerS = 0.4;
/// Most ratio of the areas of a hidden object before and after: part of it may still be hidden.
constexpr double kMostAreaRatio = 3;
/// Bhattacharyya distance of the colours, at most.
constexpr double kMostLookDistance = 0.35;

/// A feature near the outline may be one of the background.
constexpr int kInside_px = 2;
/// The patch of a feature so near to another object may have moved with that.
constexpr int kClear_px = 12;

template <class T>
T median_of(std::vector<T> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

cv::Point2f median_of(const std::vector<cv::Point2f>& shifts) {
  std::vector<float> x, y;
  for (const cv::Point2f& s : shifts) x.push_back(s.x), y.push_back(s.y);
  return {median_of(std::move(x)), median_of(std::move(y))};
}

double size_of(const RunMask& mask) {
  return std::hypot(mask.box().width, mask.box().height);
}
cv::Point2d middle_of(const RunMask& mask) {
  return cv::Point2d(mask.box().tl() + mask.box().br()) / 2;
}

/// Points spread over a mask: a grid, so that a smooth car has some, too.
std::vector<cv::Point2f> points_on(const RunMask& mask) {
  const int step = std::max(2, cvRound(std::sqrt(static_cast<double>(mask.area()) / kPoints)));
  std::vector<cv::Point2f> points;
  for (int y = mask.box().y + step / 2; y < mask.box().br().y; y += step)
    for (int x = mask.box().x + step / 2; x < mask.box().br().x; x += step)
      if (mask.contains({x, y})) points.emplace_back(static_cast<float>(x), static_cast<float>(y));
  return points;
}

bool well_inside(const RunMask& mask, const cv::Point2f& pixel) {
  const cv::Point p(cvRound(pixel.x), cvRound(pixel.y));
  for (const cv::Point by : {cv::Point(kInside_px, 0), cv::Point(-kInside_px, 0), cv::Point(0, kInside_px),
                             cv::Point(0, -kInside_px)})
    if (!mask.contains(p + by)) return false;
  return true;
}

/// How many instances there are at each pixel or nearer than kClear_px.
cv::Mat neighbourhoods(const std::vector<Instance>& instances, cv::Size size) {
  cv::Mat count = cv::Mat::zeros(size, CV_8UC1), one;
  const cv::Mat disc = cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * kClear_px + 1, 2 * kClear_px + 1});
  for (const Instance& instance : instances) {
    const cv::Rect box = instance.mask.box();
    const cv::Rect area = cv::Rect(box.x - kClear_px, box.y - kClear_px, box.width + 2 * kClear_px,
                                   box.height + 2 * kClear_px) &
                          cv::Rect({0, 0}, size);
    if (box.empty() || area.empty()) continue;
    one = cv::Mat::zeros(size, CV_8UC1);
    instance.mask.paint(one, 1);
    cv::dilate(one(area), one(area), disc);
    count(area) += one(area);
  }
  return count;
}

/// `near`: of all instances, see neighbourhoods().
Sighting sighting_of(const TrackedImage& image, const RunMask& mask, const cv::Mat& near) {
  Sighting sighting{image.frame, image.time_s, mask};
  for (const JudgedFeature& feature : image.features) {
    if (feature.decision == Vote::Unknown || !well_inside(mask, feature.keypoint.pt)) continue;
    if (near.at<std::uint8_t>(cv::Point(feature.keypoint.pt)) > 1) continue;
    ++sighting.judged;
    sighting.dynamic += feature.decision == Vote::Dynamic ? 1 : 0;
  }
  return sighting;
}

}  // namespace

void ObjectTracker::add(const TrackedImage& image) {
  flow_.build(image.grey, now_);
  follow(image);
  std::vector<cv::Mat> looks;
  for (const Instance& instance : image.instances) looks.push_back(look_of(image.colour, instance.mask));
  near_ = neighbourhoods(image.instances, image.grey.size());
  std::vector<bool> seen(active_.size(), false), taken(image.instances.size(), false);
  for (const Match& match : candidates(image, looks)) {
    if (seen[match.active] || taken[match.instance]) continue;
    seen[match.active] = taken[match.instance] = true;
    see(active_[match.active], image, image.instances[match.instance], looks[match.instance]);
  }
  for (std::size_t i = 0; i < seen.size(); ++i)
    if (!seen[i]) miss(active_[i], image);
  for (std::size_t i = 0; i < taken.size(); ++i)
    if (!taken[i]) begin(image, image.instances[i], looks[i]);
  forget_old(image.time_s);
  std::swap(last_, now_);
  last_s_ = image.time_s;
}

std::vector<ObjectTrack> ObjectTracker::finish() {
  for (Active& object : active_) {
    auto& sightings = tracks_[object.track].sightings;
    sightings.insert(sightings.end(), object.pending.begin(), object.pending.end());
  }
  active_.clear();
  last_ = ImagePyramid();
  return std::exchange(tracks_, {});
}

void ObjectTracker::follow(const TrackedImage& image) {
  if (last_.empty() || active_.empty()) return;
  cv::Mat covered = cv::Mat::zeros(image.grey.size(), CV_8UC1);
  for (const Active& object : active_) object.mask.paint(covered);
  background_.clear();
  for (int j = 0; j < kGrid; ++j) {
    for (int i = 0; i < kGrid; ++i) {
      const cv::Point p((2 * i + 1) * covered.cols / (2 * kGrid), (2 * j + 1) * covered.rows / (2 * kGrid));
      if (covered.at<std::uint8_t>(p) == 0) background_.emplace_back(p);
    }
  }
  points_ = background_;
  for (const Active& object : active_)
    points_.insert(points_.end(), object.points.begin(), object.points.end());
  flow_.track(last_, now_, points_, {}, flowed_);
  const cv::Point2f background_px = background_shift();
  std::size_t first_point = background_.size();
  for (Active& object : active_) {
    const std::size_t count = object.points.size();
    carry(object, first_point, background_px, image.time_s - last_s_, image.grey.size());
    first_point += count;
  }
}

cv::Point2f ObjectTracker::background_shift() const {
  std::vector<cv::Point2f> shifts;
  for (std::size_t i = 0; i < background_.size(); ++i)
    if (flowed_.found[i] != 0) shifts.push_back(flowed_.reference_px[i] - points_[i]);
  return shifts.size() < kLeastPoints ? cv::Point2f() : median_of(shifts);
}

void ObjectTracker::carry(Active& object, std::size_t first_point, cv::Point2f background_px, double dt_s,
                          cv::Size size) {
  std::vector<cv::Point2f> from, shifts;
  for (std::size_t i = first_point; i < first_point + object.points.size(); ++i) {
    if (flowed_.found[i] == 0) continue;
    from.push_back(points_[i]);
    shifts.push_back(flowed_.reference_px[i] - points_[i]);
  }
  object.points.clear();
  const auto dt = static_cast<float>(dt_s);
  const auto move_on_hidden = [&] {
    object.points.clear();
    object.mask = object.mask.moved(background_px + object.drift_px_per_s * dt, 1, size);
  };
  if (shifts.size() < kLeastPoints) return move_on_hidden();
  const cv::Point2f shift = median_of(shifts);
  const auto middle = cv::Point2f(middle_of(object.mask));
  std::vector<float> scales;
  for (std::size_t i = 0; i < from.size(); ++i) {
    if (cv::norm(shifts[i] - shift) > kAstray_share * size_of(object.mask)) continue;
    object.points.push_back(from[i] + shifts[i]);
    const cv::Point2f before = from[i] - middle, after = before + shifts[i] - shift;
    if (before.dot(before) > 4) scales.push_back(std::sqrt(after.dot(after) / before.dot(before)));
  }
  if (static_cast<double>(object.points.size()) <
      kVisible_share * static_cast<double>(object.points_when_seen))
    return move_on_hidden();
  const float scale = scales.empty() ? 1 : std::clamp(median_of(scales), 1 / kMostScale, kMostScale);
  object.mask = object.mask.moved(shift, scale, size);
  if (dt > 0) object.drift_px_per_s += kNewDrift * ((shift - background_px) / dt - object.drift_px_per_s);
}

std::vector<ObjectTracker::Match> ObjectTracker::candidates(const TrackedImage& image,
                                                            const std::vector<cv::Mat>& looks) const {
  std::vector<Match> found;
  for (std::size_t a = 0; a < active_.size(); ++a) {
    for (std::size_t i = 0; i < image.instances.size(); ++i) {
      const double score = score_of(active_[a], image.instances[i], looks[i], image.time_s);
      if (score > 0) found.push_back({score, a, i});
    }
  }
  std::stable_sort(found.begin(), found.end(),
                   [](const Match& a, const Match& b) { return a.score > b.score; });
  return found;
}

/// Overlap of an object that is followed, plus 1, so that it goes before one that was hidden.
double ObjectTracker::score_of(const Active& object, const Instance& instance, const cv::Mat& look,
                               double now_s) const {
  const bool same_class = tracks_[object.track].class_name == instance.class_name;
  const double iou = object.mask.intersection_over_union(instance.mask);
  if (!object.points.empty()) return iou >= (same_class ? kSame_iou : kOtherClass_iou) ? 1 + iou : 0;
  if (!same_class || object.mask.empty()) return 0;
  const double far_px = cv::norm(middle_of(object.mask) - middle_of(instance.mask));
  const double reach = (kReach + kReachPerS * (now_s - object.seen_s)) * size_of(object.mask);
  const double ratio = static_cast<double>(object.mask.area()) / instance.mask.area();
  if (far_px > reach || ratio > kMostAreaRatio || ratio < 1 / kMostAreaRatio) return 0;
  const double distance = look_distance(object.look, look);
  return distance > kMostLookDistance ? 0 : (1 - distance) * (1 - 0.5 * far_px / reach);
}

void ObjectTracker::see(Active& object, const TrackedImage& image, const Instance& instance,
                        const cv::Mat& look) {
  auto& sightings = tracks_[object.track].sightings;
  sightings.insert(sightings.end(), object.pending.begin(), object.pending.end());
  object.pending.clear();
  sightings.push_back(sighting_of(image, instance.mask, near_));
  if (object.points.empty()) sightings.back().dynamic = sightings.back().judged = 0;
  object.mask = instance.mask;
  object.points = points_on(object.mask);
  object.points_when_seen = object.points.size();
  object.seen_s = image.time_s;
  blend_look(object.look, look);
}

/// A mask is carried while the object is visible. One that is hidden covers nothing.
void ObjectTracker::miss(Active& object, const TrackedImage& image) {
  if (object.points.empty() || object.mask.empty() || image.time_s - object.seen_s > kMostCarried_s) return;
  Sighting carried{image.frame, image.time_s, object.mask};
  carried.carried = true;
  object.pending.push_back(std::move(carried));
}

void ObjectTracker::begin(const TrackedImage& image, const Instance& instance, const cv::Mat& look) {
  Active object;
  object.track = tracks_.size();
  object.look = look;
  tracks_.push_back({instance.class_name, {}});
  see(object, image, instance, look);
  active_.push_back(std::move(object));
}

void ObjectTracker::forget_old(double now_s) {
  active_.erase(
      std::remove_if(active_.begin(), active_.end(),
                     [&](const Active& a) { return a.mask.empty() || now_s - a.seen_s > kMostHidden_s; }),
      active_.end());
}

}  // namespace dynfilter::masks
