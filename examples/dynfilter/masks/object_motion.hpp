// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <vector>

#include "masks/object_track.hpp"

namespace dynfilter::masks {

/// Whether an object moves in each of its sightings, by vote of its features around that time.
std::vector<bool> moving_in(const ObjectTrack& track);

/// True if the object moves at some time of the clip.
bool is_mover(const ObjectTrack& track);

/// Whether the object is masked in each of its sightings: a mover in all of them.
/// With `until_static_s` it is not masked once it has stood for this long, until it moves again.
std::vector<bool> masked_in(const ObjectTrack& track, std::optional<double> until_static_s = std::nullopt);

}  // namespace dynfilter::masks
