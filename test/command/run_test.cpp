// SPDX-License-Identifier: MIT
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <string>

#include "run_command.hpp"
#include "walking.hpp"

using namespace dynfilter_test;
namespace fs = std::filesystem;

namespace {

// A copy that a test may damage.
class Copy {
 public:
  Copy() : folder_(root_.path() / "copy") {
    fs::copy(Walking::shared().folder(), folder_, fs::copy_options::recursive);
  }
  const fs::path& folder() const { return folder_; }
  const fs::path& root() const { return root_.path(); }
  fs::path nth(const char* kind, int n) const {
    std::vector<fs::path> files;
    for (const auto& entry : fs::directory_iterator(folder_ / kind)) files.push_back(entry.path());
    std::sort(files.begin(), files.end());
    return files.at(static_cast<std::size_t>(n));
  }
  std::string out() const { return (root_.path() / "out").string(); }
  /// Checks that the run is refused with this reason and leaves no files.
  void check_run_refused(const std::string& reason, const std::string& more = "") const {
    check_refused("run '" + folder_.string() + "' --pipeline none --out '" + out() + "' " + more, reason);
    int entries = 0;
    for ([[maybe_unused]] const auto& entry : fs::directory_iterator(root_.path())) ++entries;
    CHECK(entries == 1);
  }

 private:
  TemporaryFolder root_;
  fs::path folder_;
};

std::size_t lines_of(const std::string& text) {
  return static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
}

}  // namespace

TEST_CASE("synth writes the whole layout, again over itself, and spares what is not its own") {
  const fs::path& folder = Walking::shared().folder();
  for (const char* name : {"rgb.txt", "depth.txt", "associations.txt", "groundtruth.txt", "camera.yaml",
                           "detections.txt", "rgb", "depth", "labels", "dynamic", "motion", "masks"}) {
    CAPTURE(name);
    CHECK(fs::exists(folder / name));
  }
  const TemporaryFolder root;
  const std::string again = (root.path() / "again").string();
  REQUIRE(run_dynfilter("synth static_desk " + again + " --frames 2").exit_code == 0);
  const CommandResult second = run_dynfilter("synth static_desk " + again + " --frames 1 --json");
  CHECK(second.exit_code == 0);
  CHECK(value_of(second.out, "frames") == "1");
  CHECK(lines_of(read_text(root.path() / "again" / "associations.txt")) == 1);
  fs::create_directories(root.path() / "mine");
  write_text(root.path() / "mine" / "thesis.txt", "do not touch");
  check_refused("synth static_desk " + (root.path() / "mine").string(), "exists and is not empty");
  check_refused("synth moon_walk " + (root.path() / "moon").string(),
                "unknown scene `moon_walk`; known scenes: ");
  check_refused("synth static_desk " + (root.path() / "no" / "where").string(), "no such folder");
  check_refused("synth static_desk " + (root.path() / "zero").string() + " --frames 0", "--frames");
  CHECK_FALSE(fs::exists(root.path() / "moon"));
}

TEST_CASE("run writes trajectory, tables, summary and pictures") {
  const Walking& walking = Walking::shared();
  const fs::path out = walking.root() / "results";
  const CommandResult result = run_dynfilter("run '" + walking.folder().string() +
                                             "' --pipeline rts_slam --json --out '" + out.string() + "'");
  CAPTURE(result.err);
  REQUIRE(result.exit_code == 0);
  CHECK(result.err.empty());
  const std::string summary = read_text(out / "summary.json");
  CHECK(value_of(summary, "frames") == "14");
  CHECK(value_of(summary, "tracked_frames") == "14");
  CHECK(std::stod(value_of(summary, "ate_rmse_m")) < 0.05);
  for (const char* key :
       {"rpe_trans_rmse_m", "rpe_rot_rmse_deg", "precision", "recall", "static_kept", "features_mean",
        "rejected_mean", "total", "extraction", "correspondence", "filters", "tracking"}) {
    CAPTURE(key);
    CHECK(value_of(summary, key) != "absent");
    CHECK(value_of(result.out, key) != "absent");
  }
  CHECK(value_of(summary, "rpe_trans_rmse_m") == "null");  // shorter than a second
  CHECK(value_of(summary, "failure") == "null");
  CHECK(number_in(summary, "\"cpu_ms\"", "total") > 0);
  CHECK(number_in(summary, "\"cpu_ms\"", "judge") > 0);
  CHECK(lines_of(read_text(out / "trajectory.txt")) == 15);
  CHECK(lines_of(read_text(out / "frames.csv")) == 15);
  CHECK(lines_of(read_text(out / "verdicts.csv")) > 14 * 500);
  const cv::Mat picture = cv::imread((out / "overlay" / "000013.png").string());
  CHECK(picture.cols == 960);
  CHECK(picture.rows > 720);
}

TEST_CASE("same input, same verdicts: twice, and with one and two threads") {
  const Walking& walking = Walking::shared();
  std::string first;
  for (const char* how : {"--threads 1", "--threads 1", "--threads 2"}) {
    const fs::path out = walking.root() / "same";
    REQUIRE(run_dynfilter("run '" + walking.folder().string() + "' --pipeline rts_slam --out '" +
                          out.string() + "' --force " + how)
                .exit_code == 0);
    const std::string verdicts = read_text(out / "verdicts.csv") + read_text(out / "trajectory.txt");
    if (first.empty()) first = verdicts;
    CHECK(first == verdicts);
  }
}

// With the depths of descriptor matches only, 0.82 of the static features were kept.
TEST_CASE("stereo: people who walk in a room are found, and the room is kept") {
  const fs::path folder = Walking::shared().root() / "stereo_room";
  REQUIRE(run_dynfilter("synth walking_xyz '" + folder.string() + "' --frames 25 --seed 22").exit_code == 0);
  const CommandResult run =
      run_dynfilter("run '" + folder.string() + "' --sensor stereo --no-detections --no-masks --json");
  REQUIRE(run.exit_code == 0);
  CHECK(std::stod(value_of(run.out, "recall")) >= 0.95);
  CHECK(std::stod(value_of(run.out, "static_kept")) >= 0.90);
}

TEST_CASE("oracle rejects what moves; start, frames and reverse choose what is played") {
  const std::string folder = "'" + Walking::shared().folder().string() + "'";
  const CommandResult oracle = run_dynfilter("run " + folder + " --pipeline oracle --json");
  REQUIRE(oracle.exit_code == 0);
  CHECK(value_of(oracle.out, "recall") == "1.0");
  const CommandResult part = run_dynfilter("run " + folder + " --pipeline none --json --start 4 --frames 5");
  CHECK(value_of(part.out, "frames") == "5");
  const CommandResult reverse =
      run_dynfilter("run " + folder + " --pipeline none --json --reverse --start 4");
  CHECK(value_of(reverse.out, "frames") == "10");
  CHECK(value_of(reverse.out, "tracked_frames") == "10");
  CHECK(value_of(reverse.out, "ate_rmse_m") != "null");
  CHECK(value_of(reverse.out, "recall") == "null");
  CHECK(contains(reverse.out, "played in reverse"));
}

TEST_CASE("compare prints a row per pipeline, medians over variants, and JSON") {
  const std::string folder = "'" + Walking::shared().folder().string() + "'";
  const CommandResult table = run_dynfilter("compare " + folder + " --pipelines none,rts_slam_s");
  REQUIRE(table.exit_code == 0);
  CHECK(table.out.rfind("walking\npipeline  ", 0) == 0);
  CHECK(contains(table.out, "\nnone "));
  CHECK(contains(table.out, "\nrts_slam_s "));
  const CommandResult json =
      run_dynfilter("compare " + folder + " --pipelines none --variants --frames 3 --json");
  REQUIRE(json.exit_code == 0);
  CHECK(contains(json.out, "\"variant\": \"reverse from 10\""));
  CHECK(value_of(json.out, "runs") == "6");
  CHECK(value_of(json.out, "ate_over_oracle") == "null");
  const CommandResult both =
      run_dynfilter("compare " + folder + " --pipelines none,oracle --variants --frames 3 --json");
  REQUIRE(both.exit_code == 0);
  const std::string none = both.out.substr(both.out.find("\"medians\""));
  const std::string oracle = none.substr(none.find("\"oracle\""));
  CHECK(value_of(oracle, "ate_over_oracle") == "1.0");
  const double ratio = std::stod(value_of(none, "ate_rmse_m")) / std::stod(value_of(oracle, "ate_rmse_m"));
  CHECK(std::stod(value_of(none, "ate_over_oracle")) == doctest::Approx(ratio));
  CHECK(std::abs(ratio - 1) > 1e-3);
  check_refused("compare " + folder, "--pipelines is required (`dynfilter presets` lists the names)");
  check_refused("compare " + folder + " --pipelines none,nosuch", "presets: ");
  check_refused("compare " + folder + " --pipelines ' nosuch , none'", "dynfilter: nosuch: neither a file");
  check_refused("compare " + folder + " --pipelines ' , '", "--pipelines: expected at least one name");
}

TEST_CASE("bad usage of run") {
  const Copy copy;
  const std::string folder = "'" + copy.folder().string() + "'";
  copy.check_run_refused("the sequence has only 14 frames", "--start 14");
  copy.check_run_refused("--detections boxes.txt: no such file", "--detections boxes.txt");
  copy.check_run_refused("--camera camera.yml: no such file", "--camera camera.yml");
  check_refused("run " + folder + " --pipeline none --start -1", "--start");
  check_refused("run /nowhere/at/all --pipeline none", "/nowhere/at/all: no such folder");
  fs::remove_all(copy.folder() / "labels");
  check_refused("run " + folder + " --pipeline oracle", "has no label images, which `oracle` needs");
}

TEST_CASE("bad input: exit code 2, one line, nothing half-written") {
  const Copy copy;
  SUBCASE("empty rgb.txt") {
    fs::remove(copy.folder() / "associations.txt");
    write_text(copy.folder() / "rgb.txt", "");
    copy.check_run_refused("rgb.txt: lists no images");
  }
  SUBCASE("depth of another size, in the middle") {
    const cv::Mat depth = cv::imread(copy.nth("depth", 6).string(), cv::IMREAD_UNCHANGED);
    cv::imwrite(copy.nth("depth", 6).string(), depth(cv::Rect(0, 0, 320, 240)));
    copy.check_run_refused("is 320x240, but its colour image");
  }
  SUBCASE("truncated colour image, in the middle") {
    fs::resize_file(copy.nth("rgb", 6), 5000);
    copy.check_run_refused(copy.nth("rgb", 6).filename().string() + ": is truncated");
  }
  SUBCASE("truncated depth image at the end") {
    fs::resize_file(copy.nth("depth", 13), fs::file_size(copy.nth("depth", 13)) - 1);
    copy.check_run_refused("is truncated");
  }
  SUBCASE("no frame with any depth: all zero") {
    for (int i = 0; i < 14; ++i)
      cv::imwrite(copy.nth("depth", i).string(), cv::Mat(480, 640, CV_16UC1, cv::Scalar(0)));
    copy.check_run_refused("no frame has any depth");
  }
  SUBCASE("no frame with any depth: no images") {
    fs::remove_all(copy.folder() / "depth");
    copy.check_run_refused("no frame has depth");
  }
  SUBCASE("timestamps out of order") {
    std::string lines = read_text(copy.folder() / "associations.txt");
    lines += lines.substr(0, lines.find('\n') + 1);
    write_text(copy.folder() / "associations.txt", lines);
    copy.check_run_refused("timestamps out of order");
  }
  SUBCASE("no associations within tolerance") {
    fs::remove(copy.folder() / "associations.txt");
    std::string depth;
    for (int i = 0; i < 14; ++i)
      depth += std::to_string(10 + i) + " depth/" + copy.nth("depth", i).filename().string() + "\n";
    write_text(copy.folder() / "depth.txt", depth);
    copy.check_run_refused("no depth image within 0.02");
  }
  SUBCASE("broken ground truth") {
    write_text(copy.folder() / "groundtruth.txt", "1 2 3\n");
    copy.check_run_refused("groundtruth.txt:1: expected");
  }
  SUBCASE("broken detections") {
    write_text(copy.folder() / "detections.txt", "1 0 person high 1 2 3 4\n");
    copy.check_run_refused("detections.txt:1: 'high' is not a number");
  }
  SUBCASE("an unknown camera") {
    fs::remove(copy.folder() / "camera.yaml");
    copy.check_run_refused("the camera is not known");
    copy.check_run_refused("; give a camera file with --camera");
  }
}

TEST_CASE("odd data is left out, counted and said once") {
  const Copy copy;
  fs::remove(copy.nth("depth", 5));
  std::string boxes = read_text(copy.folder() / "detections.txt");
  boxes += "99.5 0 person 0.9 1 2 30 40\n99.5 0 person 0.8 1 2 30 40\n" +
           std::string("98.5 0 person 0.9 40 2 30 40\n");
  write_text(copy.folder() / "detections.txt", boxes);
  const CommandResult result = run_dynfilter("run '" + copy.folder().string() + "' --pipeline none");
  CHECK(result.exit_code == 0);
  CHECK(result.err.empty());
  CHECK(contains(result.out, "tracked       14 of 14 frames"));
  CHECK(contains(result.out, "1 frame has no depth image"));
  CHECK(contains(result.out, "boxes from detections.txt"));
  CHECK(contains(result.out, "boxes of 2 images that are not in the sequence"));
  CHECK(contains(result.out, "1 unusable box left out"));
}

TEST_CASE("run hands masks and boxes to the pipeline, unless told not to") {
  const TemporaryFolder folder;
  const std::string preset = (folder.path() / "p.yaml").string();
  write_text(
      preset,
      "%YAML:1.0\n---\npipeline:\n  before_pose:\n    - any:\n        - semantic_mask: { role: reject }\n"
      "        - semantic_box: { role: reject }\n");
  const auto rejected = [&](const std::string& more) {
    const CommandResult result = run_dynfilter("run '" + Walking::shared().folder().string() +
                                               "' --pipeline '" + preset + "' --frames 3 --json " + more);
    CAPTURE(result.err);
    REQUIRE(result.exit_code == 0);
    return std::stod(value_of(result.out, "rejected_mean"));
  };
  const double both = rejected(""), boxes = rejected("--no-masks"), masks = rejected("--no-detections");
  CHECK(masks > 0);
  CHECK(boxes > 0);
  CHECK(both >= std::max(boxes, masks));
  CHECK(rejected("--no-masks --no-detections") == 0);
  const std::string own = (Walking::shared().folder() / "masks").string();
  CHECK(rejected("--no-detections --masks '" + own + "'") == masks);
  const std::string run = "run '" + Walking::shared().folder().string() + "' --pipeline none ";
  check_refused(run + "--masks nowhere", "nowhere: no mask is named as a colour image of the sequence");
  check_refused(run + "--masks nowhere --no-masks", "excludes");
  check_refused(run + "--masks '" + (Walking::shared().folder() / "rgb").string() + "'",
                "is not an 8-bit label image");
}

TEST_CASE("boxes come as late as --detector-mode says, and the same in every run") {
  const Walking& walking = Walking::shared();
  const auto run = [&](const std::string& mode) {
    const std::string out = (walking.root() / ("late" + std::to_string(mode.size()) + mode.back())).string();
    const CommandResult result = run_dynfilter("run '" + walking.folder().string() +
                                               "' --pipeline rts_slam_s --json --detector-mode " + mode +
                                               " --force --out '" + out + "'");
    CAPTURE(result.err);
    REQUIRE(result.exit_code == 0);
    return read_text(fs::path(out) / "summary.json");
  };
  const auto age = [](const std::string& summary) { return value_of(summary, "age_median_frames"); };
  CHECK(std::stod(age(run("sync"))) == 0);
  const std::string late = run("late:3");
  CHECK(std::stod(age(late)) == 3);
  CHECK(value_of(late, "frames_with_result") == "11");
  CHECK(value_of(run("late:3"), "rejected_mean") == value_of(late, "rejected_mean"));
  const int looked_at = std::stoi(value_of(run("rate:10"), "looked_at"));  // 14 frames at 30 Hz
  CHECK(looked_at >= 4);
  CHECK(looked_at <= 5);
  check_refused("run '" + walking.folder().string() + "' --pipeline none --detector-mode late:x",
                "detector-mode");
}

TEST_CASE("run --map writes a cloud that stands still, and a picture of it") {
  const Walking& walking = Walking::shared();
  const TemporaryFolder out;
  const auto map_of = [&](const std::string& pipeline, const std::string& more) {
    const fs::path file = out.path() / (pipeline + ".ply");
    const CommandResult result = run_dynfilter("run '" + walking.folder().string() + "' --json --pipeline " +
                                               pipeline + " --map '" + file.string() + "' " + more);
    CAPTURE(result.err);
    REQUIRE(result.exit_code == 0);
    const cv::Mat picture = cv::imread((out.path() / (pipeline + ".png")).string());
    CHECK(picture.cols == 2 * 640);
    CHECK(picture.rows == 480 + 30);  // a title above two views
    for (const cv::Rect& part :
         {cv::Rect(0, 0, 640, 30), cv::Rect(10, 460, 120, 40), cv::Rect(650, 460, 120, 40)}) {
      double least = 0, most = 0;  // dark paper and light ink: title, and a scale in each view
      cv::minMaxLoc(picture(part).clone().reshape(1), &least, &most);
      CHECK(least < 60);
      CHECK(most > 200);
    }
    const std::string ply = read_text(file), points = value_of(result.out, "points");
    CHECK(ply.rfind("ply\nformat binary_little_endian 1.0\nelement vertex " + points + "\n", 0) == 0);
    // x, y, z, three colours, a class
    CHECK(ply.size() == ply.find("end_header\n") + 11 + std::stoul(points) * 19);
    return std::stoul(points);
  };
  const std::size_t all = map_of("none", ""), still = map_of("oracle", "");
  CHECK(still > 10000);
  CHECK(still < all);
  CHECK(map_of("oracle", "--map-leaf-m 0.08") < still / 4);
  check_refused("run '" + walking.folder().string() + "' --pipeline none --map /no/such/map.ply",
                "/no/such: no such folder");
  check_refused("run '" + walking.folder().string() + "' --pipeline none --map m.ply --map-leaf-m 0",
                "--map-leaf-m");
}
