// SPDX-License-Identifier: MIT
#pragma once

#include <cstdlib>
#include <dynfilter/config/parameters.hpp>
#include <fstream>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "doctest/doctest.h"

namespace dynfilter_test {

/// The parameter table of P for a page of docs/.
template <class P>
std::string parameter_table() {
  std::ostringstream out;
  out << "| parameter | default | unit | range | meaning |\n|---|---|---|---|---|\n";
  for (const dynfilter::FieldInfo& field : dynfilter::describe_parameters<P>())
    out << "| `" << field.name << "` | " << field.default_value << " | " << field.unit << " | " << field.range
        << " | " << field.doc << " |\n";
  return out.str();
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
