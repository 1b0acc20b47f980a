// SPDX-License-Identifier: MIT
// A program of the host: loads plugins through the host's library, and catches what they throw.
//   rgbd_tum FOLDER_OF_PLUGINS
#include <dynfilter/core/error.hpp>
#include <filesystem>
#include <fstream>
#include <iostream>

#include "hosts/library/tracking.hpp"

namespace {

namespace fs = std::filesystem;

int failures = 0;
void check(bool fine, const std::string& what) {
  std::cout << (fine ? "ok: " : "FAILED: ") << what << '\n';
  failures += fine ? 0 : 1;
}

/// A settings file that loads a plugin and may run a filter of it.
class Settings {
 public:
  Settings(const fs::path& plugin, const std::string& stage) {
    std::ofstream out(file_);
    out << "%YAML:1.0\n---\nCamera.fx: 250.0\nCamera.fy: 250.0\nCamera.cx: 160.0\nCamera.cy: 120.0\n"
        << "DynFilter.plugins: [ \"" << plugin.string() << "\" ]\n";
    if (!stage.empty()) out << "pipeline:\n  before_pose: [ " << stage << " ]\n";
  }
  Settings(const Settings&) = delete;
  Settings& operator=(const Settings&) = delete;
  ~Settings() { fs::remove(file_); }
  std::string file() const { return file_; }

 private:
  std::string file_ = "rgbd_tum_settings.yaml";
};

std::string refusal(const fs::path& plugin, const std::string& stage) {
  const Settings settings(plugin, stage);
  try {
    ORB_SLAM2::Tracking tracking(settings.file());
  } catch (const dynfilter::ConfigError& error) {
    return error.what();
  }
  return "";
}
bool has(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

void runs(const fs::path& plugin, const std::string& stage, const std::string& expected) {
  const Settings settings(plugin, stage);
  ORB_SLAM2::Tracking tracking(settings.file());
  tracking.grab(1);
  const std::string summary = tracking.grab(2);
  check(has(summary, expected), stage + ": " + summary);
  check(ORB_SLAM2::Tracking::stages_of(*tracking.mpDynFilter) == 2, "the host's own function takes our type");
}

}  // namespace

int main(int, char** argv) {
  const fs::path plugins = argv[1];
  runs(plugins / "good.so", "{ harmless: { limit_px: 2 } }", "; harmless 0");
  runs(plugins / "throws_in_apply.so", "throws_in_apply", "the sensor melted");
  runs(plugins / "good.so", "background_motion", "background_motion");
  {
    const Settings settings(plugins / "good.so", "");
    ORB_SLAM2::Tracking tracking(settings.file());
    check(has(tracking.grab(1), "frame 1: 300 features"), "the default preset is found by its name");
  }
  check(has(refusal(plugins / "good.so", "{ harmless: { limit_px: 20 } }"), "expected 0 to 10"),
        "a parameter that the plugin's code refuses");
  check(has(refusal(plugins / "throws_when_made.so", "{ named_p: { limit_px: 6 } }"),
            "too much for this machine"),
        "a ConfigError that the plugin throws");
  check(has(refusal(plugins / "no_tag.so", "harmless"), "not a dynfilter plugin"),
        "a file that is no plugin");
  return failures;
}
