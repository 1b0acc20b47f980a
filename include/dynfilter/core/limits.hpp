// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>

/// Largest sizes that are accepted from outside. They are checked before memory is allocated for them.
/// docs/explanation/trust.md lists them with those of YAML texts, and says what happens beyond each.
namespace dynfilter::limits {

/// Boxes per frame. Detectors give at most 300.
inline constexpr std::size_t kMaxBoxes = 1000;

/// Boxes times features of a frame. A stage may compare each with each. 1000 boxes with 20,000 features, or
/// 200 with 100,000.
inline constexpr std::size_t kMaxBoxFeaturePairs = 20'000'000;

/// Features per frame. ORB-SLAM extracts 1000 to 5000, dense front ends about 20,000.
inline constexpr std::size_t kMaxFeatures = 100'000;

/// Features in a square of kCrowd_px: one per pixel. ORB-SLAM has one in three such squares.
/// 20,000 corners of cv::ORB, which crowds them, are 29 in the fullest square of 121 images.
inline constexpr std::size_t kMaxCrowd = 64;
inline constexpr int kCrowd_px = 8;

/// Candidates around the search window of a feature that is matched by its descriptor.
inline constexpr std::size_t kMaxWindow = 4096;

/// Width and height of an image [px].
inline constexpr int kMaxImageSide_px = 16'384;

/// Pixels of an image. Decoded in colour it takes 200 MB.
inline constexpr std::int64_t kMaxImagePixels = 64LL * 1024 * 1024;

/// Bytes of an image file.
inline constexpr std::size_t kMaxImageBytes = std::size_t{256} * 1024 * 1024;

/// Bytes of a line of a text file. A track of 50,000 frames takes that much.
inline constexpr std::size_t kMaxLineBytes = std::size_t{1024} * 1024;

/// Fields of a text file. Each takes 32 bytes of memory.
inline constexpr std::size_t kMaxTextFields = 20'000'000;

/// Bytes of a line of a provider program.
inline constexpr std::size_t kMaxMessageLineBytes = 4096;

/// Bytes of a provider program that belong to no image and are discarded.
inline constexpr std::size_t kMaxSurplusBytes = std::size_t{1024} * 1024;

}  // namespace dynfilter::limits

namespace dynfilter {

/// `later` - `earlier`, or the nearest number that there is: a host's ids may be any numbers.
constexpr std::int64_t id_gap(std::int64_t later, std::int64_t earlier) {
  constexpr auto kMost = static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max());
  const auto a = static_cast<std::uint64_t>(later), b = static_cast<std::uint64_t>(earlier);
  return later >= earlier ? static_cast<std::int64_t>(std::min(a - b, kMost))
                          : -static_cast<std::int64_t>(std::min(b - a, kMost));
}

}  // namespace dynfilter
