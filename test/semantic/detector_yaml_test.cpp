// SPDX-License-Identifier: MIT
#include <dynfilter/config/text_lines.hpp>
#include <dynfilter/semantic/detector_yaml.hpp>
#include <fstream>
#include <stdexcept>

#include "doctest/doctest.h"
#include "io/tum_folder.hpp"

namespace detector_yaml_test {

using namespace dynfilter;
using dynfilter_test::TemporaryFolder;

namespace {

struct FixedParams {
  double score = 0.5;
  std::string file;
  static const FieldTable<FixedParams>& fields() {
    static const FieldTable<FixedParams> table{real("score", &FixedParams::score, "", {0, 1}, "of its box"),
                                               text("file", &FixedParams::file, "must be there")};
    return table;
  }
};

/// One box in every image.
class Fixed : public SemanticProvider {
 public:
  using Params = FixedParams;
  static constexpr const char* kName = "fixed";
  static constexpr const char* kSummary = "one box";
  Fixed(Params params, const ProviderFiles& files) : params_(std::move(params)) {
    if (!params_.file.empty()) files.find(params_.file, "any file");
    if (params_.score == 0) throw std::runtime_error("a score of nothing");
  }
  std::string name() const override { return kName; }
  std::optional<SemanticResult> infer(const SemanticImage& image) override {
    Detection box;
    box.score = static_cast<float>(params_.score);
    return SemanticResult{image.frame_id, image.timestamp_s, std::vector<Detection>{box}, {}};
  }

 private:
  Params params_;
};

/// Opens no files, so it needs no folders.
class Silent : public SemanticProvider {
 public:
  using Params = FixedParams;
  static constexpr const char* kName = "silent";
  static constexpr const char* kSummary = "nothing comes";
  explicit Silent(const Params& /*params*/) {}
  std::string name() const override { return kName; }
  std::optional<SemanticResult> infer(const SemanticImage& /*image*/) override { return std::nullopt; }
};

ProviderRegistry registry() {
  ProviderRegistry registry;
  registry.add<Fixed>();
  registry.add<Silent>();
  return registry;
}

std::string complaint_about(const std::string& text, const ProviderFiles& files = {}) {
  try {
    read_detector(YamlDocument::from_text(text, "d.yaml"), registry(), files).make();
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

}  // namespace

TEST_CASE("a detector's YAML makes the provider that it names, as often as asked") {
  DetectorConfig config = read_detector(
      YamlDocument::from_text("other: 1\ndetector: { name: mine, about: x, type: fixed, score: 0.25 }"),
      registry(), {});
  CHECK(config.name == "mine");
  CHECK(config.type == "fixed");
  const auto first = config.make(), second = config.make();
  CHECK(first != second);
  SemanticImage image;
  image.frame_id = 7;
  const auto result = first->infer(image);
  REQUIRE(result);
  CHECK(result->frame_id == 7);
  CHECK(result->detections->at(0).score == 0.25F);
  config = read_detector(YamlDocument::from_text("detector: { type: silent }"), registry(), {});
  CHECK(config.name == "silent");
  CHECK(!config.make()->infer(image));
}

TEST_CASE("what is wrong with a detector's YAML is said with its path and what is known") {
  CHECK(complaint_about("pipeline: { type: fixed }") == "d.yaml: expected the key `detector`");
  CHECK(complaint_about("detector: { score: 1 }") ==
        "d.yaml: detector: expected the key `type`, one of fixed, silent");
  CHECK(complaint_about("detector: { type: dnm }") ==
        "d.yaml: detector.type: expected one of fixed, silent, got `dnm`");
  CHECK(complaint_about("detector: { type: fixed, scores: 1 }") ==
        "d.yaml: detector: unknown key `scores` (did you mean `score`?); known keys: name, about, type, "
        "box_masks, score, file");
  CHECK(complaint_about("detector: { type: fixed, score: 2 }") ==
        "d.yaml: detector.score: expected 0 to 1, got `2`");
  CHECK(complaint_about("detector: { type: fixed, score: often }") ==
        "d.yaml: detector.score: expected a number, got `often`");
  CHECK(complaint_about("detector: { type: fixed, score: 0 }") ==
        "d.yaml: the provider cannot be made: a score of nothing");
  CHECK(complaint_about("detector: { type: fixed }") == "");
}

TEST_CASE("the files of a detector lie in the network folder, else beside the YAML") {
  const TemporaryFolder yaml_folder, networks;
  const auto write = [](const std::filesystem::path& path, const std::string& text) {
    std::ofstream(path) << text;
  };
  write(yaml_folder.path() / "d.yaml", "detector: { type: fixed, file: net.onnx }");
  const auto make = [&](const std::filesystem::path& folder) {
    return detector_from_file(yaml_folder.path() / "d.yaml", registry(), folder).make();
  };
  CHECK_THROWS_WITH_AS(make(networks.path()),
                       ("net.onnx: no such file in " + networks.path().string() + " nor in " +
                        yaml_folder.path().string() + " (expected any file)")
                           .c_str(),
                       IoError);
  // The real folders are named, each once: `.` says nothing.
  const std::string here = std::filesystem::current_path().string();
  CHECK_THROWS_WITH_AS(ProviderFiles({{".", here}}).find("net.onnx", "any file"),
                       ("net.onnx: no such file in " + here + " (expected any file)").c_str(), IoError);
  CHECK_THROWS_WITH_AS(ProviderFiles({{"./no", ".."}}).find("net.onnx", "any file"),
                       ("net.onnx: no such file in " + here + "/no nor in " +
                        std::filesystem::current_path().parent_path().string() + " (expected any file)")
                           .c_str(),
                       IoError);
  write(networks.path() / "net.onnx", "");
  CHECK(make(networks.path()) != nullptr);
  CHECK_THROWS_AS(make({}), IoError);
  write(yaml_folder.path() / "net.onnx", "");
  CHECK(make({}) != nullptr);
  const ProviderFiles both{{networks.path(), yaml_folder.path()}};
  CHECK(both.find("net.onnx", "") == networks.path() / "net.onnx");
  CHECK(both.find((yaml_folder.path() / "net.onnx").string(), "") == yaml_folder.path() / "net.onnx");
  CHECK_THROWS_AS(both.find("", "a network"), IoError);
}

TEST_CASE("two providers of one name are refused") {
  ProviderRegistry twice = registry();
  CHECK_THROWS_WITH_AS(twice.add<Fixed>(), "a provider named `fixed` is registered already", ConfigError);
  CHECK(twice.names() == std::vector<std::string>{"fixed", "silent"});
  CHECK(twice.find("fixed")->card.parameters.at(1).name == "file");
  CHECK(twice.find("no") == nullptr);
}

}  // namespace detector_yaml_test
