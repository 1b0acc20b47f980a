// SPDX-License-Identifier: MIT
#include "io/euroc_index.hpp"

#include <dynfilter/config/text_lines.hpp>
#include <dynfilter/core/error.hpp>
#include <system_error>
#include <utility>

#include "io/association.hpp"
#include "io/euroc_sensor.hpp"

namespace dynfilter::io::detail {

/// The images of one camera, relative to `folder`.
inline std::vector<std::pair<double, std::string>> read_euroc_list(const std::filesystem::path& folder,
                                                                   const std::string& camera,
                                                                   std::vector<std::string>& notes) {
  const std::filesystem::path path = folder / camera / "data.csv";
  std::vector<std::pair<double, std::string>> images;
  std::size_t missing = 0;
  double last_ns = -1e300;
  for (const TextLine& line : read_text_lines(path)) {
    if (line.fields.size() < 2) throw IoError(at_line(path, line.number) + ": expected 'timestamp,file'");
    const double stamp_ns = stamp_of(line, 0, path);
    if (!comes_later(stamp_ns, last_ns, line, path))
      throw IoError(at_line(path, line.number) + ": the timestamp is repeated");
    last_ns = stamp_ns;
    const std::string file = camera + "/data/" + line.fields[1];
    std::error_code error;
    if (std::filesystem::is_regular_file(folder / file, error))
      images.emplace_back(1e-9 * stamp_ns, file);
    else
      ++missing;
  }
  if (images.empty() && missing > 0) throw IoError(path.string() + ": none of the listed images exists");
  if (images.empty()) throw IoError(path.string() + ": lists no images");
  if (missing > 0)
    notes.push_back(camera + "/data.csv: " + counted(missing, "missing image", "missing images") +
                    " left out");
  return images;
}

inline std::filesystem::path euroc_root(const std::filesystem::path& folder) {
  std::error_code error;
  return std::filesystem::is_regular_file(folder / "mav0" / "cam0" / "data.csv", error) ? "mav0" : "";
}

inline void pair_right_images(const std::vector<std::pair<double, std::string>>& right,
                              const std::string& root, double max_gap_s, SequenceIndex& index) {
  std::vector<double> left_s, right_s;
  for (const IndexedFrame& frame : index.frames) left_s.push_back(frame.timestamp_s);
  for (const auto& [stamp_s, file] : right) right_s.push_back(stamp_s);
  std::size_t paired = 0;
  for (const auto& [i, j] : associate(left_s, right_s, max_gap_s)) {
    index.frames[i].right = root + right[j].second;
    ++paired;
  }
  if (paired < index.frames.size())
    index.notes.push_back(counted(index.frames.size() - paired, "frame has", "frames have") +
                          " no right image");
}

inline bool has_right_camera(const std::filesystem::path& root) {
  std::error_code error;
  return std::filesystem::is_regular_file(root / "cam1" / "data.csv", error);
}

inline Rectifier rectifier_of(const RigCamera& left, const std::filesystem::path& root) {
  const std::filesystem::path path = root / "cam1" / "sensor.yaml";
  const RigCamera right = read_euroc_sensor(path);
  try {
    return {left, right};
  } catch (const IoError& problem) {
    throw IoError(path.string() + ": " + problem.what());
  }
}

bool is_euroc_folder(const std::filesystem::path& folder) {
  std::error_code error;
  return std::filesystem::is_regular_file(folder / euroc_root(folder) / "cam0" / "data.csv", error);
}

Pose read_euroc_T_body_camera(const std::filesystem::path& root) {
  const RigCamera left = read_euroc_sensor(root / "cam0" / "sensor.yaml");
  return has_right_camera(root) ? rectifier_of(left, root).T_body_camera() : left.T_body_camera;
}

SequenceIndex read_euroc_index(const std::filesystem::path& folder, double max_gap_s) {
  SequenceIndex index;
  const std::filesystem::path below = euroc_root(folder), root = folder / below;
  const std::string prefix = below.empty() ? "" : below.string() + "/";
  for (const auto& [stamp_s, file] : read_euroc_list(root, "cam0", index.notes)) {
    IndexedFrame frame;
    frame.timestamp_s = stamp_s;
    frame.image = prefix + file;
    index.frames.push_back(frame);
  }
  const RigCamera left = read_euroc_sensor(root / "cam0" / "sensor.yaml");
  index.camera = left.camera, index.T_body_camera = left.T_body_camera;
  if (has_right_camera(root)) {
    pair_right_images(read_euroc_list(root, "cam1", index.notes), prefix, max_gap_s, index);
    index.rectifier = rectifier_of(left, root);
    index.camera = index.rectifier->camera(), index.T_body_camera = index.rectifier->T_body_camera();
  }
  index.poses = root / "state_groundtruth_estimate0" / "data.csv";
  index.pose_format = TrajectoryFormat::Euroc;
  return index;
}

}  // namespace dynfilter::io::detail
