// SPDX-License-Identifier: MIT
#include <dynfilter/detectors/class_list.hpp>
#include <dynfilter/detectors/decode_boxes.hpp>
#include <dynfilter/detectors/decode_masks.hpp>
#include <dynfilter/detectors/file_provider.hpp>
#include <dynfilter/detectors/network_files.hpp>
#include <limits>

#include "doctest/doctest.h"
#include "io/detections_writer.hpp"
#include "io/tum_folder.hpp"

namespace decoders_test {

using namespace dynfilter;
using dynfilter_test::TemporaryFolder;
using dynfilter_test::write_text;

namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

cv::Mat tensor(const std::vector<int>& shape, const std::vector<float>& values) {
  cv::Mat mat(static_cast<int>(shape.size()), shape.data(), CV_32FC1);
  REQUIRE(mat.total() == values.size());
  std::copy(values.begin(), values.end(), mat.ptr<float>());
  return mat;
}
cv::Mat transposed(const cv::Mat& rows) {
  cv::Mat columns;
  cv::transpose(cv::Mat(rows.size[1], rows.size[2], CV_32FC1, rows.data), columns);
  return tensor({1, columns.rows, columns.cols},
                std::vector<float>(columns.begin<float>(), columns.end<float>()));
}

BoxLayout layout(int classes, float min_score = 0.25F, int coefficients = 0) {
  return {{100, 200}, classes, coefficients, min_score};
}

template <class Decoder>
std::vector<NetworkBox> decoded(Decoder decoder, const cv::Mat& output, const BoxLayout& how) {
  std::vector<NetworkBox> boxes;
  decoder(output, how, boxes);
  return boxes;
}

void check_box(const NetworkBox& found, const cv::Rect2f& box, int label, float score) {
  CHECK(found.box.x == doctest::Approx(box.x));
  CHECK(found.box.y == doctest::Approx(box.y));
  CHECK(found.box.width == doctest::Approx(box.width));
  CHECK(found.box.height == doctest::Approx(box.height));
  CHECK(found.label == label);
  CHECK(found.score == doctest::Approx(score));
}

template <class Decoder>
void check_refused(Decoder decoder, const cv::Mat& output, const BoxLayout& how) {
  std::vector<NetworkBox> boxes;
  CHECK_THROWS_AS(decoder(output, how, boxes), Error);
}

}  // namespace

TEST_CASE("YOLO regions: shares of the input, the best class, NaN and weak rows left out") {
  const std::vector<float> rows{0.5F,  0.25F, 0.2F, 0.1F, 0.9F, 0.3F, 0.6F,   // class 1
                                0.5F,  0.5F,  0.2F, 0.1F, 0.9F, 0.2F, 0.1F,   // weak
                                kNan,  0.5F,  0.2F, 0.1F, 0.9F, 0.9F, 0.1F,   // no place
                                0.5F,  0.5F,  0.0F, 0.1F, 0.9F, 0.9F, 0.1F,   // no width
                                0.25F, 0.75F, 0.5F, 0.5F, 1.0F, 0.8F, kNan};  // class 0
  for (const std::vector<int>& shape : {std::vector<int>{5, 7}, {1, 5, 7}}) {
    const auto boxes = decoded(decode_yolo_regions, tensor(shape, rows), layout(2));
    REQUIRE(boxes.size() == 2);
    check_box(boxes[0], {40, 40, 20, 20}, 1, 0.6F);
    check_box(boxes[1], {0, 100, 50, 100}, 0, 0.8F);
  }
  check_refused(decode_yolo_regions, tensor({5, 7}, rows), layout(3));
  check_refused(decode_yolo_regions, tensor({1, 1, 5, 7}, rows), layout(2));
  check_refused(decode_yolo_regions, cv::Mat(5, 7, CV_64FC1), layout(2));
  check_refused(decode_yolo_regions, cv::Mat(), layout(2));
}

TEST_CASE("YOLOv5: pixels of the input, objectness times class") {
  const std::vector<float> rows{50, 100, 20, 40, 0.8F, 0.5F, 0.9F, 3, 4,   // 0.72 of class 1
                                50, 100, 20, 40, 0.8F, 0.2F, 0.3F, 3, 4,   // 0.24
                                50, 100, 20, 40, 0.2F, 1.0F, 0.3F, 3, 4};  // 0.2
  const auto boxes = decoded(decode_yolov5, tensor({1, 3, 9}, rows), layout(2, 0.25F, 2));
  REQUIRE(boxes.size() == 1);
  check_box(boxes[0], {40, 80, 20, 40}, 1, 0.72F);
  CHECK(boxes[0].anchor == 0);
  CHECK(decoded(decode_yolov5, tensor({1, 3, 9}, rows), layout(2, 0.2F, 2)).size() == 3);
  CHECK(decoded(decode_yolov5, cv::Mat(std::vector<int>{1, 0, 9}, CV_32FC1), layout(2, 0.2F, 2)).empty());
  check_refused(decode_yolov5, tensor({1, 3, 9}, rows), layout(2));
  check_refused(decode_yolov5, tensor({3, 9}, rows), layout(2, 0.25F, 2));
  CHECK(mask_coefficients(tensor({1, 3, 9}, rows), 2, 2, false) == std::vector<float>{3, 4});
}

TEST_CASE("YOLOv8 is the same turned round, without objectness") {
  const cv::Mat rows = tensor({1, 3, 8}, {50, 100, 20, 40, 0.5F, 0.9F, 3,    4,  //
                                          10, 20,  4,  8,  0.7F, 0.7F, 5,    6,  // equal: the first class
                                          10, 20,  4,  8,  0.1F, 0.2F, 1.0F, 1.0F});
  const cv::Mat columns = transposed(rows);
  const auto boxes = decoded(decode_yolov8, columns, layout(2, 0.25F, 2));
  REQUIRE(boxes.size() == 2);
  check_box(boxes[0], {40, 80, 20, 40}, 1, 0.9F);
  check_box(boxes[1], {8, 16, 4, 8}, 0, 0.7F);
  CHECK(mask_coefficients(columns, boxes[1].anchor, 2, true) == std::vector<float>{5, 6});
  check_refused(decode_yolov8, rows, layout(2, 0.25F, 2));
  check_refused(decode_yolov8, columns, layout(4, 0.25F, 2));
}

TEST_CASE("SSD: corners as shares of the input, ended by a negative image number") {
  const std::vector<float> rows{0,  15, 0.9F, 0.1F, 0.2F, 0.6F,  0.7F,  //
                                0,  7,  0.1F, 0.1F, 0.2F, 0.6F,  0.7F,  // weak
                                0,  7,  0.9F, 0.6F, 0.2F, 0.1F,  0.7F,  // inverted
                                0,  7,  0.5F, 0.0F, 0.0F, 1.25F, 0.5F,  // beyond the border
                                -1, 7,  0.9F, 0.1F, 0.2F, 0.6F,  0.7F,  // the end
                                0,  8,  0.9F, 0.1F, 0.2F, 0.6F,  0.7F};
  const auto boxes = decoded(decode_ssd, tensor({1, 1, 6, 7}, rows), layout(21));
  REQUIRE(boxes.size() == 2);
  check_box(boxes[0], {10, 40, 50, 100}, 15, 0.9F);
  check_box(boxes[1], {0, 0, 125, 100}, 7, 0.5F);
  check_refused(decode_ssd, tensor({1, 6, 7}, rows), layout(21));
  check_refused(decode_ssd, tensor({1, 1, 7, 6}, rows), layout(21));
}

TEST_CASE("non-maximum suppression within a class only, the better first") {
  std::vector<NetworkBox> boxes{{{0, 0, 10, 10}, 0, 0.5F, 0},
                                {{0, 0, 10, 10}, 0, 0.9F, 1},
                                {{0, 0, 10, 10}, 1, 0.4F, 2},
                                {{0, 5, 10, 10}, 0, 0.8F, 3},  // a third of the union
                                {{50, 0, 10, 10}, 0, 0.9F, 4}};
  const auto anchors = [](std::vector<NetworkBox> kept, float max_overlap) {
    suppress_doubles(kept, max_overlap);
    std::vector<int> result;
    for (const NetworkBox& box : kept) result.push_back(box.anchor);
    return result;
  };
  CHECK(anchors(boxes, 0.45F) == std::vector<int>{1, 4, 3, 2});
  CHECK(anchors(boxes, 0.3F) == std::vector<int>{1, 4, 2});
  CHECK(anchors(boxes, 1.0F) == std::vector<int>{1, 4, 3, 0, 2});
  CHECK(anchors({}, 0.5F).empty());
  CHECK(overlap_share({0, 0, 10, 10}, {0, 5, 10, 10}) == doctest::Approx(1.0 / 3));
  CHECK(overlap_share({0, 0, 10, 10}, {10, 0, 10, 10}) == 0.0F);
}

TEST_CASE("boxes go back to the image through stretching and letterboxing") {
  const InputFit stretched = InputFit::of({640, 480}, {320, 320}, ImageFit::Stretch);
  CHECK(stretched.area() == cv::Rect(0, 0, 320, 320));
  CHECK(stretched.to_image({160, 160, 32, 32}) == cv::Rect2f(320, 240, 64, 48));
  const InputFit boxed = InputFit::of({640, 480}, {320, 320}, ImageFit::Letterbox);
  CHECK(boxed.area() == cv::Rect(0, 40, 320, 240));
  CHECK(boxed.to_image({160, 160, 32, 32}) == cv::Rect2f(320, 240, 64, 64));
  CHECK(boxed.to_image({-5, 0, 400, 320}) == cv::Rect2f(0, 0, 640, 480));
  CHECK(boxed.to_image({10, 0, 20, 30}).height == 0.0F);  // in the filled border
  const InputFit tall = InputFit::of({100, 1000}, {64, 64}, ImageFit::Letterbox);
  CHECK(tall.area() == cv::Rect(29, 0, 6, 64));
  CHECK(tall.to_image(cv::Rect2f(tall.area())) == cv::Rect2f(0, 0, 100, 1000));
  CHECK(InputFit::of({1, 1000}, {64, 64}, ImageFit::Letterbox).area().width == 1);
}

TEST_CASE("score maps: the largest class of each pixel; one map is foreground or not") {
  cv::Mat labels;
  decode_class_scores(tensor({1, 3, 1, 4}, {1, 5, -3, kNan, 2, 5, -2, 0, 3, 4, -9, 1}), 3, 0, 0, labels);
  CHECK(labels.size() == cv::Size(4, 1));
  CHECK(cv::countNonZero(labels != (cv::Mat_<std::uint8_t>(1, 4) << 2, 0, 1, 0)) == 0);
  decode_class_scores(tensor({1, 1, 2, 2}, {0.4F, 0.6F, 0.5F, kNan}), 1, 0.5F, 0, labels);
  CHECK(cv::countNonZero(labels != (cv::Mat_<std::uint8_t>(2, 2) << 0, 1, 0, 0)) == 0);
  const cv::Mat biased = tensor({1, 2, 1, 3}, {5, 5, 5, 3.5F, 2.5F, 6});
  decode_class_scores(biased, 2, 0, 2, labels);
  CHECK(cv::countNonZero(labels != (cv::Mat_<std::uint8_t>(1, 3) << 1, 0, 1)) == 0);
  decode_class_scores(biased, 2, 0, -2, labels);
  CHECK(cv::countNonZero(labels) == 0);
  CHECK_THROWS_AS(decode_class_scores(tensor({1, 3, 1, 1}, {1, 2, 3}), 2, 0, 0, labels), Error);
  CHECK_THROWS_AS(decode_class_scores(tensor({1, 1, 3}, {1, 2, 3}), 1, 0, 0, labels), Error);
  // The image is in rows 40 to 280 of 320.
  const InputFit fit = InputFit::of({640, 480}, {320, 320}, ImageFit::Letterbox);
  CHECK(image_part(cv::Mat::zeros(16, 16, CV_8UC1), fit).size() == cv::Size(16, 12));
  CHECK(image_part(cv::Mat::zeros(1, 1, CV_8UC1), fit).size() == cv::Size(1, 1));
}

TEST_CASE("prototype masks follow their edge between prototype pixels") {
  // One prototype of 2 x 2 for an input of 8 x 8. It is -1 on the left, 1 on the right and 0 half-way at x =
  // 4.
  PrototypeMasks masks(tensor({1, 1, 2, 2}, {-1, 1, -1, 1}));
  const InputFit fit = InputFit::of({16, 16}, {8, 8}, ImageFit::Stretch);
  const cv::Mat right = masks.mask({1}, {2, 4, 12, 8}, fit);
  cv::Mat expected = cv::Mat::zeros(16, 16, CV_8UC1);
  expected(cv::Rect(8, 4, 6, 8)).setTo(255);
  CHECK(cv::countNonZero(right != expected) == 0);
  CHECK(cv::countNonZero(masks.mask({-1}, {2, 4, 12, 8}, fit)) == 6 * 8);
  CHECK(cv::countNonZero(masks.mask({0}, {2, 4, 12, 8}, fit)) == 0);
  CHECK(cv::countNonZero(masks.mask({1}, {-50, -50, 500, 500}, fit)) == 8 * 16);
  CHECK_THROWS_AS(PrototypeMasks(tensor({1, 2, 2}, {0, 0, 0, 0})), Error);
}

TEST_CASE("class lists: names, numbers, what is kept") {
  const ClassList list({"a", "b"}, 1, {"b"});
  CHECK(!list.has(0));
  CHECK(list.has(2));
  CHECK(!list.kept(1));
  CHECK(list.kept(2));
  CHECK(!list.kept(3));
  CHECK(list.name(2) == "b");
  CHECK_NOTHROW(list.check(1));
  CHECK_THROWS_WITH_AS(list.check(17),
                       "its output has class 17, but the class list has 2 names, from class 1 on", Error);
  CHECK(ClassList({"a"}, 0, {}).kept(0));
}

TEST_CASE("Darknet weights are counted from the configuration") {
  // 3 -> 8 (3x3, normalised): 4*8 + 8*3*9; 8 -> 8 in 8 groups: 8 + 8*9; route of both: 16 -> 4 (1x1): 4 +
  // 4*16.
  const std::string config =
      "[net]\nchannels = 3\n# a comment\n[convolutional]\nfilters=8\nsize=3\nbatch_normalize=1\n[maxpool]\n"
      "[convolutional]\nfilters=8\nsize=3\ngroups=8\n[shortcut]\nfrom=-2\n[route]\nlayers=-1,0\n"
      "[convolutional]\nfilters=4\n[yolo]\n";
  const std::size_t count = 32 + 216 + 8 + 72 + 4 + 64;
  Bytes weights(20 + 4 * count, 0);
  weights[4] = 2;  // version 0.2: a header of 20 bytes
  CHECK(darknet_fault(config, weights) == "");
  weights.pop_back();
  CHECK(darknet_fault(config, weights) == "has 1603 bytes, but its configuration needs 1604");
  weights.resize(16 + 4 * count);
  weights[4] = 1;
  CHECK(darknet_fault(config, weights) == "");
  CHECK(darknet_fault(config + "[lstm]\n", {weights.begin(), weights.begin() + 40}) == "");  // not known here
  CHECK(darknet_fault(config, {}) == "is empty");
  CHECK(darknet_fault(config, Bytes(5, 0)) == "is truncated");
  CHECK_THROWS_WITH_AS(darknet_fault("[net]\n[route]\nlayers=-1\n", weights),
                       "line 2: [route] names layer `-1`, which does not come before it", Error);
  CHECK_THROWS_AS(darknet_fault("[net]\n[convolutional]\nfilters=-8\n", weights), Error);
  CHECK_THROWS_AS(darknet_fault("key=1\n", weights), Error);
}

TEST_CASE("protobuf files and texts that end too early or are something else") {
  const auto fault = [](const std::string& text) { return protobuf_fault(Bytes(text.begin(), text.end())); };
  CHECK(fault("\x08\x07\x12\x03xyz\x1d....") == "");
  CHECK(fault("\x08\x07\x12\x04xyz") == "is truncated");
  CHECK(fault("\x08\x80") == "is truncated");
  CHECK(fault("\x1d...") == "is truncated");
  CHECK(fault("") == "is empty");
  CHECK(fault("\x07text") == "is no protobuf file");
  CHECK(protobuf_text_fault("layer { name: \"}\" # }\n }") == "");
  CHECK(protobuf_text_fault("layer { name: \"x\"") == "is truncated");
  CHECK(protobuf_text_fault("layer { name: \"x") == "is truncated");
  CHECK(protobuf_text_fault("}") == "has a `}` too much");
  CHECK(protobuf_text_fault("") == "is empty");
  CHECK(protobuf_text_fault("<html>") == "is not a protobuf text");
}

TEST_CASE("boxes and masks from files, by timestamp; what neither knows did not come") {
  const TemporaryFolder folder;
  const ProviderFiles files{{folder.path()}};
  write_text(folder.path() / "boxes.txt", "1.0 0 person 0.9 1 2 3 4\n2.0 none\n");
  std::filesystem::create_directory(folder.path() / "masks");
  CHECK_THROWS_AS(FileProvider({"boxes.txt", "masks"}, files), IoError);
  cv::imwrite((folder.path() / "masks/1.000200.png").string(), cv::Mat(2, 2, CV_8UC1, cv::Scalar(1)));
  cv::imwrite((folder.path() / "masks/1.000600.png").string(), cv::Mat(2, 2, CV_8UC1, cv::Scalar(2)));
  cv::imwrite((folder.path() / "masks/3.png").string(), cv::Mat(2, 2, CV_8UC3, cv::Scalar(1)));
  write_text(folder.path() / "masks/4.png", "");
  FileProvider provider({"boxes.txt", "masks"}, files);
  const auto at = [&](double timestamp_s) {
    SemanticImage image;
    image.timestamp_s = timestamp_s;
    return provider.infer(image);
  };
  CHECK(at(1)->detections->size() == 1);
  CHECK(at(1)->labels->at<std::uint8_t>(0, 0) == 1);
  CHECK(at(1.0005)->labels->at<std::uint8_t>(0, 0) == 2);
  CHECK(at(2)->detections->empty());
  CHECK(!at(2)->labels);
  CHECK(!at(2.5));
  CHECK(!at(9));
  CHECK_THROWS_AS(at(3), IoError);
  CHECK_THROWS_AS(at(4), IoError);
  CHECK_THROWS_AS(FileProvider({}, files), ConfigError);
  CHECK_THROWS_AS(FileProvider({"none.txt", ""}, files), IoError);
}

TEST_CASE("boxes that are written are read again") {
  const TemporaryFolder folder;
  Detection phone;
  phone.box = {1.25F, 2.5F, 100, 50.125F};
  phone.class_id = 67;
  phone.class_name = "cell phone";
  phone.score = 0.8125F;
  Detection unnamed = phone;
  unnamed.class_name.clear();
  io::write_detections(folder.path() / "d.txt", {{1341846434.710184, {phone, unnamed}}, {1341846435, {}}});
  const io::DetectionTrack track = io::read_detections(folder.path() / "d.txt");
  REQUIRE(track.images.size() == 2);
  CHECK(track.images[0].timestamp_s == 1341846434.710184);
  const std::vector<Detection>& found = *track.at(1341846434.710184);
  REQUIRE(found.size() == 2);
  CHECK(found[0].box == phone.box);
  CHECK(found[0].class_id == 67);
  CHECK(found[0].class_name == "cell phone");
  CHECK(found[0].score == phone.score);
  CHECK(found[1].class_name == "object");
  CHECK(track.at(1341846435)->empty());
}

}  // namespace decoders_test
