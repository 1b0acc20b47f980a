// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <fstream>
#include <iomanip>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <random>
#include <sstream>
#include <string>

namespace dynfilter_test {

/// A folder for one test, removed at its end.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::random_device device;
    path_ = std::filesystem::temp_directory_path() / ("dynfilter-test-" + std::to_string(device()));
    std::filesystem::create_directories(path_);
  }
  ~TemporaryFolder() { std::filesystem::remove_all(path_); }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

inline void write_text(const std::filesystem::path& path, const std::string& text) {
  std::ofstream(path, std::ios::binary) << text;
}

inline std::string read_text(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::stringstream text;
  text << in.rdbuf();
  return text.str();
}

inline std::string stamp(double timestamp_s) {
  std::ostringstream out;
  out << std::fixed << std::setprecision(6) << timestamp_s;
  return out.str();
}

/// Writes n tiny frames in the layout of TUM, without associations.txt. They have 16x12 pixels and are 0.1 s
/// apart from 100 s on, depth 3 ms after colour. Depth of frame i is 5000 + i everywhere.
inline void write_tum_folder(const std::filesystem::path& folder, int n) {
  std::filesystem::create_directories(folder / "rgb");
  std::filesystem::create_directories(folder / "depth");
  std::string rgb = "# colour images\n# file: 'rgbd_dataset_freiburg3_made_up.bag'\n# timestamp filename\n";
  std::string depth = "# depth maps\n";
  for (int i = 0; i < n; ++i) {
    const std::string t_rgb = stamp(100 + 0.1 * i), t_depth = stamp(100.003 + 0.1 * i);
    rgb += t_rgb + " rgb/" + t_rgb + ".png\n";
    depth += t_depth + " depth/" + t_depth + ".png\n";
    cv::imwrite((folder / "rgb" / (t_rgb + ".png")).string(),
                cv::Mat(12, 16, CV_8UC3, cv::Scalar(10, 20, i)));
    cv::imwrite((folder / "depth" / (t_depth + ".png")).string(),
                cv::Mat(12, 16, CV_16UC1, cv::Scalar(5000 + i)));
  }
  write_text(folder / "rgb.txt", rgb);
  write_text(folder / "depth.txt", depth);
  write_text(folder / "camera.yaml",
             "%YAML:1.0\n---\nCamera.fx: 20.0\nCamera.fy: 20.0\nCamera.cx: 8.0\nCamera.cy: 6.0\n");
}

}  // namespace dynfilter_test
