// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstdlib>
#include <dynfilter/config/parameters.hpp>
#include <fstream>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "doctest/doctest.h"

namespace dynfilter_test {

/// A parameter's default, unit and range. Of a long list, such as the classes that may move, the first ones.
inline std::string default_cell(const dynfilter::FieldInfo& field) {
  constexpr std::size_t kWidest = 60, kShown = 24;  // columns
  std::string cell = field.default_value;
  if (cell.size() > kWidest) {
    const auto count = std::count(cell.begin(), cell.end(), ',') + 1;
    cell = cell.substr(0, cell.rfind(',', kShown)) + ", ... " + std::to_string(count) + " in all]";
  }
  if (!field.unit.empty()) cell += " " + field.unit;
  if (!field.range.empty()) cell += " (" + field.range + ")";
  return cell;
}

/// The rows of parameters below their table's head.
inline std::string parameter_rows(const std::vector<dynfilter::FieldInfo>& fields) {
  std::string rows = "|---|---|---|\n";
  for (const dynfilter::FieldInfo& field : fields)
    rows += "| `" + field.name + "` | " + default_cell(field) + " | " + field.doc + " |\n";
  return rows;
}

constexpr const char* kParameterHead = "| parameter | default | meaning |\n";

/// The parameter table of P for a page of docs/.
template <class P>
std::string parameter_table() {
  return kParameterHead + parameter_rows(dynfilter::describe_parameters<P>());
}

/// Checks that a page of docs/ has these tables, each {name, table}.
/// `path` is relative to the repository's root.
/// Each table is between `<!-- parameters of NAME -->` and `<!-- end -->`.
/// DYNFILTER_UPDATE_DOCS=1 writes them instead.
inline void check_parameter_tables(const std::string& path,
                                   const std::vector<std::pair<std::string, std::string>>& tables) {
  const std::string file = std::string(DYNFILTER_SOURCE_DIR) + "/" + path;
  const bool update = std::getenv("DYNFILTER_UPDATE_DOCS") != nullptr;
  std::stringstream read;
  read << std::ifstream(file).rdbuf();
  std::string text = read.str();
  for (const auto& table : tables) {
    CAPTURE(table.first);
    const std::string begin = "<!-- parameters of " + table.first + " -->\n";
    REQUIRE(text.find(begin) != std::string::npos);
    const std::size_t from = text.find(begin) + begin.size(), to = text.find("<!-- end -->", from);
    REQUIRE(to != std::string::npos);
    if (update)
      text.replace(from, to - from, table.second);
    else
      CHECK(text.substr(from, to - from) == table.second);
  }
  if (update) std::ofstream(file) << text;
}

}  // namespace dynfilter_test
