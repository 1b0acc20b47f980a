// SPDX-License-Identifier: MIT
#pragma once

#include <opencv2/core.hpp>
#include <type_traits>
#include <utility>

namespace dynfilter::orb_slam {

/// What a host's own types have, found at compile time. A member that is there but private counts as missing.
namespace traits {

template <class T, class = void>
struct HasMatrixPose : std::false_type {};
/// Version 2, and early version 3: a public `cv::Mat mTcw`, empty when there is none.
template <class T>
struct HasMatrixPose<T, std::void_t<decltype(std::declval<const T&>().mTcw.empty())>> : std::true_type {};

template <class T, class = void>
struct HasGroupPose : std::false_type {};
/// Version 3: `HasPose()` and `GetPose()`, a rigid transform with `matrix()`.
template <class T>
struct HasGroupPose<T, std::void_t<decltype(std::declval<const T&>().HasPose()),
                                   decltype(std::declval<const T&>().GetPose().matrix())>> : std::true_type {
};

template <class T, class = void>
struct HasTwoCameras : std::false_type {};
/// Version 3: `Nleft` is -1, or the number of features of the left one of two fisheye cameras.
template <class T>
struct HasTwoCameras<T, std::void_t<decltype(std::declval<const T&>().Nleft), decltype(T::mvLeftToRightMatch),
                                    decltype(T::mGridRight)>> : std::true_type {};

template <class T, class = void>
struct HasCameraModel : std::false_type {};
/// Version 3: `mpCamera->GetType()`, 0 for a pinhole camera.
template <class T>
struct HasCameraModel<T, std::void_t<decltype(std::declval<const T&>().mpCamera->GetType())>>
    : std::true_type {};

template <class T, class = void>
struct IsMatrix : std::false_type {};
/// True for cv::Mat, and for what converts to it.
template <class T>
struct IsMatrix<T, std::void_t<decltype(cv::Mat(std::declval<const T&>()).empty())>> : std::true_type {};

template <class T, class = void>
struct IsFrame : std::false_type {};
/// What both versions have and this adapter cannot do without.
template <class T>
struct IsFrame<
    T, std::void_t<decltype(T::N), decltype(T::mvKeys), decltype(T::mvKeysUn), decltype(T::mDescriptors),
                   decltype(T::mvDepth), decltype(T::mvuRight), decltype(T::mvpMapPoints),
                   decltype(T::mvbOutlier), decltype(T::mGrid), decltype(T::mBowVec), decltype(T::mFeatVec),
                   decltype(T::mnId), decltype(T::mTimeStamp), decltype(T::mK), decltype(T::mDistCoef)>>
    : std::true_type {};

}  // namespace traits

/// The host's own pointer type for its map points.
template <class Frame>
using MapPointOf = std::remove_pointer_t<typename decltype(Frame::mvpMapPoints)::value_type>;

/// Does not compile for a Frame that this adapter cannot read.
template <class Frame>
constexpr void require_frame() {
  static_assert(traits::IsFrame<Frame>::value,
                "dynfilter: this is not a Frame of ORB-SLAM2 or ORB-SLAM3; one of N, mvKeys, mvKeysUn, "
                "mDescriptors, mvDepth, mvuRight, mvpMapPoints, mvbOutlier, mGrid, mBowVec, mFeatVec, mnId, "
                "mTimeStamp, mK, mDistCoef is missing or private");
  static_assert(traits::HasMatrixPose<Frame>::value || traits::HasGroupPose<Frame>::value,
                "dynfilter: this Frame has neither a public cv::Mat mTcw (version 2) nor HasPose() and "
                "GetPose() (version 3)");
}

/// Two fisheye cameras in one frame (version 3): the features of the left one come first.
template <class Frame>
bool is_pair(const Frame& frame) {
  if constexpr (traits::HasTwoCameras<Frame>::value)
    return frame.Nleft != -1;
  else
    return false;
}

/// Pinhole models do not hold for its pixels: a pair, or one fisheye camera (version 3).
template <class Frame>
bool is_fisheye(const Frame& frame) {
  if (is_pair(frame)) return true;
  if constexpr (traits::HasCameraModel<Frame>::value)
    return frame.mpCamera != nullptr && frame.mpCamera->GetType() != 0;
  else
    return false;
}

}  // namespace dynfilter::orb_slam
