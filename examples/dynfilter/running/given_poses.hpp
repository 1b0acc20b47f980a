// SPDX-License-Identifier: MIT
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <dynfilter/core/error.hpp>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "io/pose_lookup.hpp"
#include "io/sequence.hpp"
#include "io/trajectory.hpp"
#include "run_notes.hpp"
#include "sequence_run.hpp"

namespace dynfilter::command {

/// What is odd in a trajectory, one line each.
inline std::vector<std::string> notes_of(const io::TrajectoryOddities& odd, const std::string& name) {
  std::vector<std::string> notes;
  const auto note = [&](std::size_t n, const char* one, const char* many, const char* rest) {
    if (n > 0) notes.push_back(fmt::format("{}: {} {} {}", name, n, n == 1 ? one : many, rest));
  };
  note(odd.backwards, "stamp goes", "stamps go", "back: sorted by time");
  if (odd.repeated > 0)
    notes.push_back(fmt::format("{}: {} repeated {}: the last pose counts", name, odd.repeated,
                                odd.repeated == 1 ? "stamp" : "stamps"));
  note(odd.no_pose, "line", "lines", "without a pose");
  return notes;
}

/// Reads the poses of another SLAM. Frames without a pose are taken out of `order`.
/// Throws IoError if none is left.
inline io::PoseLookup given_poses(const RunOptions& options, const io::Sequence& sequence,
                                  std::vector<std::size_t>& order, std::vector<std::string>& notes) {
  io::TrajectoryOddities odd;
  const io::Trajectory given = io::read_tum_trajectory(options.trajectory, odd);
  for (std::string& note : notes_of(odd, std::filesystem::path(options.trajectory).filename().string()))
    notes.push_back(std::move(note));
  io::PoseLookup poses(given, options.max_gap_s);
  const std::size_t all = order.size();
  const double first_s = sequence.timestamp_s(order.front()), last_s = sequence.timestamp_s(order.back());
  order.erase(std::remove_if(order.begin(), order.end(),
                             [&](std::size_t i) { return !poses.at(sequence.timestamp_s(i)); }),
              order.end());
  if (order.empty())
    throw IoError(
        fmt::format("{}: no pose for any of the {} (poses from {:.3f} to {:.3f} s, frames from {:.3f} to "
                    "{:.3f} s)",
                    options.trajectory, counted(all, "frame"), given.front().timestamp_s,
                    given.back().timestamp_s, first_s, last_s));
  if (order.size() < all)
    notes.push_back(
        fmt::format("{} of {} have no pose and are left out (none within {:g} s of each other around them)",
                    all - order.size(), counted(all, "frame"), options.max_gap_s));
  return poses;
}

}  // namespace dynfilter::command
