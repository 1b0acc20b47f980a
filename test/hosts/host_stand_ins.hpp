// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstddef>
#include <map>
#include <opencv2/core.hpp>
#include <utility>
#include <vector>

// Stand-ins for the types of ORB-SLAM2 and ORB-SLAM3. They have the members that a fork's code may touch,
// under the hosts' names, and nothing else.

namespace host {

constexpr int kColumns = 64, kRows = 48;

using BowVector = std::map<unsigned, double>;
using FeatureVector = std::map<unsigned, std::vector<unsigned>>;

/// What both hosts' frames share. 640 x 480, cells of 10 px.
template <class MapPoint>
struct FrameParts {
  int N = 0;
  std::vector<cv::KeyPoint> mvKeys, mvKeysRight, mvKeysUn;
  cv::Mat mDescriptors, mDescriptorsRight;
  std::vector<float> mvuRight, mvDepth;
  std::vector<MapPoint*> mvpMapPoints;
  std::vector<bool> mvbOutlier;
  std::vector<std::size_t> mGrid[kColumns][kRows];
  BowVector mBowVec;
  FeatureVector mFeatVec;
  cv::Mat mK, mDistCoef;
  float mbf = 0, mb = 0, mThDepth = 0;
  long unsigned int mnId = 0;
  double mTimeStamp = 0;

  bool PosInGrid(const cv::KeyPoint& keypoint, int& column, int& row) {
    column = static_cast<int>(std::round(keypoint.pt.x * 0.1F));
    row = static_cast<int>(std::round(keypoint.pt.y * 0.1F));
    return column >= 0 && column < kColumns && row >= 0 && row < kRows;
  }
};

namespace v2 {

struct MapPoint {
  long unsigned int mnId = 0;
  cv::Mat world = cv::Mat::zeros(3, 1, CV_32F);
  bool bad = false;
  cv::Mat GetWorldPos() { return world.clone(); }
  bool isBad() { return bad; }
};

struct Frame : FrameParts<MapPoint> {
  cv::Mat mTcw;
};

struct KeyFrame {
  long unsigned int mnId = 0;
  const std::vector<cv::KeyPoint> mvKeysUn{};
  const std::vector<float> mvDepth{};
  std::vector<MapPoint*> points;
  cv::Mat Tcw;
  bool bad = false;
  cv::Mat GetPose() { return Tcw.clone(); }
  std::vector<MapPoint*> GetMapPointMatches() { return points; }
  bool isBad() { return bad; }
};

}  // namespace v2

namespace v3 {

/// As Sophus::SE3f shows itself.
struct SE3f {
  Eigen::Matrix4f m = Eigen::Matrix4f::Identity();
  Eigen::Matrix4f matrix() const { return m; }
};

struct MapPoint {
  long unsigned int mnId = 0;
  Eigen::Vector3f world = Eigen::Vector3f::Zero();
  bool bad = false;
  Eigen::Vector3f GetWorldPos() { return world; }
  bool isBad() { return bad; }
};

struct GeometricCamera {
  unsigned int type = 0;
  unsigned int GetType() { return type; }
};

class Frame : public FrameParts<MapPoint> {
 public:
  SE3f GetPose() const { return mTcw; }
  bool HasPose() const { return mbHasPose; }
  void SetPose(const SE3f& Tcw) { mTcw = Tcw, mbHasPose = true; }

  Eigen::Matrix3f mK_ = Eigen::Matrix3f::Identity();
  int mnCloseMPs = 0;
  GeometricCamera *mpCamera = nullptr, *mpCamera2 = nullptr;
  int Nleft = -1, Nright = -1;
  int monoLeft = -1, monoRight = -1;
  std::vector<int> mvLeftToRightMatch, mvRightToLeftMatch;
  std::vector<Eigen::Vector3f> mvStereo3Dpoints;
  std::vector<std::size_t> mGridRight[kColumns][kRows];

 private:
  SE3f mTcw;
  bool mbHasPose = false;
};

struct KeyFrame {
  long unsigned int mnId = 0;
  const std::vector<cv::KeyPoint> mvKeysUn{};
  const std::vector<float> mvDepth{};
  std::vector<MapPoint*> points;
  SE3f Tcw;
  bool bad = false;
  SE3f GetPose() { return Tcw; }
  std::vector<MapPoint*> GetMapPointMatches() { return points; }
  bool isBad() { return bad; }
};

}  // namespace v3

}  // namespace host
