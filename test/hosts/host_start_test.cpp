// SPDX-License-Identifier: MIT
#include <dynfilter/config/parameters.hpp>
#include <dynfilter/core/error.hpp>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/detectors/host_providers.hpp>
#include <dynfilter/hosts/masked_host.hpp>
#include <dynfilter/hosts/orb_slam.hpp>
#include <dynfilter/hosts/orb_slam/settings.hpp>
#include <dynfilter/pipeline/builtin_filters.hpp>
#include <dynfilter/semantic/provider.hpp>
#include <dynfilter/semantic/provider_registry.hpp>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <stdexcept>

#include "doctest/doctest.h"
#include "hosts/host_stand_ins.hpp"
#include "hosts/settings_folder.hpp"

namespace host_start_test {

// What a host is told at start and later, and where its boxes and masks come from.

using namespace dynfilter;

namespace {

using Frame = host::v2::Frame;
using Lines = std::vector<std::string>;

class Folder : public dynfilter_test::SettingsFolder {
 public:
  Folder() { std::filesystem::create_directories(path() / "masks"); }
  std::string settings(const std::string& keys) const {
    return write("settings.yaml",
                 "%YAML:1.0\n---\nCamera.fx: 250.0\nCamera.fy: 250.0\nCamera.cx: 160.0\nCamera.cy: 120.0\n"
                 "DepthMapFactor: 1.0\n" +
                     keys);
  }
};

constexpr int kWidth = 320, kHeight = 240;

/// 40 columns and 30 rows of features, 8 px apart, of class_id i; map points where `tracked`.
struct Host {
  explicit Host(long unsigned int id, bool tracked = false) : points(1200) {
    frame.mK = (cv::Mat_<float>(3, 3) << 250, 0, 160, 0, 250, 120, 0, 0, 1);
    frame.mDistCoef = cv::Mat::zeros(4, 1, CV_32F);
    frame.mnId = id;
    frame.mTimeStamp = stamp_s(id);
    for (int i = 0; i < 1200; ++i) {
      frame.mvKeys.emplace_back(static_cast<float>(4 + 8 * (i % 40)), static_cast<float>(4 + 8 * (i / 40)),
                                31, 0, 0, 0, i);
      frame.mvDepth.push_back(2);
      frame.mvuRight.push_back(-1);
      points[static_cast<std::size_t>(i)].mnId = static_cast<long unsigned int>(i);
      frame.mvpMapPoints.push_back(tracked ? &points[static_cast<std::size_t>(i)] : nullptr);
      frame.mvbOutlier.push_back(false);
    }
    frame.mvKeysUn = frame.mvKeys;
    frame.mDescriptors = cv::Mat::zeros(1200, 32, CV_8U);
    frame.N = 1200;
    if (tracked) frame.mTcw = cv::Mat::eye(4, 4, CV_32F);
  }
  static double stamp_s(long unsigned int id) { return 100 + 0.04 * static_cast<double>(id); }
  /// Of the left half of the image, and of all.
  std::pair<int, int> left_and_all() const {
    int left = 0;
    for (const cv::KeyPoint& key : frame.mvKeys) left += key.pt.x < kWidth / 2 ? 1 : 0;
    return {left, frame.N};
  }

  Frame frame;
  std::vector<host::v2::MapPoint> points;
};

cv::Mat grey(unsigned seed = 1) {
  cv::Mat image(kHeight, kWidth, CV_8UC1);
  std::mt19937 random(seed);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) image.at<std::uint8_t>(y, x) = static_cast<std::uint8_t>(random());
  return image;
}
cv::Mat depth() {
  return cv::Mat(kHeight, kWidth, CV_32FC1, cv::Scalar(2));
}
cv::Mat left_mask() {
  cv::Mat mask = cv::Mat::zeros(kHeight, kWidth, CV_8UC1);
  mask.colRange(0, kWidth / 2).setTo(1);
  return mask;
}
/// The left half.
Detection person() {
  Detection detection;
  detection.box = {-5, -5, kWidth / 2 + 5.0F, kHeight + 10.0F};
  detection.class_name = "person";
  return detection;
}

const char* const kNoFloor = "DynFilter.min_features_before_map: 0\nDynFilter.min_features: 0\n";
const char* const kReject =
    "pipeline:\n  floor: { min_features: 0 }\n  before_pose:\n"
    "    any: [ { semantic_box: { role: reject } }, { semantic_mask: { role: reject, dilate_px: 0 } } ]\n";

std::unique_ptr<OrbSlam> start(const std::string& settings_file, Lines& lines,
                               const ProviderRegistry& providers = host_providers()) {
  return OrbSlam::start(
      settings_file, 2, [&lines](const std::string& line) { lines.push_back(line); }, builtin_filters(),
      providers);
}
std::pair<int, int> judge(OrbSlam& filter, long unsigned int id, bool map_exists = true) {
  Host host(id);
  filter.before_tracking(host.frame, grey(), depth(), map_exists);
  return host.left_and_all();
}
std::string error_of(const std::string& settings_file) {
  try {
    OrbSlam filter(settings_file, 2, builtin_filters(), host_providers());
    return "";
  } catch (const ConfigError& error) {
    return error.what();
  }
}
bool has(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

/// Finds the left half in every image but those that it is to fail on.
class LeftHalf final : public SemanticProvider {
 public:
  struct Params {
    bool fails = false;
    static const FieldTable<Params>& fields() {
      static const FieldTable<Params> table{flag("fails", &Params::fails, "throws")};
      return table;
    }
  };
  static constexpr const char* kName = "left_half";
  static constexpr const char* kSummary = "the left half";
  explicit LeftHalf(const Params& params) : params_(params) {}
  std::string name() const override { return kName; }
  std::optional<SemanticResult> infer(const SemanticImage& image) override {
    if (params_.fails) throw std::runtime_error("no network");
    SemanticResult result;
    result.detections.emplace();
    if (image.pixels.channels() == 3) result.detections->push_back(person());  // on colour images only
    return result;
  }

 private:
  Params params_;
};

}  // namespace

TEST_CASE("masks and boxes decide on the first frame, with the default pipeline") {
  const Folder folder;
  for (const bool by_mask : {true, false}) {
    CAPTURE(by_mask);
    const auto first = [&](const std::string& keys, bool after_reset) {
      OrbSlam filter(folder.settings(keys), 2, builtin_filters(), host_providers());
      if (after_reset) judge(filter, 0), filter.reset();
      by_mask ? filter.set_mask(left_mask()) : filter.set_detections({person()});
      const std::pair<int, int> kept = judge(filter, 7, false);
      for (std::size_t i = 0; i < 1200; ++i) {
        if (filter.verdict().keep(i)) continue;
        CHECK(filter.verdict().reason(i) == (by_mask ? "semantic_mask" : "semantic_box"));
      }
      return kept;
    };
    CHECK(first("DynFilter.keep_first_frame: 1\n", false) == std::pair(600, 1200));
    for (const bool after_reset : {false, true}) {
      const auto [left, all] = first(kNoFloor, after_reset);
      CHECK(left == 0);
      CHECK(all >= 600 - 2 * 30);  // a mask reaches a few pixels beyond its outline
      // The floor holds: it restores some of the left half.
      CHECK(first("DynFilter.min_features_before_map: 700\n", after_reset).second == 700);
    }
  }
}

TEST_CASE("start: one line says which pipeline runs, what it uses and what the host gives") {
  const Folder folder;
  Lines lines;
  auto filter = start(folder.settings("DynFilter.pipeline: des_slam\n"), lines);
  REQUIRE(filter);
  REQUIRE(lines.size() == 1);
  CHECK(lines[0] == filter->start_line());
  CHECK(has(lines[0], "dynfilter: pipeline `des_slam` of "));
  CHECK(has(lines[0],
            "des_slam.yaml uses depth, camera, pose, mask, map points, covisible keyframes, "
            "correspondences; the host gives depth, camera, pose, map points, covisible keyframes, "
            "correspondences, but not: mask (masks: set_mask(), DynFilter.masks or "
            "DynFilter.detector); it also needs the calls at_keyframe()"));
  CHECK(filter->pipeline().name() == "des_slam");
  CHECK(has(filter->pipeline_file(), "des_slam.yaml"));

  const auto line = [&](const std::string& keys, int sensor = 2) {
    return OrbSlam(folder.settings(keys), sensor, builtin_filters(), host_providers()).start_line();
  };
  CHECK(has(line(kReject), "settings.yaml uses "));
  CHECK(has(line("DynFilter.pipeline: dynfilter\n", 0), "but not: depth, boxes, mask"));
  CHECK(has(line("DynFilter.pipeline: none\n"), "uses nothing"));
  CHECK(has(line(std::string("DynFilter.pipeline: rts_slam_g\n")), "the host gives all of it"));
  folder.write("boxes.txt", "100.0 none\n");
  CHECK(has(line("DynFilter.boxes: boxes.txt\n"), "but not: mask ("));
  CHECK(line("DynFilter.enabled: 0\n") == "dynfilter: off, every feature is kept (DynFilter.enabled)");
}

TEST_CASE("start: of wrong settings one line is told; on_error stops, or lets every feature through") {
  const Folder folder;
  for (const std::string wrong :
       {"DynFilter.pipeline: des_slm\n", "DynFilter.min_features: many\n", "DynFilter.unknown: 1\n",
        "Dynfilter.pipeline: rts_slam\n", "DynFilter.boxes: nowhere.txt\n", "DynFilter.pipeline: oracle\n"}) {
    CAPTURE(wrong);
    Lines lines;
    CHECK(start(folder.settings(wrong), lines) == nullptr);
    REQUIRE(lines.size() == 1);
    CHECK(has(lines[0], "dynfilter: " + (folder.path() / "settings.yaml").string() + ": "));
    CHECK(lines[0].find('\n') == std::string::npos);
    CHECK(start(folder.settings("DynFilter.on_error: stop\n" + wrong), lines) == nullptr);

    lines.clear();
    auto off = start(folder.settings("DynFilter.on_error: off\n" + wrong), lines);
    REQUIRE(off);
    REQUIRE(lines.size() == 1);
    CHECK(has(lines[0], "dynfilter: off, every feature is kept: "));
    off->set_detections({person()});
    for (long unsigned int id = 0; id < 3; ++id) CHECK(judge(*off, id) == std::pair(600, 1200));
    off->reset();
  }
  Lines lines;
  folder.write("oracle.yaml", "pipeline: { before_pose: [ epipolar ] }\n");  // not the preset
  const std::string own = (folder.path() / "oracle.yaml").string();
  CHECK(start(folder.settings("DynFilter.pipeline: " + own + "\n"), lines) != nullptr);
  lines.clear();
  CHECK(start(folder.settings("DynFilter.on_error: maybe\n"), lines) == nullptr);
  CHECK(has(lines.at(0), "expected one of stop, off, got `maybe`"));
  CHECK(start("/nowhere/settings.yaml", lines) == nullptr);
  CHECK(OrbSlam::start("/nowhere/settings.yaml", 2, nullptr) == nullptr);
}

TEST_CASE("an input that never came is warned of once: presets that need masks") {
  const Folder folder;
  for (const std::string name : {"des_slam", "ds_slam", "dynaslam", "rds_slam", "ngd_slam"}) {
    CAPTURE(name);
    const auto run = [&](bool masks, bool all_calls) {
      Lines lines;
      auto filter = start(folder.settings("DynFilter.pipeline: " + name + "\n"), lines);
      REQUIRE(filter);
      for (long unsigned int id = 0; id < 34; ++id) {
        CHECK(lines.size() == (id < 30 || lines.size() == 1 ? 1 : 2));
        Host host(id, true);
        if (masks) filter->set_mask(left_mask());
        filter->before_tracking(host.frame, grey(), depth(), true);
        if (!all_calls) continue;
        filter->after_pose(host.frame);
        filter->at_keyframe(host.frame, std::vector<host::v2::KeyFrame*>{});
      }
      return lines.size() > 1 ? lines[1] : "";
    };
    const std::string without = run(false, true);
    CHECK(has(without, "dynfilter: warning: pipeline `" + name + "`: in 30 frames no "));
    CHECK(has(without, "mask"));
    CHECK(has(without, "DynFilter.masks"));
    CHECK(has(without, "; nothing was rejected"));
    const std::string with = run(true, true);
    CHECK_FALSE(has(with.substr(0, with.find("; judged by semantic_mask")), "mask"));
    CHECK_FALSE(has(with, "was never called"));
    const bool later_stages = name != "ds_slam" && name != "ngd_slam";
    CHECK(has(run(true, false), "at_keyframe() was never called") == later_stages);
  }
}

TEST_CASE("boxes that suspects are routed by are needed: rts_slam warns, with the stages that judged") {
  const Folder folder;
  Lines lines;
  auto filter = start(folder.settings("DynFilter.pipeline: rts_slam\n"), lines);
  REQUIRE(filter);
  CHECK_FALSE(has(lines[0], "optional"));
  for (long unsigned int id = 0; id < 32; ++id) judge(*filter, id);
  REQUIRE(lines.size() == 2);
  CHECK(has(lines[1], "no boxes came for semantic_box; nothing was rejected; "));
}

TEST_CASE("a pipeline that gets all that it asks for, or is off, warns of nothing") {
  const Folder folder;
  for (const std::string keys :
       {"DynFilter.pipeline: rts_slam_g\n", "DynFilter.enabled: 0\n", "DynFilter.pipeline: none\n"}) {
    Lines lines;
    auto filter = start(folder.settings(keys), lines);
    REQUIRE(filter);
    for (long unsigned int id = 0; id < 32; ++id) judge(*filter, id);
    CHECK(lines.size() == 1);
    CHECK(filter->warning().empty());
  }
  // The default pipeline without a detector.
  Lines plain;
  auto by_default = start(folder.settings(""), plain);
  REQUIRE(by_default);
  for (long unsigned int id = 0; id < 32; ++id) judge(*by_default, id);
  CHECK(plain.size() == 1);
  // One frame with boxes is enough; a stage that lacks something else is named with it.
  Lines lines;
  auto filter = start(folder.settings(kReject), lines);
  REQUIRE(filter);
  for (long unsigned int id = 0; id < 32; ++id) {
    if (id == 3) filter->set_detections({person()});
    judge(*filter, id);
  }
  REQUIRE(lines.size() == 2);
  CHECK(lines[1] == filter->warning());
  CHECK(has(lines[1], "no mask came for semantic_mask; judged by semantic_box (masks: "));
}

TEST_CASE("DynFilter.boxes and masks: files by timestamp, beside the settings file") {
  const Folder folder;
  folder.write("boxes.txt",
               "100.0 0 person 0.9 -5 -5 160 250\n100.04 none\n100.08 0 chair 0.9 0 0 320 240\n");
  cv::imwrite((folder.path() / "masks/100.040000.png").string(), left_mask());
  const std::string open = std::string("DynFilter.keep_first_frame: 0\n") + kNoFloor + kReject;
  OrbSlam boxes(folder.settings("DynFilter.boxes: boxes.txt\n" + open), 2, builtin_filters(),
                host_providers());
  CHECK(judge(boxes, 0) == std::pair(0, 600));
  CHECK(judge(boxes, 1) == std::pair(600, 1200));
  CHECK(judge(boxes, 2) == std::pair(600, 1200));  // no chair moves by itself
  boxes.set_detections({person()});                // goes before the file
  CHECK(judge(boxes, 3) == std::pair(0, 600));

  OrbSlam both(folder.settings("DynFilter.boxes: boxes.txt\nDynFilter.masks: masks\n" + open), 2,
               builtin_filters(), host_providers());
  CHECK(judge(both, 0) == std::pair(0, 600));
  CHECK(judge(both, 1) == std::pair(0, 600));

  CHECK(has(error_of(folder.settings("DynFilter.boxes: nowhere.txt\n")), "DynFilter.boxes: nowhere.txt: no"));
  CHECK(has(error_of(folder.settings("DynFilter.masks: nowhere\n")), "DynFilter.masks: nowhere: no"));
  folder.write("wrong.txt", "100.0 person\n");
  CHECK(has(error_of(folder.settings("DynFilter.boxes: wrong.txt\n")), "wrong.txt:1: expected"));
  CHECK(has(error_of(folder.settings("DynFilter.boxes: boxes.txt\nDynFilter.detector: files\n")),
            "expected one"));
  // A host that hands in no kinds of detector is told what to add.
  for (const std::string key : {"boxes: boxes.txt", "masks: masks", "detector: read.yaml"}) {
    std::string error;
    try {
      OrbSlam without(folder.settings("DynFilter." + key + "\n" + open), 2);
    } catch (const ConfigError& refused) {
      error = refused.what();
    }
    CHECK(has(error, "DynFilter." + key.substr(0, key.find(':')) + ": this host has no detectors"));
    CHECK(has(error, "host_providers()"));
  }
  // Off is off: nothing is opened.
  CHECK(error_of(folder.settings("DynFilter.enabled: 0\nDynFilter.boxes: nowhere.txt\n")).empty());
}

TEST_CASE("DynFilter.detector: a detector's file or a preset, in any mode") {
  const Folder folder;
  folder.write("boxes.txt", "100.0 0 person 0.9 -5 -5 160 250\n");
  folder.write("read.yaml", "%YAML:1.0\n---\ndetector:\n  type: files\n  detections: boxes.txt\n");
  const std::string open = std::string("DynFilter.keep_first_frame: 0\n") + kNoFloor + kReject;
  OrbSlam files(folder.settings("DynFilter.detector: read.yaml\nDynFilter.detector_mode: sync\n" + open), 2,
                builtin_filters(), host_providers());
  CHECK(judge(files, 0) == std::pair(0, 600));

  ProviderRegistry providers;
  providers.add<LeftHalf>();
  folder.write("left.yaml", "%YAML:1.0\n---\ndetector:\n  type: left_half\n");
  folder.write("fails.yaml", "%YAML:1.0\n---\ndetector:\n  type: left_half\n  fails: true\n");
  Lines lines;
  const std::string sync = "DynFilter.detector_mode: sync\n" + open;
  auto filter = start(folder.settings("DynFilter.detector: left.yaml\n" + sync), lines, providers);
  REQUIRE(filter);
  CHECK(judge(*filter, 0) == std::pair(600, 1200));
  filter->set_detector_image(cv::Mat(kHeight, kWidth, CV_8UC3, cv::Scalar::all(9)));
  CHECK(judge(*filter, 1) == std::pair(0, 600));
  CHECK(judge(*filter, 2) == std::pair(600, 1200));  // that image was for one frame

  lines.clear();
  auto failing = start(folder.settings("DynFilter.detector: fails.yaml\n" + sync), lines, providers);
  REQUIRE(failing);
  for (long unsigned int id = 0; id < 4; ++id) CHECK(judge(*failing, id) == std::pair(600, 1200));
  REQUIRE(lines.size() == 2);
  CHECK(lines[1] == "dynfilter: warning: the detector failed: no network");

  OrbSlam beside(folder.settings("DynFilter.detector: read.yaml\n" + open), 2, builtin_filters(),
                 host_providers());  // async
  for (long unsigned int id = 0; id < 3; ++id) judge(beside, id);

  const auto error = [&](const std::string& keys) { return error_of(folder.settings(keys)); };
  CHECK(has(error("DynFilter.detector: nowhere\n"), "DynFilter.detector: nowhere: "));
  CHECK(has(error("DynFilter.detector: yolo_fasst\n"), "did you mean `yolo_fastest`?"));
  CHECK(
      has(error("DynFilter.detector: files\n"), "DynFilter.detector: "));  // the preset's files are not here
  CHECK(has(error("DynFilter.detector: read.yaml\nDynFilter.detector_mode: fast\n"),
            "DynFilter.detector_mode: expected sync, async"));
  folder.write("net.yaml", "%YAML:1.0\n---\ndetector:\n  type: dnn\n  network: x.onnx\n");
  CHECK(has(error("DynFilter.detector: net.yaml\n"), "link dynfilter::dnn, or use a detector of type"));
}

TEST_CASE("DynFilter.plugins: filters of modules may be named in the settings") {
  const Folder folder;
  const std::string pipeline = "pipeline:\n  before_pose: [ harmless ]\n";
  CHECK(has(error_of(folder.settings(pipeline)), "unknown filter `harmless`"));
  const std::string module = std::string("DynFilter.plugins: [ \"") + DYNFILTER_GOOD_PLUGIN + "\" ]\n";
  Lines lines;
  auto filter = start(folder.settings(module + pipeline), lines);
  REQUIRE(filter);
  judge(*filter, 0);
  REQUIRE(filter->verdict().report.stages.size() == 2);
  CHECK(filter->verdict().report.stages[1].name == "harmless");
  std::filesystem::copy_file(DYNFILTER_GOOD_PLUGIN, folder.path() / "beside.so");
  CHECK(error_of(folder.settings("DynFilter.plugins: beside.so\n" + pipeline)).empty());
  CHECK(
      has(error_of(folder.settings("DynFilter.plugins: nowhere.so\n")), "DynFilter.plugins: nowhere.so: no"));
}

TEST_CASE("boxes and masks of a frame are there at its later call points, and not in the next frame") {
  const Folder folder;
  OrbSlam filter(folder.settings(std::string("DynFilter.pipeline: rds_slam\n") + kNoFloor), 2,
                 builtin_filters(), host_providers());
  Host host(4, true);
  filter.set_mask(left_mask());
  filter.before_tracking(host.frame, grey(), depth(), true);
  CHECK(host.left_and_all() == std::pair(600, 1200));
  filter.after_pose(host.frame);  // every feature on the mask has a map point
  CHECK(host.left_and_all() == std::pair(0, 600));

  OrbSlam boxes(
      folder.settings(std::string(kNoFloor) + "pipeline:\n  floor: { min_features: 0 }\n  after_pose:\n"
                                              "    - semantic_box: { role: reject }\n"),
      2);
  boxes.set_detections({person()});
  for (long unsigned int id = 0; id < 2; ++id) {
    Host next(id, true);
    boxes.before_tracking(next.frame, grey(), depth(), true);
    boxes.after_pose(next.frame);
    CHECK(next.left_and_all() == (id == 0 ? std::pair(0, 600) : std::pair(600, 1200)));
  }
}

TEST_CASE("a closed host has the same keys: boxes of a file, the first frame, the line at start") {
  const Folder folder;
  folder.write("boxes.txt", "100.0 0 person 0.9 -5 -5 160 250\n");
  const std::string boxes = "DynFilter.boxes: boxes.txt\n";
  const auto zeroed = [&](const std::string& keys) {
    MaskedHost closed(folder.settings(keys), 2, builtin_filters(), MaskedImageParams(), host_providers());
    const MaskedHost::Images& images = closed.process(grey(), depth(), 100.0);
    return kWidth * kHeight - cv::countNonZero(images.depth);
  };
  CHECK(zeroed(boxes + "DynFilter.keep_first_frame: 1\n") == 0);
  CHECK(zeroed(boxes) > kWidth * kHeight / 4);  // a prior of the default
  MaskedHost closed(folder.settings(boxes), 2, builtin_filters(), MaskedImageParams(), host_providers());
  CHECK(has(closed.start_line(), "dynfilter: pipeline `dynfilter` of "));
  CHECK(has(closed.start_line(), "but not: pose, mask ("));
  CHECK(has(closed.start_line(), "; mask is optional"));
  for (int k = 0; k < 31; ++k) closed.process(grey(), depth(), 100 + 0.04 * k);
  CHECK(closed.warning().empty());
  MaskedHost needy(folder.settings(boxes + "DynFilter.pipeline: dynaslam\n"), 2, builtin_filters(),
                   MaskedImageParams(), host_providers());
  for (int k = 0; k < 31; ++k) needy.process(grey(), depth(), 100 + 0.04 * k);
  CHECK(has(needy.warning(), "no mask came for semantic_mask"));
}

}  // namespace host_start_test
