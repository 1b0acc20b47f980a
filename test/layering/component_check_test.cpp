// SPDX-License-Identifier: MIT
#include "layering/component_check.hpp"

#include "doctest/doctest.h"

using namespace layering;

namespace {

const std::string kComponents =
    "\ndynfilter_component(core OPENCV core)\n"
    "dynfilter_component(below COMPONENTS core)\n"
    "  dynfilter_component(apart COMPONENTS below HEADERS below/apart)\n"
    "dynfilter_component(above COMPONENTS below\n  OPENCV imgproc)\n";

std::map<std::string, std::string> headers() {
  return {{"core/a.hpp", "#include <opencv2/core.hpp>\n"},
          {"below/b.hpp", "#include <dynfilter/core/a.hpp>\n"},
          {"below/detail/b-inl.hpp", "#include <dynfilter/below/b.hpp>\n"},
          {"below/apart.hpp", "#include <dynfilter/below/b.hpp>\n"},
          {"above/c.hpp", "#include <opencv2/imgproc.hpp>\n#include <dynfilter/below/b.hpp>\n"}};
}

std::vector<std::string> faults(const std::map<std::string, std::string>& files) {
  return faults_of_components(components_of(kComponents), files);
}

}  // namespace

TEST_CASE("components link what their headers include, and no more") {
  const std::filesystem::path source = DYNFILTER_SOURCE_DIR;
  const Components all = components_of(read_text(source / "cmake/components.cmake"));
  CHECK(all.count("core") == 1);
  CHECK(all.count("filters") == 1);
  std::map<std::string, std::string> files;
  const std::filesystem::path root = source / "include/dynfilter";
  for (const auto& entry : std::filesystem::recursive_directory_iterator(root))
    if (entry.is_regular_file())
      files[entry.path().lexically_relative(root).generic_string()] = read_text(entry.path());
  for (const std::string& fault : faults_of_components(all, files)) FAIL_CHECK(fault);
}

TEST_CASE("a component that links too little or too much is found") {
  CHECK(faults(headers()).empty());
  auto unused = headers();
  unused["above/c.hpp"] = "#include <opencv2/imgproc.hpp>\n";
  CHECK(faults(unused) == std::vector<std::string>{"above links below and includes nothing of it"});
  auto upwards = headers();
  upwards["above/detail/c-inl.hpp"] = "";
  upwards["below/b.hpp"] += "#include <dynfilter/above/c.hpp>\n";
  CHECK(faults(upwards) == std::vector<std::string>{"below includes headers of above and does not link it"});
  auto image = headers();
  image["below/b.hpp"] += "#include <opencv2/imgproc/imgproc.hpp>\n";
  CHECK(faults(image) == std::vector<std::string>{"below includes opencv2/imgproc and does not link it"});
  auto no_image = headers();
  no_image["above/c.hpp"] = "#include <dynfilter/below/b.hpp>\n";
  CHECK(faults(no_image) ==
        std::vector<std::string>{"above links opencv_imgproc and includes nothing of it"});
  auto optional = headers();
  optional["below/b.hpp"] += "#ifdef DYNFILTER_HAS_APART\n#include <opencv2/imgproc.hpp>\n#endif\n";
  CHECK(faults(optional).empty());
}
