// SPDX-License-Identifier: MIT
#include "render/person_materials.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace dynfilter::render {

namespace cloth {

cv::Scalar dye(Random& r, double darkest, double lightest) {
  const double grey = r.uniform(darkest, lightest), loud = r.uniform(0.05, 0.5),
               hue = r.uniform(0, 2 * CV_PI);
  cv::Scalar out;
  for (int c = 0; c < 3; ++c) out[c] = std::min(250.0, grey * (1 + loud * std::cos(hue + 2.094 * c)));
  return out;
}

void fold(cv::Mat& out, Random& r, double depth) {
  shade_by(out, fractal_noise(out.size(), {3, 6}, 3, 0.55, r), depth);
  shade_by(out, fractal_noise(out.size(), {64, 64}, 2, 0.8, r), 0.16);
}

cv::Mat plaid(Random& r) {
  const cv::Scalar base = dye(r, 110, 210);
  cv::Mat out(512, 512, CV_8UC3, base);
  const int count = 7 + r.below(4);
  const cv::Scalar bands[3] = {dye(r, 25, 70), dye(r, 40, 200), dye(r, 150, 235)};
  for (int axis = 0; axis < 2; ++axis) {
    for (int i = 0; i < count; ++i) {
      const int at = 512 * i / count + r.below(12), width = 12 + r.below(24);
      cv::Mat overlay = out.clone();
      const cv::Rect band = axis ? cv::Rect(at, 0, width, 512) : cv::Rect(0, at, 512, width);
      cv::rectangle(overlay, band, bands[i % 3], cv::FILLED);
      cv::addWeighted(out, 0.38, overlay, 0.62, 0, out);
      const cv::Rect line = axis ? cv::Rect(at + width + 8, 0, 4, 512) : cv::Rect(0, at + width + 8, 512, 4);
      cv::rectangle(out, line, r.chance(0.5) ? bgr(236, 230, 214) : bgr(28, 26, 34), cv::FILLED);
    }
  }
  fold(out, r, 0.5);
  return out;
}

cv::Mat stripes(Random& r) {
  cv::Mat out(512, 512, CV_8UC3, dye(r, 170, 225));
  const cv::Scalar dark = dye(r, 25, 80), accent = dye(r, 70, 150);
  for (int y = 0; y < 512; y += 64) {
    cv::rectangle(out, {0, y, 512, 26}, dark, cv::FILLED);
    cv::rectangle(out, {0, y + 38, 512, 6}, accent, cv::FILLED);
  }
  for (int i = 0; i < 60; ++i) {
    const int y = 64 * r.below(8) + 48, x = r.below(490);
    const cv::Scalar colour = r.chance(0.5) ? dark : accent;
    cv::rectangle(out, cv::Rect(x, y, 6 + r.below(12), 8), colour, cv::FILLED);
  }
  fold(out, r, 0.5);
  return out;
}

cv::Mat printed(Random& r) {
  const bool dark = r.chance(0.6);
  cv::Mat out(512, 512, CV_8UC3, dark ? dye(r, 35, 80) : dye(r, 150, 215));
  for (int i = 0; i < 70; ++i) {
    const cv::Scalar ink = dark ? dye(r, 130, 235) : dye(r, 20, 100);
    const cv::Point p = cv::Point(30, 30) + r.below(cv::Size(430, 450));
    const int kind = r.below(4);
    if (kind == 0)
      cv::putText(out, scribble(r, 4), p - cv::Point(20, -8), cv::FONT_HERSHEY_DUPLEX, 1.0, ink, 3,
                  cv::LINE_AA);
    if (kind == 1) {
      const int thickness = r.chance(0.5) ? cv::FILLED : 4;
      cv::circle(out, p, 6 + r.below(16), ink, thickness, cv::LINE_AA);
    }
    if (kind == 2) cv::ellipse(out, p, {20, 7}, r.uniform(0, 180), 0, 360, ink, cv::FILLED, cv::LINE_AA);
    if (kind == 3) {
      const int height = 10 + r.below(30), width = 10 + r.below(40);
      cv::rectangle(out, cv::Rect(p.x, p.y, width, height), ink, cv::FILLED);
    }
  }
  fold(out, r, 0.5);
  return out;
}

cv::Mat camouflage(Random& r) {
  const cv::Scalar tones[4] = {bgr(150, 140, 104), bgr(88, 98, 62), bgr(84, 64, 46), bgr(40, 42, 36)};
  cv::Mat out(512, 512, CV_8UC3, tones[0]);
  for (int k = 1; k < 4; ++k) {
    const cv::Mat blot = fractal_noise(out.size(), {7, 7}, 3, 0.6, r);
    out.setTo(tones[k], blot > 0.56 + 0.01 * k);
  }
  fold(out, r, 0.4);
  return out;
}

cv::Mat denim(Random& r) {
  const cv::Scalar blue = r.colour_near(bgr(66, 84, 122), 24);
  cv::Mat out = ramp(fractal_noise({512, 512}, {5, 3}, 6, 0.72, r), blue * 0.55, blue * 1.55, 2.2);
  for (int i = 0; i < 160; ++i) {  // worn threads
    const cv::Point p = r.below(out.size());
    const cv::Scalar colour = r.chance(0.6) ? blue * 1.8 : blue * 0.45;
    cv::line(out, p, p + r.below(cv::Size(24, 10)) - cv::Point(12, 0), colour, 2, cv::LINE_AA);
  }
  for (int x : {6, 20, 262}) cv::line(out, {x, 0}, {x, 511}, bgr(178, 140, 84), 3);
  for (int x : {70, 330}) {
    const cv::Point corner = cv::Point(x, 40) + r.below(cv::Size(60, 60));
    cv::rectangle(out, cv::Rect(corner, cv::Size(84, 70)), blue * 0.5, 5);
  }
  fold(out, r, 0.45);
  return out;
}

cv::Mat skin(Random& r, const cv::Scalar& tone) {
  cv::Mat out = ramp(fractal_noise({128, 128}, {4, 4}, 5, 0.7, r), tone * 0.86, tone * 1.1, 1.5);
  for (int i = 0; i < 6; ++i)
    cv::circle(out, {r.below(128), r.below(128)}, 1, tone * 0.8, cv::FILLED, cv::LINE_AA);
  return out;
}

cv::Mat shoe(Random& r) {
  const cv::Scalar base = dye(r, 40, 130);
  cv::Mat out = ramp(fractal_noise({256, 256}, {6, 6}, 4, 0.7, r), base * 0.7, base * 1.2, 1.6);
  for (int i = 0; i < 5; ++i)
    cv::line(out, {104, 70 + i * 26}, {152, 82 + i * 26}, bgr(236, 232, 224), 6, cv::LINE_AA);
  cv::rectangle(out, {0, 226, 256, 30}, bgr(226, 222, 214), cv::FILLED);
  return out;
}

cv::Mat face(Random& r, const cv::Scalar& tone, const cv::Scalar& hair_tone, bool beard, bool glasses) {
  cv::Mat out(512, 512, CV_8UC3);
  cv::resize(skin(r, tone), out, out.size());
  if (beard) {
    cv::Mat stubble =
        ramp(fractal_noise({300, 150}, {30, 14}, 3, 0.8, r), hair_tone * 0.6, hair_tone * 1.3, 2);
    cv::Mat area = out(cv::Rect(106, 362, 300, 150));
    cv::addWeighted(area, 0.3, stubble, 0.7, 0, area);
  }
  for (int side : {-1, 1}) {
    const int x = 256 + side * 43;
    cv::ellipse(out, {x, 262}, {27, 14}, 0, 0, 360, tone * 0.74, cv::FILLED, cv::LINE_AA);
    cv::ellipse(out, {x, 263}, {18, 7}, 0, 0, 360, bgr(226, 232, 228), cv::FILLED, cv::LINE_AA);
    cv::circle(out, {x, 263}, 7, bgr(60, 48, 38), cv::FILLED, cv::LINE_AA);
    cv::ellipse(out, {x, 262}, {20, 9}, 0, 180, 360, bgr(50, 34, 30), 3, cv::LINE_AA);
    cv::ellipse(out, {x, 240}, {32, 12}, 0, 200, 340, hair_tone * 0.7, 9, cv::LINE_AA);
    cv::ellipse(out, {256 + side * 13, 352}, {8, 5}, 0, 0, 360, tone * 0.45, cv::FILLED, cv::LINE_AA);
    if (glasses) cv::ellipse(out, {x, 264}, {34, 25}, 0, 0, 360, bgr(26, 24, 26), 5, cv::LINE_AA);
  }
  if (glasses) cv::line(out, {246, 260}, {266, 260}, bgr(26, 24, 26), 5, cv::LINE_AA);
  cv::ellipse(out, {256, 402}, {40, 11}, 0, 0, 360, tone.mul(cv::Scalar(0.62, 0.6, 0.82)), cv::FILLED,
              cv::LINE_AA);
  cv::line(out, {220, 401}, {292, 401}, tone * 0.42, 3, cv::LINE_AA);
  cv::GaussianBlur(out, out, {3, 3}, 0);
  cv::Mat strands = hair(r, hair_tone);
  cv::resize(strands, strands, {512, 512});
  for (int y = 0; y < 512; ++y) {  // hair line: high over the forehead, low in the neck
    for (int x = 0; x < 512; ++x) {
      const double from_face = std::abs(x - 256) / 256.0;
      const double line = from_face < 0.32 ? 175 : from_face < 0.42 ? 300 : 415;
      if (y < line + 10 * std::sin(x * 0.35)) out.at<cv::Vec3b>(y, x) = strands.at<cv::Vec3b>(y, x);
    }
  }
  return out;
}

}  // namespace cloth

Outfit::Outfit(MaterialSet& set, Random& r) {
  static const cv::Scalar kSkins[4] = {bgr(224, 178, 150), bgr(206, 158, 126), bgr(158, 110, 80),
                                       bgr(112, 76, 56)};
  static const cv::Scalar kHair[4] = {bgr(52, 38, 30), bgr(104, 74, 44), bgr(26, 24, 26), bgr(168, 130, 78)};
  const cv::Scalar tone = kSkins[r.below(4)], strands = kHair[r.below(4)];
  const int kind = r.below(5);
  shirt = set.add(kind <= 1   ? cloth::plaid(r)
                  : kind == 2 ? cloth::stripes(r)
                  : kind == 3 ? cloth::camouflage(r)
                              : cloth::printed(r));
  trousers = set.add(r.chance(0.35) && kind != 3 ? cloth::camouflage(r) : cloth::denim(r));
  skin = set.add(cloth::skin(r, tone));
  const bool glasses = r.chance(0.4), beard = r.chance(0.4);
  face = set.add(cloth::face(r, tone, strands, beard, glasses));
  hair = set.add(cloth::hair(r, strands), 0.25F);
  shoe = set.add(cloth::shoe(r));
  belt = set.add(cv::Mat(8, 8, CV_8UC3, bgr(40, 32, 28)));
  long_sleeves = r.chance(0.5);
}

}  // namespace dynfilter::render
