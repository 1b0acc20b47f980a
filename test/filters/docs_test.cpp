// SPDX-License-Identifier: MIT
#include <cstdlib>
#include <dynfilter/config/parameters.hpp>
#include <dynfilter/config/registry.hpp>
#include <dynfilter/pipeline/builtin_filters.hpp>
#include <fstream>
#include <sstream>
#include <string>

#include "../../examples/multi_model/multi_model.hpp"
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

/// The table on the page is that of the card, or becomes it with DYNFILTER_UPDATE_DOCS=1.
void check_table(const std::string& path, const FilterCard& card) {
  std::string page = read(path);
  const auto begin = page.find(kBegin), end = page.find(kEnd);
  REQUIRE(begin != std::string::npos);
  REQUIRE(end != std::string::npos);
  const auto from = begin + std::string(kBegin).size();
  const std::string wanted = dynfilter_test::kParameterHead + dynfilter_test::parameter_rows(card.parameters);
  if (std::getenv("DYNFILTER_UPDATE_DOCS") != nullptr)
    std::ofstream(path) << page.replace(from, end - from, wanted);
  else
    CHECK(page.substr(from, end - from) == wanted);
}

}  // namespace

TEST_CASE("every rejector has a card in docs/reference/filters whose table is that of its parameters") {
  const Registry registry = builtin_filters();
  const std::string index = read(std::string(DYNFILTER_SOURCE_DIR) + "/docs/reference/filters/README.md");
  for (const std::string& name : registry.names()) {
    CAPTURE(name);
    CHECK(index.find("[" + name + "](" + name + ".md)") != std::string::npos);
    check_table(std::string(DYNFILTER_SOURCE_DIR) + "/docs/reference/filters/" + name + ".md",
                registry.find(name)->card);
  }
}

TEST_CASE("background_motion's card begins with state, residual, decision and symbols, before any constant") {
  const std::string card = read(DYNFILTER_SOURCE_DIR "/docs/reference/filters/background_motion.md");
  std::size_t last = 0;
  for (const char* part :
       {"**State.**", "**Residual.**", "**Decision.**", "| symbol |", "## The model", "## Constants"}) {
    CAPTURE(part);
    const std::size_t at = card.find(part);
    REQUIRE(at != std::string::npos);
    CHECK(at > last);
    last = at;
  }
}

TEST_CASE("the page of the example multi_model has the table of its parameters") {
  Registry registry;
  registry.add<multi_model::MultiModelFilter>();
  check_table(DYNFILTER_SOURCE_DIR "/examples/multi_model/README.md", registry.find("multi_model")->card);
}

}  // namespace docs_test
