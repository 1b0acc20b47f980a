// SPDX-License-Identifier: MIT
#include <dynfilter/detectors/dnn_provider.hpp>
#include <dynfilter/detectors/file_provider.hpp>
#include <dynfilter/detectors/process_provider.hpp>
#include <dynfilter/semantic/box_masks.hpp>
#include <dynfilter/semantic/detector_yaml.hpp>
#include <dynfilter/semantic/runner.hpp>
#include <sstream>

#include "doctest/doctest.h"
#include "io/tum_folder.hpp"
#include "semantic/tiny_networks.hpp"
#include "support/parameter_tables.hpp"

namespace dnn_provider_test {

using namespace dynfilter;
using dynfilter_test::TemporaryFolder;
using dynfilter_test::write_text;

namespace {

const cv::Scalar kRed(0, 0, 255), kGrey(90, 90, 90);

/// 1 where red is above 127.5: class 1 of two.
const tiny::PixelMap kRedMap{{0.5F, 0}, {0, 0, 0, 1, 0, 0}};
/// A box of 2 x 2 pixels around (2, 2); class 0 scores the red of the pixel, class 1 nothing.
const tiny::PixelMap kRedHead{{2, 2, 2, 2, 0, 0}, {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0}};

class Network {
 public:
  Network(const std::string& file, const std::string& content) { add(file, content); }
  void add(const std::string& file, const std::string& content) const {
    write_text(folder_.path() / file, content);
  }
  std::string path(const std::string& file) const { return (folder_.path() / file).string(); }

  std::unique_ptr<SemanticProvider> make(const std::string& keys) const {
    ProviderRegistry registry;
    registry.add<DnnProvider>();
    const auto document =
        YamlDocument::from_text("detector: { type: dnn, scale: 0.00392156862745, " + keys + " }");
    return read_detector(document, registry, {{folder_.path()}}).make();
  }
  SemanticResult run(const std::string& keys, const cv::Mat& image) const {
    SemanticImage input;
    input.frame_id = 3;
    input.pixels = image;
    const auto result = make(keys)->infer(input);
    REQUIRE(result);
    CHECK(result->frame_id == 3);
    return *result;
  }
  /// The error of its creation; "" without one.
  std::string complaint(const std::string& keys) const {
    try {
      make(keys);
    } catch (const Error& error) {
      std::string text = error.what();
      CHECK(text.find('\n') == std::string::npos);
      return text;
    }
    return "";
  }

 private:
  TemporaryFolder folder_;
};

cv::Mat painted(cv::Size size, const cv::Rect& red) {
  cv::Mat image(size, CV_8UC3, kGrey);
  image(red).setTo(kRed);
  return image;
}

const char* const kSegmenter =
    "network: n.onnx, decoder: class_scores, width_px: 4, height_px: 4, classes: [ground, thing]";
const char* const kHead =
    "network: n.onnx, decoder: yolov8, width_px: 4, height_px: 4, classes: [thing, other]";
const char* const kDarknet =
    "network: n.weights, config: n.cfg, decoder: yolo_regions, width_px: 4, height_px: 4, classes: [thing]";

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}
bool same(const cv::Rect2f& a, const cv::Rect2f& b) {
  const auto near = [](float x, float y) { return std::abs(x - y) < 1e-3F; };
  return near(a.x, b.x) && near(a.y, b.y) && near(a.width, b.width) && near(a.height, b.height);
}

}  // namespace

TEST_CASE("a segmenter written as ONNX: label image, channel order, mean, classes that are kept") {
  const Network network("n.onnx", tiny::onnx_map(kRedMap, 4, 4));
  const cv::Mat image = painted({4, 4}, {1, 0, 2, 3});
  cv::Mat expected = cv::Mat::zeros(4, 4, CV_8UC1);
  expected(cv::Rect(1, 0, 2, 3)).setTo(1);
  const SemanticResult result = network.run(kSegmenter, image);
  CHECK(!result.detections);
  REQUIRE(result.labels);
  CHECK(cv::countNonZero(*result.labels != expected) == 0);

  const std::string keys(kSegmenter);
  // No blue anywhere.
  CHECK(cv::countNonZero(*network.run(keys + ", channels: bgr", image).labels) == 0);
  CHECK(cv::countNonZero(*network.run(keys + ", keep: [thing]", image).labels) == 6);
  CHECK(cv::countNonZero(*network.run(keys + ", keep: [ground]", image).labels) == 0);
  CHECK(cv::countNonZero(*network.run(keys + ", mean: [-100, 0, 0]", image).labels) ==
        16);                                                                            // 190 of 255 and more
  CHECK(cv::countNonZero(*network.run(keys + ", std: [3, 1, 1]", image).labels) == 0);  // a third
}

TEST_CASE("a segmenter's labels cover the image, also when it was letterboxed") {
  const Network network("n.onnx", tiny::onnx_map(kRedMap, 4, 4));
  const cv::Mat image = painted({16, 8}, {0, 0, 8, 8});
  const cv::Mat labels = *network.run(std::string(kSegmenter) + ", fit: letterbox", image).labels;
  CHECK(labels.size() == cv::Size(4, 2));
  CHECK(cv::countNonZero(labels.colRange(0, 2) == 1) == 4);
  CHECK(cv::countNonZero(labels.colRange(2, 4)) == 0);
}

TEST_CASE("a YOLOv8 head written as ONNX: one box after suppression, in pixels of the image") {
  const Network network("n.onnx", tiny::onnx_head(kRedHead, 4, 4));
  SemanticResult result = network.run(kHead, painted({8, 8}, {0, 0, 8, 8}));
  REQUIRE(result.detections);
  REQUIRE(result.detections->size() == 1);
  CHECK(same(result.detections->at(0).box, {2, 2, 4, 4}));
  CHECK(result.detections->at(0).class_name == "thing");
  CHECK(result.detections->at(0).class_id == 0);
  CHECK(result.detections->at(0).score == doctest::Approx(1).epsilon(1e-4));
  CHECK(!result.labels);
  // 4 x 2 pixels in the middle of the input: box rows 1 to 3 are the whole image.
  result = network.run(std::string(kHead) + ", fit: letterbox", painted({8, 4}, {0, 0, 8, 4}));
  REQUIRE(result.detections->size() == 1);
  CHECK(same(result.detections->at(0).box, {2, 0, 4, 4}));

  CHECK(network.run(kHead, cv::Mat(8, 8, CV_8UC3, kGrey)).detections->empty());
  CHECK(network.run(kHead, cv::Mat(8, 8, CV_8UC1, cv::Scalar(250))).detections->size() == 1);
  CHECK(
      network.run(std::string(kHead) + ", keep: [other]", painted({8, 8}, {0, 0, 8, 8})).detections->empty());
}

TEST_CASE("instance masks: prototypes times coefficients, cut by the box, merged into labels") {
  tiny::PixelMap head = kRedHead;  // a coefficient of 1 behind the classes
  head.bias.push_back(1);
  head.weights.insert(head.weights.end(), {0, 0, 0});
  const Network network("n.onnx", tiny::onnx_head(head, 4, 4, {{-0.5F}, {1, 0, 0}}));
  const SemanticResult result = network.run(kHead, painted({4, 4}, {0, 0, 2, 4}));
  REQUIRE(result.detections->size() == 1);
  CHECK(same(result.detections->at(0).box, {1, 1, 2, 2}));
  cv::Mat expected = cv::Mat::zeros(4, 4, CV_8UC1);
  expected(cv::Rect(1, 1, 1, 2)).setTo(255);  // red is left of 2, the box begins at 1
  CHECK(cv::countNonZero(result.detections->at(0).mask != expected) == 0);
  REQUIRE(result.labels);
  CHECK(cv::countNonZero(*result.labels == 1) == 2);
  CHECK(cv::countNonZero(*result.labels) == 2);
}

TEST_CASE("a YOLO network written for Darknet: the box of the red cell") {
  const Network network("n.weights", tiny::darknet_weights());
  network.add("n.cfg", tiny::darknet_config(4, 4));
  SemanticResult result = network.run(kDarknet, painted({4, 4}, {2, 1, 1, 1}));
  REQUIRE(result.detections);
  REQUIRE(result.detections->size() == 1);
  CHECK(same(result.detections->at(0).box, {1.5F, 0.5F, 2, 2}));
  CHECK(result.detections->at(0).class_name == "thing");
  network.add("n.cfg", [] {  // Windows' line ends
    std::string text;
    for (const char c : tiny::darknet_config(4, 4))
      text += c == '\n' ? std::string("\r\n") : std::string(1, c);
    return text;
  }());
  result = network.run(kDarknet, painted({4, 4}, {2, 1, 1, 1}));
  CHECK(result.detections->size() == 1);
}

TEST_CASE("files that are missing, short or something else: one line that names the file") {
  const Network network("n.weights", tiny::darknet_weights());
  const std::string weights = network.path("n.weights"), config = network.path("n.cfg");
  CHECK(contains(network.complaint(kDarknet), "n.cfg: no such file in "));
  network.add("n.cfg", tiny::darknet_config(4, 4));
  CHECK(network.complaint(kDarknet) == "");
  const std::string whole = tiny::darknet_weights();
  network.add("n.weights", whole.substr(0, whole.size() - 4));
  CHECK(network.complaint(kDarknet) == weights + ": has 112 bytes, but its configuration needs 116");
  network.add("n.weights", "");
  CHECK(network.complaint(kDarknet) == weights + ": is empty");
  network.add("n.weights", whole);
  network.add("n.cfg", "[net]\nwidth 4\n");
  CHECK(network.complaint(kDarknet) ==
        config + ": line 2: expected `[section]` or `key=value`, got `width4`");
  network.add("n.cfg", "[convolutional]\n");
  CHECK(network.complaint(kDarknet) == config + ": expected a Darknet configuration that begins with [net]");
  CHECK(contains(
      network.complaint("network: n.weights, decoder: yolo_regions, width_px: 4, height_px: 4, classes: [a]"),
      weights + ": a Darknet network also needs its configuration (`config`)"));

  const std::string onnx = tiny::onnx_map(kRedMap, 4, 4), file = network.path("n.onnx");
  CHECK(contains(network.complaint(kSegmenter), "n.onnx: no such file in "));
  for (const std::size_t size : {onnx.size() - 1, onnx.size() / 2, std::size_t{3}}) {
    network.add("n.onnx", onnx.substr(0, size));
    CHECK(network.complaint(kSegmenter) == file + ": is truncated");
  }
  network.add("n.onnx", "");
  CHECK(network.complaint(kSegmenter) == file + ": is empty");
  network.add("n.onnx", "PK\x03\x04 a zip file, as PyTorch's own are");
  CHECK(contains(network.complaint(kSegmenter), file + ": is "));
  network.add("n.pt", "x");
  CHECK(contains(network.complaint("network: n.pt, width_px: 4, height_px: 4, classes: [a]"),
                 network.path("n.pt") + ": expected a network file: .weights (Darknet), .onnx"));
}

TEST_CASE("a network that OpenCV cannot load or run") {
  const std::string graph = tiny::bytes(1, tiny::node("NoSuchLayer", {"image"}, "out")) +
                            tiny::bytes(2, "tiny") +
                            tiny::bytes(11, tiny::value_info("image", {1, 3, 4, 4})) +
                            tiny::bytes(12, tiny::value_info("out", {1, 2, 4, 4}));
  const Network network("n.onnx", tiny::model(graph));
  const std::string text = network.complaint(kSegmenter);
  CAPTURE(text);
  CHECK(text.find(network.path("n.onnx") + ": OpenCV ") == 0);
  CHECK(contains(text, "cannot"));
  const Network other("n.onnx", tiny::onnx_head(kRedHead, 4, 4));
  CHECK(contains(
      other.complaint("network: n.onnx, decoder: yolov8, width_px: 5, height_px: 4, classes: [a, b]"),
      "cannot run this network on an input of 1x3x4x5 (channels, height, width)"));
}

TEST_CASE("an output of another layout, a class list of another length") {
  const Network head("n.onnx", tiny::onnx_head(kRedHead, 4, 4));
  const std::string file = head.path("n.onnx");
  CHECK(head.complaint("network: n.onnx, decoder: yolov8, width_px: 4, height_px: 4, classes: [a, b, c]") ==
        file + ": its output is 1x6x16, expected 1x7xN (a box, 3 class scores)");
  CHECK(head.complaint("network: n.onnx, decoder: yolov5, width_px: 4, height_px: 4, classes: [a]") ==
        file + ": its output is 1x6x16, expected 1xNx6 (a box, objectness, 1 class scores)");
  CHECK(head.complaint("network: n.onnx, decoder: ssd, width_px: 4, height_px: 4, classes: [a]") ==
        file + ": its output is 1x6x16, expected 1x1xNx7 (image, label, score, box)");
  CHECK(head.complaint("network: n.onnx, decoder: class_scores, width_px: 4, height_px: 4, classes: [a]") ==
        file + ": its output is 1x6x16, expected 1x1xHxW (a score map for each of 1 classes, at most 255)");
  CHECK(head.complaint(std::string(kHead) + ", keep: [nobody]") ==
        file + ": keep: there is no class `nobody` in the class list");
  CHECK(contains(head.complaint("network: n.onnx, decoder: yolov8, width_px: 4, height_px: 4"),
                 "classes: expected the class names"));
  head.add("names.txt", "thing\ncell phone\r\n\n");
  CHECK(head.complaint("network: n.onnx, decoder: yolov8, width_px: 4, height_px: 4, class_file: names.txt, "
                       "keep: ['cell phone']") == "");
  CHECK(contains(head.complaint(std::string(kHead) + ", outputs: [nose]"), "it has no output `nose`"));
  CHECK(contains(head.complaint("network: n.onnx, decoder: yolov8, height_px: 4, classes: [a, b]"),
                 "width_px: expected 1 to 8192, got `0`"));
}

TEST_CASE("images of no size or of another type are refused, the provider goes on") {
  const Network network("n.onnx", tiny::onnx_head(kRedHead, 4, 4));
  const auto provider = network.make(kHead);
  SemanticImage image;
  CHECK_THROWS_WITH_AS(provider->infer(image),
                       (network.path("n.onnx") +
                        ": expected an image of 8-bit colour or grey, got one of 0x0 pixels, type CV_8UC1")
                           .c_str(),
                       Error);
  image.pixels = cv::Mat(4, 4, CV_32FC3, cv::Scalar::all(1));
  CHECK_THROWS_AS(provider->infer(image), Error);
  image.pixels = painted({1, 1}, {0, 0, 1, 1});
  CHECK(provider->infer(image)->detections->size() == 1);
}

TEST_CASE("the tables of docs/reference/detectors.md are those of the parameters") {
  using dynfilter_test::parameter_table;
  dynfilter_test::check_parameter_tables("docs/reference/detectors.md",
                                         {{"dnn", parameter_table<DnnParams>()},
                                          {"files", parameter_table<FileProviderParams>()},
                                          {"box_masks", parameter_table<BoxMaskParams>()}});
  dynfilter_test::check_parameter_tables("docs/reference/provider_process.md",
                                         {{"process", parameter_table<ProcessProviderParams>()}});
}

TEST_CASE("every file of examples/detectors can be read, and asks for its network") {
  ProviderRegistry registry;
  registry.add<DnnProvider>();
  registry.add<FileProvider>();
  registry.add<ProcessProvider>();
  const TemporaryFolder empty;
  int count = 0;
  for (const auto& entry :
       std::filesystem::directory_iterator(std::string(DYNFILTER_SOURCE_DIR) + "/examples/detectors")) {
    CAPTURE(entry.path());
    const DetectorConfig config = detector_from_file(entry.path(), registry, empty.path());
    CHECK(config.name == entry.path().stem().string());
    if (config.type == ProcessProvider::kName)
      CHECK_THROWS_AS(config.make(), Error);  // no program with this name, or its network is missing
    else
      CHECK_THROWS_AS(config.make(), IoError);  // parameters are valid, only the network is missing
    ++count;
  }
  CHECK(count >= 9);
}

}  // namespace dnn_provider_test
