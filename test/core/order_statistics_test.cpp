// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <dynfilter/core/order_statistics.hpp>
#include <vector>

#include "doctest/doctest.h"

namespace order_statistics_test {

using namespace dynfilter;

TEST_CASE("order statistics: by hand") {
  std::vector<float> values{5, 1, 4, 2, 3};
  CHECK(median_in_place(values) == 3.0F);
  CHECK(quantile_in_place(values, 20) == 2.0F);
  CHECK(quantile_in_place(values, 0) == 1.0F);
  std::vector<double> even{4, 1, 3, 2};
  CHECK(median_in_place(even) == 3.0);  // the upper one
  std::vector<float> none;
  CHECK(std::isnan(median_in_place(none)));
}

TEST_CASE("averaged median: the middle value, or the mean of the two middle ones") {
  std::vector<double> odd{5, 1, 4, 2, 3}, even{4, 1, 3, 2}, one{7}, none;
  CHECK(averaged_median_in_place(odd) == 3.0);
  CHECK(averaged_median_in_place(even) == 2.5);
  CHECK(averaged_median_in_place(one) == 7.0);
  CHECK(std::isnan(averaged_median_in_place(none)));
  std::vector<double> many;
  for (int i = 0; i < 100; ++i) many.push_back((i * 37) % 100);  // 0 to 99 in another order
  CHECK(averaged_median_in_place(many) == 49.5);
}

TEST_CASE("selection and sort: what std::sort gives, whatever the values") {
  std::uint32_t state = 1;
  const auto next = [&state] { return (state = state * 1664525U + 1013904223U) >> 8; };
  for (const std::uint32_t kinds : {1U, 2U, 7U, 1000000U})  // many equal ones, all equal
    for (const std::size_t count : {1, 2, 24, 25, 26, 100, 1000})
      for (const int shape : {0, 1, 2, 3}) {
        std::vector<float> values;
        for (std::size_t i = 0; i < count; ++i) values.push_back(static_cast<float>(next() % kinds));
        if (shape == 1) std::sort(values.begin(), values.end());
        if (shape == 2) std::sort(values.rbegin(), values.rend());
        if (shape == 3) std::sort(values.begin() + static_cast<std::ptrdiff_t>(count / 2), values.end());
        std::vector<float> sorted = values;
        std::sort(sorted.begin(), sorted.end());
        for (const std::size_t at : {std::size_t{0}, count / 3, count / 2, count - 1}) {
          std::vector<float> copy = values;
          CHECK(select_in_place(copy.data(), count, at) == sorted[at]);
          std::sort(copy.begin(), copy.end());
          CHECK(copy == sorted);  // no value was lost
          std::vector<float> in_order = values;
          sort_in_place(in_order.data(), count);
          CHECK(in_order == sorted);
        }
      }
  std::vector<float> nothing(100, std::nanf(""));
  CHECK(std::isnan(median_in_place(nothing)));
}

TEST_CASE("densest window: most values win, of equal ones the lowest") {
  std::vector<float> two_layers{3.0F, 1.0F, 3.1F, 1.1F, 3.2F, 8.0F};
  CHECK(*densest_in_place(two_layers, 0.25F) == 3.1F);
  std::vector<float> tie{2.0F, 1.0F, 2.1F, 1.1F};
  CHECK(*densest_in_place(tie, 0.2F) == 1.1F);
  std::vector<float> apart{3, 1, 2};
  CHECK(*densest_in_place(apart, 0.0F) == 1.0F);
  std::vector<float> none;
  CHECK_FALSE(densest_in_place(none, 1.0F).has_value());
}

}  // namespace order_statistics_test
