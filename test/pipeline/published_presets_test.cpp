// SPDX-License-Identifier: MIT
// One hand-made case for each rule of each published preset.
#include <dynfilter/core/camera.hpp>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/pose.hpp>
#include <dynfilter/core/random.hpp>
#include <dynfilter/core/span.hpp>
#include <dynfilter/core/verdict.hpp>
#include <dynfilter/core/votes.hpp>
#include <dynfilter/pipeline/builtin_filters.hpp>
#include <dynfilter/pipeline/pipeline.hpp>
#include <dynfilter/pipeline/pipeline_yaml.hpp>
#include <dynfilter/testing/exact_scene_presets.hpp>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "doctest/doctest.h"

namespace published_presets_test {

using namespace dynfilter;

namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
const cv::Size kImage(640, 480);

Pipeline load(const std::string& preset) {
  return Pipeline(pipeline_from_file(
      std::string(DYNFILTER_SOURCE_DIR) + "/examples/pipelines/" + preset + ".yaml", builtin_filters()));
}

Detection box(float x, float y, float w, float h, const char* name = "person") {
  Detection d;
  d.box = {x, y, w, h};
  d.class_name = name;
  d.score = 0.9F;
  return d;
}
cv::Mat mask_with(const cv::Rect& place) {
  cv::Mat mask = cv::Mat::zeros(kImage, CV_8UC1);
  mask(place).setTo(255);
  return mask;
}

/// A static camera, and 24 x 18 features every 25 px from (25, 25).
/// They are matched with themselves in the last frame. The wall is 3 m away.
struct Shot {
  Shot() : depth(kImage, CV_32FC1, cv::Scalar(3)), grey(kImage, CV_8UC1, cv::Scalar(0)) {
    for (int r = 1; r <= 18; ++r)
      for (int c = 1; c <= 24; ++c)
        keypoints.emplace_back(static_cast<float>(25 * c), static_cast<float>(25 * r), 1.0F);
    camera.fx_px = camera.fy_px = 525;
    camera.cx_px = 320;
    camera.cy_px = 240;
    camera.width_px = kImage.width;
    camera.height_px = kImage.height;
  }
  std::size_t at(int column, int row) const { return static_cast<std::size_t>((row - 1) * 24 + column - 1); }
  cv::Point2f& px(int column, int row) { return keypoints[at(column, row)].pt; }

  /// The previous image of a camera that moves sideways, with points of all depths.
  /// Epipolar lines are rows.
  Shot& sideways() {
    Random random(9, 1);
    for (cv::KeyPoint& keypoint : keypoints) keypoint.pt.x += static_cast<float>(random.uniform(6, 20));
    return *this;
  }

  FrameView view(std::int64_t id) {
    index.resize(keypoints.size());
    for (std::size_t i = 0; i < index.size(); ++i) index[i] = static_cast<std::int32_t>(i);
    FrameView frame;
    frame.id = id;
    frame.timestamp_s = static_cast<double>(id) / 30;
    frame.keypoints = keypoints;
    frame.grey = grey;
    frame.depth = depth;
    frame.camera = camera;
    frame.pose_provenance = provenance;
    if (boxes) frame.detections = DetectionInput{-1, *boxes};
    if (!mask.empty()) frame.mask = MaskInput{mask_frame_id, mask};
    if (id > 0) frame.matches = HostMatches{reference_id >= 0 ? reference_id : id - 1, index};
    frame.map_point_ids = map_points;
    return frame;
  }

  std::vector<cv::KeyPoint> keypoints;
  cv::Mat depth, grey, mask;
  std::int64_t mask_frame_id = -1, reference_id = -1;
  std::optional<std::vector<Detection>> boxes;
  std::vector<std::int32_t> index;
  std::vector<std::int64_t> map_points;
  Camera camera;
  PoseProvenance provenance = PoseProvenance::None;
};

/// Frame 0, then frame 1.
Verdict second(Pipeline& pipeline, Shot& before, Shot& now) {
  pipeline.before_pose(before.view(0));
  return pipeline.before_pose(now.view(1));
}
Verdict second(const std::string& preset, Shot& before, Shot& now) {
  Pipeline pipeline = load(preset);
  return second(pipeline, before, now);
}
bool dynamic(const Verdict& verdict, std::size_t i) {
  return verdict.decision[i] == Vote::Dynamic;
}
std::size_t rejected(const Verdict& verdict) {
  return verdict.size() - verdict.kept();
}

}  // namespace

TEST_CASE("des_slam: dynamic on the mask and at another depth, by 12 percent; either alone is not enough") {
  Shot before, now;
  now.mask = mask_with({190, 190, 120, 120});  // columns and rows 8 to 12
  before.depth(cv::Rect(0, 0, 330, 480)).setTo(2.0);
  now.depth(cv::Rect(0, 0, 330, 480)).setTo(2.0);
  const auto comes = [](Shot& shot, const cv::Rect& place, double z_m) { shot.depth(place).setTo(z_m); };
  comes(now, {190, 190, 22, 22}, 1.75);  // on the mask: |1 - 2 / 1.75| = 0.143
  comes(now, {240, 190, 22, 22}, 1.82);  // on the mask: 0.099
  comes(now, {90, 190, 22, 22}, 1.75);   // beside it
  for (const char* preset : {"des_slam", "des_slam_published"}) {
    const Verdict verdict = second(preset, before, now);
    CHECK(dynamic(verdict, now.at(8, 8)));
    CHECK_FALSE(dynamic(verdict, now.at(10, 8)));
    CHECK_FALSE(dynamic(verdict, now.at(12, 12)));  // on the mask, but static
    CHECK_FALSE(dynamic(verdict, now.at(4, 8)));
    CHECK(rejected(verdict) == 1);
  }
}

TEST_CASE("des_slam: at keyframes 8 percent of the map point's depth, without any mask") {
  Shot now;
  now.provenance = PoseProvenance::Refined;
  now.map_points.assign(now.keypoints.size(), -1);
  std::vector<cv::Point3f> world(now.keypoints.size());
  const auto point = [&](std::size_t i, float z) {
    now.map_points[i] = static_cast<std::int64_t>(i);
    world[i] = {(now.keypoints[i].pt.x - 320) / 525 * z, (now.keypoints[i].pt.y - 240) / 525 * z, z};
  };
  point(now.at(3, 3), 3.0F);
  point(now.at(5, 3), 3.24F);  // 0.074
  point(now.at(7, 3), 3.3F);   // 0.091
  KeyframeView keyframe;
  keyframe.map_point_ids = now.map_points;
  const std::vector<KeyframeView> keyframes{keyframe};
  for (const char* preset : {"des_slam", "des_slam_published"}) {
    Pipeline pipeline = load(preset);
    FrameView frame = now.view(0);
    frame.map_points_world_m = world;
    frame.covisible_keyframes = keyframes;
    const Verdict& verdict = pipeline.at_keyframe(frame);
    CHECK(verdict.decision[now.at(3, 3)] == Vote::Static);
    CHECK(verdict.decision[now.at(5, 3)] == Vote::Static);
    CHECK(dynamic(verdict, now.at(7, 3)));
    CHECK(rejected(verdict) == 1);
  }
}

TEST_CASE("des_slam: who comes slowly is found against ten frames back, not against the last one") {
  const auto found_with = [](const std::string& preset, int gap_frames) {
    Pipeline pipeline = load(preset);
    Shot shot;
    shot.mask = mask_with({190, 190, 120, 120});
    std::size_t found = 0;
    for (int k = 0; k < 14; ++k) {
      shot.reference_id = std::max(0, k - gap_frames);
      shot.depth(cv::Rect(180, 180, 140, 140)).setTo(2.2 - 0.04 * k);  // 2 % a frame
      found = rejected(pipeline.before_pose(shot.view(k)));
    }
    return found;
  };
  CHECK(found_with("des_slam", 10) == 25);
  CHECK(found_with("des_slam_published", 1) == 0);
}

TEST_CASE("sg_slam: 0.2 px inside a person's box, 1 px outside") {
  Shot before, now;
  before.sideways();
  now.boxes = {box(190, 190, 120, 120), box(390, 190, 70, 120, "tvmonitor")};
  now.px(8, 8).y += 0.4F;
  now.px(9, 9).y += 0.1F;
  now.px(2, 2).y += 0.4F;
  now.px(16, 8).y += 0.4F;  // in the box of a monitor
  now.px(4, 4).y += 1.6F;
  const Verdict verdict = second("sg_slam", before, now);
  CHECK(dynamic(verdict, now.at(8, 8)));
  CHECK_FALSE(dynamic(verdict, now.at(9, 9)));
  CHECK_FALSE(dynamic(verdict, now.at(2, 2)));
  CHECK_FALSE(dynamic(verdict, now.at(16, 8)));
  CHECK(dynamic(verdict, now.at(4, 4)));
  CHECK(rejected(verdict) == 2);
}

// 432 features; all but an L of 24 + 17 of them are in the box.
// With fewer than 43.2 left, all are restored.
TEST_CASE("sg_slam: below a tenth of the features all are restored") {
  for (const bool two_columns : {false, true}) {
    Shot before, now;
    before.sideways();
    const int first = two_columns ? 3 : 2;
    now.boxes = {box(static_cast<float>(25 * first) - 5, 45, 900, 900)};
    for (int r = 2; r <= 18; ++r)
      for (int c = first; c <= 24; ++c) now.px(c, r).y += (r + c) % 2 == 0 ? 0.6F : -0.6F;
    const Verdict verdict = second("sg_slam", before, now);
    CHECK(verdict.report.restored == (two_columns ? 0U : 17U * 23U));
    CHECK(rejected(verdict) == (two_columns ? 17U * 22U : 0U));
  }
}

TEST_CASE("ds_slam: one outlier within 15 px of the person mask condemns the whole mask, and only the mask") {
  Shot before, now;
  before.sideways();
  now.mask = mask_with({190, 190, 120, 120});  // to 309: columns and rows 8 to 12
  for (const float distance_px : {10.0F, 14.0F, 17.0F}) {
    CAPTURE(distance_px);
    Shot then = before, shot = now;
    then.px(13, 10) = {320 + distance_px, 250};
    shot.px(13, 10) = {309 + distance_px, 252};  // 2 px off its line
    shot.px(20, 3).y += 5;                       // an outlier far away
    const Verdict verdict = second("ds_slam", then, shot);
    const bool near = distance_px <= 15;
    CHECK(rejected(verdict) == (near ? 25 : 0));
    CHECK(dynamic(verdict, shot.at(10, 10)) == near);
    CHECK_FALSE(dynamic(verdict, shot.at(13, 10)));
  }
  Shot slow = now;
  slow.px(10, 10).y += 0.8F;  // below 1 px
  CHECK(rejected(second("ds_slam", before, slow)) == 0);
  slow.px(10, 10).y += 0.8F;
  CHECK(rejected(second("ds_slam", before, slow)) == 25);
}

TEST_CASE("ovd_slam: a person's box stays while nothing in it moves, and goes when a fifth does") {
  for (const int moving : {0, 4, 5}) {
    CAPTURE(moving);
    Shot before, now;
    before.sideways();
    now.boxes = {box(190, 190, 120, 120)};                        // 25 features
    for (int k = 0; k < moving; ++k) now.px(8 + k, 8).y += 0.5F;  // exp(-d^2 / 2) = 0.88 < 0.96
    const Verdict verdict = second("ovd_slam", before, now);
    CHECK(rejected(verdict) == (moving == 5 ? 25 : 0));
  }
}

TEST_CASE("ovd_slam: other classes want 0.8, a person's background stays, and 1 px is dynamic anywhere") {
  Shot before, now;
  before.sideways();
  now.boxes = {box(190, 190, 120, 120, "chair"), box(390, 190, 70, 120, "car"), box(390, 40, 120, 120)};
  for (int k = 8; k <= 12; ++k) now.px(k, 8).y += 0.5F;    // 0.88: not below 0.8
  for (int k = 16; k <= 18; ++k) now.px(k, 8).y += 0.75F;  // 0.755; 3 of 15
  for (int k = 16; k <= 20; ++k) now.px(k, 2).y += 0.5F;   // a person of 25 features,
  now.depth(cv::Rect(0, 0, 460, 180)).setTo(1.8);          // columns 16 to 18 of it the foreground
  now.px(3, 12).y += 1.5F;
  const Verdict verdict = second("ovd_slam", before, now);
  CHECK_FALSE(dynamic(verdict, now.at(10, 8)));
  CHECK(dynamic(verdict, now.at(16, 8)));
  CHECK(dynamic(verdict, now.at(18, 12)));  // all of the car
  CHECK(dynamic(verdict, now.at(17, 5)));
  CHECK_FALSE(dynamic(verdict, now.at(20, 5)));  // the wall behind the person
  CHECK(dynamic(verdict, now.at(3, 12)));
  CHECK(rejected(verdict) == 15 + 15 + 1);
}

TEST_CASE("dynaslam: the mask, dilated by 15 px") {
  Shot now;
  now.mask = mask_with({215, 215, 21, 21});  // 215 to 235 around (225, 225): columns and rows 9
  Pipeline pipeline = load("dynaslam");
  now.px(10, 9).x = 250;  // 15 px
  now.px(8, 9).x = 199;   // 16 px
  const Verdict& verdict = pipeline.before_pose(now.view(0));
  CHECK(dynamic(verdict, now.at(9, 9)));
  CHECK(dynamic(verdict, now.at(10, 9)));
  CHECK_FALSE(dynamic(verdict, now.at(8, 9)));
}

TEST_CASE("dynaslam: what is 0.4 m nearer than the keyframe saw is grown over the depth image") {
  Shot before, now;
  before.provenance = now.provenance = PoseProvenance::Estimated;
  before.depth(cv::Rect(190, 300, 120, 60)).setTo(2.2);  // a chest where the legs will be
  now.depth(cv::Rect(190, 190, 120, 170)).setTo(2.0);    // a person on no mask, columns 8 to 12
  now.depth(cv::Rect(390, 190, 70, 120)).setTo(2.7);     // 0.3 m nearer than the wall
  now.mask = mask_with({0, 0, 1, 1});
  Pipeline pipeline = load("dynaslam");
  pipeline.at_keyframe(before.view(0));
  pipeline.before_pose(now.view(1));
  const Verdict& verdict = pipeline.after_pose(now.view(1));
  CHECK(dynamic(verdict, now.at(10, 10)));        // 3 - 2 = 1 m
  CHECK(dynamic(verdict, now.at(10, 13)));        // 2.2 - 2 = 0.2 m, but grown from above
  CHECK_FALSE(dynamic(verdict, now.at(17, 10)));  // 0.3 m
  CHECK_FALSE(dynamic(verdict, now.at(3, 3)));
  CHECK(rejected(verdict) >= 30);
}

TEST_CASE("rds_slam: a belief per map point, 0.9 on and 0.1 off the mask from 0.5, dynamic above 0.5") {
  Pipeline pipeline = load("rds_slam");
  Shot shot;
  shot.map_points.assign(shot.keypoints.size(), -1);
  shot.map_points[shot.at(10, 10)] = 7;
  const auto judge = [&](std::int64_t id) {
    const Verdict& verdict = pipeline.after_pose(shot.view(id));
    CHECK(verdict.kept() + (dynamic(verdict, shot.at(10, 10)) ? 1 : 0) == verdict.size());
    return std::make_pair(verdict.decision[shot.at(10, 10)], verdict.suspicion[shot.at(10, 10)]);
  };
  CHECK(judge(0).first == Vote::Unknown);  // no mask yet
  shot.mask = mask_with({190, 190, 120, 120});
  CHECK(judge(1).first == Vote::Dynamic);  // 0.9
  CHECK(judge(1).second == doctest::Approx(0.9));
  shot.mask = cv::Mat();
  CHECK(judge(2).first == Vote::Dynamic);  // between masks
  shot.mask = mask_with({0, 0, 9, 9});
  CHECK(judge(3).first == Vote::Unknown);          // back to 0.5
  CHECK(judge(4).first == Vote::Static);           // 0.1
  CHECK(judge(4).second == doctest::Approx(0.1));  // a mask counts once
  pipeline.reset();
  shot.mask = cv::Mat();
  CHECK(judge(5).first == Vote::Unknown);
}

TEST_CASE("rds_slam: a late mask is about where its keyframe saw the map point") {
  Pipeline pipeline = load("rds_slam");
  Shot then, now;
  then.map_points.assign(then.keypoints.size(), -1);
  then.map_points[then.at(10, 10)] = 7;
  now.map_points = then.map_points;
  pipeline.after_pose(then.view(0));
  now.px(10, 10) += cv::Point2f(150, 0);
  now.mask = mask_with({240, 240, 20, 20});  // around its place in frame 0
  now.mask_frame_id = now.reference_id = 0;
  CHECK(dynamic(pipeline.after_pose(now.view(1)), now.at(10, 10)));
}

TEST_CASE("ngd_slam: the last mask is carried by flow and sorted into layers of depth") {
  Pipeline pipeline = load("ngd_slam");
  Shot then, now;
  then.mask = mask_with({190, 190, 120, 120});
  pipeline.before_pose(then.view(0));
  for (int r = 8; r <= 12; ++r)
    for (int c = 8; c <= 12; ++c)
      if (c < 12 || r < 11) now.px(c, r).x += 200;     // the person walks; (12, 11) and (12, 12) are wall
  now.depth(cv::Rect(380, 180, 110, 140)).setTo(1.8);  // on the person, x 400 to 500
  now.depth(cv::Rect(490, 180, 30, 80)).setTo(1.9);
  now.px(20, 2) = {440, 230};  // a new feature on the person
  now.px(20, 3) = {600, 230};  // as near as the person, but beside
  now.depth(cv::Rect(590, 220, 20, 20)).setTo(1.8);
  now.mask = then.mask;
  now.mask_frame_id = 0;
  const Verdict verdict = pipeline.before_pose(now.view(1));
  CHECK(dynamic(verdict, now.at(8, 8)));
  CHECK(dynamic(verdict, now.at(12, 8)));         // 0.1 m behind: the same layer
  CHECK_FALSE(dynamic(verdict, now.at(12, 12)));  // the wall, on the old mask
  CHECK(dynamic(verdict, now.at(20, 2)));
  CHECK_FALSE(dynamic(verdict, now.at(20, 3)));
  CHECK_FALSE(dynamic(verdict, now.at(3, 3)));
  CHECK(rejected(verdict) >= 24);
}

TEST_CASE("yolo_slam: boxes, without the background that is far behind the depth most of a box shares") {
  Shot now;
  now.boxes = {box(190, 190, 120, 120), box(390, 190, 70, 120, "tvmonitor")};
  now.depth(cv::Rect(180, 180, 107, 140)).setTo(1.8);  // columns 8 to 11
  now.depth(cv::Rect(215, 190, 20, 120)).setTo(2.0);   // column 9: still of the person
  now.depth.at<float>(200, 200) = kNan;
  Pipeline pipeline = load("yolo_slam");
  const Verdict& verdict = pipeline.before_pose(now.view(0));
  CHECK(dynamic(verdict, now.at(8, 9)));
  CHECK(dynamic(verdict, now.at(9, 9)));
  CHECK_FALSE(dynamic(verdict, now.at(12, 9)));
  CHECK_FALSE(dynamic(verdict, now.at(17, 9)));  // a monitor does not move by itself
  CHECK(rejected(verdict) == 20);
}

TEST_CASE("coeb_slam: a blurred box goes as a whole, in a sharp one the epipolar distance decides") {
  Shot before, now;
  before.sideways();
  Random random(5, 1);
  for (int y = 0; y < kImage.height; y += 4)
    for (int x = 0; x < kImage.width; x += 4) now.grey(cv::Rect(x, y, 4, 4)).setTo(random.below(256));
  before.grey = now.grey.clone();
  now.boxes = {box(190, 190, 120, 120), box(390, 190, 70, 120)};
  cv::Mat blurred = now.grey(cv::Rect(185, 185, 130, 130));
  cv::blur(blurred.clone(), blurred, cv::Size(15, 1));
  now.px(17, 10).y += 3;
  now.px(2, 2).y += 3;
  const Verdict verdict = second("coeb_slam", before, now);
  CHECK(dynamic(verdict, now.at(10, 10)));
  CHECK(verdict.reason(now.at(10, 10)) == "box_blur");
  CHECK(dynamic(verdict, now.at(17, 10)));
  CHECK_FALSE(dynamic(verdict, now.at(16, 8)));
  CHECK(dynamic(verdict, now.at(2, 2)));
  CHECK(rejected(verdict) == 25 + 2);
  // Blur of the whole image is caused by the camera, not by the boxes.
  cv::blur(before.grey, now.grey, cv::Size(15, 15));
  CHECK(rejected(second("coeb_slam", before, now)) == 2);
}

// No input makes a preset crash or a stage fail, and every feature gets a decision.
TEST_CASE("odd input: masks, boxes, descriptors, poses and numbers that are none") {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  const std::vector<Detection> odd_boxes = [] {
    std::vector<Detection> list{box(-500, -500, 100, 100), box(600, 400, 900, 900), box(300, 300, -50, -50),
                                box(kNan, 0, 10, 10),      box(0, 0, kNan, kNan),   box(0, 0, 1e30F, 1e30F),
                                box(100, 100, 0, 0)};
    for (Detection& d : list) d.mask = cv::Mat(3, 5, CV_16UC1, cv::Scalar(1));
    list.push_back(box(10, 10, 300, 300));
    list.back().score = kNan;
    list.back().mask = cv::Mat(7, 3, CV_8UC1, cv::Scalar(1));
    return list;
  }();
  const std::vector<cv::Mat> masks{cv::Mat(13, 7, CV_8UC1, cv::Scalar(255)), cv::Mat(480, 640, CV_8UC3),
                                   cv::Mat(480, 640, CV_32FC1), cv::Mat(1, 1, CV_8UC1, cv::Scalar(0)),
                                   cv::Mat()};
  int judged = 0;
  for (const char* preset :
       {"des_slam", "des_slam_published", "sg_slam", "ds_slam", "ovd_slam", "dynaslam", "rds_slam",
        "ngd_slam", "yolo_slam", "coeb_slam", "rts_slam", "rts_slam_published"}) {
    CAPTURE(preset);
    Pipeline pipeline = load(preset);
    for (int k = 0; k < 10; ++k) {
      Shot shot;
      shot.map_points.assign(shot.keypoints.size(), 3);
      shot.mask = masks[static_cast<std::size_t>(k) % masks.size()];
      shot.mask_frame_id = k % 3 == 0 ? k - 1 : k % 3 == 1 ? 99 : -1;
      shot.boxes = odd_boxes;
      shot.provenance = PoseProvenance::Estimated;
      for (std::size_t i = 0; i < 6; ++i) shot.keypoints[20 * i].pt.x = i % 2 == 0 ? kNan : -1e30F;
      shot.keypoints[7].pt = {640, 480};
      shot.keypoints[8].pt = {1e30F, kNan};
      shot.depth(cv::Rect(0, 0, 320, 480)).setTo(k % 2 == 0 ? kNone : -1.0);
      FrameView frame = shot.view(k);
      std::vector<cv::Point3f> world(shot.keypoints.size(), {kNan, 0, 1});
      std::vector<float> kp_depth(3, kNan);
      frame.map_points_world_m = world;
      frame.descriptors = cv::Mat::zeros(k, 32, CV_8UC1);
      if (k % 4 == 1) frame.T_world_camera.rotation[0] = -1;
      if (k % 4 == 2) frame.T_world_camera.translation_m[2] = kNone;
      if (k % 4 == 3) frame.T_world_camera.rotation.fill(0);
      if (k == 5) frame.camera->fx_px = kNone;
      if (k == 6) frame.matches->reference_index = Span<const std::int32_t>(shot.index.data(), 5);
      if (k == 7) shot.index[3] = 100000, shot.index[4] = -7;
      if (k == 8) frame.depth_unit_m = kNone;
      KeyframeView keyframe;
      keyframe.T_world_camera.rotation[8] = k % 2 == 0 ? kNone : 1;
      keyframe.keypoints_undistorted = shot.keypoints;
      keyframe.depth_m = kp_depth;
      keyframe.map_point_ids = shot.map_points;
      const std::vector<KeyframeView> keyframes{keyframe, keyframe};
      frame.covisible_keyframes = keyframes;
      for (const CallPoint point : {CallPoint::BeforePose, CallPoint::AfterPose, CallPoint::AtKeyframe}) {
        const Verdict& verdict = pipeline.process(frame, point);
        CHECK(verdict.size() == shot.keypoints.size());
        for (const StageReport& stage : verdict.report.stages) {
          CAPTURE(stage.note);
          CHECK_FALSE(stage.failed);
        }
        ++judged;
      }
      pipeline.update_pose(k, frame.T_world_camera, PoseProvenance::Refined);
    }
  }
  CHECK(judged == 12 * 30);
}

TEST_CASE("a pose that is not rigid counts as none, and the report says so") {
  Pipeline pipeline = load("des_slam");
  Shot shot;
  shot.provenance = PoseProvenance::Estimated;
  FrameView frame = shot.view(0);
  frame.T_world_camera.rotation[0] = 2;
  const Verdict& verdict = pipeline.at_keyframe(frame);
  REQUIRE(verdict.report.notes.size() == 1);
  CHECK(verdict.report.notes[0] == "pose cannot be used: not rigid");
  CHECK(verdict.report.stages[1].note == "skipped: no pose, covisible keyframes");
}

}  // namespace published_presets_test
