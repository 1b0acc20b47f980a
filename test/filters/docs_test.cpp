// SPDX-License-Identifier: MIT
#include <cstdlib>
#include <dynfilter/config/parameters.hpp>
#include <dynfilter/config/registry.hpp>
#include <dynfilter/pipeline/builtin_filters.hpp>
#include <fstream>
#include <sstream>
#include <string>

#include "doctest/doctest.h"
#include "support/parameter_tables.hpp"

namespace docs_test {

using namespace dynfilter;

namespace {

constexpr const char* kBegin = "<!-- parameters -->\n";
constexpr const char* kEnd = "<!-- end -->";

std::string read(const std::string& path) {
  std::ifstream file(path);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

}  // namespace

// DYNFILTER_UPDATE_DOCS=1 writes the tables instead.
TEST_CASE("every rejector has a card in docs/reference/filters whose table is that of its parameters") {
  const Registry registry = builtin_filters();
  const std::string index = read(std::string(DYNFILTER_SOURCE_DIR) + "/docs/reference/filters/README.md");
  for (const std::string& name : registry.names()) {
    CAPTURE(name);
    CHECK(index.find("[" + name + "](" + name + ".md)") != std::string::npos);
    const std::string path = std::string(DYNFILTER_SOURCE_DIR) + "/docs/reference/filters/" + name + ".md";
    std::string card = read(path);
    const auto begin = card.find(kBegin), end = card.find(kEnd);
    REQUIRE(begin != std::string::npos);
    REQUIRE(end != std::string::npos);
    const auto from = begin + std::string(kBegin).size();
    const std::string wanted =
        dynfilter_test::kParameterHead + dynfilter_test::parameter_rows(registry.find(name)->card.parameters);
    if (std::getenv("DYNFILTER_UPDATE_DOCS") != nullptr)
      std::ofstream(path) << card.replace(from, end - from, wanted);
    else
      CHECK(card.substr(from, end - from) == wanted);
  }
}

}  // namespace docs_test
