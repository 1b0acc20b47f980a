// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cstring>
#include <dynfilter/core/verdict.hpp>
#include <dynfilter/recorder/recording.hpp>
#include <tuple>
#include <vector>

namespace dynfilter::recorder {

namespace {

template <class T>
bool same_bits(const T& a, const T& b) {
  return std::memcmp(&a, &b, sizeof(T)) == 0;  // NaN is NaN
}

bool same_feature(const Verdict& a, const Verdict& b, std::size_t i) {
  const bool spread =
      a.spread.size() == b.spread.size() && (i >= a.spread.size() || same_bits(a.spread[i], b.spread[i]));
  return spread && a.decision[i] == b.decision[i] && same_bits(a.suspicion[i], b.suspicion[i]) &&
         a.prior[i] == b.prior[i] && a.restored[i] == b.restored[i] && a.reasons[i] == b.reasons[i];
}

bool same_stage(const StageReport& a, const StageReport& b) {
  const auto all = [](const StageReport& s) {
    return std::tie(s.name, s.path, s.skipped, s.failed, s.note, s.judged, s.dynamic, s.unknown, s.prior);
  };
  return all(a) == all(b);
}

bool same_point(const MapPointVerdict& a, const MapPointVerdict& b) {
  return a.map_point_id == b.map_point_id && a.vote == b.vote && same_bits(a.suspicion, b.suspicion);
}

template <class T, class Same>
bool same_lists(const std::vector<T>& a, const std::vector<T>& b, const Same& same) {
  return a.size() == b.size() && std::equal(a.begin(), a.end(), b.begin(), same);
}

bool same_report(const FrameReport& a, const FrameReport& b) {
  const auto all = [](const FrameReport& r) {
    return std::tie(r.frame_id, r.call_point, r.notes, r.features, r.rejected, r.restored,
                    r.wait_for_keyframe, r.doubts);
  };
  return all(a) == all(b) && same_lists(a.stages, b.stages, same_stage);
}

}  // namespace

VerdictDifference difference(const Verdict& a, const Verdict& b) {
  const std::size_t both = std::min(a.size(), b.size());
  VerdictDifference found;
  found.decisions = found.features = std::max(a.size(), b.size()) - both;
  for (std::size_t i = 0; i < both; ++i) {
    found.decisions += a.decision[i] != b.decision[i] ? 1 : 0;
    found.features += same_feature(a, b, i) ? 0 : 1;
  }
  found.report = !same_report(a.report, b.report) || !same_lists(a.map_points, b.map_points, same_point);
  return found;
}

}  // namespace dynfilter::recorder
