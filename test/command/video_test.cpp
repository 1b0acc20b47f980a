// SPDX-License-Identifier: MIT
#ifdef DYNFILTER_HAS_VIDEOIO
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "io/video_samples.hpp"
#include "run_command.hpp"
#include "walking.hpp"

using namespace dynfilter_test;
namespace fs = std::filesystem;

namespace {

const cv::Size kSize{320, 240};

/// A textured wall and a textured square that moves over it, from a camera that stands still.
cv::Mat scene(int i) {
  cv::Mat wall(kSize, CV_8UC3), thing(80, 80, CV_8UC3);
  cv::RNG random(7);
  random.fill(wall, cv::RNG::UNIFORM, 0, 256);
  random.fill(thing, cv::RNG::UNIFORM, 0, 256);
  cv::GaussianBlur(wall, wall, {}, 2), cv::GaussianBlur(thing, thing, {}, 2);
  cv::normalize(wall, wall, 0, 255, cv::NORM_MINMAX), cv::normalize(thing, thing, 0, 255, cv::NORM_MINMAX);
  thing.copyTo(wall(cv::Rect(20 + 4 * (i % 50), 80, 80, 80)));
  return wall;
}

/// A video of 24 frames for all tests.
class Clip {
 public:
  Clip() : file_(root_.path() / "clip.avi") { write(file_, 24); }
  static void write(const fs::path& file, int frames) {
    cv::VideoWriter writer(file.string(), cv::CAP_FFMPEG, cv::VideoWriter::fourcc('M', 'J', 'P', 'G'), 25,
                           kSize);
    REQUIRE(writer.isOpened());
    for (int i = 0; i < frames; ++i) writer.write(scene(i));
  }
  static std::string file() {
    static const Clip clip;
    return "'" + clip.file_.string() + "'";
  }

 private:
  TemporaryFolder root_;
  fs::path file_;
};

std::size_t entries(const fs::path& folder) {
  std::size_t n = 0;
  for ([[maybe_unused]] const auto& entry : fs::directory_iterator(folder)) ++n;
  return n;
}

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t n = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++n;
  return n;
}

bool installed(const char* program) {
  return std::system(("command -v " + std::string(program) + " >/dev/null 2>&1").c_str()) == 0;
}

/// Largest resident memory of a run of the command [MB].
double peak_mb(const std::string& arguments) {
  const pid_t child = ::fork();
  if (child == 0) {
    const std::string line = "exec '" DYNFILTER_COMMAND "' " + arguments + " >/dev/null 2>&1";
    ::execl("/bin/sh", "sh", "-c", line.c_str(), nullptr);
    ::_exit(127);
  }
  int status = 0;
  rusage used{};
  REQUIRE(::wait4(child, &status, 0, &used) == child);
  REQUIRE(WIFEXITED(status));
  REQUIRE(WEXITSTATUS(status) == 0);
  return static_cast<double>(used.ru_maxrss) / 1024;
}

}  // namespace

TEST_CASE("run on a video: verdicts, no trajectory, and where to write them") {
  const CommandResult text = run_dynfilter("run " + Clip::file());
  CAPTURE(text.err);
  REQUIRE(text.exit_code == 0);
  CHECK(text.err.empty());
  CHECK(contains(text.out, "judged        24 frames: verdicts only, no trajectory"));
  CHECK_FALSE(contains(text.out, "ATE"));
  CHECK(contains(text.out, "guessed as 320 pixels"));
  CHECK(contains(text.out, "CPU time      decoding "));
  CHECK(contains(text.out, "frames a second on one core besides decoding; the video has 25"));
  CHECK(contains(text.out,
                 "--out dynfilter_clip writes dynfilter_clip/report.html, --video dynfilter_clip.mp4"));
  const CommandResult json = run_dynfilter("run " + Clip::file() + " --json");
  REQUIRE(json.exit_code == 0);
  CHECK(value_of(json.out, "frames") == "24");
  CHECK(value_of(json.out, "verdicts_only") == "true");
  CHECK(value_of(json.out, "sensor") == "\"mono\"");
  CHECK(number_in(json.out, "\"costs\"", "features_ms") > 0);
  CHECK(number_in(json.out, "\"costs\"", "source_rate_hz") == 25);
  CHECK(std::stod(value_of(json.out, "rejected_mean")) > 20);  // of the square
}

TEST_CASE("the verdicts of a video are those of its images") {
  const TemporaryFolder folder;
  cv::VideoCapture video(Clip::file().substr(1, Clip::file().size() - 2));
  fs::create_directories(folder.path() / "images");
  std::string times;
  cv::Mat image;
  for (int i = 0; video.read(image); ++i) {
    cv::imwrite((folder.path() / "images" / (std::to_string(i) + ".png")).string(), image);
    times += stamp(i / 25.0) + "\n";
  }
  write_text(folder.path() / "times.txt", times);
  std::string tables[3];
  const std::string inputs[] = {
      Clip::file(), "'" + folder.path().string() + "'",
      "'" + (folder.path() / "images" / "*.png").string() + "' --camera camera.yaml"};
  for (int k = 0; k < 2; ++k) {
    const fs::path out = folder.path() / ("out" + std::to_string(k));
    const CommandResult result = run_dynfilter("run " + inputs[k] + " --out '" + out.string() + "'");
    CAPTURE(result.err);
    REQUIRE(result.exit_code == 0);
    CHECK(contains(result.out, "verdicts only, no trajectory"));
    tables[k] = read_text(out / "verdicts.csv");
  }
  CHECK(tables[0].size() > 10'000);
  CHECK(tables[0] == tables[1]);
  const CommandResult pattern =
      run_dynfilter("run '" + (folder.path() / "images" / "*.png").string() + "' --json");
  REQUIRE(pattern.exit_code == 0);
  CHECK(value_of(pattern.out, "frames") == "24");
}

TEST_CASE("start, step, frames and scale choose what of a video is played") {
  const CommandResult part = run_dynfilter("run " + Clip::file() + " --start 3 --step 4 --frames 5 --json");
  REQUIRE(part.exit_code == 0);
  CHECK(value_of(part.out, "frames") == "5");
  CHECK(std::stod(value_of(part.out, "first_s")) == doctest::Approx(3 / 25.0));
  CHECK(std::stod(value_of(part.out, "last_s")) == doctest::Approx(19 / 25.0));
  const CommandResult rest = run_dynfilter("run " + Clip::file() + " --start 3 --step 4 --json");
  CHECK(value_of(rest.out, "frames") == "6");  // 3, 7, ... 23
  const TemporaryFolder folder;
  const std::string out = (folder.path() / "out").string();
  REQUIRE(run_dynfilter("run " + Clip::file() + " --scale 0.5 --out '" + out + "'").exit_code == 0);
  const cv::Mat picture = cv::imread(out + "/overlay/000010.png");
  CHECK(picture.cols == 240);  // 160 and a half
  check_refused("run " + Clip::file() + " --scale 2", "--scale");
  check_refused("run " + Clip::file() + " --step 0", "--step");
}

TEST_CASE("compare takes videos; with a camera file there are poses") {
  const CommandResult table = run_dynfilter("compare " + Clip::file() + " --pipelines none,dynfilter");
  CAPTURE(table.err);
  REQUIRE(table.exit_code == 0);
  CHECK(contains(table.out, "clip.avi\n"));
  CHECK(contains(table.out, "verdicts only, no trajectory"));
  const TemporaryFolder folder;
  const std::string camera = (folder.path() / "camera.yaml").string();
  write_text(camera, "Camera.fx: 300\nCamera.fy: 300\nCamera.cx: 160\nCamera.cy: 120\n");
  const CommandResult still = run_dynfilter("run " + Clip::file() + " --camera '" + camera + "'");
  CAPTURE(still.out);
  CHECK(still.exit_code == 0);
  CHECK_FALSE(contains(still.out, "guessed"));
  CHECK(contains(still.out, "the camera did not move enough for a map: verdicts only"));
}

TEST_CASE("the report of a video has a picture of every frame") {
  const TemporaryFolder folder;
  const fs::path out = folder.path() / "out";
  REQUIRE(run_dynfilter("run " + Clip::file() + " --out '" + out.string() + "'").exit_code == 0);
  const std::string page = read_text(out / "report.html");
  CHECK(count(page, "\"jpeg\":") == 24);
  CHECK(page.size() < 10'000'000);
  CHECK(contains(page, "guessed as 320 pixels"));
}

TEST_CASE("--video writes the annotated video, or nothing") {
  const TemporaryFolder folder;
  for (const char* name : {"out.mp4", "out.avi"}) {
    CAPTURE(name);
    const fs::path file = folder.path() / name;
    const CommandResult result =
        run_dynfilter("run " + Clip::file() + " --step 2 --video '" + file.string() + "'");
    CAPTURE(result.err);
    REQUIRE(result.exit_code == 0);
    CHECK(contains(result.out, "written to " + file.string()));
    cv::VideoCapture video(file.string());
    REQUIRE(video.isOpened());
    CHECK(video.get(cv::CAP_PROP_FPS) == doctest::Approx(12.5));
    cv::Mat frame;
    int frames = 0, red = 0;
    for (; video.read(frame); ++frames) {
      cv::Mat strong;
      cv::inRange(frame, cv::Scalar(0, 0, 170), cv::Scalar(110, 110, 255), strong);
      red += frames > 4 ? cv::countNonZero(strong) : 0;
    }
    CHECK(frames == 12);
    CHECK(red > 100);  // rejected features are drawn
  }
  const std::string file = (folder.path() / "out.mp4").string();
  check_refused("run " + Clip::file() + " --video '" + file + "'",
                "exists: choose another name, or replace it with --force");
  check_refused("run " + Clip::file() + " --video '" + file + ".gif'",
                "expected a name that ends with .mp4, .mov, .mkv or .avi");
  check_refused("run " + Clip::file() + " --video '" + folder.path().string() + "/no/x.mp4'",
                "no such folder");
  CHECK(entries(folder.path()) == 2);
  CHECK(run_dynfilter("run " + Clip::file() + " --frames 3 --force --video '" + file + "'").exit_code == 0);
  CHECK(entries(folder.path()) == 2);
}

TEST_CASE("an error in the middle leaves no half-written video") {
  const TemporaryFolder folder;
  fs::create_directories(folder.path() / "in");
  for (int i = 0; i < 4; ++i)
    cv::imwrite((folder.path() / "in" / (std::to_string(i) + ".png")).string(), scene(i));
  fs::resize_file(folder.path() / "in" / "3.png", 5000);
  check_refused("run '" + (folder.path() / "in").string() + "' --video '" +
                    (folder.path() / "x.mp4").string() + "' --out '" + (folder.path() / "out").string() + "'",
                "3.png: is truncated");
  CHECK(entries(folder.path()) == 1);
}

TEST_CASE("what a video or a camera cannot do names the option that helps") {
  const TemporaryFolder folder;
  const std::string nowhere = (folder.path() / "x").string();
  write_text(folder.path() / "poses.txt", "0 0 0 0 0 0 0 1\n");
  check_refused("map " + Clip::file() + " '" + (folder.path() / "poses.txt").string() + "'",
                "a map needs depth images, and a video has none; give a folder with depth");
  check_refused("run " + Clip::file() + " --map '" + nowhere + ".ply'",
                "a map needs depth images, and a video has none");
  check_refused("run " + Clip::file() + " --sensor rgbd", "has no depth images, which the sensor rgbd needs");
  check_refused("run " + Clip::file() + " --reverse",
                "is decoded forwards only; extract its images to a folder");
  check_refused("run " + Clip::file() + " --start 24", "the sequence has only 24 frames");
  check_refused("run " + Clip::file() + " --pipeline oracle", "has no label images, which `oracle` needs");
  check_refused("compare " + Clip::file() + " --pipelines none --variants --frames 2",
                "is decoded forwards only");
  const std::string camera = "'camera:" + Clip::file().substr(1);
  check_refused("run " + camera, "a camera has no end; give --frames N, or --live and end it with q");
  check_refused("compare " + camera + " --frames 3 --pipelines none,dynfilter", "a camera plays once");
  const CommandResult played = run_dynfilter("run " + camera + " --frames 5 --json");
  CHECK(value_of(played.out, "frames") == "5");
  const CommandResult ended = run_dynfilter("run " + camera + " --frames 500 --json");
  CHECK(value_of(ended.out, "frames") == "24");
  for (const char* command : {"run", "map", "compare", "detect", "masks"}) {
    const std::string more = command == std::string("map")
                                 ? " '" + (folder.path() / "poses.txt").string() + "'"
                             : command == std::string("compare") ? " --pipelines none"
                             : command == std::string("detect")  ? " --detector files --frames 1"
                             : command == std::string("masks")   ? " '" + nowhere + "' --frames 1"
                                                                 : " --out '" + nowhere + "' --frames 1";
    check_refused(std::string(command) + " camera:97" + more, "camera:97: no image comes from this camera");
    check_refused(std::string(command) + " '" + (folder.path() / "poses.txt").string() + "'" + more,
                  "poses.txt: is no video that OpenCV can read");
  }
  CHECK(entries(folder.path()) == 1);
}

TEST_CASE("--live without a display is one line") {
  for (const char* display : {"env -u DISPLAY -u WAYLAND_DISPLAY", "env -u WAYLAND_DISPLAY DISPLAY=:4711"}) {
    CAPTURE(display);
    const TemporaryFolder folder;
    const std::string err = (folder.path() / "err").string();
    const std::string line = std::string(display) + " '" DYNFILTER_COMMAND "' run " + Clip::file() +
                             " --live --out '" + (folder.path() / "out").string() + "' >/dev/null 2>" + err;
    CHECK(WEXITSTATUS(std::system(line.c_str())) == 2);
    const std::string said = read_text(err);
    CHECK(said.rfind("dynfilter: --live: ", 0) == 0);
    CHECK(count(said, "\n") == 1);
    CHECK(contains(said, "--video FILE.mp4 writes what it would show"));
    CHECK(entries(folder.path()) == 1);
  }
}

TEST_CASE("--live shows the features and keeps the pace, under Xvfb") {
  if (!installed("xvfb-run") || !installed("import")) {
    MESSAGE("skipped: needs xvfb-run and ImageMagick's import");
    return;
  }
  const TemporaryFolder folder;
  const std::string picture = (folder.path() / "window.png").string(),
                    out = (folder.path() / "out.json").string();
  const fs::path script = folder.path() / "script.sh", clip = folder.path() / "long.avi";
  Clip::write(clip, 100);
  write_text(script, "'" DYNFILTER_COMMAND "' run '" + clip.string() + "' --live --json >'" + out +
                         "' & run=$!\nsleep 2.5\nimport -window root '" + picture + "'\nwait $run\n");
  REQUIRE(WEXITSTATUS(std::system(("xvfb-run -a sh '" + script.string() + "' 2>/dev/null").c_str())) == 0);
  const std::string json = read_text(out);
  CAPTURE(json);
  const double frames = std::stod(value_of(json, "frames"));
  const std::size_t at = json.find(" dropped to keep the pace");
  const double dropped = at == std::string::npos ? 0 : std::stod(json.substr(json.rfind('"', at) + 1));
  CHECK(frames + dropped == 100);
  CHECK(std::stod(value_of(json, "last_s")) - std::stod(value_of(json, "first_s")) > 3.5);
  const cv::Mat shown = cv::imread(picture);
  REQUIRE_FALSE(shown.empty());
  cv::Mat green, red;
  cv::inRange(shown, cv::Scalar(40, 190, 40), cv::Scalar(110, 230, 90), green);
  cv::inRange(shown, cv::Scalar(0, 0, 170), cv::Scalar(110, 110, 255), red);
  CHECK(cv::countNonZero(green) > 200);
  CHECK(cv::countNonZero(red) > 50);
}

TEST_CASE("a run on a long video takes no more memory than one on a short video") {
  const TemporaryFolder folder;
  const fs::path file = folder.path() / "long.avi";
  Clip::write(file, 500);
  const std::string run = "run '" + file.string() + "' --frames ";
  const double short_mb = peak_mb(run + "100"), long_mb = peak_mb(run + "500");
  MESSAGE("100 frames " << short_mb << " MB, 500 frames " << long_mb << " MB; the images are 115 MB");
  CHECK(long_mb - short_mb < 12);
}
TEST_CASE("masks of a video come with the images that they are for") {
  const TemporaryFolder folder;
  const fs::path out = folder.path() / "out";
  const CommandResult run =
      run_dynfilter("masks " + Clip::file() + " '" + out.string() + "' --for colmap --start 2 --step 4");
  REQUIRE(run.exit_code == 0);
  CHECK(run.out.find("--image_path " + (out / "images").string()) != std::string::npos);
  CHECK(entries(out / "images") == 6);  // 2, 6, ..., 22 of 24
  CHECK(entries(out / "masks") == 6);
  const cv::Mat image = cv::imread((out / "images" / "000006.png").string());
  REQUIRE(image.size() == kSize);
  CHECK(cv::norm(image, scene(6), cv::NORM_L1) < cv::norm(image, scene(5), cv::NORM_L1));
  CHECK(cv::imread((out / "masks" / "000006.png.png").string(), cv::IMREAD_UNCHANGED).size() == kSize);

  check_refused("masks " + Clip::file() + " '" + out.string() + "2' --scale 0.5", "--scale");
  CHECK_FALSE(fs::exists(out.string() + "2"));
}

#endif
