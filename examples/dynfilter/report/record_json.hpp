// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "base64.hpp"
#include "run_record.hpp"
#include "text/json.hpp"

namespace dynfilter::command::report {

namespace detail {

/// Few digits, so that the page stays small; null for NaN.
inline Json rounded(double value, double digits) {
  return std::isfinite(value) ? Json(std::round(value * digits) / digits) : Json();
}
constexpr double kTenthMm = 1e4, kMicrosecond = 1e6, kThousandth = 1e3;

template <class List, class Get>
Json column(const List& list, Get get) {
  Json values = Json::array();
  for (const auto& entry : list) values.push_back(get(entry));
  return values;
}

inline Json axes(const std::vector<Eigen::Vector3d>& points) {
  Json json = Json::array();
  for (int a = 0; a < 3; ++a)
    json.push_back(column(points, [a](const Eigen::Vector3d& p) { return rounded(p(a), kTenthMm); }));
  return json;
}

inline Json direction(const Eigen::Vector3d& v) {
  const double length = v.norm();
  if (!(length > 0)) return {0, -1, 0};  // that of a level camera at the origin
  return {rounded(v.x() / length, kTenthMm), rounded(v.y() / length, kTenthMm),
          rounded(v.z() / length, kTenthMm)};
}

inline Json frames_json(const RunRecord& r) {
  const auto rows = [&](const auto& get) { return column(r.rows, get); };
  const auto ms = [&](auto get) {
    return rows([get](const FrameRow& row) { return rounded(get(row), kThousandth); });
  };
  const auto share = [&](auto get) {
    return rows([get](const FrameRow& row) { return rounded(get(row.truth), kTenthMm); });
  };
  return {{"index", rows([](const FrameRow& f) { return f.index; })},
          {"time_s", rows([](const FrameRow& f) { return rounded(f.timestamp_s, kMicrosecond); })},
          {"state", rows([](const FrameRow& f) { return f.state; })},
          {"keyframe", rows([](const FrameRow& f) { return f.keyframe ? 1 : 0; })},
          {"relocalised", rows([](const FrameRow& f) { return f.relocalised ? 1 : 0; })},
          {"features", rows([](const FrameRow& f) { return f.features; })},
          {"static", rows([](const FrameRow& f) { return f.of_static; })},
          {"unknown",
           rows([&, k = std::size_t{0}](const FrameRow& f) mutable { return f.unknown - r.restored[k++]; })},
          {"restored", r.restored},
          {"weight", rows([](const FrameRow& f) { return rounded(f.weight_mean, kTenthMm); })},
          {"rejected", rows([](const FrameRow& f) { return f.dynamic; })},
          {"tracked_points", rows([](const FrameRow& f) { return f.tracked_points; })},
          {"precision", share([](const auto& truth) { return truth.precision(); })},
          {"recall", share([](const auto& truth) { return truth.recall(); })},
          {"static_kept", share([](const auto& truth) { return truth.static_kept(); })},
          {"total_ms", ms([](const FrameRow& f) { return f.total_ms(); })},
          {"extraction_ms", ms([](const FrameRow& f) { return f.extraction_ms; })},
          {"correspondence_ms", ms([](const FrameRow& f) { return f.correspondence_ms; })},
          {"filters_ms", ms([](const FrameRow& f) { return f.filters_ms; })},
          {"tracking_ms", ms([](const FrameRow& f) { return f.tracking_ms; })},
          {"age_frames", column(r.age_frames, [](double age) { return rounded(age, 1); })},
          {"error_m", column(r.errors_m, [](double e) { return rounded(e, kMicrosecond); })},
          {"note", rows([](const FrameRow& f) { return f.note; })}};
}

/// Positions as 16-bit steps from the lowest corner.
inline Json map_json(const RunRecord& r) {
  Eigen::Vector3f low = r.map_m[0], high = low;
  for (const Eigen::Vector3f& p : r.map_m) low = low.cwiseMin(p), high = high.cwiseMax(p);
  constexpr double kSteps = 65535;
  const double step_m = std::max(1e-6, static_cast<double>((high - low).maxCoeff()) / kSteps);
  std::vector<std::uint8_t> xyz, rgb;
  for (std::size_t i = 0; i < r.map_m.size(); ++i) {
    for (int a = 0; a < 3; ++a) {
      const double steps = std::round(static_cast<double>(r.map_m[i](a) - low(a)) / step_m);
      const auto q = static_cast<std::uint16_t>(std::clamp(steps, 0.0, kSteps));
      xyz.push_back(static_cast<std::uint8_t>(q & 255U));
      xyz.push_back(static_cast<std::uint8_t>(q >> 8));
    }
    for (int c = 2; c >= 0; --c) rgb.push_back(r.map_bgr[i][c]);
  }
  return {{"points", r.map_points},
          {"shown", r.map_m.size()},
          {"low_m", {low.x(), low.y(), low.z()}},
          {"step_m", step_m},
          {"up", direction(r.map_up)},
          {"xyz", base64(xyz.data(), xyz.size())},
          {"rgb", base64(rgb.data(), rgb.size())}};
}

}  // namespace detail

/// One run for the page. Lists have an entry per played frame.
inline Json to_json(const RunRecord& r) {
  using detail::column;
  Json json{{"summary", named_json(r.summary)}, {"variant", r.variant}, {"frames", detail::frames_json(r)}};
  json["reasons"] = column(r.reasons, [](const ReasonSeries& s) {
    return Json{{"name", s.name}, {"features", s.features}};
  });
  json["stages"] = column(r.stages, [](const StageSeries& s) {
    const Json ms = column(s.ms, [](double v) { return detail::rounded(v, detail::kThousandth); });
    return Json{
        {"name", s.name}, {"path", s.path}, {"call_point", s.call_point}, {"depth", s.depth}, {"ms", ms}};
  });
  json["marks"] = column(r.marks, [](const FrameMark& m) {
    return Json{{"frame", m.frame}, {"kind", m.kind}, {"text", m.text}};
  });
  json["pictures"] = column(r.pictures, [](const FramePicture& p) {
    return Json{{"frame", p.frame}, {"jpeg", base64(p.jpeg.data(), p.jpeg.size())}};
  });
  json["position_m"] = detail::axes(r.positions_m);
  json["truth_m"] = detail::axes(r.truth_m);
  json["truth_s"] = column(r.truth_s, [](double s) { return detail::rounded(s, detail::kMicrosecond); });
  json["up"] = detail::direction(r.up);
  json["map"] = r.map_m.empty() ? Json() : detail::map_json(r);
  return json;
}

}  // namespace dynfilter::command::report
