// SPDX-License-Identifier: MIT
#include "io/euroc_index.hpp"

#include <cmath>
#include <dynfilter/config/text_lines.hpp>
#include <dynfilter/config/yaml.hpp>
#include <dynfilter/core/error.hpp>
#include <system_error>
#include <utility>

#include "io/association.hpp"

namespace dynfilter::io::detail {

inline std::vector<double> numbers_of(const YamlNode& map, const std::string& key, std::size_t n) {
  const auto node = map.find(key);
  if (!node) map.fail("'" + key + "' is missing");
  std::vector<double> values = node->reals();
  if (values.size() != n) node->fail("expected " + std::to_string(n) + " numbers");
  return values;
}

inline std::string word_of(const YamlNode& map, const std::string& key) {
  const auto node = map.find(key);
  return node ? node->text() : "";
}

inline Pose read_T_body_sensor(const YamlNode& root) {
  const auto T = root.find("T_BS");
  if (!T) root.fail("'T_BS' is missing");
  const std::vector<double> n = numbers_of(*T, "data", 16);
  Pose pose;
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t c = 0; c < 3; ++c) pose.rotation[3 * row + c] = n[4 * row + c];
    pose.translation_m[row] = n[4 * row + 3];
  }
  if (!is_rigid(pose)) T->fail("is not a rotation and a translation");
  return pose;
}

inline Camera read_euroc_camera(const YamlNode& root) {
  if (word_of(root, "camera_model") != "pinhole") root.fail("only the camera_model pinhole is supported");
  const std::vector<double> size = numbers_of(root, "resolution", 2), f = numbers_of(root, "intrinsics", 4);
  Camera camera;
  camera.fx_px = f[0], camera.fy_px = f[1], camera.cx_px = f[2], camera.cy_px = f[3];
  camera.width_px = static_cast<int>(size[0]), camera.height_px = static_cast<int>(size[1]);
  if (!(f[0] > 0 && f[1] > 0 && size[0] >= 1 && size[1] >= 1))
    root.fail("intrinsics and resolution must be above 0");
  const std::string model = word_of(root, "distortion_model");
  if (model.empty() || model == "none") return camera;
  if (model != "radial-tangential" && model != "radtan")
    root.fail("only the distortion_model radial-tangential is supported, not " + model);
  const std::vector<double> k = numbers_of(root, "distortion_coefficients", 4);
  for (std::size_t i = 0; i < k.size(); ++i) camera.distortion[i] = k[i];
  return camera;
}

inline RigCamera read_euroc_sensor(const std::filesystem::path& path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) throw IoError(path.string() + ": no such file");
  try {
    const YamlDocument document = YamlDocument::from_file(path.string());
    return {read_euroc_camera(document.root()), read_T_body_sensor(document.root())};
  } catch (const ConfigError& problem) {
    const std::string what = problem.what();
    throw IoError(what.find(path.string()) == std::string::npos ? path.string() + ": " + what : what);
  }
}

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

bool is_euroc_folder(const std::filesystem::path& folder) {
  std::error_code error;
  return std::filesystem::is_regular_file(folder / euroc_root(folder) / "cam0" / "data.csv", error);
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
  std::error_code error;
  if (std::filesystem::is_regular_file(root / "cam1" / "data.csv", error)) {
    pair_right_images(read_euroc_list(root, "cam1", index.notes), prefix, max_gap_s, index);
    const RigCamera right = read_euroc_sensor(root / "cam1" / "sensor.yaml");
    try {
      index.rectifier.emplace(left, right);
    } catch (const IoError& problem) {
      throw IoError((root / "cam1" / "sensor.yaml").string() + ": " + problem.what());
    }
    index.camera = index.rectifier->camera(), index.T_body_camera = index.rectifier->T_body_camera();
  }
  index.poses = root / "state_groundtruth_estimate0" / "data.csv";
  index.pose_format = TrajectoryFormat::Euroc;
  return index;
}

}  // namespace dynfilter::io::detail
