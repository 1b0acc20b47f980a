// SPDX-License-Identifier: MIT
#include "render/street_materials.hpp"

#include <algorithm>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "render/room_materials.hpp"

namespace dynfilter::render {

namespace picture {

cv::Mat asphalt(Random& r) {
  constexpr int kSide = 1024;
  cv::Mat out =
      ramp(fractal_noise({kSide, kSide}, {5, 5}, 8, 0.92, r), bgr(66, 66, 70), bgr(132, 130, 128), 1.7);
  for (int i = 0; i < 1500; ++i) {  // gravel
    const cv::Scalar colour = r.chance(0.5) ? bgr(168, 164, 158) : bgr(44, 44, 48);
    const int radius = 1 + r.below(2);
    cv::circle(out, {r.below(kSide), r.below(kSide)}, radius, colour, cv::FILLED, cv::LINE_AA);
  }
  for (int i = 0; i < 5; ++i) {  // patches
    const int height = 40 + r.below(90), width = 40 + r.below(70);
    const cv::Rect patch(r.below(cv::Size(900, 900)), cv::Size(width, height));
    cv::rectangle(out, patch, bgr(64, 64, 67) * r.uniform(0.85, 1.1), cv::FILLED);
    cv::rectangle(out, patch, bgr(36, 36, 40), 3, cv::LINE_AA);
  }
  for (int i = 0; i < 7; ++i) {  // cracks
    cv::Point p = r.below(out.size());
    for (int k = 0; k < 14; ++k) {
      const cv::Point q = p + r.below(cv::Size(70, 70)) - cv::Point(30, 30);
      cv::line(out, p, q, bgr(40, 40, 42), 2, cv::LINE_AA);
      p = q;
    }
  }
  shade_by(out, fractal_noise(out.size(), {3, 3}, 4, 0.6, r), 0.3);
  return out;
}

cv::Mat paving(Random& r) {
  cv::Mat out =
      ramp(fractal_noise({512, 512}, {6, 6}, 6, 0.8, r), bgr(136, 132, 126), bgr(184, 180, 172), 1.4);
  constexpr int kSlab = 128;
  for (int y = 0; y < 4; ++y)
    for (int x = 0; x < 4; ++x) {
      cv::Mat slab = out(cv::Rect(kSlab * x, kSlab * y, kSlab, kSlab));
      slab = slab * r.uniform(0.82, 1.08);
      cv::rectangle(out, {kSlab * x, kSlab * y, kSlab, kSlab}, bgr(84, 82, 78), 3);
    }
  for (int i = 0; i < 40; ++i) {
    const int radius = 2 + r.below(4);
    cv::circle(out, {r.below(512), r.below(512)}, radius, bgr(72, 70, 70), cv::FILLED, cv::LINE_AA);
  }
  return out;
}

inline void facade_window(cv::Mat& out, const cv::Rect& at, const cv::Scalar& frame, Random& r) {
  cv::rectangle(out, at, frame, cv::FILLED);
  const cv::Rect glass(at.x + 3, at.y + 3, at.width - 6, at.height - 6);
  const cv::Scalar dark = r.colour_near(bgr(58, 68, 80), 16);
  cv::rectangle(out, glass, dark, cv::FILLED);
  cv::rectangle(out, {glass.x, glass.y, glass.width, glass.height / 3}, dark * 1.7, cv::FILLED);
  if (r.chance(0.5))  // a curtain
    cv::rectangle(out, {glass.x, glass.y, glass.width / 3, glass.height},
                  r.colour_near(bgr(196, 190, 178), 20), cv::FILLED);
  cv::line(out, {at.x + at.width / 2, at.y}, {at.x + at.width / 2, at.y + at.height}, frame, 3);
  cv::rectangle(out, {at.x - 4, at.y + at.height, at.width + 8, 5}, frame * 0.75, cv::FILLED);
}

inline void ground_floor(cv::Mat& out, int top, const cv::Scalar& frame, Random& r) {
  const int high = out.rows - top, wide = out.cols;
  if (r.chance(0.5)) {  // a shop
    cv::rectangle(out, {12, top + 6, wide - 24, 34}, r.colour_near(bgr(120, 70, 60), 90), cv::FILLED);
    cv::putText(out, scribble(r, 9), {60, top + 33}, cv::FONT_HERSHEY_DUPLEX, 1.0, bgr(240, 236, 220), 3,
                cv::LINE_AA);
    for (int x = 20; x < wide - 90; x += 120) facade_window(out, {x, top + 50, 104, high - 64}, frame, r);
  } else {
    for (int x = 30; x < wide - 80; x += 116)
      if (x != 146) facade_window(out, {x, top + 22, 66, high - 70}, frame, r);
  }
  const cv::Rect door(150, top + 26, 70, high - 26);
  cv::rectangle(out, door, r.colour_near(bgr(92, 62, 44), 40), cv::FILLED);
  cv::rectangle(out, door, frame, 5);
  cv::circle(out, {door.x + 60, door.y + door.height / 2}, 4, bgr(214, 198, 130), cv::FILLED, cv::LINE_AA);
}

cv::Mat facade(Random& r) {
  const cv::Scalar wall = r.colour_near(r.chance(0.4) ? bgr(158, 108, 88) : bgr(196, 184, 164), 28);
  cv::Mat out = ramp(fractal_noise({512, 512}, {5, 5}, 7, 0.8, r), wall * 0.82, wall * 1.12, 1.5);
  if (r.chance(0.5))  // courses of bricks
    for (int y = 0; y < 512; y += 9) {
      cv::line(out, {0, y}, {511, y}, wall * 0.7, 1);
      for (int x = (y / 9 % 2) * 10; x < 512; x += 20) cv::line(out, {x, y}, {x, y + 9}, wall * 0.7, 1);
    }
  const cv::Scalar frame = r.chance(0.7) ? bgr(236, 234, 226) : bgr(70, 60, 54);
  const int floors = 2 + r.below(2), columns = 3 + r.below(2);
  const int ground = 360, floor_px = ground / floors, column_px = 512 / columns;
  for (int f = 0; f < floors; ++f) {
    for (int c = 0; c < columns; ++c)
      facade_window(out,
                    {c * column_px + column_px / 4, f * floor_px + floor_px / 4, column_px / 2, floor_px / 2},
                    frame, r);
    cv::rectangle(out, {0, (f + 1) * floor_px - 8, 512, 8}, wall * 0.72, cv::FILLED);
  }
  ground_floor(out, ground, frame, r);
  cv::rectangle(out, {0, 0, 512, 14}, wall * 0.6, cv::FILLED);
  shade_by(out, fractal_noise(out.size(), {3, 3}, 5, 0.7, r), 0.35);
  return out;
}

cv::Mat foliage(Random& r) {
  const cv::Scalar green = r.colour_near(bgr(70, 104, 44), 16);
  cv::Mat out = ramp(fractal_noise({512, 512}, {10, 10}, 6, 0.95, r), green * 0.3, green * 1.5, 2.4);
  for (int i = 0; i < 1600; ++i) {
    const cv::Scalar colour = green * r.uniform(0.4, 1.8);
    const double angle_deg = r.uniform(0, 180);
    const int height = 2 + r.below(2), width = 3 + r.below(5);
    cv::ellipse(out, r.below(out.size()), {width, height}, angle_deg, 0, 360, colour, cv::FILLED,
                cv::LINE_AA);
  }
  return out;
}

cv::Mat bark(Random& r) {
  return ramp(fractal_noise({128, 256}, {16, 4}, 5, 0.8, r), bgr(52, 42, 34), bgr(132, 114, 96), 2.0);
}

cv::Mat sky(Random& r) {
  constexpr int kWide = 1024, kHigh = 512;
  cv::Mat out(kHigh, kWide, CV_8UC3);
  const cv::Mat cloud = fractal_noise({kWide, kHigh}, {4, 5}, 5, 0.5, r);
  for (int y = 0; y < kHigh; ++y) {
    const double low = static_cast<double>(y) / kHigh;
    const cv::Scalar blue = bgr(98, 150, 216) * (1 - low) + bgr(206, 220, 232) * low;
    for (int x = 0; x < kWide; ++x) {
      const double share = std::clamp(3.0 * (cloud.at<float>(y, x) - 0.5), 0.0, 0.85);
      for (int c = 0; c < 3; ++c)
        out.at<cv::Vec3b>(y, x)[c] = cv::saturate_cast<uchar>(blue[c] * (1 - share) + 244 * share);
    }
  }
  return out;
}

cv::Mat sign(Random& r) {
  cv::Mat out(128, 128, CV_8UC3, r.chance(0.5) ? bgr(236, 236, 232) : bgr(36, 84, 166));
  cv::circle(out, {64, 64}, 58, bgr(196, 34, 38), 12, cv::LINE_AA);
  cv::putText(out, std::to_string(10 * (2 + r.below(6))), {34, 80}, cv::FONT_HERSHEY_DUPLEX, 1.5,
              bgr(24, 24, 26), 4, cv::LINE_AA);
  return out;
}

cv::Mat car_side(Random& r, const cv::Scalar& paint) {
  cv::Mat out(128, 512, CV_8UC3);
  for (int y = 0; y < out.rows; ++y) {  // lighter above: the sky; darker below: the road
    const double k = 1.15 - 0.55 * y / out.rows;
    out.row(y).setTo(paint * k);
  }
  shade_by(out, fractal_noise(out.size(), {6, 3}, 4, 0.6, r), 0.22);
  cv::line(out, {0, 44}, {511, 38}, paint * 0.6, 2, cv::LINE_AA);
  cv::rectangle(out, {0, 112, 512, 16}, bgr(40, 40, 42), cv::FILLED);
  for (const int x : {176, 272, 372}) cv::line(out, {x, 0}, {x - 6, 112}, bgr(26, 26, 28), 2, cv::LINE_AA);
  for (const int x : {186, 284}) cv::rectangle(out, {x, 26, 24, 6}, bgr(206, 206, 208), cv::FILLED);
  for (const int x : {101, 411}) cv::circle(out, {x, 128}, 50, bgr(18, 18, 20), cv::FILLED, cv::LINE_AA);
  cv::rectangle(out, {496, 34, 16, 18}, bgr(232, 226, 200), cv::FILLED);
  cv::rectangle(out, {0, 30, 14, 22}, bgr(178, 22, 24), cv::FILLED);
  return out;
}

cv::Mat car_glass(Random& r) {
  cv::Mat out = ramp(fractal_noise({256, 128}, {3, 2}, 4, 0.55, r), bgr(30, 38, 46), bgr(132, 150, 166), 1.8);
  for (int i = 0; i < 3; ++i)  // seats and headrests
    cv::ellipse(out, cv::Point(50 + 78 * i, 96), cv::Size(22, 30), 0, 0, 360, bgr(26, 28, 32), cv::FILLED,
                cv::LINE_AA);
  cv::rectangle(out, {0, 0, 256, 128}, bgr(20, 20, 22), 6);
  return out;
}

cv::Mat car_windows(Random& r) {
  cv::Mat out = ramp(fractal_noise({512, 64}, {6, 2}, 4, 0.6, r), bgr(28, 34, 42), bgr(120, 136, 150), 1.8);
  for (const int x : {150, 262, 368}) cv::rectangle(out, {x, 0, 12, 64}, bgr(22, 22, 24), cv::FILLED);
  cv::rectangle(out, {0, 0, 512, 64}, bgr(22, 22, 24), 5);
  return out;
}

inline void plate(cv::Mat& out, const cv::Rect& at, Random& r) {
  cv::rectangle(out, at, bgr(236, 236, 230), cv::FILLED);
  cv::rectangle(out, {at.x, at.y, 7, at.height}, bgr(30, 60, 160), cv::FILLED);
  cv::putText(out, scribble(r, 6), {at.x + 9, at.y + at.height - 5}, cv::FONT_HERSHEY_PLAIN, 1.0,
              bgr(20, 20, 22), 2, cv::LINE_AA);
}

cv::Mat car_front(Random& r, const cv::Scalar& paint) {
  cv::Mat out(128, 256, CV_8UC3, paint);
  shade_by(out, fractal_noise(out.size(), {4, 3}, 4, 0.6, r), 0.25);
  cv::rectangle(out, {70, 30, 116, 34}, bgr(24, 24, 26), cv::FILLED);
  for (int y = 34; y < 62; y += 7) cv::line(out, {74, y}, {182, y}, bgr(150, 150, 154), 2);
  for (const int x : {34, 222}) {
    cv::ellipse(out, cv::Point(x, 42), cv::Size(28, 15), 0, 0, 360, bgr(40, 42, 46), cv::FILLED, cv::LINE_AA);
    cv::circle(out, {x, 42}, 11, bgr(238, 240, 240), cv::FILLED, cv::LINE_AA);
  }
  plate(out, {88, 74, 80, 18}, r);
  cv::rectangle(out, {20, 98, 216, 24}, bgr(34, 34, 36), cv::FILLED);
  return out;
}

cv::Mat car_rear(Random& r, const cv::Scalar& paint) {
  cv::Mat out(128, 256, CV_8UC3, paint * 0.9);
  shade_by(out, fractal_noise(out.size(), {4, 3}, 4, 0.6, r), 0.25);
  for (const int x : {8, 204}) {
    cv::rectangle(out, {x, 18, 44, 36}, bgr(168, 18, 22), cv::FILLED);
    cv::rectangle(out, {x + 8, 40, 28, 9}, bgr(238, 196, 150), cv::FILLED);
  }
  plate(out, {86, 34, 84, 20}, r);
  cv::line(out, {40, 66}, {216, 66}, paint * 0.5, 3, cv::LINE_AA);
  cv::rectangle(out, {0, 88, 256, 40}, bgr(44, 44, 46), cv::FILLED);
  cv::circle(out, {112, 14}, 7, bgr(206, 206, 210), cv::FILLED, cv::LINE_AA);
  return out;
}

cv::Mat car_top(Random& r, const cv::Scalar& paint) {
  cv::Mat out = ramp(fractal_noise({128, 128}, {3, 3}, 4, 0.55, r), paint * 0.85, paint * 1.25, 1.4);
  cv::rectangle(out, {0, 0, 128, 128}, paint * 0.55, 3);
  return out;
}

cv::Mat wheel(Random& r) {
  cv::Mat out(128, 128, CV_8UC3, bgr(26, 26, 28));
  cv::circle(out, {64, 64}, 40, bgr(166, 168, 172), cv::FILLED, cv::LINE_AA);
  const int spokes = 5 + r.below(3);
  for (int i = 0; i < spokes; ++i) {
    const double angle = 2 * CV_PI * (i + 0.5) / spokes;
    cv::circle(out, {64 + cvRound(25 * std::cos(angle)), 64 + cvRound(25 * std::sin(angle))}, 9,
               bgr(40, 40, 44), cv::FILLED, cv::LINE_AA);
  }
  cv::circle(out, {64, 64}, 8, bgr(90, 92, 96), cv::FILLED, cv::LINE_AA);
  return out;
}

cv::Mat bus_side(Random& r, const cv::Scalar& paint) {
  cv::Mat out(256, 1024, CV_8UC3, paint);
  shade_by(out, fractal_noise(out.size(), {8, 3}, 5, 0.6, r), 0.25);
  cv::rectangle(out, {0, 40, 1024, 90}, bgr(34, 40, 48), cv::FILLED);
  for (int x = 20; x + 104 < 1024; x += 118) {
    cv::Mat glass = out(cv::Rect(x, 46, 104, 78));
    ramp(fractal_noise(glass.size(), {3, 2}, 4, 0.6, r), bgr(40, 48, 58), bgr(150, 166, 180), 1.8)
        .copyTo(glass);
    if (r.chance(0.6)) {  // a passenger
      const cv::Scalar colour = r.colour_near(bgr(120, 90, 80), 40);
      cv::circle(out, {x + 20 + r.below(60), 108}, 15, colour, cv::FILLED, cv::LINE_AA);
    }
  }
  const cv::Mat poster = art_poster(r);
  cv::Mat advert = out(cv::Rect(270, 142, 420, 80));
  cv::resize(poster, advert, advert.size(), 0, 0, cv::INTER_AREA);
  cv::putText(out, scribble(r, 12), {290, 200}, cv::FONT_HERSHEY_DUPLEX, 1.6, bgr(248, 248, 240), 4,
              cv::LINE_AA);
  for (const int x : {200, 800}) cv::circle(out, {x, 256}, 62, bgr(16, 16, 18), cv::FILLED, cv::LINE_AA);
  cv::rectangle(out, {0, 236, 1024, 20}, bgr(38, 38, 40), cv::FILLED);
  return out;
}

}  // namespace picture

CarPaint::CarPaint(MaterialSet& set, Random& r) {
  static const cv::Scalar kPaints[] = {bgr(176, 24, 30), bgr(34, 62, 128),   bgr(206, 208, 212),
                                       bgr(44, 46, 50),  bgr(232, 232, 228), bgr(126, 132, 138),
                                       bgr(58, 96, 70),  bgr(206, 148, 52)};
  const cv::Scalar paint = r.colour_near(kPaints[r.below(static_cast<int>(std::size(kPaints)))], 12);
  side = set.add(picture::car_side(r, paint));
  windows = set.add(picture::car_windows(r));
  glass = set.add(picture::car_glass(r));
  front = set.add(picture::car_front(r, paint));
  rear = set.add(picture::car_rear(r, paint));
  top = set.add(picture::car_top(r, paint));
  wheel = set.add(picture::wheel(r));
  tyre = set.add(cv::Mat(8, 8, CV_8UC3, bgr(24, 24, 26)));
  shadow = set.add(cv::Mat(8, 8, CV_8UC3, bgr(22, 22, 24)));
}

StreetMaterials::StreetMaterials(MaterialSet& set, Random& r) {
  constexpr int kFacades = 8, kTrees = 3, kSigns = 4;
  asphalt = set.add(picture::asphalt(r));
  paving = set.add(picture::paving(r));
  kerb = set.add(picture::plaster(r, bgr(150, 148, 142), 0.12));
  marking = set.add(picture::plaster(r, bgr(222, 220, 212), 0.1));
  bark = set.add(picture::bark(r));
  sky = set.add(picture::sky(r), 0, true);
  sky_top = set.add(cv::Mat(8, 8, CV_8UC3, bgr(96, 148, 214)), 0, true);
  metal = set.add(picture::plaster(r, bgr(92, 96, 100), 0.1));
  roof = set.add(picture::plaster(r, bgr(112, 72, 58), 0.16));
  plain_wall = set.add(picture::plaster(r, bgr(176, 168, 152), 0.14));
  for (int i = 0; i < kFacades; ++i) facades.push_back(set.add(picture::facade(r)));
  for (int i = 0; i < kTrees; ++i) foliage.push_back(set.add(picture::foliage(r)));
  for (int i = 0; i < kSigns; ++i) signs.push_back(set.add(picture::sign(r)));
}

}  // namespace dynfilter::render
