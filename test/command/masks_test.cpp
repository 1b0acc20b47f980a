// SPDX-License-Identifier: MIT
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <set>
#include <sstream>
#include <utility>
#include <vector>

#include "run_command.hpp"
#include "support/effort.hpp"
#include "walking.hpp"

using namespace dynfilter_test;
namespace fs = std::filesystem;

namespace {

std::string quoted(const fs::path& path) {
  return "'" + path.string() + "'";
}

/// People who walk, with perfect instance masks.
class Clip {
 public:
  Clip() {
    REQUIRE(run_dynfilter("synth walking_static " + quoted(input()) +
                          " --frames 14 --seed 3 --no-right --instances")
                .exit_code == 0);
  }
  fs::path input() const { return root_.path() / "clip"; }
  fs::path out() const { return root_.path() / "out"; }
  /// `masks INPUT OUT` with further arguments.
  std::string masks(const std::string& arguments) const {
    return "masks " + quoted(input()) + " " + quoted(out()) + " " + arguments;
  }
  std::string perfect() const {
    return "--shape objects --detections " + quoted(input() / "instances.txt") + " --masks " +
           quoted(input() / "instances") + " ";
  }
  static const Clip& shared() {
    static const Clip clip;
    return clip;
  }

 private:
  TemporaryFolder root_;
};

std::set<std::string> names_in(const fs::path& folder) {
  std::set<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder)) names.insert(entry.path().filename().string());
  return names;
}

}  // namespace

TEST_CASE("synth --instances: numbers of all objects, and their exact boxes") {
  const fs::path input = Clip::shared().input();
  const std::string name = "1700000000.266667.png";
  const cv::Mat instances = cv::imread((input / "instances" / name).string(), cv::IMREAD_UNCHANGED);
  const cv::Mat small = cv::imread((input / "instances_small" / name).string(), cv::IMREAD_UNCHANGED);
  CHECK(instances.size() == cv::Size(640, 480));
  CHECK(small.size() == cv::Size(160, 120));
  std::istringstream lines(read_text(input / "instances.txt"));
  int boxes = 0;
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string time, id, class_name, score;
    float x1 = 0, y1 = 0, x2 = 0, y2 = 0;
    words >> time >> id >> class_name >> score >> x1 >> y1 >> x2 >> y2;
    if (time != "1700000000.266667") continue;
    bool exact = false;
    for (int number = 1; number < 256 && !exact; ++number)
      exact = cv::Rect2f(cv::boundingRect(instances == number)) == cv::Rect2f({x1, y1}, cv::Point2f(x2, y2));
    CAPTURE(line);
    CHECK(exact);
    ++boxes;
  }
  CHECK(boxes >= 3);
  CHECK(!fs::exists(Walking::shared().folder() / "instances"));  // only if it is asked for
}

TEST_CASE("masks: one per image, with the name, the polarity and the size that each tool takes") {
  const Clip& clip = Clip::shared();
  cv::Mat plain;
  for (const auto& [tool, name] :
       std::vector<std::pair<std::string, std::string>>{{"plain", "1700000000.266667.png"},
                                                        {"colmap", "1700000000.266667.png.png"},
                                                        {"openmvg", "1700000000.266667_mask.png"},
                                                        {"nerfstudio", "1700000000.266667.png"},
                                                        {"droid", "1700000000.266667.png"}}) {
    CAPTURE(tool);
    const CommandResult result = run_dynfilter(clip.masks(clip.perfect() + "--force --for " + tool));
    CAPTURE(result.err);
    REQUIRE(result.exit_code == 0);
    CHECK(contains(result.out, "masks of clip for " + tool + ", shape objects, pipeline dynfilter"));
    CHECK(names_in(clip.out()) == std::set<std::string>{"masks", "masks.json", "overlay"});
    CHECK(names_in(clip.out() / "masks").size() == 14);
    CHECK(names_in(clip.out() / "overlay").size() == 14);
    const cv::Mat mask = cv::imread((clip.out() / "masks" / name).string(), cv::IMREAD_UNCHANGED);
    REQUIRE(mask.type() == CV_8UC1);
    CHECK(mask.size() == cv::Size(640, 480));
    CHECK(cv::countNonZero((mask != 0) & (mask != 255)) == 0);
    if (tool == "plain")
      plain = 255 - mask;
    else
      CHECK(cv::countNonZero(mask != plain) == 0);
  }
}

TEST_CASE("masks of objects: the people who walk, and nothing of the room") {
  const Clip& clip = Clip::shared();
  const CommandResult result = run_dynfilter(clip.masks(clip.perfect() + "--force --truth --json --grow 0"));
  CAPTURE(result.err);
  REQUIRE(result.exit_code == 0);
  CHECK(number_in(result.out, "truth", "iou") > 0.9);
  CHECK(number_in(result.out, "truth", "static_lost") < 0.01);
  CHECK(read_text(clip.out() / "masks.json") == result.out);
  const CommandResult grown = run_dynfilter(clip.masks(clip.perfect() + "--force --truth --json --grow 5"));
  CHECK(number_in(grown.out, "truth", "static_lost") > number_in(result.out, "truth", "static_lost"));
  CHECK(number_in(grown.out, "truth", "movers_masked") >= number_in(result.out, "truth", "movers_masked"));
}

TEST_CASE("masks of objects from a detector are those from the same boxes and masks in files") {
  const Clip& clip = Clip::shared();
  const TemporaryFolder root;
  write_text(root.path() / "f.yaml",
             "%YAML:1.0\n---\ndetector: { type: files, detections: instances.txt, masks: instances }\n");
  const std::string detector =
      "--detector " + quoted(root.path() / "f.yaml") + " --network-dir " + quoted(clip.input());
  const CommandResult files = run_dynfilter(clip.masks(clip.perfect() + "--force --truth --json"));
  const CommandResult same = run_dynfilter(clip.masks("--shape objects --force --truth --json " + detector));
  CAPTURE(same.err);
  REQUIRE(same.exit_code == 0);
  for (const char* key : {"iou", "movers_masked", "static_lost"})
    CHECK(number_in(same.out, "truth", key) == number_in(files.out, "truth", key));
  CHECK(contains(same.out, "boxes and masks from the detector files"));
}

TEST_CASE("masks with --until-static leave out people while they stand" * doctest::skip(!kLongTests)) {
  const TemporaryFolder root;  // they do not move in the first 15 frames
  const fs::path input = root.path() / "clip";
  REQUIRE(run_dynfilter("synth synchronous " + quoted(input) + " --frames 45 --seed 3 --no-right --instances")
              .exit_code == 0);
  const std::string masks = "masks " + quoted(input) + " " + quoted(root.path() / "out") +
                            " --force --json --truth --shape objects --detections " +
                            quoted(input / "instances.txt") + " --masks " + quoted(input / "instances");
  const CommandResult always = run_dynfilter(masks), moving = run_dynfilter(masks + " --until-static 0");
  CAPTURE(always.err);
  REQUIRE(always.exit_code == 0);
  CHECK(number_in(always.out, "truth", "movers_masked") > 0.9);
  CHECK(number_in(moving.out, "truth", "movers_masked") > 0.4);
  CHECK(number_in(moving.out, "truth", "movers_masked") < 0.8);
  const cv::Mat first =
      cv::imread((root.path() / "out/masks/1700000000.000000.png").string(), cv::IMREAD_UNCHANGED);
  CHECK(cv::countNonZero(first) == 0);
}

TEST_CASE("masks of features need no detector") {
  const Clip& clip = Clip::shared();
  const std::string features = "--force --truth --json --no-detections --no-masks ";
  const CommandResult result = run_dynfilter(clip.masks(features));
  CAPTURE(result.err);
  REQUIRE(result.exit_code == 0);
  CHECK(number_in(result.out, "truth", "iou") > 0.4);
  // What is between the features is most of a body.
  const CommandResult discs = run_dynfilter(clip.masks(features + "--shape discs"));
  CHECK(number_in(discs.out, "truth", "iou") < number_in(result.out, "truth", "iou"));
  CHECK(number_in(discs.out, "truth", "movers_masked") > 0);
  const CommandResult none = run_dynfilter(clip.masks(features + "--pipeline none"));
  CHECK(number_in(none.out, "truth", "movers_masked") == 0);
  const cv::Mat mask =
      cv::imread((clip.out() / "masks/1700000000.266667.png").string(), cv::IMREAD_UNCHANGED);
  CHECK(cv::countNonZero(mask) == 0);
  const CommandResult oracle = run_dynfilter(clip.masks(features + "--pipeline oracle"));
  // True votes spare the static scene. Votes that reach beyond outlines may cover a little more of the body.
  CHECK(number_in(oracle.out, "truth", "static_lost") < number_in(result.out, "truth", "static_lost") / 2);
  CHECK(number_in(oracle.out, "truth", "iou") > number_in(discs.out, "truth", "iou"));
}

TEST_CASE("masks for nerfstudio: transforms.json names a mask for every frame") {
  const TemporaryFolder root;
  const fs::path input = root.path() / "data";
  fs::create_directories(input / "images");
  std::string frames;
  for (int i = 1; i <= 3; ++i) {
    const std::string name = "frame_0000" + std::to_string(i) + ".png";
    cv::imwrite((input / "images" / name).string(), cv::Mat(48, 64, CV_8UC3, cv::Scalar(10, 20, i)));
    frames += std::string(i > 1 ? "," : "") + "{\"file_path\": \"images/" + name + "\"}";
  }
  write_text(input / "camera.yaml",
             "%YAML:1.0\n---\nCamera.fx: 60.0\nCamera.fy: 60.0\nCamera.cx: 32.0\nCamera.cy: 24.0\n");
  write_text(input / "transforms.json", "{\"fl_x\": 60, \"frames\": [" + frames + "]}");
  const std::string masks =
      "masks " + quoted(input) + " " + quoted(root.path() / "out") + " --for nerfstudio";
  const CommandResult result = run_dynfilter(masks);
  CAPTURE(result.err);
  REQUIRE(result.exit_code == 0);
  const std::string transforms = read_text(root.path() / "out/transforms.json");
  for (int i = 1; i <= 3; ++i)
    CHECK(contains(transforms, "\"mask_path\": \"masks/frame_0000" + std::to_string(i) + ".png\""));
  CHECK(contains(transforms, "\"fl_x\": 60"));
  CHECK(fs::exists(root.path() / "out/masks/frame_00003.png"));
  check_refused(masks + " --force --frames 2", "the frame `frame_00003` has no mask");
  CHECK(contains(read_text(root.path() / "out/transforms.json"), "frame_00003"));  // the old ones stay
  write_text(input / "transforms.json", "{}");
  check_refused(masks + " --force", "transforms.json: is not nerfstudio's");
}

TEST_CASE("masks refuse what cannot be, in one line, and leave nothing") {
  const Clip& clip = Clip::shared();
  const TemporaryFolder root;
  const fs::path out = root.path() / "out";
  const std::string input = "masks " + quoted(clip.input()) + " ";
  check_refused(input + quoted(out) + " --shape objects --no-detections --no-masks",
                "--shape objects: " + clip.input().string() + " has no masks of objects: give --detector");
  check_refused(input + quoted(out) + " --shape objects --no-masks --sensor mono",
                "there are boxes but no masks, and no depth images to make masks from: give --detector");
  check_refused(input + quoted(out) + " --shape objects --detector-mode late:3", "--detector-mode sync");
  check_refused(input + quoted(out) + " --for metashape", "--for");
  check_refused(input + quoted(out) + " --shape boxes", "--shape");
  check_refused(input + quoted(out) + " --until-static -1", "--until-static");
  check_refused("masks " + quoted(root.path() / "none") + " " + quoted(out), "no such folder");
  check_refused(input + quoted(clip.input()), "is in the input");
  check_refused(input + quoted(clip.input() / "new"), "is in the input");
  check_refused(input + quoted(clip.input().parent_path()), "contains the input");
  CHECK(!fs::exists(clip.input() / "new"));
  CHECK(names_in(root.path()).empty());
  write_tum_folder(root.path() / "unlabelled", 2);
  check_refused("masks " + quoted(root.path() / "unlabelled") + " " + quoted(out) + " --truth",
                "--truth needs");
  CHECK(!fs::exists(out));
}

TEST_CASE("masks in a folder are replaced with --force only") {
  const TemporaryFolder root;
  const std::string masks = "masks " + quoted(Walking::shared().folder()) + " " + quoted(root.path() / "out");
  REQUIRE(run_dynfilter(masks + " --frames 3").exit_code == 0);
  check_refused(masks + " --frames 2 --for colmap", "--force");
  REQUIRE(run_dynfilter(masks + " --frames 2 --for colmap --force").exit_code == 0);
  CHECK(names_in(root.path() / "out/masks") ==
        std::set<std::string>{"1700000000.000000.png.png", "1700000000.033333.png.png"});
}
