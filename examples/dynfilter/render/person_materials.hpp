// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/core/random.hpp>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>

#include "render/paint.hpp"
#include "render/texture.hpp"

namespace dynfilter::render {

/// Clothes and skin, painted from a seed. Each returns a CV_8UC3 picture that repeats seamlessly.
namespace cloth {

/// A typical colour of clothes: any hue, rarely saturated.
cv::Scalar dye(Random& r, double darkest, double lightest);

/// Soft folds, more across the body than along it.
void fold(cv::Mat& out, Random& r, double depth);

cv::Mat plaid(Random& r);

cv::Mat stripes(Random& r);

cv::Mat printed(Random& r);

cv::Mat camouflage(Random& r);

cv::Mat denim(Random& r);

cv::Mat skin(Random& r, const cv::Scalar& tone);

inline cv::Mat hair(Random& r, const cv::Scalar& tone) {
  return ramp(fractal_noise({256, 256}, {40, 3}, 4, 0.75, r), tone * 0.45, tone * 1.7, 2.2);
}

cv::Mat shoe(Random& r);

/// The head unrolled: the face is around u = 0.5; v = 0 is the crown, 1 the chin.
cv::Mat face(Random& r, const cv::Scalar& tone, const cv::Scalar& hair_tone, bool beard, bool glasses);

}  // namespace cloth

/// Clothes of one person.
struct Outfit {
  int shirt, trousers, skin, face, hair, shoe, belt;
  bool long_sleeves;

  Outfit(MaterialSet& set, Random& r);
};

}  // namespace dynfilter::render
