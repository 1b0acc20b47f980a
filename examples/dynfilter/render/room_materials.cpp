// SPDX-License-Identifier: MIT
#include "render/room_materials.hpp"

#include <algorithm>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace dynfilter::render {

namespace picture {

cv::Mat plaster(Random& r, const cv::Scalar& colour, double roughness) {
  cv::Mat out = ramp(fractal_noise({512, 512}, {4, 4}, 7, 0.75, r), colour * (1 - roughness),
                     colour * (1 + roughness), 1.6);
  for (int i = 0; i < static_cast<int>(36 * roughness / 0.1); ++i) {  // scuffs and filled holes
    const cv::Point p = r.below(out.size());
    const cv::Scalar mark = colour * r.uniform(0.62, 0.9);
    if (r.chance(0.5))
      cv::circle(out, p, 1 + r.below(4), mark, cv::FILLED, cv::LINE_AA);
    else
      cv::line(out, p, p + r.below(cv::Size(60, 40)) - cv::Point(30, 20), mark, 1, cv::LINE_AA);
  }
  return out;
}

cv::Mat wood(Random& r, const cv::Scalar& dark, const cv::Scalar& light) {
  cv::Mat out = ramp(fractal_noise({512, 512}, {2, 24}, 5, 0.62, r), dark, light, 2.0);
  for (int i = 0; i < 5; ++i) {  // knots
    const cv::Point p = r.below(out.size());
    for (int k = 3; k > 0; --k)
      cv::ellipse(out, p, {5 * k, 2 * k}, 0, 0, 360, dark * (0.55 + 0.12 * k), 2, cv::LINE_AA);
  }
  return out;
}

cv::Mat parquet(Random& r) {
  cv::Mat out(1024, 1024, CV_8UC3);
  const int rows = 16, plank_px = 1024 / rows;
  for (int row = 0; row < rows; ++row) {
    int x = -r.below(256);
    while (x < 1024) {
      const int length = 200 + r.below(200);
      const cv::Scalar light = bgr(190, 152, 108) * r.uniform(0.78, 1.1);
      cv::Mat plank =
          ramp(fractal_noise({length, plank_px}, {3, 8}, 3, 0.65, r), light * 0.68, light * 1.08, 1.7);
      const cv::Rect area = cv::Rect(x, row * plank_px, length, plank_px) & cv::Rect(0, 0, 1024, 1024);
      if (area.width > 0) plank(cv::Rect(area.x - x, 0, area.width, plank_px)).copyTo(out(area));
      cv::rectangle(out, cv::Rect(x, row * plank_px, length, plank_px), bgr(84, 60, 38), 2);
      x += length;
    }
  }
  return out;
}

cv::Mat carpet(Random& r) {
  cv::Mat out =
      ramp(fractal_noise({1024, 1024}, {6, 6}, 8, 0.9, r), bgr(78, 82, 94), bgr(160, 160, 166), 2.0);
  for (int i = 0; i < 900; ++i) {
    const cv::Scalar fleck = r.chance(0.5) ? bgr(196, 188, 168) : bgr(44, 46, 60);
    const cv::Scalar colour = r.colour_near(fleck, 22);
    const int radius = 1 + r.below(4);
    cv::circle(out, {r.below(1024), r.below(1024)}, radius, colour, cv::FILLED, cv::LINE_AA);
  }
  for (int i = 0; i < 4; ++i) {
    cv::line(out, {256 * i, 0}, {256 * i, 1023}, bgr(58, 60, 72), 2);
    cv::line(out, {0, 256 * i}, {1023, 256 * i}, bgr(58, 60, 72), 2);
  }
  return out;
}

cv::Mat ceiling_tile(Random& r) {
  cv::Mat out(256, 256, CV_8UC3, bgr(222, 222, 216));
  for (int i = 0; i < 420; ++i) {
    const int radius = r.below(3);
    cv::circle(out, {r.below(256), r.below(256)}, radius, bgr(168, 168, 162), cv::FILLED, cv::LINE_AA);
  }
  cv::rectangle(out, {0, 0, 256, 256}, bgr(140, 142, 142), 5);
  return out;
}

cv::Mat landscape(Random& r, cv::Size size) {
  cv::Mat out = ramp(fractal_noise(size, {3, 4}, 5, 0.55, r), bgr(112, 158, 212), bgr(244, 246, 250), 1.6);
  for (int layer = 0; layer < 3; ++layer) {
    const cv::Mat ridge = fractal_noise({size.width, 8}, {4 + 2 * layer, 1}, 5, 0.55, r);
    const cv::Scalar tone = layer == 0 ? bgr(96, 120, 138) : layer == 1 ? bgr(70, 104, 62) : bgr(48, 74, 38);
    cv::Mat cover = ramp(fractal_noise(size, {10, 10}, 5, 0.8, r), tone * 0.55, tone * 1.45, 2.0);
    for (int x = 0; x < size.width; ++x) {
      const int top =
          static_cast<int>(size.height * (0.34 + 0.17 * layer + 0.45 * (ridge.at<float>(4, x) - 0.5)));
      for (int y = std::max(0, top); y < size.height; ++y)
        out.at<cv::Vec3b>(y, x) = cover.at<cv::Vec3b>(y, x);
    }
  }
  return out;
}

cv::Mat window_view(Random& r) {
  cv::Mat out = landscape(r, {512, 512});
  out = out * 0.75 + cv::Scalar(70, 66, 62);
  for (int i = 0; i < 4; ++i) {  // houses
    const int width = 60 + r.below(70), top = 190 + r.below(80), left = r.below(440);
    const cv::Rect house(left, top, width, 120);
    cv::rectangle(out, house, r.colour_near(bgr(214, 190, 172), 30), cv::FILLED);
    for (int k = 0; k < 9; ++k) {
      cv::rectangle(out,
                    cv::Rect(house.x + 8 + (k % 3) * house.width / 3, house.y + 10 + (k / 3) * 32, 10, 16),
                    bgr(84, 96, 116), cv::FILLED);
    }
    const std::vector<cv::Point> roof{{house.x - 6, house.y},
                                      {house.x + house.width / 2, house.y - 36},
                                      {house.x + house.width + 6, house.y}};
    cv::fillConvexPoly(out, roof, r.colour_near(bgr(160, 84, 62), 20), cv::LINE_AA);
  }
  const cv::Scalar frame = bgr(238, 238, 234);
  cv::rectangle(out, {0, 0, 512, 512}, frame, 30);
  cv::line(out, {256, 0}, {256, 512}, frame, 20);
  cv::line(out, {0, 150}, {512, 150}, frame, 12);
  return out;
}

inline cv::Scalar any_colour(Random& r, double darkest, double lightest) {
  cv::Scalar out;
  for (int channel : {2, 1, 0}) out[channel] = r.uniform(darkest, lightest);
  return out;
}

void paint_shapes(cv::Mat& out, Random& r, int count) {
  for (int i = 0; i < count; ++i) {
    const cv::Point p = r.below(out.size());
    const cv::Scalar colour = any_colour(r, 20, 240);
    const int size = out.cols / 20 + r.below(out.cols / 6);
    const int kind = r.below(3);
    if (kind == 0) cv::circle(out, p, size / 2, colour, r.chance(0.6) ? cv::FILLED : 4, cv::LINE_AA);
    if (kind == 1) {
      const int thickness = r.chance(0.6) ? cv::FILLED : 4;
      cv::rectangle(out, cv::Rect(p.x, p.y, size, size * (1 + r.below(3)) / 2), colour, thickness);
    }
    if (kind == 2) {
      const cv::Point q = p + cv::Point(size, r.below(size)), s = p + cv::Point(r.below(size), size);
      cv::fillConvexPoly(out, std::vector<cv::Point>{p, q, s}, colour, cv::LINE_AA);
    }
  }
}

cv::Mat art_poster(Random& r) {
  const cv::Scalar paper = r.colour_near(bgr(224, 212, 190), 28);
  cv::Mat out(768, 512, CV_8UC3, paper);
  cv::Mat art(460, 440, CV_8UC3);
  if (r.chance(0.5)) {
    art = landscape(r, art.size());
  } else {
    art.setTo(r.colour_near(bgr(150, 150, 150), 90));
    paint_shapes(art, r, 26);
    shade_by(art, fractal_noise(art.size(), {8, 8}, 5, 0.7, r), 0.4);
  }
  art.copyTo(out(cv::Rect(36, 120, 440, 460)));
  const cv::Scalar ink = r.colour_near(bgr(60, 40, 50), 60);
  cv::putText(out, scribble(r, 7), {34, 90}, cv::FONT_HERSHEY_DUPLEX, 2.6, ink, 6, cv::LINE_AA);
  print_lines(out, {40, 610, 430, 130}, 16, paper * 0.35, r);
  return out;
}

cv::Mat paper_poster(Random& r) {  // a conference poster: columns of print and figures
  cv::Mat out(768, 512, CV_8UC3, bgr(236, 236, 232));
  const double red = r.uniform(20, 110), green = r.uniform(40, 130), blue = r.uniform(60, 190);
  const cv::Scalar band(blue, green, red);
  cv::rectangle(out, {0, 0, 512, 96}, band, cv::FILLED);
  cv::putText(out, scribble(r, 9), {24, 62}, cv::FONT_HERSHEY_SIMPLEX, 1.9, bgr(245, 245, 240), 4,
              cv::LINE_AA);
  for (int c = 0; c < 2; ++c) {
    for (int row = 0; row < 4; ++row) {
      const cv::Rect cell(20 + c * 244, 116 + row * 162, 228, 150);
      cv::rectangle(out, cv::Rect(cell.x, cell.y, cell.width, 20), band * 0.8, cv::FILLED);
      if (r.chance(0.45)) {
        cv::Mat figure(110, 200, CV_8UC3, r.colour_near(bgr(180, 190, 200), 50));
        paint_shapes(figure, r, 12);
        figure.copyTo(out(cv::Rect(cell.x + 12, cell.y + 30, 200, 110)));
      } else {
        print_lines(out, {cell.x, cell.y + 32, cell.width, cell.height - 34}, 11, bgr(52, 52, 60), r);
      }
    }
  }
  return out;
}

cv::Mat whiteboard(Random& r) {
  cv::Mat out(512, 1024, CV_8UC3, bgr(238, 240, 240));
  shade_by(out, fractal_noise(out.size(), {4, 2}, 4, 0.5, r), 0.06);
  const cv::Scalar pens[3] = {bgr(30, 40, 120), bgr(170, 36, 40), bgr(24, 110, 60)};
  for (int i = 0; i < 16; ++i) {
    const cv::Scalar pen = pens[r.below(3)];
    const cv::Point p = cv::Point(40, 60) + r.below(cv::Size(800, 400));
    const int kind = r.below(4);
    if (kind == 0)
      cv::putText(out, scribble(r, 5 + r.below(5)), p, cv::FONT_HERSHEY_SCRIPT_SIMPLEX, 1.6, pen, 3,
                  cv::LINE_AA);
    if (kind == 1) cv::ellipse(out, p, {30 + r.below(60), 20 + r.below(40)}, 0, 0, 360, pen, 3, cv::LINE_AA);
    if (kind == 2)
      cv::arrowedLine(out, p, p + r.below(cv::Size(200, 120)) - cv::Point(100, 60), pen, 3, cv::LINE_AA);
    if (kind == 3) {
      const int height = 40 + r.below(40), width = 60 + r.below(90);
      cv::rectangle(out, cv::Rect(p.x, p.y, width, height), pen, 3, cv::LINE_AA);
    }
  }
  cv::rectangle(out, {0, 0, 1024, 512}, bgr(140, 144, 148), 14);
  return out;
}

cv::Mat book_backs(Random& r) {
  const int width = 1024 / kBooks;
  cv::Mat out(512, 1024, CV_8UC3);
  for (int i = 0; i < kBooks; ++i) {
    const double grey = r.uniform(35, 190);
    const cv::Scalar cover = r.colour_near({grey * 0.85, grey * 0.95, grey * 1.1}, 45);
    cv::Mat back(width, 512, CV_8UC3, cover);
    const cv::Scalar ink = cover[0] + cover[1] + cover[2] > 330 ? cover * 0.2 : cv::Scalar(190, 225, 235);
    cv::rectangle(back, {20 + r.below(30), 0, 8 + r.below(20), width}, ink, cv::FILLED);
    const cv::Scalar label = r.colour_near(cover, 90);
    cv::rectangle(back, {430 + r.below(20), 0, 30, width}, label, cv::FILLED);
    cv::putText(back, scribble(r, 6 + r.below(5)), {110, width - 10}, cv::FONT_HERSHEY_DUPLEX, 0.8, ink, 2,
                cv::LINE_AA);
    shade_by(back, fractal_noise(back.size(), {10, 1}, 4, 0.7, r), 0.25);
    cv::Mat upright;
    cv::rotate(back, upright, cv::ROTATE_90_CLOCKWISE);
    cv::rectangle(upright, {0, 0, width, 512}, cover * 0.45, 2);
    upright.copyTo(out(cv::Rect(i * width, 0, width, 512)));
  }
  return out;
}

cv::Mat book_cover(Random& r) {
  cv::Mat out(256, 256, CV_8UC3, any_colour(r, 20, 220));
  paint_shapes(out, r, 7);
  const cv::Scalar ink = r.chance(0.5) ? bgr(245, 240, 230) : bgr(20, 20, 26);
  cv::putText(out, scribble(r, 7), {16, 60}, cv::FONT_HERSHEY_DUPLEX, 1.6, ink, 4, cv::LINE_AA);
  cv::putText(out, scribble(r, 8), {20, 220}, cv::FONT_HERSHEY_SIMPLEX, 1.0, bgr(240, 236, 222), 2,
              cv::LINE_AA);
  cv::rectangle(out, {0, 0, 256, 256}, bgr(40, 36, 36), 3);
  return out;
}

cv::Mat screen(Random& r) {
  cv::Mat out(512, 1024, CV_8UC3);
  ramp(fractal_noise({1024, 512}, {3, 2}, 3, 0.5, r), bgr(18, 44, 84), bgr(44, 112, 158), 1.4).copyTo(out);
  for (int i = 0; i < 3; ++i) {
    const int height = 270 + r.below(60), top = 40 + r.below(110), left = 40 + i * 250 + r.below(80);
    const cv::Rect window(left, top, 360, height);
    const bool dark = r.chance(0.4);
    cv::rectangle(out, window, dark ? bgr(32, 34, 40) : bgr(236, 238, 240), cv::FILLED);
    cv::rectangle(out, cv::Rect(window.x, window.y, window.width, 20), bgr(92, 104, 122), cv::FILLED);
    print_lines(out, {window.x + 14, window.y + 34, window.width - 30, window.height - 46}, 13,
                dark ? bgr(150, 200, 160) : bgr(46, 48, 70), r);
  }
  cv::rectangle(out, {0, 484, 1024, 28}, bgr(24, 26, 32), cv::FILLED);
  cv::rectangle(out, {0, 0, 1024, 512}, bgr(16, 16, 18), 26);
  return out * 0.85;
}

cv::Mat keyboard(Random& r) {
  cv::Mat out(256, 768, CV_8UC3, bgr(34, 34, 38));
  for (int row = 0; row < 6; ++row) {
    int x = 14;
    while (x < 735) {
      const int width = row == 5 && x > 150 && x < 200 ? 220 : 28 + (r.chance(0.12) ? 22 : 0);
      const cv::Rect key(x, 12 + row * 40, std::min(width, 752 - x), 32);
      cv::rectangle(out, key, bgr(62, 62, 68), cv::FILLED);
      cv::putText(out, scribble(r, 1), {key.x + 6, key.y + 22}, cv::FONT_HERSHEY_SIMPLEX, 0.6,
                  bgr(206, 206, 206), 2, cv::LINE_AA);
      x += key.width + 6;
    }
  }
  return out;
}

cv::Mat paper_sheet(Random& r) {
  cv::Mat out(512, 362, CV_8UC3, bgr(240, 240, 236));
  print_lines(out, {34, 40, 290, 430}, 14, bgr(60, 60, 68), r);
  if (r.chance(0.6)) {
    cv::Mat figure(120, 200, CV_8UC3, bgr(200, 206, 210));
    paint_shapes(figure, r, 8);
    figure.copyTo(out(cv::Rect(80, 180 + r.below(120), 200, 120)));
  }
  return out;
}

cv::Mat cardboard(Random& r) {
  cv::Mat out =
      ramp(fractal_noise({512, 512}, {3, 30}, 5, 0.7, r), bgr(150, 112, 72), bgr(206, 166, 118), 1.6);
  cv::rectangle(out, {0, 222, 512, 66}, bgr(196, 176, 132), cv::FILLED);  // tape
  for (int i = 0; i < 3; ++i) {
    const int top = r.chance(0.5) ? 40 + r.below(60) : 310 + r.below(60);
    const cv::Rect label(24 + i * 150 + r.below(40), top, 130, 110);
    cv::rectangle(out, label, bgr(236, 234, 226), cv::FILLED);
    cv::rectangle(out, label, bgr(60, 56, 56), 2);
    print_lines(out, {label.x + 8, label.y + 10, 112, 56}, 11, bgr(30, 30, 34), r);
    for (int bar = 0; bar < 26; ++bar) {
      if (r.chance(0.55))
        cv::rectangle(out, cv::Rect(label.x + 10 + bar * 4, label.y + 72, 3, 30), bgr(20, 20, 22),
                      cv::FILLED);
    }
  }
  cv::putText(out, scribble(r, 6), {40, 208}, cv::FONT_HERSHEY_DUPLEX, 2.1, bgr(120, 40, 34), 6, cv::LINE_AA);
  cv::putText(out, scribble(r, 5), {210, 470}, cv::FONT_HERSHEY_DUPLEX, 1.8, bgr(40, 44, 60), 5, cv::LINE_AA);
  cv::rectangle(out, {0, 0, 512, 512}, bgr(112, 80, 50), 5);
  return out;
}

cv::Mat fabric(Random& r, const cv::Scalar& colour) {
  cv::Mat out = ramp(fractal_noise({256, 256}, {16, 16}, 4, 0.9, r), colour * 0.66, colour * 1.3, 1.8);
  for (int i = 0; i < 256; i += 8) cv::line(out, {0, i}, {255, i}, colour * 0.8, 1);
  return out;
}

cv::Mat leaf(Random& r) {
  const cv::Scalar green = r.colour_near(bgr(58, 118, 46), 16);
  cv::Mat out = ramp(fractal_noise({128, 256}, {4, 6}, 5, 0.7, r), green * 0.6, green * 1.3, 1.7);
  cv::line(out, {64, 0}, {64, 255}, bgr(150, 180, 110), 4, cv::LINE_AA);
  for (int y = 10; y < 250; y += 24) {
    cv::line(out, {64, y + 20}, {4, y}, bgr(112, 156, 88), 2, cv::LINE_AA);
    cv::line(out, {64, y + 20}, {124, y}, bgr(112, 156, 88), 2, cv::LINE_AA);
  }
  return out;
}

cv::Mat drawers(Random& r, const cv::Scalar& colour) {
  cv::Mat out = plaster(r, colour, 0.06);
  for (int i = 0; i < 4; ++i) {
    cv::rectangle(out, cv::Rect(14, 12 + i * 125, 484, 112), colour * 0.55, 4);
    cv::rectangle(out, cv::Rect(196, 36 + i * 125, 120, 16), bgr(70, 72, 76), cv::FILLED);
    cv::rectangle(out, cv::Rect(206, 64 + i * 125, 100, 34), bgr(238, 236, 226), cv::FILLED);
    print_lines(out, {212, 68 + i * 125, 88, 26}, 10, bgr(40, 40, 48), r);
  }
  return out;
}

cv::Mat door(Random& r) {
  cv::Mat out = wood(r, bgr(128, 88, 54), bgr(184, 138, 92));
  cv::resize(out, out, {512, 1024});
  cv::rectangle(out, {0, 0, 512, 1024}, bgr(92, 62, 38), 24);
  cv::rectangle(out, {90, 100, 330, 320}, bgr(104, 72, 44), 8);
  cv::rectangle(out, {90, 560, 330, 360}, bgr(104, 72, 44), 8);
  cv::circle(out, {448, 520}, 18, bgr(206, 200, 184), cv::FILLED, cv::LINE_AA);
  cv::rectangle(out, {196, 200, 110, 80}, bgr(238, 238, 230), cv::FILLED);
  print_lines(out, {204, 210, 94, 60}, 14, bgr(40, 40, 44), r);
  return out;
}

cv::Mat joints(const cv::Scalar& colour, const cv::Scalar& joint, int wide_px, int high_px) {
  constexpr int kSize = 512, kJoint_px = 5;
  cv::Mat out(kSize, kSize, CV_8UC3, colour);
  for (int at = 0; wide_px > 0 && at < kSize; at += wide_px)
    cv::rectangle(out, {at, 0, kJoint_px, kSize}, joint, cv::FILLED);
  for (int at = 0; high_px > 0 && at < kSize; at += high_px)
    cv::rectangle(out, {0, at, kSize, kJoint_px}, joint, cv::FILLED);
  return out;
}

}  // namespace picture

RoomMaterials::RoomMaterials(MaterialSet& set, Random& r, RoomLook look) {
  const bool plain = look != RoomLook::Furnished;
  const auto flat = [&](const cv::Scalar& c) { return set.add(cv::Mat(cv::Mat(8, 8, CV_8UC3, c))); };
  const cv::Scalar paint = r.colour_near(bgr(204, 200, 190), 10);
  wall = set.add(picture::plaster(r, paint, plain ? 0.012 : 0.09));
  partition =
      set.add(plain ? picture::plaster(r, bgr(178, 150, 112), 0.015) : picture::felt(r, bgr(176, 148, 110)));
  floor = plain ? set.add(picture::plaster(r, bgr(128, 126, 122), 0.02))
                : set.add(r.chance(0.6) ? picture::carpet(r) : picture::parquet(r));
  ceiling = plain ? flat(bgr(216, 216, 212)) : set.add(picture::ceiling_tile(r));
  light_panel = set.add(cv::Mat(8, 8, CV_8UC3, bgr(252, 252, 246)), 0.3F, true);
  for (int i = 0; i < 2; ++i) windows.push_back(set.add(picture::window_view(r), 0.55F, true));
  wood_light =
      plain ? flat(bgr(206, 190, 160)) : set.add(picture::wood(r, bgr(176, 146, 104), bgr(226, 202, 160)));
  wood_dark = plain ? flat(bgr(120, 92, 66)) : set.add(picture::wood(r, bgr(92, 60, 36), bgr(150, 108, 70)));
  metal = set.add(picture::plaster(r, bgr(150, 152, 156), 0.05), 0.08F);
  black = set.add(picture::plaster(r, bgr(38, 38, 42), plain ? 0.05 : 0.25), 0.25F);
  white = set.add(picture::plaster(r, bgr(222, 222, 218), plain ? 0.01 : 0.04));
  whiteboard = set.add(picture::whiteboard(r), 0.2F);
  book_backs = set.add(picture::book_backs(r));
  pages = set.add(picture::page_edges(r));
  keyboard = set.add(picture::keyboard(r), 0.05F);
  cardboard = set.add(picture::cardboard(r));
  chair_fabric = set.add(picture::fabric(r, r.colour_near(bgr(58, 74, 118), 30)));
  leaf = set.add(picture::leaf(r));
  pot = set.add(picture::plaster(r, bgr(168, 92, 62), 0.12));
  drawers = set.add(picture::drawers(r, bgr(186, 186, 180)));
  door = set.add(picture::door(r));
  mug = set.add(picture::art_poster(r));
  radiator = set.add(picture::keyboard(r));
  for (int i = 0; i < 8; ++i)
    posters.push_back(set.add(i % 2 ? picture::paper_poster(r) : picture::art_poster(r)));
  for (int i = 0; i < 3; ++i) screens.push_back(set.add(picture::screen(r), 0.35F, true));
  for (int i = 0; i < 8; ++i) covers.push_back(set.add(picture::book_cover(r)));
  for (int i = 0; i < 4; ++i) papers.push_back(set.add(picture::paper_sheet(r)));
  if (look == RoomLook::Edges) set_edges(set, r);
}

void RoomMaterials::set_edges(MaterialSet& set, Random& r) {
  const cv::Scalar paint = r.colour_near(bgr(206, 204, 198), 8);
  floor = set.add(picture::joints(paint * 0.8, paint * 0.45, 128, 128));
  wall = set.add(picture::joints(paint, paint * 0.7, 96, 0));
  partition = set.add(picture::joints(paint * 0.7, paint * 0.4, 0, 32));
  ceiling = set.add(picture::joints(paint * 1.1, paint * 0.75, 256, 64));
  for (int& screen : screens) screen = set.add(cv::Mat(8, 8, CV_8UC3, bgr(36, 60, 96)), 0.35F, true);
  for (int& window : windows)
    window = set.add(picture::joints(bgr(236, 236, 228), bgr(120, 124, 130), 0, 16));
}

}  // namespace dynfilter::render
