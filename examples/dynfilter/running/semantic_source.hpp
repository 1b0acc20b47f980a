// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <dynfilter/detectors/detections.hpp>
#include <dynfilter/semantic/detector_yaml.hpp>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "command_registry.hpp"
#include "interruption.hpp"
#include "io/sequence.hpp"
#include "run_input.hpp"
#include "semantic_feed.hpp"
#include "sequence_run.hpp"

namespace dynfilter::command {

/// Boxes and masks of a sequence: from the detector of the options, else from files.
/// `order`: the frames that are played. Throws Error if a file or the detector cannot be opened.
inline SemanticFeed semantic_feed(const RunOptions& options, const io::Sequence& sequence,
                                  const std::vector<std::size_t>& order, std::vector<std::string>& notes) {
  if (!options.detector.empty()) {
    const DetectorConfig detector = load_detector(options.detector, options.network_dir, options.plugins);
    notes.push_back("boxes and masks from the detector " + detector.name);
    Interruption::watch();
    return {detector.make(), options.detector_mode, false};
  }
  std::optional<io::DetectionTrack> boxes = load_detections(options, sequence, notes);
  return {std::make_unique<SequenceFiles>(std::move(boxes), MaskFolder(options, sequence), order, sequence),
          options.detector_mode, true};
}

/// True if a detector or files say where objects are.
inline bool has_semantics(const RunOptions& options, const io::Sequence& sequence) {
  const bool boxes =
      !options.no_detections && (!options.detections.empty() || detections_in(sequence.folder()).has_value());
  return !options.detector.empty() || boxes || !MaskFolder(options, sequence).empty();
}

}  // namespace dynfilter::command
