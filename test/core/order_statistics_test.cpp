// SPDX-License-Identifier: MIT
#include <cmath>
#include <dynfilter/core/order_statistics.hpp>

#include "doctest/doctest.h"

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
