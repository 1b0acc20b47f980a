// SPDX-License-Identifier: MIT
#include "io/association.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <queue>
#include <tuple>

namespace dynfilter::io {

namespace detail {

/// The closest pair of two lists is always adjacent in their merged order.
/// So only adjacent stamps are candidates, and each removed pair makes at most one new candidate.
class StampPairing {
 public:
  StampPairing(const std::vector<double>& a_s, const std::vector<double>& b_s, double max_gap_s);

  std::vector<std::pair<std::size_t, std::size_t>> pairs();

 private:
  struct Stamp {
    double time_s;
    bool of_b;
    std::size_t index;
    std::size_t last, next;  ///< neighbours in the merged order, among those without a partner
  };
  /// Gap [s], index into a, index into b; places of the earlier and the later stamp.
  using Candidate = std::tuple<double, std::size_t, std::size_t, std::size_t, std::size_t>;

  /// Adds the stamp at this place and the next one if they may be a pair.
  void consider(std::size_t place);
  void take(std::size_t place);

  double max_gap_s_;
  std::vector<Stamp> merged_;  ///< the first and the last belong to no list
  std::vector<bool> taken_;
  std::priority_queue<Candidate, std::vector<Candidate>, std::greater<>> candidates_;
};

inline StampPairing::StampPairing(const std::vector<double>& a_s, const std::vector<double>& b_s,
                                  double max_gap_s)
    : max_gap_s_(max_gap_s) {
  merged_.reserve(a_s.size() + b_s.size() + 2);
  merged_.push_back({});
  for (std::size_t i = 0, j = 0; i < a_s.size() || j < b_s.size();) {
    const bool of_b = i == a_s.size() || (j < b_s.size() && b_s[j] < a_s[i]);
    merged_.push_back({of_b ? b_s[j] : a_s[i], of_b, of_b ? j : i, 0, 0});
    of_b ? ++j : ++i;
  }
  merged_.push_back({});
  taken_.assign(merged_.size(), false);
  taken_.front() = taken_.back() = true;
  for (std::size_t place = 1; place + 1 < merged_.size(); ++place) {
    merged_[place].last = place - 1;
    merged_[place].next = place + 1;
    consider(place);
  }
}

inline void StampPairing::consider(std::size_t place) {
  const Stamp& stamp = merged_[place];
  const std::size_t after = stamp.next;
  if (taken_[place] || taken_[after] || merged_[after].of_b == stamp.of_b) return;
  const Stamp& other = merged_[after];
  const double gap_s = std::abs(stamp.time_s - other.time_s);
  if (gap_s < max_gap_s_)
    candidates_.emplace(gap_s, stamp.of_b ? other.index : stamp.index, stamp.of_b ? stamp.index : other.index,
                        place, after);
}

inline void StampPairing::take(std::size_t place) {
  taken_[place] = true;
  const Stamp& stamp = merged_[place];
  merged_[stamp.last].next = stamp.next;
  merged_[stamp.next].last = stamp.last;
}

inline std::vector<std::pair<std::size_t, std::size_t>> StampPairing::pairs() {
  std::vector<std::pair<std::size_t, std::size_t>> pairs;
  while (!candidates_.empty()) {
    const auto [gap_s, i, j, earlier, later] = candidates_.top();
    candidates_.pop();
    if (taken_[earlier] || taken_[later]) continue;
    take(earlier);
    take(later);
    pairs.emplace_back(i, j);
    consider(merged_[earlier].last);
  }
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

}  // namespace detail

std::vector<std::pair<std::size_t, std::size_t>> associate(const std::vector<double>& a_s,
                                                           const std::vector<double>& b_s, double max_gap_s) {
  return detail::StampPairing(a_s, b_s, max_gap_s).pairs();
}

}  // namespace dynfilter::io
