// SPDX-License-Identifier: MIT
#include "layering/include_check.hpp"

#include "doctest/doctest.h"

using namespace layering;

namespace {

const std::string kHead = "// SPDX-License-Identifier: MIT\n#pragma once\n";

std::size_t complaints(const std::string& path, const std::string& includes) {
  return complaints_about(path, kHead + includes).size();
}

std::set<std::string> reachable(const std::string& folder) {
  std::set<std::string> seen;
  std::vector<std::string> open{folder};
  while (!open.empty()) {
    const std::string next = open.back();
    open.pop_back();
    for (const std::string& below : allowed_folders().at(next))
      if (seen.insert(below).second) open.push_back(below);
  }
  return seen;
}

}  // namespace

TEST_CASE("no header of the toolkit includes against the flow of data") {
  const std::filesystem::path headers = std::filesystem::path(DYNFILTER_SOURCE_DIR) / "include/dynfilter";
  REQUIRE(std::filesystem::exists(headers / "core/camera.hpp"));
  for (const std::string& complaint : complaints_about_tree(headers)) FAIL_CHECK(complaint);
}

TEST_CASE("the table itself has no circle and keeps filters away from files and figures") {
  for (const auto& [folder, below] : allowed_folders()) {
    const auto& shown = folder;  // clang 14 captures no structured binding
    CAPTURE(shown);
    CHECK(reachable(folder).count(folder) == 0);
    for (const std::string& name : below) CHECK(allowed_folders().count(name) == 1);
  }
  for (const char* outside : {"io", "eval", "synth", "pipeline"})
    CHECK(reachable("filters").count(outside) == 0);
  CHECK(reachable("core").empty());
}

TEST_CASE("stated alignments and functions that depend on the processor are found") {
  for (const char* code :
       {"const __m256i v = _mm256_load_si256(p);", "_mm_store_ps(to, v);", "_mm256_stream_ps(to, v);",
        "using Eight = float __attribute__((vector_size(32), aligned(4)));",
        "__builtin_assume_aligned(p, 32)"})
    CHECK(complaints("mapping/x.hpp", std::string(code) + "\n") == 1);
  for (const char* code :
       {"_mm256_loadu_ps(p)", "_mm_loadl_epi64(p)", "using Four = float __attribute__((vector_size(16)));",
        "#include <immintrin.h>", "#include <arm_neon.h>", "alignas(32) float x[8];", "// aligned(4)"}) {
    const bool own = std::string(code).find("align") == std::string::npos;
    CHECK(complaints("mapping/x.hpp", std::string(code) + "\n") == (own ? 1 : 0));
    CHECK(complaints("core/simd.hpp", std::string(code) + "\n") == 0);
  }
  CHECK(complaints("core/simd.hpp", "_mm_store_ps(to, v);\n") == 1);
  for (const char* code :
       {"std::exp(x)", "1 / std::hypot(x, y)", "std::powf(x, 2)", "Eigen::AngleAxisd(a, b)"}) {
    CHECK(complaints("filters/x.hpp", std::string(code) + "\n") == 1);
    CHECK(complaints("mapping/x.hpp", std::string(code) + "\n") == 0);
  }
  for (const char* code : {"std::sqrt(x)", "portable::exp(x)", "// not std::exp(x)", "std::expected(x)"})
    CHECK(complaints("filters/x.hpp", std::string(code) + "\n") == 0);
}

TEST_CASE("an include that points back is found, one that follows the flow is not") {
  CHECK(complaints("filters/x.hpp", "#include <dynfilter/core/filter.hpp>\n#include <vector>\n") == 0);
  CHECK(complaints("core/x.hpp", "#include <dynfilter/filters/y.hpp>\n") == 1);
  CHECK(complaints("core/x.hpp", "  #  include \"dynfilter/pipeline/y.hpp\"\n") == 1);
  CHECK(complaints("geometry/x.hpp", "#include <dynfilter/correspondence/y.hpp>\n") == 1);
  CHECK(complaints("evidence/x.hpp", "#include <dynfilter/filters/y.hpp>\n") == 1);
  CHECK(complaints("filters/x.hpp",
                   "#include <dynfilter/mapping/tum.hpp>\n#include <dynfilter/synth/s.hpp>\n") == 2);
  CHECK(complaints("core/x.hpp", "// #include <dynfilter/filters/y.hpp>\n") == 0);
  CHECK(complaints_about("core/x.hpp", kHead + "#include <dynfilter/filters/y.hpp>\n").front() ==
        "core/x.hpp: includes <dynfilter/filters/y.hpp>, but core/ may not use filters/");
}

TEST_CASE("heavy and foreign headers come in by their own door only") {
  CHECK(complaints("filters/x.hpp", "#include <opencv2/core.hpp>\n") == 0);
  CHECK(complaints("filters/x.hpp", "#include <opencv2/opencv.hpp>\n") == 1);
  CHECK(complaints("filters/x.hpp", "#include <opencv2/dnn.hpp>\n") == 1);
  CHECK(complaints("semantic/x.hpp", "#include <opencv2/dnn.hpp>\n") == 1);
  CHECK(complaints("cluster/x.hpp", "#include <flann/algorithms/kdtree_single_index.h>\n") == 1);
  CHECK(complaints("filters/x.hpp", "#include <flann/algorithms/kdtree_single_index.h>\n") == 0);
  CHECK(complaints("core/x.hpp", "#include \"camera.hpp\"\n") == 1);
  CHECK(complaints("core/x.hpp", "#include <dynfilter/dynfilter.hpp>\n") == 1);
}

TEST_CASE("functions are included by their own header only, and details by their own folder") {
  CHECK(bodies_of("semantic/ply.hpp") == "semantic/detail/ply-inl.hpp");
  CHECK(bodies_of("hosts/orb_slam/traits.hpp") == "hosts/orb_slam/detail/traits-inl.hpp");
  CHECK(complaints("semantic/ply.hpp", "#include <dynfilter/semantic/detail/ply-inl.hpp>\n") == 0);
  CHECK(complaints("semantic/x.hpp", "#include <dynfilter/semantic/detail/ply-inl.hpp>\n") == 1);
  CHECK(complaints("hosts/x.hpp", "#include <dynfilter/semantic/detail/rows.hpp>\n") == 1);
  CHECK(complaints("semantic/x.hpp", "#include <dynfilter/semantic/detail/rows.hpp>\n") == 0);
  CHECK(complaints("semantic/detail/ply-inl.hpp",
                   "#include <dynfilter/semantic/ply.hpp>\n#include <vector>\n") == 0);
  CHECK(complaints("semantic/detail/ply-inl.hpp", "#include <dynfilter/semantic/text.hpp>\n") == 1);
  CHECK(complaints("semantic/detail/ply-inl.hpp", "") == 1);
}

TEST_CASE("a header in no known folder, without licence or guard is found") {
  CHECK(complaints("elsewhere/x.hpp", "") == 1);
  CHECK(complaints_about("core/x.hpp", "#pragma once\n").size() == 1);
  CHECK(complaints_about("core/x.hpp", "// SPDX-License-Identifier: MIT\nint x;\n").size() == 1);
}
