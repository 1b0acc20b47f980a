// SPDX-License-Identifier: MIT
#include "render/car.hpp"

#include <array>
#include <cmath>
#include <cstddef>
#include <opencv2/core.hpp>
#include <vector>

#include "render/furniture.hpp"

namespace dynfilter::render {

namespace detail {

/// Corners in the order of the picture's: upper left, upper right, lower left, lower right.
using Quad = std::array<Eigen::Vector3f, 4>;

/// A flat patch whose picture is the part `window` of a material. Its front is where `outside` points.
inline void add_quad(Model& model, const Quad& q, const cv::Rect2f& window, int material,
                     const Eigen::Vector3f& outside, int instance) {
  Eigen::Vector3f normal = (q[1] - q[0]).cross(q[2] - q[0]);
  if (normal.norm() < 1e-6F) normal = (q[3] - q[1]).cross(q[3] - q[2]);
  normal.normalize();
  if (normal.dot(outside) < 0) normal = -normal;
  const auto base = static_cast<std::uint32_t>(model.vertices.size());
  for (int i = 0; i < 4; ++i) {
    const float u = i % 2 == 0 ? 0.0F : 1.0F, v = i < 2 ? 0.0F : 1.0F;
    model.vertices.push_back({q[static_cast<std::size_t>(i)],
                              normal,
                              {window.x + u * window.width, window.y + v * window.height}});
  }
  const auto m = static_cast<std::uint16_t>(material), object = static_cast<std::uint16_t>(instance);
  model.faces.push_back({{base, base + 1, base + 2}, m, object});
  model.faces.push_back({{base + 1, base + 3, base + 2}, m, object});
}

/// A cross-section of a car at `y`: heights of shoulder and roof, and half widths there.
struct CarSection {
  float y, shoulder, roof, wide, roof_wide;
};

inline std::vector<CarSection> car_sections(CarKind kind) {
  std::vector<CarSection> s{{-2.15F, 0.80F, 0.82F, 0.78F, 0.76F}, {-2.05F, 0.95F, 0.98F, 0.85F, 0.80F},
                            {-1.55F, 0.98F, 1.03F, 0.87F, 0.78F}, {-0.95F, 0.99F, 1.42F, 0.87F, 0.62F},
                            {-0.10F, 0.99F, 1.47F, 0.87F, 0.63F}, {0.35F, 0.99F, 1.42F, 0.87F, 0.62F},
                            {1.15F, 0.97F, 1.01F, 0.87F, 0.78F},  {1.95F, 0.84F, 0.88F, 0.84F, 0.78F},
                            {2.15F, 0.62F, 0.64F, 0.77F, 0.74F}};
  if (kind == CarKind::Saloon) return s;
  s[0] = {-1.95F, 0.90F, 0.92F, 0.80F, 0.78F};
  s[1] = {-1.90F, 0.97F, 1.02F, 0.85F, 0.80F};
  s[2] = {-1.55F, 0.99F, 1.44F, 0.87F, 0.64F};
  s[3].roof = 1.49F;
  if (kind == CarKind::Hatchback) return s;
  for (CarSection& at : s) at.y *= 1.1F;
  s[1].roof = 1.95F, s[1].roof_wide = 0.74F;
  for (std::size_t i = 2; i < 6; ++i) s[i].roof = 2.05F, s[i].roof_wide = 0.76F;
  s[6].roof = 1.2F;
  return s;
}

constexpr float kSill_m = 0.24F;

inline void add_car_sides(Model& model, const std::vector<CarSection>& s, const CarPaint& paint,
                          int instance) {
  const float rear = s.front().y, length = s.back().y - s.front().y;
  for (const float side : {-1.0F, 1.0F}) {
    for (std::size_t i = 0; i + 1 < s.size(); ++i) {
      const CarSection &a = s[i], &b = s[i + 1];
      const cv::Rect2f window((a.y - rear) / length, 0, (b.y - a.y) / length, 1);
      const Eigen::Vector3f out(side, 0, 0);
      add_quad(model,
               {Eigen::Vector3f(side * a.wide, a.y, a.shoulder),
                {side * b.wide, b.y, b.shoulder},
                {side * a.wide * 0.97F, a.y, kSill_m},
                {side * b.wide * 0.97F, b.y, kSill_m}},
               window, paint.side, out, instance);
      const bool cabin = a.roof - a.shoulder > 0.1F || b.roof - b.shoulder > 0.1F;
      add_quad(model,
               {Eigen::Vector3f(side * a.roof_wide, a.y, a.roof),
                {side * b.roof_wide, b.y, b.roof},
                {side * a.wide, a.y, a.shoulder},
                {side * b.wide, b.y, b.shoulder}},
               window, cabin ? paint.windows : paint.top, out, instance);
    }
  }
}

inline void add_car_top(Model& model, const std::vector<CarSection>& s, const CarPaint& paint, int instance) {
  for (std::size_t i = 0; i + 1 < s.size(); ++i) {
    const CarSection &a = s[i], &b = s[i + 1];
    const bool steep = std::abs(b.roof - a.roof) > 0.3F;
    const Eigen::Vector3f out(0, 0, 1);
    // A picture's upper edge is the upper edge of the glass.
    const CarSection &upper = a.roof > b.roof ? a : b, &lower = a.roof > b.roof ? b : a;
    add_quad(model,
             {Eigen::Vector3f(-upper.roof_wide, upper.y, upper.roof),
              {upper.roof_wide, upper.y, upper.roof},
              {-lower.roof_wide, lower.y, lower.roof},
              {lower.roof_wide, lower.y, lower.roof}},
             {0, 0, 1, 1}, steep ? paint.glass : paint.top, out, instance);
  }
}

inline void add_car_ends(Model& model, const std::vector<CarSection>& s, const CarPaint& paint,
                         int instance) {
  const CarSection &rear = s.front(), &front = s.back();
  add_quad(model,
           {Eigen::Vector3f(-rear.wide, rear.y, rear.roof),
            {rear.wide, rear.y, rear.roof},
            {-rear.wide, rear.y, kSill_m},
            {rear.wide, rear.y, kSill_m}},
           {0, 0, 1, 1}, paint.rear, {0, -1, 0}, instance);
  add_quad(model,
           {Eigen::Vector3f(front.wide, front.y, front.roof),
            {-front.wide, front.y, front.roof},
            {front.wide, front.y, kSill_m},
            {-front.wide, front.y, kSill_m}},
           {0, 0, 1, 1}, paint.front, {0, 1, 0}, instance);
}

inline void add_wheel(Model& model, const Eigen::Vector3f& hub, float side, const CarPaint& paint,
                      int instance) {
  constexpr int kCorners = 14;
  constexpr float kRadius = 0.32F, kWide = 0.2F;
  const auto m = static_cast<std::uint16_t>(paint.wheel), object = static_cast<std::uint16_t>(instance);
  const auto rim = [&](int i) {
    const float angle = static_cast<float>(2 * CV_PI) * static_cast<float>(i) / kCorners;
    return Eigen::Vector3f(0, kRadius * std::cos(angle), kRadius * std::sin(angle));
  };
  const auto base = static_cast<std::uint32_t>(model.vertices.size());
  model.vertices.push_back({hub, {side, 0, 0}, {0.5F, 0.5F}});
  for (int i = 0; i <= kCorners; ++i) {
    const Eigen::Vector3f p = rim(i);
    model.vertices.push_back(
        {hub + p, {side, 0, 0}, {0.5F + 0.49F * p.y() / kRadius, 0.5F - 0.49F * p.z() / kRadius}});
  }
  for (std::uint32_t i = 1; i <= kCorners; ++i)
    model.faces.push_back({{base, base + i, base + i + 1}, m, object});
  const Eigen::Vector3f inward(-side * kWide, 0, 0);
  for (int i = 0; i < kCorners; ++i)
    add_quad(model, {hub + rim(i), hub + rim(i + 1), hub + rim(i) + inward, hub + rim(i + 1) + inward},
             {0, 0, 1, 1}, paint.tyre, rim(i), instance);
}

inline void add_shadow(Model& model, float half_wide, float half_long, int material, int instance) {
  constexpr float kAboveRoad_m = 0.02F;
  add_quad(model,
           {Eigen::Vector3f(-half_wide, half_long, kAboveRoad_m),
            {half_wide, half_long, kAboveRoad_m},
            {-half_wide, -half_long, kAboveRoad_m},
            {half_wide, -half_long, kAboveRoad_m}},
           {0, 0, 1, 1}, material, {0, 0, 1}, instance);
}

}  // namespace detail

Model car_model(const CarPaint& paint, CarKind kind, int instance) {
  const std::vector<detail::CarSection> sections = detail::car_sections(kind);
  Model model;
  detail::add_car_sides(model, sections, paint, instance);
  detail::add_car_top(model, sections, paint, instance);
  detail::add_car_ends(model, sections, paint, instance);
  const float length = sections.back().y - sections.front().y, rear = sections.front().y;
  for (const float side : {-1.0F, 1.0F})
    for (const float share : {0.2F, 0.8F})  // where the arches of car_side() are
      detail::add_wheel(model, {side * 0.86F, rear + share * length, 0.32F}, side, paint, instance);
  detail::add_shadow(model, 0.85F, 0.47F * length, paint.shadow, instance);
  model.finish();
  return model;
}

Model bus_model(MaterialSet& set, Random& random, int instance) {
  const CarPaint paint(set, random);
  const cv::Scalar colour = random.colour_near(bgr(190, 60, 50), 60);
  const int side = set.add(picture::bus_side(random, colour)),
            front = set.add(picture::car_front(random, colour));
  Model model;
  constexpr float kLong = 10.5F, kHigh = 2.75F, kWide = 2.5F, kClear = 0.3F;
  BoxSkin skin = BoxSkin::all({side});
  skin.front.material = paint.rear, skin.back.material = front;
  skin.top.material = paint.top, skin.bottom.material = kNoSkin;
  add_box(model, placed({0, 0, kClear + kHigh / 2}, 0), {kWide, kLong, kHigh}, skin, 10, instance);
  for (const float x : {-1.0F, 1.0F})
    for (const float y : {-0.305F, 0.281F})  // where the arches of bus_side() are
      detail::add_wheel(model, {x * (kWide / 2 + 0.01F), y * kLong, 0.42F}, x, paint, instance);
  detail::add_shadow(model, 0.48F * kWide, 0.48F * kLong, paint.shadow, instance);
  model.finish();
  return model;
}

}  // namespace dynfilter::render
