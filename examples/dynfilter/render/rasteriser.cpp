// SPDX-License-Identifier: MIT
#include "render/rasteriser.hpp"

#include <cmath>
#include <opencv2/core.hpp>

namespace dynfilter::render {

void GeometryImage::create(cv::Size size) {
  colour.create(size, CV_8UC3);
  depth_m.create(size, CV_32FC1);
  item.create(size, CV_16UC1);
  instance.create(size, CV_16UC1);
  material.create(size, CV_16UC1);
  facing.create(size, CV_32FC1);
}

Rasteriser::Rasteriser(const Camera& camera)
    : camera_(camera), wide_(2 * camera.width_px), high_(2 * camera.height_px) {
  nearness_.resize(stride() * static_cast<std::size_t>(high_));
  triangle_.resize(nearness_.size());
}

void Rasteriser::begin(RowRange rows) {
  rows_ = {std::max(0, rows.first), std::min(camera_.height_px - 1, rows.last)};
  const std::ptrdiff_t from = 2L * rows_.first * wide_, to = std::max(from, 2L * (rows_.last + 1) * wide_);
  std::fill(nearness_.begin() + from, nearness_.begin() + to, 0.0F);
  std::fill(triangle_.begin() + from, triangle_.begin() + to, 0U);
  triangles_.assign(1, {});
}

void Rasteriser::draw(const Model& model, const Eigen::Isometry3f& T_camera_model, int item,
                      const std::vector<Eigen::Vector3f>* shades) {
  if (!sphere_visible(T_camera_model * model.centre_m, model.radius_m)) return;
  in_camera_.resize(model.vertices.size());
  for (std::size_t i = 0; i < model.vertices.size(); ++i) {
    in_camera_[i] = T_camera_model * model.vertices[i].position_m;
  }
  for (const Face& face : model.faces) draw_face(model, face, item, shades);
}

void Rasteriser::resolve(const MaterialSet& set, GeometryImage& out) const {
  out.create({camera_.width_px, camera_.height_px});
  for (int y = rows_.first; y <= rows_.last; ++y) {
    for (int x = 0; x < camera_.width_px; ++x) resolve_pixel(set, x, y, out);
  }
}

void Rasteriser::resolve_colour(const MaterialSet& set, cv::Mat& out) const {
  out.create(camera_.height_px, camera_.width_px, CV_8UC3);
  for (int y = rows_.first; y <= rows_.last; ++y) {
    auto* row = out.ptr<cv::Vec3b>(y);
    for (int x = 0; x < camera_.width_px; ++x) row[x] = pixel_colour(set, samples(x, y), x, y);
  }
}

inline bool Rasteriser::sphere_visible(const Eigen::Vector3f& centre, float radius) const {
  if (centre.z() + radius < kNear) return false;
  const auto outside = [&](double slope, float across) {
    // A plane through the optical centre with slope `slope`.
    return (across - static_cast<float>(slope) * centre.z()) /
               std::sqrt(1.0F + static_cast<float>(slope * slope)) >
           radius;
  };
  return !outside((camera_.width_px - camera_.cx_px) / camera_.fx_px, centre.x()) &&
         !outside(camera_.cx_px / camera_.fx_px, -centre.x()) &&
         !outside((bottom_px() - camera_.cy_px) / camera_.fy_px, centre.y()) &&
         !outside((camera_.cy_px - top_px()) / camera_.fy_px, -centre.y());
}

inline Rasteriser::Edge Rasteriser::edge(const Eigen::Vector3f& a, const Eigen::Vector3f& b) const {
  const Eigen::Vector3d n = a.cast<double>().cross(b.cast<double>());
  const double ex = n.x() / camera_.fx_px, ey = n.y() / camera_.fy_px;
  return {ex, ey, n.z() - ex * camera_.cx_px - ey * camera_.cy_px};
}

inline Rasteriser::Bounds Rasteriser::bounds(const Eigen::Vector3f* corner[3]) const {
  const int top = 2 * rows_.first, bottom = 2 * rows_.last + 1;
  const Bounds box{0, top, wide_ - 1, bottom};
  double low_x = 1e9, low_y = 1e9, high_x = -1e9, high_y = -1e9;
  for (int i = 0; i < 3; ++i) {
    if (corner[i]->z() < kNear) return box;
    const double x = camera_.fx_px * corner[i]->x() / corner[i]->z() + camera_.cx_px;
    const double y = camera_.fy_px * corner[i]->y() / corner[i]->z() + camera_.cy_px;
    low_x = std::min(low_x, x), high_x = std::max(high_x, x);
    low_y = std::min(low_y, y), high_y = std::max(high_y, y);
  }
  const auto first = [](double v) {
    return static_cast<int>(std::ceil(std::max(-1e6, std::min(1e6, 2 * v + 0.5)) - 1e-6));
  };
  const auto last = [](double v) {
    return static_cast<int>(std::floor(std::max(-1e6, std::min(1e6, 2 * v + 0.5)) + 1e-6));
  };
  return {std::max(0, first(low_x)), std::max(top, first(low_y)), std::min(wide_ - 1, last(high_x)),
          std::min(bottom, last(high_y))};
}

inline void Rasteriser::draw_face(const Model& model, const Face& face, int item,
                                  const std::vector<Eigen::Vector3f>* shades) {
  const Eigen::Vector3f* corner[3] = {&in_camera_[face.corner[0]], &in_camera_[face.corner[1]],
                                      &in_camera_[face.corner[2]]};
  if (corner[0]->z() < kNear && corner[1]->z() < kNear && corner[2]->z() < kNear) return;
  const double det =
      corner[0]->cast<double>().dot(corner[1]->cast<double>().cross(corner[2]->cast<double>()));
  if (det <= 1e-12) return;  // back side, or edge on
  const Bounds box = bounds(corner);
  if (box.x0 > box.x1 || box.y0 > box.y1) return;
  const Edge edges[3] = {edge(*corner[1], *corner[2]), edge(*corner[2], *corner[0]),
                         edge(*corner[0], *corner[1])};
  triangles_.push_back(set_up(model, face, item, shades, edges, det, box));
  fill(edges, det, box, static_cast<std::uint32_t>(triangles_.size() - 1));
}

inline Rasteriser::Triangle Rasteriser::set_up(const Model& model, const Face& face, int item,
                                               const std::vector<Eigen::Vector3f>* shades,
                                               const Edge (&edges)[3], double det, const Bounds& box) const {
  Triangle t;
  const int x0 = box.x0 / 2, y0 = box.y0 / 2;
  t.x0 = static_cast<float>(x0), t.y0 = static_cast<float>(y0);
  t.item = static_cast<std::uint16_t>(item);
  t.material = face.material;
  t.instance = face.instance;
  const auto combine = [&](double k0, double k1, double k2) {
    double sum[3];
    for (std::size_t i = 0; i < 3; ++i)
      sum[i] = (k0 * edges[0][i] + k1 * edges[1][i] + k2 * edges[2][i]) / det;
    const double c = sum[2] + sum[0] * t.x0 + sum[1] * t.y0;
    return Affine{static_cast<float>(sum[0]), static_cast<float>(sum[1]), static_cast<float>(c)};
  };
  const Vertex* v[3];
  const Eigen::Vector3f* s[3];
  for (int i = 0; i < 3; ++i) {
    v[i] = &model.vertices[face.corner[i]];
    s[i] = shades ? &(*shades)[face.corner[i]] : &v[i]->shade;
  }
  t.q = combine(1, 1, 1);
  t.u = combine(v[0]->uv.x(), v[1]->uv.x(), v[2]->uv.x());
  t.v = combine(v[0]->uv.y(), v[1]->uv.y(), v[2]->uv.y());
  for (int c = 0; c < 3; ++c) t.shade[c] = combine((*s[0])[c], (*s[1])[c], (*s[2])[c]);
  return t;
}

inline void Rasteriser::fill(const Edge (&edges)[3], double det, const Bounds& box, std::uint32_t index) {
  double q[3];
  for (std::size_t i = 0; i < 3; ++i) q[i] = (edges[0][i] + edges[1][i] + edges[2][i]) / det;
  for (int sy = box.y0; sy <= box.y1; ++sy) {
    const double y = 0.5 * (sy + 0.5) - 0.5;
    double low = box.x0, high = box.x1;
    for (const Edge& e : edges) {
      const double rest = e[1] * y + e[2];
      if (e[0] == 0) {
        if (rest < 0) high = -1;
        continue;
      }
      const double crossing = 2 * (-rest / e[0]) + 0.5;
      if (e[0] > 0)
        low = std::max(low, crossing);
      else
        high = std::min(high, crossing);
    }
    if (low > high) continue;
    fill_span(sy, static_cast<int>(std::ceil(low)), static_cast<int>(std::floor(high)), q, y, index);
  }
}

inline void Rasteriser::fill_span(int sy, int first, int last, const double (&q)[3], double y,
                                  std::uint32_t index) {
  const auto step = static_cast<float>(0.5 * q[0]);
  const auto start = static_cast<float>(q[0] * (0.5 * (first + 0.5) - 0.5) + q[1] * y + q[2]);
  const std::size_t row = static_cast<std::size_t>(sy) * stride() + static_cast<std::size_t>(first);
  float* nearness = nearness_.data() + row;
  std::uint32_t* triangle = triangle_.data() + row;
  const int count = last - first + 1;
  for (int i = 0; i < count; ++i) {
    const float value = start + step * static_cast<float>(i);
    const bool closer = value > nearness[i] && value < 1.0F / kNear;
    nearness[i] = closer ? value : nearness[i];
    triangle[i] = closer ? index : triangle[i];
  }
}

cv::Vec3f Rasteriser::colour(const MaterialSet& set, const Triangle& t, float x, float y) const {
  const float z = 1.0F / std::max(1e-3F, t.q(x, y));
  const float u = t.u(x, y) * z, v = t.v(x, y) * z;
  const Material& material = set.materials[t.material];
  const Texture& texture = set.textures[static_cast<std::size_t>(material.texture)];
  const float w = texture.width() * z, h = texture.height() * z;
  const float ux = (t.u.a - u * t.q.a) * w, uy = (t.u.b - u * t.q.b) * w;
  const float vx = (t.v.a - v * t.q.a) * h, vy = (t.v.b - v * t.q.b) * h;
  // Between the lengths of the footprint's two axes: a compromise between blur and flicker.
  const float along = std::max(ux * ux + vx * vx, uy * uy + vy * vy), area = std::abs(ux * vy - uy * vx);
  const float lod = 0.5F * std::log2(std::max(1e-9F, 0.35F * along + 0.65F * area));
  cv::Vec3f out = texture.sample(u, v, lod);
  if (material.glows) return out;
  for (int c = 0; c < 3; ++c) out[c] = std::min(255.0F, out[c] * std::max(0.0F, t.shade[c](x, y) * z));
  return out;
}

inline Rasteriser::Samples Rasteriser::samples(int x, int y) const {
  const std::size_t at = first_sample(x, y);
  return {triangle_[at], triangle_[at + 1], triangle_[at + stride()], triangle_[at + stride() + 1]};
}

inline void Rasteriser::resolve_pixel(const MaterialSet& set, int x, int y, GeometryImage& out) const {
  const Samples ids = samples(x, y);
  out.colour.at<cv::Vec3b>(y, x) = pixel_colour(set, ids, x, y);
  write_geometry(front(ids, first_sample(x, y)), x, y, out);
}

inline cv::Vec3b Rasteriser::pixel_colour(const MaterialSet& set, const Samples& ids, int x, int y) const {
  cv::Vec3f sum(0, 0, 0);
  for (std::size_t i = 0; i < 4; ++i) {
    int same = 1;
    bool done = false;
    for (std::size_t j = 0; j < i; ++j) done = done || ids[j] == ids[i];
    if (done || ids[i] == 0) continue;
    for (std::size_t j = i + 1; j < 4; ++j) same += ids[j] == ids[i] ? 1 : 0;
    const Triangle& t = triangles_[ids[i]];
    sum += colour(set, t, static_cast<float>(x) - t.x0, static_cast<float>(y) - t.y0) *
           (0.25F * static_cast<float>(same));
  }
  return {cv::saturate_cast<uchar>(sum[0]), cv::saturate_cast<uchar>(sum[1]),
          cv::saturate_cast<uchar>(sum[2])};
}

inline const Rasteriser::Triangle& Rasteriser::front(const Samples& ids, std::size_t at) const {
  const float near[4] = {nearness_[at], nearness_[at + 1], nearness_[at + stride()],
                         nearness_[at + stride() + 1]};
  std::size_t best = 0;
  int best_votes = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    int votes = 0;
    for (const auto id : ids) votes += triangles_[id].item == triangles_[ids[i]].item ? 1 : 0;
    if (votes > best_votes || (votes == best_votes && near[i] > near[best])) best = i, best_votes = votes;
  }
  return triangles_[ids[best]];
}

inline void Rasteriser::write_geometry(const Triangle& t, int x, int y, GeometryImage& out) const {
  const float px = static_cast<float>(x), py = static_cast<float>(y);
  const float q = t.q(px - t.x0, py - t.y0);
  out.depth_m.at<float>(y, x) = q > 1e-3F ? 1.0F / q : 0.0F;
  out.item.at<std::uint16_t>(y, x) = t.item;
  out.instance.at<std::uint16_t>(y, x) = t.instance;
  out.material.at<std::uint16_t>(y, x) = t.material;
  const auto fx = static_cast<float>(camera_.fx_px), fy = static_cast<float>(camera_.fy_px);
  const float rx = (px - static_cast<float>(camera_.cx_px)) / fx,
              ry = (py - static_cast<float>(camera_.cy_px)) / fy;
  const float nx = t.q.a * fx, ny = t.q.b * fy, nz = q - nx * rx - ny * ry;
  const float length = std::sqrt((nx * nx + ny * ny + nz * nz) * (rx * rx + ry * ry + 1));
  out.facing.at<float>(y, x) = length > 0 ? std::abs(q) / length : 0.0F;
}

}  // namespace dynfilter::render
