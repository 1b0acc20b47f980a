// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <dynfilter/filters/detail/grid_motion_statistics.hpp>
#include <fstream>
#include <limits>
#include <map>
#include <random>
#include <sstream>
#include <string>

#include "doctest/doctest.h"

namespace gms_test {

using namespace dynfilter;

namespace {

const cv::Size kSize(640, 480);

struct Matches {
  std::vector<cv::Point2f> first, second;
};

/// Groups of features that move together, and the given share of mismatches.
Matches scene(int n, double mismatches, unsigned seed) {
  std::mt19937 random(seed);
  const auto uniform = [&](double low, double high) {
    return low + (high - low) * static_cast<double>(random()) / 4294967296.0;
  };
  Matches m;
  for (int i = 0; i < n; ++i) {
    const cv::Point2d clump(80 + 120 * static_cast<int>(random() % 5),
                            60 + 120 * static_cast<int>(random() % 4));
    const cv::Point2d p = clump + cv::Point2d(uniform(-50, 50), uniform(-50, 50));
    cv::Point2d q = p + cv::Point2d(7, -4);
    if (uniform(0, 1) < mismatches) q = {uniform(0, 640), uniform(0, 480)};
    m.first.emplace_back(p);
    m.second.emplace_back(q);
  }
  return m;
}

struct Cell {
  int x, y;
  bool operator==(const Cell& o) const { return x == o.x && y == o.y; }
};

/// Reference implementation of the paper's definition: every match against every other.
class Twin {
 public:
  Twin(const Matches& m, const GmsParams& params, int cells) : params_(params), m_(m), cells_(cells) {}

  static Cell cell(const cv::Point2f& p, int cells, float dx, float dy) {
    const auto unit = [](float v, int size) {
      return std::clamp(v / static_cast<float>(size), 0.0F, 0.999999F);
    };
    const auto n = static_cast<float>(cells);
    return {static_cast<int>(std::floor(unit(p.x, kSize.width) * n + dx)),
            static_cast<int>(std::floor(unit(p.y, kSize.height) * n + dy))};
  }
  static bool exists(const Cell& c, int cells, int from_x = 0, int from_y = 0) {
    return c.x >= from_x && c.y >= from_y && c.x < cells && c.y < cells;
  }
  static Cell neighbour(const Cell& c, int j) { return {c.x + (j - 1) % 3 - 1, c.y + (j - 1) / 3 - 1}; }

  std::vector<std::uint8_t> run() {
    const std::size_t n = m_.first.size();
    std::vector<std::uint8_t> kept(n, 0);
    for (int shift = 0; shift < 4; ++shift) {
      const bool right = (shift & 1) != 0, down = (shift & 2) != 0;
      std::vector<Cell> a(n), b(n);
      for (std::size_t i = 0; i < n; ++i) {
        a[i] = cell(m_.first[i], cells_, right ? 0.5F : 0, down ? 0.5F : 0);
        if (!exists(a[i], cells_, right ? 1 : 0, down ? 1 : 0)) a[i] = {-9, -9};
        b[i] = cell(m_.second[i], cells_, 0, 0);
      }
      for (std::size_t i = 0; i < n; ++i)
        if (a[i].x >= 0 && (params_.every_pair || partner(a, b, a[i]) == b[i]) && supported(a, b, a[i], b[i]))
          kept[i] = 1;
    }
    return kept;
  }
  /// Most frequent target cell of a cell; the first in row order wins a tie.
  Cell partner(const std::vector<Cell>& a, const std::vector<Cell>& b, const Cell& from) const {
    std::map<int, int> count;
    for (std::size_t i = 0; i < a.size(); ++i)
      if (a[i] == from) ++count[b[i].y * cells_ + b[i].x];
    int best = -1, most = 0;
    for (const auto& [to, matches] : count)
      if (matches > most) best = to, most = matches;
    return {best % cells_, best / cells_};
  }
  bool supported(const std::vector<Cell>& a, const std::vector<Cell>& b, const Cell& from,
                 const Cell& to) const {
    int support = 0, matches = 0, pairs = 0;
    for (int j = 1; j <= 9; ++j) {
      const Cell l = neighbour(from, j), r = neighbour(to, j);
      if (!exists(l, cells_) || !exists(r, cells_)) continue;
      ++pairs;
      for (std::size_t i = 0; i < a.size(); ++i) {
        matches += a[i] == l ? 1 : 0;
        support += a[i] == l && b[i] == r ? 1 : 0;
      }
    }
    return support >= params_.factor * std::sqrt(static_cast<double>(matches) / pairs);
  }

  GmsParams params_;
  const Matches& m_;
  int cells_;
};

std::vector<std::uint8_t> kept(const Matches& m, const GmsParams& params) {
  std::vector<std::uint8_t> result;
  GridMotionStatistics(params).run(m.first, kSize, m.second, kSize, {}, result);
  return result;
}

GmsParams published() {
  GmsParams params;
  params.grid_cells = 20;
  params.factor = 6;
  params.every_pair = false;
  return params;
}
GmsParams with(int grid_cells, double factor) {
  GmsParams params;
  params.grid_cells = grid_cells;
  params.factor = factor;
  return params;
}

/// F1 of mismatches on one pair of AdelaideRMF; -1 without the file.
double f1_of_mismatches(const std::string& name, const GmsParams& params) {
  std::ifstream file(std::string(DYNFILTER_DATA_DIR) + "/motion/adelaide_rmf/" + name + ".txt");
  if (!file) return -1;
  Matches m;
  std::vector<int> labels;
  for (std::string line; std::getline(file, line);) {
    if (line.empty() || line[0] == '#') continue;
    std::istringstream words(line);
    int label = 0;
    cv::Point2f a, b;
    words >> label >> a.x >> a.y >> b.x >> b.y;
    labels.push_back(label);
    m.first.push_back(a), m.second.push_back(b);
  }
  const std::vector<std::uint8_t> k = kept(m, params);
  int found = 0, wrong = 0;
  for (std::size_t i = 0; i < k.size(); ++i) {
    found += k[i] == 0 && labels[i] == 0 ? 1 : 0;
    wrong += (k[i] == 0) != (labels[i] == 0) ? 1 : 0;
  }
  return 2.0 * found / (2.0 * found + wrong);
}

}  // namespace

TEST_CASE("the decisions are those of the paper's definition, match by match") {
  for (unsigned seed = 0; seed < 3; ++seed)
    for (const double mismatches : {0.0, 0.3, 0.7}) {
      const Matches m = scene(400, mismatches, seed);
      for (GmsParams params : {published(), with(12, 3), with(7, 2)})
        for (const bool every_pair : {false, true}) {
          params.every_pair = every_pair;
          CHECK(kept(m, params) == Twin(m, params, params.grid_cells).run());
        }
      GmsParams adaptive;
      CHECK(kept(m, adaptive) == Twin(m, adaptive, GridMotionStatistics(adaptive).cells_for(400)).run());
    }
}

TEST_CASE("one clump that agrees is kept, one match that does not is not, by hand") {
  // 20 x 20 cells of 32 x 24 px: 40 matches within one cell, all by (+64, +48), and one elsewhere.
  Matches m;
  for (int i = 0; i < 40; ++i) {
    m.first.emplace_back(330.0F + static_cast<float>(i % 8), 250.0F + static_cast<float>(i / 8));
    m.second.push_back(m.first.back() + cv::Point2f(64, 48));
  }
  m.first.emplace_back(335.0F, 252.0F);
  m.second.emplace_back(100.0F, 100.0F);
  const std::vector<std::uint8_t> k = kept(m, published());
  // Nine cells hold 41 matches: 40 >= 6 sqrt(41 / 9) = 12.8.
  CHECK(std::count(k.begin(), k.end() - 1, 1) == 40);
  CHECK(k.back() == 0);
  // 12 of them: 12 >= 6 sqrt(12 / 9) = 6.9. Three: 3 < 6 sqrt(3 / 9) = 3.46.
  m.first.resize(12), m.second.resize(12);
  const auto twelve = kept(m, published());
  CHECK(std::count(twelve.begin(), twelve.end(), 1) == 12);
  m.first.resize(3), m.second.resize(3);
  const auto three = kept(m, published());
  CHECK(std::count(three.begin(), three.end(), 1) == 0);
}

TEST_CASE("points on and beyond the border, and odd ones, are no danger") {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN(),
                  kInf = std::numeric_limits<float>::infinity();
  Matches m = scene(300, 0.2, 9);
  for (const cv::Point2f odd : {cv::Point2f(640, 480), cv::Point2f(-3, 900), cv::Point2f(kNan, 5),
                                cv::Point2f(5, kInf), cv::Point2f(1e30F, -1e30F)}) {
    m.first.push_back(odd), m.second.emplace_back(100.0F, 100.0F);
    m.first.emplace_back(100.0F, 100.0F), m.second.push_back(odd);
  }
  GmsParams all = with(20, 3);
  const std::vector<std::uint8_t> k = kept(m, all);
  CHECK(k[304] == 0);  // not finite
  CHECK(k[305] == 0);
  CHECK(kept({}, all).empty());
  // All at the corner: they agree.
  const Matches corner{std::vector<cv::Point2f>(60, {640, 480}), std::vector<cv::Point2f>(60, {640, 480})};
  const auto at_corner = kept(corner, published());
  CHECK(std::count(at_corner.begin(), at_corner.end(), 1) == 60);
}

TEST_CASE("what is not valid takes no part, and buffers of an earlier call do not matter") {
  const Matches m = scene(500, 0.3, 11), other = scene(900, 0.6, 12);
  std::vector<std::uint8_t> valid(500, 1);
  Matches some;
  for (std::size_t i = 0; i < 500; ++i) {
    valid[i] = i % 3 != 0;
    if (valid[i] != 0) some.first.push_back(m.first[i]), some.second.push_back(m.second[i]);
  }
  GridMotionStatistics gms(with(0, 3));
  std::vector<std::uint8_t> k, ignored;
  gms.run(other.first, kSize, other.second, kSize, {}, ignored);
  gms.run(m.first, kSize, m.second, kSize, valid, k);
  std::vector<std::uint8_t> of_valid;
  for (std::size_t i = 0; i < 500; ++i) {
    if (valid[i] != 0)
      of_valid.push_back(k[i]);
    else
      CHECK(k[i] == 0);
  }
  CHECK(of_valid == kept(some, with(0, 3)));
}

TEST_CASE("mismatches of real pairs are found with one set of parameters" *
          doctest::test_suite("shared_data")) {
  const char* const names[] = {"biscuit",      "biscuitbookbox",    "book",    "breadcube", "breadtoy",
                               "carchipscube", "cubebreadtoychips", "cubetoy", "game",      "toycubecar"};
  double sum = 0, sum_published = 0;
  for (const char* name : names) {
    const double f1 = f1_of_mismatches(name, GmsParams());
    if (f1 < 0) {
      MESSAGE("skipped: no ../shared/data");
      return;
    }
    CAPTURE(name);
    CHECK(f1 >= 0.95);
    sum += f1;
    sum_published += f1_of_mismatches(name, published());
  }
  MESSAGE("mean F1 " << sum / 10 << ", published parameters " << sum_published / 10);
  CHECK(sum / 10 >= 0.97);
  CHECK(sum_published < sum);
}

TEST_CASE("parameters out of range are refused") {
  CHECK_THROWS_AS(GridMotionStatistics(with(41, 3)), ConfigError);
  CHECK_THROWS_AS(GridMotionStatistics(with(-1, 3)), ConfigError);
  CHECK_THROWS_AS(GridMotionStatistics(with(10, std::nan(""))), ConfigError);
}

}  // namespace gms_test
