// SPDX-License-Identifier: MIT
#include <cstdlib>
#include <dynfilter/keyframe/make_selector.hpp>
#include <fstream>
#include <sstream>

#include "doctest/doctest.h"

using namespace dynfilter;

namespace {

template <class P>
std::string table() {
  std::ostringstream out;
  out << "| parameter | default | unit | range | meaning |\n|---|---|---|---|---|\n";
  for (const FieldInfo& field : describe_parameters<P>())
    out << "| `" << field.name << "` | " << field.default_value << " | " << field.unit << " | " << field.range
        << " | " << field.doc << " |\n";
  return out.str();
}

}  // namespace

// DYNFILTER_UPDATE_DOCS=1 writes the tables instead.
TEST_CASE("the tables of docs/keyframes.md are those of the parameters") {
  const std::string path = std::string(DYNFILTER_SOURCE_DIR) + "/docs/keyframes.md";
  std::stringstream file;
  file << std::ifstream(path).rdbuf();
  std::string text = file.str();
  for (const auto& [kind, wanted] :
       {std::pair<std::string, std::string>{"pose_change", table<PoseChangeParams>()},
        {"vertex_cover", table<VertexCoverParams>()}}) {
    const std::string name = kind;  // clang's lambdas take no structured binding
    CAPTURE(name);
    const std::string begin = "<!-- parameters of " + name + " -->\n";
    REQUIRE(text.find(begin) != std::string::npos);
    const std::size_t from = text.find(begin) + begin.size(), to = text.find("<!-- end -->", from);
    REQUIRE(to != std::string::npos);
    if (std::getenv("DYNFILTER_UPDATE_DOCS") != nullptr)
      text.replace(from, to - from, wanted);
    else
      CHECK(text.substr(from, to - from) == wanted);
  }
  if (std::getenv("DYNFILTER_UPDATE_DOCS") != nullptr) std::ofstream(path) << text;
}
