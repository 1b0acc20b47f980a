// SPDX-License-Identifier: MIT
#include <algorithm>
#include <dynfilter/detectors/dnn_provider.hpp>
#include <dynfilter/detectors/image_file.hpp>
#include <dynfilter/semantic/detector_yaml.hpp>
#include <filesystem>
#include <opencv2/imgproc.hpp>

#include "doctest/doctest.h"

namespace real_networks_test {

using namespace dynfilter;
namespace fs = std::filesystem;

namespace {

const fs::path kData(DYNFILTER_DATA_DIR);

/// Every n-th colour image of the walking sequence in order of time. Empty without the data.
std::vector<fs::path> walking_images(std::size_t every) {
  std::vector<fs::path> files, chosen;
  std::error_code absent;
  for (const auto& entry : fs::directory_iterator(kData / "tum_fr3_walking_halfsphere/rgb", absent))
    files.push_back(entry.path());
  if (!fs::is_directory(kData / "nets", absent)) files.clear();
  if (files.empty()) MESSAGE("skipped: no ../shared/data");
  std::sort(files.begin(), files.end());
  for (std::size_t i = 0; i < files.size(); i += every) chosen.push_back(files[i]);
  return chosen;
}

std::unique_ptr<SemanticProvider> shipped(const std::string& detector) {
  ProviderRegistry registry;
  registry.add<DnnProvider>();
  const fs::path file = fs::path(DYNFILTER_SOURCE_DIR) / "examples/detectors" / (detector + ".yaml");
  return detector_from_file(file, registry, kData / "nets").make();
}

SemanticResult look(SemanticProvider& provider, const fs::path& file) {
  SemanticImage image;
  image.pixels = io::read_image(file, io::ImageAs::Colour);
  return *provider.infer(image);
}

std::vector<cv::Rect2f> people(const SemanticResult& result) {
  std::vector<cv::Rect2f> boxes;
  for (const Detection& d : *result.detections)
    if (d.class_name == "person") boxes.push_back(d.box);
  return boxes;
}

/// True if two boxes are not duplicates.
bool has_two(const std::vector<cv::Rect2f>& boxes) {
  for (std::size_t i = 1; i < boxes.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if ((boxes[i] & boxes[j]).area() < 0.7F * std::min(boxes[i].area(), boxes[j].area())) return true;
  return false;
}

}  // namespace

TEST_CASE("Yolo-Fastest finds the people of the real walking frames" * doctest::test_suite("shared_data")) {
  for (const auto& [name, every] :
       {std::pair<const char*, std::size_t>{"yolo_fastest", 1}, {"yolo_fastest_xl", 4}}) {
    const std::vector<fs::path> images = walking_images(every);
    if (images.empty()) return;
    const std::string detector = name;  // clang's lambdas take no structured binding
    CAPTURE(detector);
    const auto provider = shipped(detector);
    std::size_t one = 0, two = 0;
    for (const fs::path& file : images) {
      const auto boxes = people(look(*provider, file));
      one += boxes.empty() ? 0 : 1;
      two += has_two(boxes) ? 1 : 0;
    }
    CHECK(one == images.size());
    CHECK(10 * two >= 8 * images.size());  // in the last frames one occludes the other
  }
}

TEST_CASE("the DeepLab network marks people, and little beside them" * doctest::test_suite("shared_data")) {
  const std::vector<fs::path> images = walking_images(12);
  if (images.empty()) return;
  const auto provider = shipped("deeplabv3plus_person"), detector = shipped("yolo_fastest_xl");
  for (const fs::path& file : images) {
    CAPTURE(file);
    const SemanticResult result = look(*provider, file);
    REQUIRE(result.labels);
    cv::Mat mask;
    cv::resize(*result.labels, mask, {640, 480}, 0, 0, cv::INTER_NEAREST);
    cv::Mat inside = cv::Mat::zeros(mask.size(), CV_8UC1);
    for (const cv::Rect2f& box : people(look(*detector, file))) {
      const cv::Rect area = cv::Rect(box) & cv::Rect(0, 0, 640, 480);
      inside(area).setTo(255);
      CHECK(cv::countNonZero(mask(area)) > 0.1 * area.area());
    }
    CHECK(cv::countNonZero(mask & inside) > 0.75 * cv::countNonZero(mask));
  }
}

}  // namespace real_networks_test
