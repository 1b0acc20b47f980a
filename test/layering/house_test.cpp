// SPDX-License-Identifier: MIT
#include <cstdlib>
#include <fstream>
#include <string>

#include "doctest/doctest.h"
#include "layering/house_check.hpp"

using namespace layering;

namespace {

const std::filesystem::path kHeaders = std::filesystem::path(DYNFILTER_SOURCE_DIR) / "include/dynfilter";

void check_size(const std::string& what, const Size& size, const Size& most) {
  MESSAGE(what << ": " << size.files << " files, " << size.lines << " lines (at most " << most.files << ", "
               << most.lines << ")");
  CHECK(size.files <= most.files);
  CHECK(size.lines <= most.lines);
}

}  // namespace

TEST_CASE("the toolkit stays small enough to be understood, and its doors stay light") {
  const House house = house_at(kHeaders);
  check_size("include/dynfilter", size_of(house), {260, 35000});
  check_size("dynfilter.hpp", size_of(reached_from(house, "dynfilter.hpp")), {25, 1405});
  check_size("hosts/orb_slam.hpp", size_of(reached_from(house, "hosts/orb_slam.hpp")), {30, 2500});
}

TEST_CASE("no clock below the pipeline, and no shared header for one filter") {
  const House house = house_at(kHeaders);
  for (const std::string& fault : faults_of_clocks(house)) FAIL_CHECK(fault);
  for (const std::string& fault : faults_of_sharing(house)) FAIL_CHECK(fault);
}

TEST_CASE("small units are part of their neighbours") {
  const std::set<std::string> exceptions{
      "dynfilter.hpp",          "version.hpp",  // what users include, what CMake reads
      "core/inline.hpp",                        // read by every file of functions
      "core/span.hpp",                          // read by the smallest headers
      "config/field_table.hpp",  // lets structs of parameters be read without the reader of YAML
  };
  for (const std::string& fault : faults_of_small_units(house_at(kHeaders), 40, exceptions))
    FAIL_CHECK(fault);
}

TEST_CASE("CONTRIBUTING has the table of rooms and what each may include") {
  const std::filesystem::path file = std::filesystem::path(DYNFILTER_SOURCE_DIR) / "CONTRIBUTING.md";
  const std::string text = read_text(file), begin = "<!-- rooms -->\n", end = "<!-- end of rooms -->";
  REQUIRE(contains(text, begin));
  const std::size_t from = text.find(begin) + begin.size(), to = text.find(end, from);
  REQUIRE(to != std::string::npos);
  if (std::getenv("DYNFILTER_UPDATE_DOCS") != nullptr)
    std::ofstream(file) << text.substr(0, from) + table_of_rooms() + text.substr(to);
  else
    CHECK(text.substr(from, to - from) == table_of_rooms());
}

TEST_CASE("what the toolkit consists of is counted") {
  const House house{
      {"a.hpp", "#include <dynfilter/core/b.hpp>\n"},
      {"core/b.hpp", "int b();\n#ifdef X\n#include <dynfilter/core/detail/b-inl.hpp>\n#endif\n"},
      {"core/detail/b-inl.hpp", "#include <dynfilter/core/c.hpp>\n"},
      {"core/c.hpp", "\n"}};
  CHECK(size_of(house).files == 4);
  CHECK(size_of(house).lines == 7);
  const House reached = reached_from(house, "a.hpp");
  CHECK(reached.size() == 2);
  CHECK(size_of(reached).lines == 5);
}

TEST_CASE("a shared header for one filter is found, also through another header") {
  House house{{"geometry/deep.hpp", ""},
              {"geometry/shared.hpp", "#include <dynfilter/geometry/deep.hpp>\n"},
              {"filters/detail/one-inl.hpp", "#include <dynfilter/geometry/shared.hpp>\n"}};
  CHECK(users_of(house, "geometry/deep.hpp") == std::set<std::string>{"filters/one.hpp"});
  CHECK(faults_of_sharing(house).size() == 2);
  house["filters/two.hpp"] = "#include <dynfilter/geometry/deep.hpp>\n";
  CHECK(faults_of_sharing(house) ==
        std::vector<std::string>{"geometry/shared.hpp: only filters/one.hpp uses it"});
  house["pipeline/stage.hpp"] = "#include <dynfilter/geometry/shared.hpp>\n";
  CHECK(faults_of_sharing(house).empty());
}

TEST_CASE("a clock, stages and small units are found") {
  CHECK(faults_of_clocks({{"evidence/x.hpp", "#include <chrono>\n"}}).size() == 1);
  CHECK(faults_of_clocks({{"filters/x.hpp", "#include <dynfilter/pipeline/stage.hpp>\n"}}).size() == 1);
  CHECK(faults_of_clocks({{"pipeline/x.hpp", "#include <chrono>\n"}}).empty());
  const House house{{"core/x.hpp", "\n\n"}, {"core/detail/x-inl.hpp", "\n"}};
  CHECK(faults_of_small_units(house, 4, {}) == std::vector<std::string>{"core/x.hpp: 3 lines"});
  CHECK(faults_of_small_units(house, 3, {}).empty());
  CHECK(faults_of_small_units(house, 4, {"core/x.hpp"}).empty());
}
