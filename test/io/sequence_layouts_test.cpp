// SPDX-License-Identifier: MIT
#include <Eigen/Geometry>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "doctest/doctest.h"
#include "io/sequence.hpp"
#include "io/tum_folder.hpp"

namespace sequence_layouts_test {

using namespace dynfilter;
using namespace dynfilter_test;
namespace fs = std::filesystem;

namespace {

std::string complaint(const fs::path& folder, const io::SequenceOptions& options = {}) {
  try {
    const io::Sequence sequence = io::Sequence::open(folder, options);
    for (std::size_t i = 0; i < sequence.size(); ++i) sequence.load(i);
    sequence.ground_truth();
    return "";
  } catch (const IoError& error) {
    CHECK(std::string(error.what()).find('\n') == std::string::npos);
    return error.what();
  }
}

void has(const std::string& text, const std::string& part) {
  CAPTURE(text);
  CHECK(text.find(part) != std::string::npos);
}

void write_image(const fs::path& path, int value, cv::Size size = {16, 12}) {
  fs::create_directories(path.parent_path());
  cv::imwrite(path.string(), cv::Mat(size, CV_8UC1, cv::Scalar(value)));
}

// Focal length 10 px; camera 1 is 0.5 m to the right of camera 0, 2 is 0.06 m and 3 is 0.6 m.
constexpr const char* kCalibration =
    "P0: 10 0 8 0 0 11 6 0 0 0 1 0\nP1: 10 0 8 -5 0 11 6 0 0 0 1 0\n"
    "P2: 10 0 8 -0.6 0 11 6 0 0 0 1 0\nP3: 10 0 8 -6 0 11 6 0 0 0 1 0\nTr: 1 0 0 0 0 1 0 0 0 0 1 0\n";

// Three frames, 0.1 s apart. Camera 0 looks along the world's z axis and moves along it by 1 m a frame.
void write_kitti_folder(const fs::path& folder, const std::string& left = "image_0",
                        const std::string& right = "image_1") {
  for (int i = 0; i < 3; ++i) {
    const std::string name = "00000" + std::to_string(i) + ".png";
    write_image(folder / left / name, 10 + i);
    write_image(folder / right / name, 20 + i);
  }
  write_text(folder / "calib.txt", kCalibration);
  write_text(folder / "times.txt", "0\n1.0e-01\n2.0e-01\n");
  write_text(folder / "poses.txt",
             "1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 0 0 1 0 0 0 0 1 1\n1 0 0 0 0 1 0 0 0 0 1 2\n");
}

/// A camera of a rig in EuRoC's manner, with an image of a few bright dots.
struct RigView {
  Eigen::Isometry3d T_body_camera;
  double fx, fy, cx, cy, k1, k2, p1, p2;
  static constexpr int kWidth = 320, kHeight = 200;

  Eigen::Vector2d project(const Eigen::Vector3d& body_m) const {
    const Eigen::Vector3d p = T_body_camera.inverse() * body_m;
    const double x = p.x() / p.z(), y = p.y() / p.z(), r2 = x * x + y * y;
    const double radial = 1 + k1 * r2 + k2 * r2 * r2;
    return {fx * (x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x)) + cx,
            fy * (y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y) + cy};
  }
  cv::Mat image_of(const std::vector<Eigen::Vector3d>& body_m) const {
    cv::Mat image(kHeight, kWidth, CV_8UC1);
    for (int v = 0; v < kHeight; ++v)
      for (int u = 0; u < kWidth; ++u) {
        double light = 0;
        for (const Eigen::Vector3d& p : body_m) {
          constexpr double kSpread_px = 2;
          light += 250 * std::exp(-0.5 * (Eigen::Vector2d(u, v) - project(p)).squaredNorm() /
                                  (kSpread_px * kSpread_px));
        }
        image.at<std::uint8_t>(v, u) = cv::saturate_cast<std::uint8_t>(light);
      }
    return image;
  }
  std::string yaml() const {
    std::ostringstream out;
    out.precision(17);
    out << "# General sensor definitions.\nsensor_type: camera\ncomment: made up (no sensor)\n\n"
        << "# Sensor extrinsics wrt. the body-frame.\nT_BS:\n  cols: 4\n  rows: 4\n  data: [";
    for (int r = 0; r < 4; ++r)
      for (int c = 0; c < 4; ++c)
        out << T_body_camera.matrix()(r, c) << (r == 3 && c == 3 ? "]\n" : c == 3 ? ",\n         " : ", ");
    out << "\n# Camera specific definitions.\nrate_hz: 20\nresolution: [" << kWidth << ", " << kHeight
        << "]\ncamera_model: pinhole\nintrinsics: [" << fx << ", " << fy << ", " << cx << ", " << cy
        << "] #fu, fv, cu, cv\ndistortion_model: radial-tangential\ndistortion_coefficients: [" << k1 << ", "
        << k2 << ", " << p1 << ", " << p2 << "]\n";
    return out.str();
  }
};

Eigen::Isometry3d placed(double x, double y, double z, double roll, double pitch, double yaw) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() =
      (Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()) * Eigen::AngleAxisd(pitch, Eigen::Vector3d::UnitY()) *
       Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitX()))
          .toRotationMatrix();
  T.translation() = Eigen::Vector3d(x, y, z);
  return T;
}

// The body's z axis is ahead. Both cameras are turned by some degrees and are not level.
const RigView kLeft{
    placed(-0.02, -0.06, 0.01, 0.02, -0.01, 0.03), 200, 198, 163, 97, -0.28, 0.07, 2e-4, 2e-5},
    kRight{placed(0.09, -0.055, 0.014, 0.01, 0.015, -0.02), 202, 201, 155, 103, -0.27, 0.06, -1e-4, 3e-4};
// One dot per quarter of the image, at different depths.
const std::vector<Eigen::Vector3d> kDots{{-0.5, -0.25, 1.5}, {0.9, -0.5, 2.5}, {-0.8, 0.5, 2}, {1.1, 0.6, 3}};

void write_euroc_folder(const fs::path& folder) {
  const fs::path root = folder / "mav0";
  fs::create_directories(root / "cam0" / "data");
  fs::create_directories(root / "cam1" / "data");
  static const cv::Mat left = kLeft.image_of(kDots), right = kRight.image_of(kDots);
  std::string list = "#timestamp [ns],filename\n";
  for (const std::string stamp_ns : {"1403636579763555584", "1403636579813555456"}) {
    list += stamp_ns + "," + stamp_ns + ".png\r\n";
    cv::imwrite((root / "cam0" / "data" / (stamp_ns + ".png")).string(), left);
    cv::imwrite((root / "cam1" / "data" / (stamp_ns + ".png")).string(), right);
  }
  write_text(root / "cam0" / "data.csv", list);
  write_text(root / "cam1" / "data.csv", list);
  write_text(root / "cam0" / "sensor.yaml", kLeft.yaml());
  write_text(root / "cam1" / "sensor.yaml", kRight.yaml());
  fs::create_directories(root / "state_groundtruth_estimate0");
  // A quarter turn of the body about its z axis, at (1, 2, 3).
  write_text(root / "state_groundtruth_estimate0" / "data.csv",
             "#timestamp, p_RS_R_x [m], ...\n1403636579763555584,1,2,3,0.70710678118654752,0,0,"
             "0.70710678118654752,0,0,0,0,0,0,0,0,0\n");
}

/// Centre of the dot nearest to a pixel.
cv::Point2d dot_near(const cv::Mat& grey, const Eigen::Vector2d& px) {
  double sum = 0, u = 0, v = 0;
  constexpr int kReach = 9;
  for (int y = cvRound(px.y()) - kReach; y <= cvRound(px.y()) + kReach; ++y)
    for (int x = cvRound(px.x()) - kReach; x <= cvRound(px.x()) + kReach; ++x) {
      if (x < 0 || y < 0 || x >= grey.cols || y >= grey.rows) continue;
      const double light = grey.at<std::uint8_t>(y, x);
      sum += light, u += light * x, v += light * y;
    }
  return {u / sum, v / sum};
}

}  // namespace

TEST_CASE("KITTI odometry: grey images, calibration, times and poses") {
  const TemporaryFolder root;
  write_kitti_folder(root.path());
  const io::Sequence sequence = io::Sequence::open(root.path());
  REQUIRE(sequence.size() == 3);
  CHECK(sequence.notes().empty());
  CHECK(sequence.timestamp_s(2) == 0.2);
  CHECK(sequence.image_name(1) == "000001");
  const Camera& camera = sequence.camera();
  CHECK(camera.fx_px == 10);
  CHECK(camera.fy_px == 11);
  CHECK(camera.cx_px == 8);
  CHECK(camera.cy_px == 6);
  CHECK(camera.baseline_m() == doctest::Approx(0.5));
  CHECK(sequence.has_stereo());
  CHECK_FALSE(sequence.has_depth());
  const io::SequenceFrame frame = sequence.load(1);
  CHECK(frame.grey.at<std::uint8_t>(5, 5) == 11);
  CHECK(frame.right.at<std::uint8_t>(5, 5) == 21);
  CHECK(frame.colour.type() == CV_8UC3);
  CHECK(frame.depth.empty());
  const auto truth = sequence.ground_truth();
  REQUIRE(truth);
  CHECK(truth->at(2).timestamp_s == 0.2);
  CHECK(truth->at(2).T_world_camera.translation_m[2] == 2);
}

TEST_CASE("KITTI odometry: the colour cameras are beside camera 0, where the poses are") {
  const TemporaryFolder root;
  const fs::path folder = root.path() / "sequences" / "07";
  write_kitti_folder(folder, "image_2", "image_3");
  fs::create_directories(root.path() / "poses");
  fs::rename(folder / "poses.txt", root.path() / "poses" / "07.txt");  // as downloaded
  const io::Sequence sequence = io::Sequence::open(folder);
  CHECK(sequence.camera().baseline_m() == doctest::Approx(0.54));
  REQUIRE(sequence.ground_truth());
  CHECK(sequence.ground_truth()->at(1).T_world_camera.translation_m[0] == doctest::Approx(0.06));
  CHECK(sequence.ground_truth()->at(1).T_world_camera.translation_m[2] == 1);
}

TEST_CASE("KITTI odometry without right images is mono; missing images are counted") {
  const TemporaryFolder root;
  write_kitti_folder(root.path());
  fs::remove(root.path() / "image_1" / "000001.png");
  fs::remove(root.path() / "image_0" / "000002.png");
  {
    const io::Sequence sequence = io::Sequence::open(root.path());
    CHECK(sequence.size() == 2);
    CHECK(sequence.has_stereo());
    CHECK(sequence.load(1).right.empty());
    REQUIRE(sequence.notes().size() == 2);
    has(sequence.notes()[0], "times.txt: 1 missing image left out");
    has(sequence.notes()[1], "1 frame has no right image");
  }
  fs::remove_all(root.path() / "image_1");
  const io::Sequence mono = io::Sequence::open(root.path());
  CHECK_FALSE(mono.has_stereo());
  CHECK(mono.camera().baseline_fx_px_m == 0);
  CHECK(mono.notes().size() == 1);
}

TEST_CASE("bad KITTI folders: one line that names the culprit") {
  const TemporaryFolder root;
  const fs::path& folder = root.path();
  write_kitti_folder(folder);
  REQUIRE(complaint(folder) == "");
  SUBCASE("a projection too short") {
    write_text(folder / "calib.txt", "P0: 10 0 8 0 0 11 6 0 0 0 1\n");
    has(complaint(folder), "calib.txt:1: expected the 12 numbers of a projection, found 11");
  }
  SUBCASE("no projection of the right camera") {
    write_text(folder / "calib.txt", "P0: 10 0 8 0 0 11 6 0 0 0 1 0\n");
    has(complaint(folder), "calib.txt: 'P1:' is missing");
  }
  SUBCASE("the cameras swapped") {
    write_text(folder / "calib.txt", "P0: 10 0 8 0 0 11 6 0 0 0 1 0\nP1: 10 0 8 5 0 11 6 0 0 0 1 0\n");
    has(complaint(folder), "calib.txt: the second camera is not to the right");
  }
  SUBCASE("a focal length of 0") {
    write_text(folder / "calib.txt", "P0: 0 0 8 0 0 11 6 0 0 0 1 0\n");
    has(complaint(folder), "calib.txt:1: the focal length must be above 0");
  }
  SUBCASE("no times") {
    fs::remove(folder / "times.txt");
    has(complaint(folder), "times.txt: no such file");
  }
  SUBCASE("times out of order") {
    write_text(folder / "times.txt", "0\n0.2\n0.1\n");
    has(complaint(folder), "times.txt:3: timestamps out of order");
  }
  SUBCASE("a repeated time") {
    write_text(folder / "times.txt", "0\n0.2\n0.2\n");
    has(complaint(folder), "times.txt:3: the timestamp is repeated");
  }
  SUBCASE("a time that is no number") {
    write_text(folder / "times.txt", "0\nsoon\n");
    has(complaint(folder), "times.txt:2: 'soon' is not a timestamp");
  }
  SUBCASE("a right image of another size") {
    write_image(folder / "image_1" / "000001.png", 1, {8, 6});
    has(complaint(folder), "000001.png: is 8x6, but its left image image_0/000001.png is 16x12");
  }
  SUBCASE("a truncated right image") {
    fs::resize_file(folder / "image_1" / "000001.png", 40);
    has(complaint(folder), "000001.png: is truncated");
  }
  SUBCASE("no image") {
    fs::remove_all(folder / "image_0");
    fs::create_directories(folder / "image_0");
    has(complaint(folder), "none of the images of times.txt exists");
  }
}

TEST_CASE("EuRoC: rectified images have a point on one row, at the disparity of its depth") {
  const TemporaryFolder root;
  write_euroc_folder(root.path());
  for (const fs::path& folder : {root.path(), root.path() / "mav0"}) {
    const io::Sequence sequence = io::Sequence::open(folder);
    REQUIRE(sequence.size() == 2);
    CHECK(sequence.timestamp_s(0) == doctest::Approx(1403636579.763555584).epsilon(1e-15));
    const Camera& camera = sequence.camera();
    CHECK_FALSE(camera.distorted());
    const double baseline_m = (kRight.T_body_camera.translation() - kLeft.T_body_camera.translation()).norm();
    CHECK(camera.baseline_m() == doctest::Approx(baseline_m));
    const io::SequenceFrame frame = sequence.load(1);
    CHECK(frame.grey.size() == cv::Size(RigView::kWidth, RigView::kHeight));

    // The poses are those of the rectified left camera.
    REQUIRE(sequence.ground_truth());
    const Eigen::Isometry3d T_world_body = [] {
      Eigen::Isometry3d T(Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitZ()));
      T.translation() = Eigen::Vector3d(1, 2, 3);
      return T;
    }();
    const Eigen::Isometry3d T_camera_body =
        sequence.ground_truth()->at(0).T_world_camera.isometry().inverse() * T_world_body;
    for (const Eigen::Vector3d& dot : kDots) {
      const Eigen::Vector3d p = T_camera_body * dot;
      const Eigen::Vector2d expected(camera.fx_px * p.x() / p.z() + camera.cx_px,
                                     camera.fy_px * p.y() / p.z() + camera.cy_px);
      const double disparity_px = camera.baseline_fx_px_m / p.z();
      const cv::Point2d left = dot_near(frame.grey, expected),
                        right = dot_near(frame.right, expected - Eigen::Vector2d(disparity_px, 0));
      constexpr double kTolerance_px = 0.1;  // of the dots' centres, which the distortion stretches
      CHECK(std::abs(left.x - expected.x()) < kTolerance_px);
      CHECK(std::abs(left.y - expected.y()) < kTolerance_px);
      CHECK(std::abs(left.y - right.y) < kTolerance_px);
      CHECK(std::abs(left.x - right.x - disparity_px) < kTolerance_px);
    }
  }
}

TEST_CASE("EuRoC without the second camera is mono, with the distortion of the first") {
  const TemporaryFolder root;
  write_euroc_folder(root.path());
  fs::remove_all(root.path() / "mav0" / "cam1");
  const io::Sequence sequence = io::Sequence::open(root.path());
  CHECK_FALSE(sequence.has_stereo());
  CHECK(sequence.camera().fx_px == 200);
  CHECK(sequence.camera().distortion == std::array<double, 5>{-0.28, 0.07, 2e-4, 2e-5, 0});
  CHECK(sequence.load(0).right.empty());
}

TEST_CASE("bad EuRoC folders: one line that names the culprit") {
  const TemporaryFolder root;
  const fs::path& folder = root.path();
  write_euroc_folder(folder);
  const fs::path left = folder / "mav0" / "cam0", right = folder / "mav0" / "cam1";
  SUBCASE("no sensor.yaml") {
    fs::remove(left / "sensor.yaml");
    has(complaint(folder), "sensor.yaml: no such file");
  }
  SUBCASE("another distortion") {
    std::string yaml = kLeft.yaml();
    yaml.replace(yaml.find("radial-tangential"), 17, "equidistant");
    write_text(left / "sensor.yaml", yaml);
    has(complaint(folder), "only the distortion_model radial-tangential is supported, not equidistant");
  }
  SUBCASE("no intrinsics") {
    std::string yaml = kLeft.yaml();
    yaml.replace(yaml.find("intrinsics"), 10, "intrinsicx");
    write_text(left / "sensor.yaml", yaml);
    has(complaint(folder), "'intrinsics' is missing");
    has(complaint(folder), "sensor.yaml");
  }
  SUBCASE("no rotation") {
    RigView bent = kLeft;
    bent.T_body_camera.linear()(0, 0) = 3;
    write_text(left / "sensor.yaml", bent.yaml());
    has(complaint(folder), "is not a rotation and a translation");
  }
  SUBCASE("the cameras swapped") {
    write_text(left / "sensor.yaml", kRight.yaml());
    write_text(right / "sensor.yaml", kLeft.yaml());
    has(complaint(folder), "cam1/sensor.yaml: the second camera is not to the right of the first one");
  }
  SUBCASE("cameras that look apart") {
    RigView turned = kRight;
    turned.T_body_camera.linear() = Eigen::AngleAxisd(0.9, Eigen::Vector3d::UnitX()).toRotationMatrix();
    write_text(right / "sensor.yaml", turned.yaml());
    has(complaint(folder), "the cameras look in different directions");
  }
  SUBCASE("a stamp that is no number") {
    write_text(left / "data.csv", "now,1.png\n");
    has(complaint(folder), "data.csv:1: 'now' is not a timestamp");
  }
  SUBCASE("a line too short") {
    write_text(right / "data.csv", "1403636579763555584\n");
    has(complaint(folder), "data.csv:1: expected 'timestamp,file'");
  }
  SUBCASE("no image") {
    fs::remove_all(left / "data");
    has(complaint(folder), "data.csv: none of the listed images exists");
  }
}

TEST_CASE("a folder of images: stamps from times.txt, from names, from the rate, or 30 Hz") {
  const TemporaryFolder root;
  const fs::path& folder = root.path();
  for (int i = 0; i < 3; ++i) write_image(folder / ("frame" + std::to_string(i) + ".jpg"), 100 + i);
  write_text(folder / "camera.yaml", "Camera.fx: 20\nCamera.fy: 20\nCamera.cx: 8\nCamera.cy: 6\n");
  {
    const io::Sequence sequence = io::Sequence::open(folder);
    CHECK(sequence.size() == 3);
    CHECK(sequence.timestamp_s(2) == doctest::Approx(2 / 30.0));
    REQUIRE(sequence.notes().size() == 1);
    has(sequence.notes()[0], "played at 30 Hz");
    CHECK_FALSE(sequence.has_stereo());
    CHECK_FALSE(sequence.ground_truth());
    CHECK(sequence.load(2).grey.at<std::uint8_t>(3, 3) == 102);
  }
  io::SequenceOptions options;
  options.rate_hz = 5;
  CHECK(io::Sequence::open(folder, options).timestamp_s(2) == doctest::Approx(0.4));
  write_text(folder / "camera.yaml",
             "Camera.fx: 20\nCamera.fy: 20\nCamera.cx: 8\nCamera.cy: 6\nCamera.fps: 10\n");
  CHECK(io::Sequence::open(folder).timestamp_s(2) == doctest::Approx(0.2));
  write_text(folder / "times.txt", "7\n7.5\n9\n");
  CHECK(io::Sequence::open(folder).timestamp_s(2) == 9);
  write_text(folder / "groundtruth.txt", "7 1 2 3 0 0 0 1\n");
  CHECK(io::Sequence::open(folder).ground_truth()->at(0).T_world_camera.translation_m[1] == 2);
}

TEST_CASE("a folder of images: names that are stamps, and right images") {
  const TemporaryFolder root;
  const fs::path& folder = root.path();
  write_text(folder / "camera.yaml",
             "Camera.fx: 20\nCamera.fy: 20\nCamera.cx: 8\nCamera.cy: 6\nCamera.bf: 4\n");
  for (const char* name : {"1403636579763555584.png", "1403636579813555456.png"}) {
    write_image(folder / "left" / name, 1);
    write_image(folder / "right" / name, 2);
  }
  fs::remove(folder / "right" / "1403636579813555456.png");
  const io::Sequence sequence = io::Sequence::open(folder);
  CHECK(sequence.timestamp_s(1) - sequence.timestamp_s(0) == doctest::Approx(0.05).epsilon(1e-4));
  CHECK(sequence.has_stereo());
  CHECK(sequence.camera().baseline_m() == doctest::Approx(0.2));
  CHECK(sequence.load(0).right.at<std::uint8_t>(0, 0) == 2);
  REQUIRE(sequence.notes().size() == 1);
  has(sequence.notes()[0], "1 frame has no right image");
}

TEST_CASE("bad folders of images: one line that names the culprit") {
  const TemporaryFolder root;
  const fs::path& folder = root.path();
  has(complaint(folder), "is no sequence");
  write_image(folder / "images" / "a.png", 1);
  CHECK(io::Sequence::open(folder).camera_is_guessed());  // verdicts need none
  write_text(folder / "camera.yaml", "Camera.fx: 20\nCamera.fy: 20\nCamera.cx: 8\nCamera.cy: 6\n");
  REQUIRE(complaint(folder) == "");
  SUBCASE("more times than images") {
    write_text(folder / "times.txt", "1\n2\n");
    has(complaint(folder), "times.txt: 2 times for 1 image");
  }
  SUBCASE("a bad rate") {
    write_text(folder / "camera.yaml",
               "Camera.fx: 20\nCamera.fy: 20\nCamera.cx: 8\nCamera.cy: 6\nCamera.fps: 0\n");
    has(complaint(folder), "'Camera.fps' must be above 0");
  }
  SUBCASE("a file that is no image") {
    write_text(folder / "images" / "a.png", "not a picture");
    has(complaint(folder), "a.png: is not a PNG, JPEG, BMP or binary PGM or PPM image");
  }
  SUBCASE("a right folder without a counterpart") {
    write_image(folder / "left" / "a.png", 1);
    write_image(folder / "right" / "b.png", 1);
    has(complaint(folder), "right: no image is named as one of the left camera");
  }
}

TEST_CASE("TUM folders may have right images") {
  const TemporaryFolder root;
  write_tum_folder(root.path(), 2);
  CHECK_FALSE(io::Sequence::open(root.path()).has_stereo());
  for (const char* name : {"100.000000.png", "100.100000.png"}) write_image(root.path() / "right" / name, 7);
  CHECK_FALSE(io::Sequence::open(root.path()).has_stereo());  // no baseline
  write_text(root.path() / "camera.yaml",
             "Camera.fx: 20\nCamera.fy: 20\nCamera.cx: 8\nCamera.cy: 6\nCamera.bf: 2\n");
  const io::Sequence sequence = io::Sequence::open(root.path());
  CHECK(sequence.has_stereo());
  CHECK(sequence.has_depth());
  CHECK(sequence.load(1).right.at<std::uint8_t>(0, 0) == 7);
}

TEST_CASE("the real KITTI folder loads as it is" * doctest::test_suite("shared_data")) {
  if (!fs::exists(DYNFILTER_DATA_DIR)) {
    MESSAGE("skipped: no ../shared/data");
    return;
  }
  const io::Sequence sequence = io::Sequence::open(fs::path(DYNFILTER_DATA_DIR) / "kitti_stereo");
  CHECK(sequence.size() == 51);
  CHECK(sequence.notes().empty());
  CHECK(sequence.camera().baseline_m() == doctest::Approx(379.8145 / 707.0912));
  CHECK(sequence.has_stereo());
  CHECK(sequence.load(50).grey.size() == cv::Size(1226, 370));
  CHECK(sequence.load(50).right.size() == cv::Size(1226, 370));
  REQUIRE(sequence.ground_truth());
  CHECK(sequence.ground_truth()->size() == 51);
}

}  // namespace sequence_layouts_test
