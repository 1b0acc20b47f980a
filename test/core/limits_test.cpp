// SPDX-License-Identifier: MIT
#include <dynfilter/config/yaml_text.hpp>
#include <dynfilter/core/limits.hpp>
#include <fstream>
#include <sstream>
#include <string>

#include "doctest/doctest.h"

namespace limits_test {

TEST_CASE("the table of docs/explanation/trust.md has every limit with its value") {
  using namespace dynfilter::limits;
  std::stringstream docs;
  docs << std::ifstream(DYNFILTER_SOURCE_DIR "/docs/explanation/trust.md").rdbuf();
  const auto has = [&](const std::string& name, long long value) {
    const std::string cells = " | " + std::to_string(value) + " | `" + name + "` | ";
    CAPTURE(cells);
    CHECK(docs.str().find(cells) != std::string::npos);
  };
  has("kMaxBoxes", static_cast<long long>(kMaxBoxes));
  has("kMaxFeatures", static_cast<long long>(kMaxFeatures));
  has("kMaxCrowd", static_cast<long long>(kMaxCrowd));
  has("kMaxWindow", static_cast<long long>(kMaxWindow));
  has("kMaxBoxFeaturePairs", static_cast<long long>(kMaxBoxFeaturePairs));
  has("kMaxImageSide_px", kMaxImageSide_px);
  has("kMaxImagePixels", kMaxImagePixels);
  has("kMaxImageBytes", static_cast<long long>(kMaxImageBytes));
  has("kMaxLineBytes", static_cast<long long>(kMaxLineBytes));
  has("kMaxTextFields", static_cast<long long>(kMaxTextFields));
  has("kMaxMessageLineBytes", static_cast<long long>(kMaxMessageLineBytes));
  has("kMaxSurplusBytes", static_cast<long long>(kMaxSurplusBytes));
  has("kMaxBytes", static_cast<long long>(dynfilter::YamlText::kMaxBytes));
  has("kMaxDepth", dynfilter::YamlText::kMaxDepth);
}

}  // namespace limits_test
