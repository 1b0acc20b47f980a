// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

namespace dynfilter::odometry {

/// 256 bits of an ORB descriptor.
using Descriptor = std::array<std::uint64_t, 4>;

/// Number of set bits. Without -mpopcnt the builtin would be a function call.
inline int count_bits(std::uint64_t v) {
  v -= (v >> 1) & 0x5555555555555555ULL;
  v = (v & 0x3333333333333333ULL) + ((v >> 2) & 0x3333333333333333ULL);
  v = (v + (v >> 4)) & 0x0f0f0f0f0f0f0f0fULL;
  return static_cast<int>((v * 0x0101010101010101ULL) >> 56);
}

inline int hamming(const Descriptor& a, const Descriptor& b) {
  return count_bits(a[0] ^ b[0]) + count_bits(a[1] ^ b[1]) + count_bits(a[2] ^ b[2]) +
         count_bits(a[3] ^ b[3]);
}

/// A view of the descriptors as an N x 32 CV_8U matrix, without a copy.
inline cv::Mat as_matrix(std::vector<Descriptor>& descriptors) {
  return descriptors.empty() ? cv::Mat()
                             : cv::Mat(static_cast<int>(descriptors.size()), 32, CV_8U, descriptors.data());
}

}  // namespace dynfilter::odometry
