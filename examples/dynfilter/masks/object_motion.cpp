// SPDX-License-Identifier: MIT
#include "masks/object_motion.hpp"

#include <algorithm>
#include <cstddef>

namespace dynfilter::masks {
namespace {

/// Features vote together over this time: a small object has few of them in one image.
constexpr double kVote_s = 0.5;
/// Fewer votes decide nothing.
constexpr int kLeastVotes = 6;
/// Share of the votes that makes an object a moving one. A parked one has votes at its outline, where its
/// features slide over the background.
constexpr double kMoving_share = 0.5;
/// An object that moves for less than this in all is a parked one with a few wrong votes.
constexpr double kLeastMoving_s = 0.5;
/// A track that is shorter moves for at least this share of it.
constexpr double kLeastMoving_share = 0.5;

double duration_s(const ObjectTrack& track) {
  return track.sightings.empty() ? 0 : track.sightings.back().time_s - track.sightings.front().time_s;
}

/// Time that the object moves. A sighting counts for the time to the next one.
double moving_s(const ObjectTrack& track, const std::vector<bool>& moving) {
  double sum_s = 0;
  for (std::size_t k = 0; k + 1 < track.sightings.size(); ++k)
    if (moving[k]) sum_s += track.sightings[k + 1].time_s - track.sightings[k].time_s;
  return sum_s;
}

bool is_mover(const ObjectTrack& track, const std::vector<bool>& moving) {
  if (std::none_of(moving.begin(), moving.end(), [](bool m) { return m; })) return false;
  return moving_s(track, moving) >= std::min(kLeastMoving_s, kLeastMoving_share * duration_s(track));
}

}  // namespace

std::vector<bool> moving_in(const ObjectTrack& track) {
  const std::vector<Sighting>& all = track.sightings;
  std::vector<bool> moving;
  std::size_t first = 0, behind = 0;
  int dynamic = 0, judged = 0;  // of the sightings from `first` to `behind`
  for (const Sighting& now : all) {
    for (; behind < all.size() && all[behind].time_s <= now.time_s + kVote_s / 2; ++behind)
      dynamic += all[behind].dynamic, judged += all[behind].judged;
    for (; all[first].time_s < now.time_s - kVote_s / 2; ++first)
      dynamic -= all[first].dynamic, judged -= all[first].judged;
    moving.push_back(judged >= kLeastVotes && dynamic >= kMoving_share * judged);
  }
  return moving;
}

bool is_mover(const ObjectTrack& track) {
  return is_mover(track, moving_in(track));
}

std::vector<bool> masked_in(const ObjectTrack& track, std::optional<double> until_static_s) {
  const std::vector<bool> moving = moving_in(track);
  std::vector<bool> masked(moving.size(), is_mover(track, moving));
  if (!until_static_s || masked.empty() || !masked.front()) return masked;
  double stands_since_s = track.sightings.front().time_s;
  for (std::size_t k = 0; k < masked.size(); ++k) {
    const double now_s = track.sightings[k].time_s;
    if (moving[k]) stands_since_s = now_s;
    masked[k] = moving[k] || now_s - stands_since_s < *until_static_s;
  }
  return masked;
}

}  // namespace dynfilter::masks
