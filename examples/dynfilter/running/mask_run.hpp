// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "masks/mask_truth.hpp"
#include "sequence_run.hpp"

namespace dynfilter::command {

struct MaskOptions {
  /// Sequence, pipeline, sources of boxes and masks. `out`: the folder for the masks.
  /// `truth`: also compare the masks with the labels of a rendered sequence.
  RunOptions run;
  std::string tool = "plain", shape = "features";
  int grow_px = 1;                       ///< margin around objects
  std::optional<double> until_static_s;  ///< an object that stands for longer is not masked
};

/// One object of the clip.
struct MaskedObject {
  std::string class_name;
  double first_s = 0, last_s = 0;  ///< timestamps
  std::size_t images = 0, masked = 0;
};

struct MaskSummary {
  std::string sequence, tool, shape, pipeline, folder;
  std::string images;  ///< folder of the images that the masks are for
  std::size_t frames = 0;
  double masked_share = 0;            ///< of all pixels
  std::vector<MaskedObject> objects;  ///< of the shape `objects`
  std::optional<masks::MaskCounts> truth;
  std::vector<std::string> notes;
  std::string failure;  ///< why the detector failed on every image; empty: it did not

  std::size_t movers() const;
};

/// Writes a mask per image. All files appear at the end, or none.
/// Throws Error for unusable input.
MaskSummary run_masks(const MaskOptions& options,
                      const std::function<void(std::size_t, std::size_t)>& progress);

}  // namespace dynfilter::command
