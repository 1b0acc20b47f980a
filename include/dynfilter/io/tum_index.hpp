// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

/// The lists of a TUM RGB-D folder (rgb.txt, depth.txt, associations.txt), without the images.
namespace dynfilter::io::detail {

struct IndexedFrame {
  double timestamp_s = 0;
  std::string colour, depth;  // depth empty: no depth image
};

struct TumIndex {
  std::vector<IndexedFrame> frames;
  std::vector<std::string> notes;
};

std::string counted(std::size_t n, const std::string& one, const std::string& many);

/// Reads associations.txt if it exists, because other systems use it.
/// Otherwise associates rgb.txt and depth.txt.
TumIndex read_tum_index(const std::filesystem::path& folder, double max_gap_s);

}  // namespace dynfilter::io::detail

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/io/detail/tum_index-inl.hpp>
#endif
