// SPDX-License-Identifier: MIT
#include "io/kitti_index.hpp"

#include <array>
#include <cstdio>
#include <dynfilter/config/text_lines.hpp>
#include <dynfilter/core/error.hpp>
#include <map>
#include <system_error>

namespace dynfilter::io::detail {

/// The 12 numbers of a projection matrix P = K [I | t], row by row.
using KittiProjection = std::array<double, 12>;

inline std::map<std::string, KittiProjection> read_kitti_calibration(const std::filesystem::path& path) {
  std::map<std::string, KittiProjection> all;
  for (const TextLine& line : read_text_lines(path)) {
    const std::string& key = line.fields[0];
    if (key.size() != 3 || key[0] != 'P' || key[2] != ':') continue;  // Tr: of the laser scanner
    KittiProjection P;
    if (line.fields.size() != P.size() + 1)
      throw IoError(at_line(path, line.number) + ": expected the 12 numbers of a projection, found " +
                    std::to_string(line.fields.size() - 1));
    for (std::size_t i = 0; i < P.size(); ++i) P[i] = number_at(line, i + 1, path);
    if (!(P[0] > 0) || !(P[5] > 0))
      throw IoError(at_line(path, line.number) + ": the focal length must be above 0");
    if (!all.emplace(key.substr(0, 2), P).second)
      throw IoError(at_line(path, line.number) + ": '" + key + "' is given twice");
  }
  return all;
}

inline const KittiProjection& projection_of(const std::map<std::string, KittiProjection>& all, char camera,
                                            const std::filesystem::path& path) {
  const auto found = all.find(std::string("P") + camera);
  if (found == all.end()) throw IoError(path.string() + ": 'P" + camera + ":' is missing");
  return found->second;
}

/// Position of a camera along the row of camera 0 [m].
inline double kitti_offset_m(const KittiProjection& P) {
  return -P[3] / P[0];
}

inline std::filesystem::path kitti_poses(const std::filesystem::path& folder) {
  std::error_code error;
  if (std::filesystem::is_regular_file(folder / "poses.txt", error)) return folder / "poses.txt";
  const std::filesystem::path whole = std::filesystem::weakly_canonical(folder, error);
  const std::filesystem::path own = whole.has_filename() ? whole : whole.parent_path();
  return own.parent_path().parent_path() / "poses" / (own.filename().string() + ".txt");
}

inline void read_kitti_cameras(const std::filesystem::path& folder, char left, char right,
                               SequenceIndex& index) {
  const std::filesystem::path path = folder / "calib.txt";
  const auto all = read_kitti_calibration(path);
  const KittiProjection& P = projection_of(all, left, path);
  Camera camera;
  camera.fx_px = P[0], camera.fy_px = P[5], camera.cx_px = P[2], camera.cy_px = P[6];
  index.T_body_camera.translation_m[0] = kitti_offset_m(P);
  std::error_code error;
  if (std::filesystem::is_directory(folder / (std::string("image_") + right), error)) {
    const double baseline_m = kitti_offset_m(projection_of(all, right, path)) - kitti_offset_m(P);
    if (!(baseline_m > 0)) throw IoError(path.string() + ": the second camera is not to the right");
    camera.baseline_fx_px_m = baseline_m * P[0];
  }
  index.camera = camera;
}

inline void list_kitti_images(const std::filesystem::path& folder, char left, char right,
                              SequenceIndex& index) {
  const std::string left_folder = std::string("image_") + left + "/",
                    right_folder = std::string("image_") + right + "/";
  std::size_t missing = 0, without_right = 0;
  std::error_code error;
  const auto exists = [&](const std::string& file) {
    return std::filesystem::is_regular_file(folder / file, error);
  };
  for (std::size_t i = 0; i < index.pose_times_s.size(); ++i) {
    const std::string number = std::to_string(i);
    constexpr std::size_t kDigits = 6;
    const std::string name = std::string(kDigits - std::min(kDigits, number.size()), '0') + number + ".png";
    if (!exists(left_folder + name)) {
      ++missing;
      continue;
    }
    IndexedFrame frame;
    frame.timestamp_s = index.pose_times_s[i];
    frame.image = left_folder + name;
    if (exists(right_folder + name)) frame.right = right_folder + name;
    without_right += frame.right.empty() ? 1U : 0U;
    index.frames.push_back(frame);
  }
  if (index.frames.empty())
    throw IoError((folder / left_folder).string() + ": none of the images of times.txt exists");
  if (missing > 0)
    index.notes.push_back("times.txt: " + counted(missing, "missing image", "missing images") + " left out");
  if (index.camera->baseline_fx_px_m > 0 && without_right > 0)
    index.notes.push_back(counted(without_right, "frame has", "frames have") + " no right image");
}

bool is_kitti_folder(const std::filesystem::path& folder) {
  std::error_code error;
  return std::filesystem::is_regular_file(folder / "calib.txt", error) &&
         (std::filesystem::is_directory(folder / "image_0", error) ||
          std::filesystem::is_directory(folder / "image_2", error));
}

SequenceIndex read_kitti_index(const std::filesystem::path& folder) {
  std::error_code error;
  const bool grey = std::filesystem::is_directory(folder / "image_0", error);
  const char left = grey ? '0' : '2', right = grey ? '1' : '3';
  SequenceIndex index;
  read_kitti_cameras(folder, left, right, index);
  const std::filesystem::path times = folder / "times.txt";
  for (const TextLine& line : read_text_lines(times)) {
    const double timestamp_s = stamp_of(line, 0, times);
    const double last_s = index.pose_times_s.empty() ? -1e300 : index.pose_times_s.back();
    if (!comes_later(timestamp_s, last_s, line, times))
      throw IoError(at_line(times, line.number) + ": the timestamp is repeated");
    index.pose_times_s.push_back(timestamp_s);
  }
  if (index.pose_times_s.empty()) throw IoError(times.string() + ": contains no time");
  list_kitti_images(folder, left, right, index);
  index.poses = kitti_poses(folder);
  index.pose_format = TrajectoryFormat::Kitti;
  return index;
}

}  // namespace dynfilter::io::detail
