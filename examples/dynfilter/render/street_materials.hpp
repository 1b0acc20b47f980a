// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/core/random.hpp>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
#include <vector>

#include "render/paint.hpp"
#include "render/texture.hpp"

namespace dynfilter::render {

/// Pictures for streets and cars, painted from a seed. Each returns CV_8UC3.
namespace picture {

/// Worn asphalt with cracks and patches, repeating.
cv::Mat asphalt(Random& r);

/// Concrete slabs, repeating.
cv::Mat paving(Random& r);

/// The front of a house, floors of windows above a ground floor with a door or a shop.
cv::Mat facade(Random& r);

/// Leaves from some metres away, repeating.
cv::Mat foliage(Random& r);

cv::Mat bark(Random& r);

/// Clouds above a horizon, which is the lower edge.
cv::Mat sky(Random& r);

/// A traffic sign or a shop's sign.
cv::Mat sign(Random& r);

/// The lower side of a car, its front to the right: doors, handles, wheel arches.
cv::Mat car_side(Random& r, const cv::Scalar& paint);

/// The side windows of a car.
cv::Mat car_windows(Random& r);

/// Windscreen or rear window, with what it reflects.
cv::Mat car_glass(Random& r);

cv::Mat car_front(Random& r, const cv::Scalar& paint);

cv::Mat car_rear(Random& r, const cv::Scalar& paint);

/// Bonnet and roof.
cv::Mat car_top(Random& r, const cv::Scalar& paint);

cv::Mat wheel(Random& r);

/// The whole side of a bus, with an advertisement.
cv::Mat bus_side(Random& r, const cv::Scalar& paint);

}  // namespace picture

/// Materials of one make of car.
struct CarPaint {
  int side, windows, glass, front, rear, top, wheel, tyre, shadow;

  CarPaint(MaterialSet& set, Random& r);
};

/// Materials of everything in a street but cars.
struct StreetMaterials {
  int asphalt, paving, kerb, marking, bark, sky, sky_top, metal, roof, plain_wall;
  std::vector<int> facades, foliage, signs;

  StreetMaterials(MaterialSet& set, Random& r);
};

}  // namespace dynfilter::render
