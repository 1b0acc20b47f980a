// SPDX-License-Identifier: MIT
#include "run_command.hpp"
#include "semantic/tiny_networks.hpp"
#include "walking.hpp"

using namespace dynfilter_test;
namespace fs = std::filesystem;

namespace {

/// A network of a few numbers that detects red, its YAML, and an image with a red area.
class Workshop {
 public:
  Workshop() {
    write_text(root() / "net.onnx",
               tiny::onnx_head({{2, 2, 2, 2, 0}, {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0}}, 4, 4));
    write_text(root() / "d.yaml", yaml("thing"));
    cv::imwrite((root() / "1.500000.png").string(), cv::Mat(8, 8, CV_8UC3, cv::Scalar(0, 0, 255)));
  }
  static std::string yaml(const std::string& classes) {
    return "%YAML:1.0\n---\ndetector:\n  name: red\n  type: dnn\n  network: net.onnx\n  decoder: yolov8\n  "
           "width_px: 4\n"
           "  height_px: 4\n  scale: 0.00392156862745\n  classes: [ " +
           classes + " ]\n";
  }
  const fs::path& root() const { return folder_.path(); }
  std::string file(const std::string& name) const { return "'" + (root() / name).string() + "'"; }

 private:
  TemporaryFolder folder_;
};

}  // namespace

TEST_CASE("detect: boxes of a picture as a file that run reads, and a picture of them") {
  const Workshop shop;
  const CommandResult result = run_dynfilter("detect " + shop.file("1.500000.png") + " --detector " +
                                             shop.file("d.yaml") + " --out " + shop.file("out"));
  CAPTURE(result.err);
  REQUIRE(result.exit_code == 0);
  CHECK(contains(result.out, "red on "));
  CHECK(contains(result.out, "1 image: 1 box in 1 of them, masks for 0"));
  CHECK(contains(result.out, "thing            1 box, in 1 image, two or more in 0"));
  CHECK(
      read_text(shop.root() / "out/detections.txt") ==
      "# timestamp class_id class_name score x1 y1 x2 y2\n1.500000 0 thing 1.0000 2.000 2.000 6.000 6.000\n");
  CHECK(fs::exists(shop.root() / "out/overlay/1.500000.png"));
  CHECK(!fs::exists(shop.root() / "out/masks"));
  const CommandResult json =
      run_dynfilter("detect " + shop.file("1.500000.png") + " --json --detector " + shop.file("d.yaml"));
  CHECK(contains(json.out, "\"images_with_two\": 0"));
}

TEST_CASE("detect: where nothing is found, the count and detections.txt agree") {
  const Workshop shop;
  cv::imwrite((shop.root() / "2.500000.png").string(), cv::Mat(8, 8, CV_8UC3, cv::Scalar(0, 0, 0)));
  const std::string detect = "detect " + shop.file("2.500000.png") + " --detector " + shop.file("d.yaml");
  const CommandResult result = run_dynfilter(detect + " --out " + shop.file("out"));
  CHECK(result.exit_code == 0);
  CHECK(contains(result.out, "1 image: 0 boxes in 0 of them"));
  CHECK(read_text(shop.root() / "out/detections.txt") ==
        "# timestamp class_id class_name score x1 y1 x2 y2\n2.500000 none\n");
  const std::string json = run_dynfilter(detect + " --json").out;
  CHECK(contains(json, "\"with_boxes\": 0"));
  CHECK(contains(json, "\"boxes\": 0"));
  CHECK(contains(json, "\"answers\": 1"));
  check_refused(detect + " --out " + shop.file("out"), "replace them with --force");
  CHECK(run_dynfilter(detect + " --force --out " + shop.file("out")).exit_code == 0);
}

TEST_CASE("detect and run refuse detectors that cannot be: one line each") {
  const Workshop shop;
  const std::string image = shop.file("1.500000.png") + " ", with = "--detector " + shop.file("d.yaml");
  check_refused("detect " + image + "--detector yolo_fast", "presets: deeplabv3plus_person, files, ");
  check_refused("detect " + image + "--detector yolo_fastest --network-dir " + shop.file(""),
                "yolo-fastest-1.1.weights: no such file in ");
  check_refused("detect " + image + "--detector yolo_fastest",
                "; --network-dir says where the detector's files are");
  check_refused("detect " + image + with + " --network-dir /no/such", "/no/such: no such folder");
  check_refused("detect " + shop.file("2.png") + " " + with, "2.png: no such file");
  check_refused("detect " + image + with + " --start 1", "--start 1: there are only 1 images");
  write_text(shop.root() / "d.yaml", Workshop::yaml("a, b"));
  check_refused("detect " + image + with,
                "net.onnx: its output is 1x5x16, expected 1x6xN (a box, 2 class scores)");
  write_text(shop.root() / "d.yaml", Workshop::yaml("thing"));
  const std::string whole = read_text(shop.root() / "net.onnx");
  write_text(shop.root() / "net.onnx", whole.substr(0, whole.size() / 2));
  check_refused("detect " + image + with, "net.onnx: is truncated");
  // OpenCV's own message about an unsupported layer is suppressed.
  write_text(shop.root() / "net.onnx",
             tiny::model(tiny::bytes(1, tiny::node("NoSuchLayer", {"image"}, "out")) +
                         tiny::bytes(11, tiny::value_info("image", {1, 3, 4, 4})) +
                         tiny::bytes(12, tiny::value_info("out", {1, 5, 16}))));
  check_refused("detect " + image + with, "cannot load this ONNX network");
  fs::remove(shop.root() / "net.onnx");
  check_refused("detect " + image + with, "net.onnx: no such file in ");
  write_text(shop.root() / "d.yaml", "%YAML:1.0\n---\ndetector: { type: dmn }\n");
  check_refused("detect " + image + with,
                "d.yaml: detector.type: expected one of dnn, files, process, got `dmn`");
}

TEST_CASE("run takes boxes and masks from a detector") {
  const Workshop shop;
  REQUIRE(run_dynfilter("synth walking_static " + shop.file("walking") + " --frames 12 --seed 3 --no-right")
              .exit_code == 0);
  const std::string run = "run " + shop.file("walking") + " --pipeline rts_slam_s --json ";
  // A detector that reads the written files gives the same result.
  write_text(shop.root() / "f.yaml",
             "%YAML:1.0\n---\ndetector: { type: files, detections: detections.txt, masks: masks }\n");
  const CommandResult files = run_dynfilter(run);
  const CommandResult detector =
      run_dynfilter(run + "--detector " + shop.file("f.yaml") + " --network-dir " + shop.file("walking"));
  CAPTURE(detector.err);
  REQUIRE(files.exit_code == 0);
  REQUIRE(detector.exit_code == 0);
  const auto value = [](const std::string& json, const std::string& key) {
    const std::size_t at = json.find("\"" + key + "\": ");
    REQUIRE(at != std::string::npos);
    return json.substr(at, json.find('\n', at) - at);
  };
  for (const char* key : {"ate_rmse_m", "recall", "rejected_mean", "tracked_frames"})
    CHECK(value(files.out, key) == value(detector.out, key));
  CHECK(value(files.out, "recall") != value(run_dynfilter(run + "--no-detections").out, "recall"));
  CHECK(contains(detector.out, "boxes and masks from the detector files"));
  check_refused(run + "--detector " + shop.file("d.yaml") + " --detections x", "--detections");
  fs::remove(shop.root() / "net.onnx");
  check_refused(run + "--detector " + shop.file("d.yaml") + " --out " + shop.file("out"),
                "net.onnx: no such file");
  CHECK(!fs::exists(shop.root() / "out"));
}

TEST_CASE("serve answers images with boxes, until the stream ends") {
  const Workshop shop;
  std::string red;
  for (int i = 0; i < 64; ++i) red += std::string("\0\0\xFF", 3);
  write_text(shop.root() / "images",
             "image 7 1.5 8 8 3\n" + red + "image 8 1.6 1 1 1\n" + std::string(1, '\0'));
  const CommandResult result = run_dynfilter("serve " + shop.file("d.yaml") + " <" + shop.file("images"));
  CAPTURE(result.err);
  CHECK(result.exit_code == 0);
  CHECK(result.out ==
        "dynfilter-provider 1\nresult 7\ndetections 1\n0 1 2 2 6 6 thing\nend\n"
        "result 8\ndetections 0\nend\n");
}

TEST_CASE("serve says in one line what it cannot read") {
  const Workshop shop;
  write_text(shop.root() / "images", "picture 7\n");
  const CommandResult result = run_dynfilter("serve " + shop.file("d.yaml") + " <" + shop.file("images"));
  CHECK(result.exit_code == 2);
  CHECK(contains(result.err, "expected `image ID TIMESTAMP WIDTH HEIGHT CHANNELS`, got `picture 7`"));
  CHECK(std::count(result.err.begin(), result.err.end(), '\n') == 1);
  check_refused("serve /no/such.yaml", "/no/such.yaml");
}

TEST_CASE("a detector that fails: on every image exit code 1 and no figures, on some it is said") {
  const Workshop shop;
  const std::string sequence = "'" + Walking::shared().folder().string() + "' ";
  // Fails on each image, or on all but the first.
  const auto detector = [&](const std::string& name, const std::string& first) {
    write_text(shop.root() / (name + ".yaml"),
               "%YAML:1.0\n---\ndetector:\n  name: " + name + "\n  type: process\n  command: [ /bin/sh, \"" +
                   (shop.root() / (name + ".sh")).string() + "\" ]\n  restarts: 100\n");
    write_text(shop.root() / (name + ".sh"),
               "echo dynfilter-provider 1\nid=0\nwhile read word id rest; do\nhead -c 921600 >/dev/null\n" +
                   first + "echo 'error it melted'\ndone\n");
    return "--detector " + shop.file(name + ".yaml") + " ";
  };
  const std::string broken = detector("broken", "");
  const std::string flaky =
      detector("flaky", "[ $id = 0 ] && { echo result 0; echo detections 0; echo end; continue; }\n");
  const std::string line = "the detector failed on every image: ";

  const CommandResult run =
      run_dynfilter("run " + sequence + "--pipeline rts_slam --json --frames 4 " + broken);
  CHECK(run.exit_code == 1);
  CHECK(std::count(run.err.begin(), run.err.end(), '\n') == 1);
  CHECK(run.err.rfind("dynfilter: rts_slam on walking: " + line, 0) == 0);
  CHECK(contains(run.err, "it melted"));
  CHECK(contains(value_of(run.out, "failure"), line));
  for (const char* key : {"ate_rmse_m", "recall", "static_kept"}) CHECK(value_of(run.out, key) == "null");

  const CommandResult compare =
      run_dynfilter("compare " + sequence + "--pipelines none,rts_slam --frames 4 --markdown " + broken);
  CHECK(compare.exit_code == 1);
  CHECK(std::count(compare.err.begin(), compare.err.end(), '\n') == 2);
  CHECK(!contains(compare.out, "ATE"));  // no row has one

  const CommandResult detect = run_dynfilter("detect " + sequence + "--frames 4 " + broken);
  CHECK(detect.exit_code == 1);
  CHECK(contains(detect.err, "broken on "));
  CHECK(contains(detect.err, line));

  const CommandResult some = run_dynfilter("run " + sequence + "--pipeline rts_slam --frames 4 " + flaky);
  CAPTURE(some.err);
  CHECK(some.exit_code == 0);
  CHECK(some.err.empty());
  CHECK(contains(some.out, "note: the detector failed on 3 of 4 images: "));
  const CommandResult seen = run_dynfilter("detect " + sequence + "--frames 4 " + flaky);
  CHECK(seen.exit_code == 0);
  CHECK(contains(seen.out, "the detector failed on 3 of them: "));
}
