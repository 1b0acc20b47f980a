// SPDX-License-Identifier: MIT
// A minimal front end around a pipeline: ORB, matches to the last frame, PnP.
// It has no other part of a SLAM system.
// The lines between "dynfilter" and "end" connect the pipeline.
//   04_pnp_loop PIPELINE.yaml SEQUENCE
#include <cstdio>
#include <dynfilter/dynfilter.hpp>
#include <opencv2/calib3d.hpp>
#include <opencv2/features2d.hpp>

#include "io/sequence.hpp"

namespace {

/// Features of a frame that the next frame is matched with.
struct Features {
  std::vector<cv::KeyPoint> keypoints;
  cv::Mat descriptors;
  std::vector<float> depth_m;
};

std::vector<float> depth_of(const std::vector<cv::KeyPoint>& keypoints,
                            const dynfilter::io::SequenceFrame& image) {
  std::vector<float> depth_m;
  for (const cv::KeyPoint& k : keypoints) {
    const int x = cvRound(k.pt.x), y = cvRound(k.pt.y);
    const bool inside = x >= 0 && y >= 0 && x < image.depth.cols && y < image.depth.rows;
    const int raw = inside ? image.depth.at<std::uint16_t>(y, x) : 0;
    depth_m.push_back(static_cast<float>(raw * image.depth_unit_m));
  }
  return depth_m;
}

Features kept(const Features& all, const dynfilter::Verdict& verdict) {
  Features out;
  for (std::size_t i = 0; i < verdict.size(); ++i) {
    if (!verdict.keep(i)) continue;
    out.keypoints.push_back(all.keypoints[i]);
    out.depth_m.push_back(all.depth_m[i]);
    out.descriptors.push_back(all.descriptors.row(static_cast<int>(i)));
  }
  return out;
}

/// T_now_before from 3-D points of the last frame and pixels of this one.
/// Identity if there are too few.
cv::Matx44d motion(const Features& before, const Features& now, const dynfilter::Camera& camera) {
  std::vector<cv::DMatch> matches;
  if (!before.descriptors.empty() && !now.descriptors.empty())
    cv::BFMatcher(cv::NORM_HAMMING, true).match(before.descriptors, now.descriptors, matches);
  std::vector<cv::Point3f> points;
  std::vector<cv::Point2f> pixels;
  for (const cv::DMatch& match : matches) {
    const float z = before.depth_m[static_cast<std::size_t>(match.queryIdx)];
    if (!dynfilter::valid_depth(z)) continue;
    const cv::Point2f px = before.keypoints[static_cast<std::size_t>(match.queryIdx)].pt;
    points.emplace_back((px.x - static_cast<float>(camera.cx_px)) * z / static_cast<float>(camera.fx_px),
                        (px.y - static_cast<float>(camera.cy_px)) * z / static_cast<float>(camera.fy_px), z);
    pixels.push_back(now.keypoints[static_cast<std::size_t>(match.trainIdx)].pt);
  }
  cv::Matx44d T = cv::Matx44d::eye();
  const cv::Matx33d K(camera.fx_px, 0, camera.cx_px, 0, camera.fy_px, camera.cy_px, 0, 0, 1);
  cv::Vec3d rotation, t;
  if (points.size() < 10 ||
      !cv::solvePnPRansac(points, pixels, K, cv::noArray(), rotation, t, false, 200, 2.0F))
    return T;
  cv::Matx33d R;
  cv::Rodrigues(rotation, R);
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) T(r, c) = R(r, c);
    T(r, 3) = t[r];
  }
  return T;
}

int run(const char* pipeline_file, const char* folder) {
  dynfilter::Pipeline pipeline(dynfilter::pipeline_from_file(pipeline_file, dynfilter::builtin_filters()));
  const auto sequence = dynfilter::io::Sequence::open(folder);
  const auto orb = cv::ORB::create(1000);
  Features before;
  cv::Matx44d T_world_camera = cv::Matx44d::eye();
  for (std::size_t k = 0; k < sequence.size(); ++k) {
    const dynfilter::io::SequenceFrame image = sequence.load(k);
    Features now;
    orb->detectAndCompute(image.grey, cv::noArray(), now.keypoints, now.descriptors);
    now.depth_m = depth_of(now.keypoints, image);

    // ---- dynfilter
    dynfilter::FrameView view;
    view.id = static_cast<std::int64_t>(k);
    view.timestamp_s = image.timestamp_s;
    view.keypoints = now.keypoints;
    view.descriptors = now.descriptors;
    view.depth_m = now.depth_m;
    view.grey = image.grey;
    view.depth = image.depth;
    view.depth_unit_m = image.depth_unit_m;
    view.camera = sequence.camera();
    const dynfilter::Verdict& verdict = pipeline.before_pose(view);
    const Features survivors = kept(now, verdict);
    // ---- end

    if (k > 0) T_world_camera = T_world_camera * motion(before, survivors, sequence.camera()).inv();
    std::printf("frame %zu: %zu of %zu features kept, camera at %.3f %.3f %.3f m\n", k, verdict.kept(),
                verdict.size(), T_world_camera(0, 3), T_world_camera(1, 3), T_world_camera(2, 3));
    before = survivors;
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fprintf(stderr, "usage: %s PIPELINE.yaml SEQUENCE\n", argv[0]);
    return 2;
  }
  try {
    return run(argv[1], argv[2]);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 2;
  }
}
