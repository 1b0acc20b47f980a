// SPDX-License-Identifier: MIT
// Plays the same frames to and fro for as long as asked, and says what memory and time did meanwhile.
//   steady_soak HOST FRAMES      HOST: a preset, c_facade, orb_slam
// Memory: after a tenth of the frames (120 to 2000), the growth of what malloc() has given out, and of the
// process. Time: CPU time of this thread in before_pose, and of the wall. A call is disturbed if the kernel
// gave the processor to another program meanwhile: then it also has the time to fill the caches again. Exit
// code 1: memory grew by 1 MB.
#include <fmt/format.h>
#include <malloc.h>
#include <sys/resource.h>
#include <unistd.h>

#include <dynfilter/facade/dynfilter.h>
#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <ctime>
#include <dynfilter/hosts/orb_slam.hpp>
#include <dynfilter/pipeline/presets.hpp>
#include <fstream>
#include <functional>
#include <opencv2/core/utility.hpp>
#include <string>
#include <utility>
#include <vector>

#include "hosts/host_stand_ins.hpp"
#include "recording.hpp"

namespace {

using namespace dynfilter;

constexpr const char* kScene = "walking_xyz";
constexpr int kFrames = 30;                                    ///< rendered
constexpr std::size_t kLeastWarmUp = 120, kMostWarmUp = 2000;  ///< two periods of the recording at least
constexpr double kMostGrowth_kB = 1000;

double cpu_ms() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}
double wall_ms() {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

struct Memory {
  double given_kB = 0, process_kB = 0;
};
Memory memory() {
  std::size_t pages = 0, resident = 0;
  std::ifstream("/proc/self/statm") >> pages >> resident;
  return {static_cast<double>(mallinfo2().uordblks + mallinfo2().hblkhd) / 1e3,
          static_cast<double>(resident) * static_cast<double>(sysconf(_SC_PAGESIZE)) / 1e3};
}

/// What the kernel did to this thread so far.
struct Kernel {
  long switches = 0, page_faults = 0;
};
Kernel kernel() {
  rusage usage{};
  getrusage(RUSAGE_THREAD, &usage);
  return {usage.ru_nivcsw + usage.ru_nvcsw, usage.ru_minflt + usage.ru_majflt};
}

double quantile(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

/// Milliseconds of each frame. Its memory is taken at the beginning.
class Times {
 public:
  explicit Times(std::size_t frames) { values_ms_.reserve(frames); }
  void add(double ms) { values_ms_.push_back(ms); }
  std::size_t size() const { return values_ms_.size(); }

  /// Each frame comes again every `period` frames, and costs the same. The rest is the machine's.
  double worst_of_medians(std::size_t period) const {
    double worst_ms = 0;
    for (std::size_t phase = 0; phase < period && phase < values_ms_.size(); ++phase) {
      std::vector<double> again;
      for (std::size_t n = phase; n < values_ms_.size(); n += period) again.push_back(values_ms_[n]);
      worst_ms = std::max(worst_ms, quantile(again, 0.5));
    }
    return worst_ms;
  }
  std::string text() const {
    if (values_ms_.empty()) return "none";
    const auto at = [&](double share) { return quantile(values_ms_, share); };
    return fmt::format("median {:.3f}, 99 % {:.3f}, 99.9 % {:.3f}, worst {:.3f} ms, worst / median {:.2f}",
                       at(0.5), at(0.99), at(0.999), at(1), at(1) / at(0.5));
  }

 private:
  std::vector<double> values_ms_;
};

/// `process(n)` judges frame n.
int soak(const std::string& name, std::size_t frames, const std::function<void(std::size_t)>& process) {
  const std::size_t warm_up = std::clamp(frames / 10, kLeastWarmUp, kMostWarmUp);
  Times cpu(frames), wall(frames), undisturbed(frames);
  Memory before;
  long faults = 0;
  for (std::size_t n = 0; n < warm_up + frames; ++n) {
    if (n == warm_up) before = memory();
    const Kernel kernel_start = kernel();
    const double cpu_start = cpu_ms(), start = wall_ms();
    process(n);
    const double cpu_end = cpu_ms(), end = wall_ms();
    const Kernel kernel_end = kernel();
    if (n < warm_up) continue;
    cpu.add(cpu_end - cpu_start);
    wall.add(end - start);
    if (kernel_end.switches == kernel_start.switches) undisturbed.add(cpu_end - cpu_start);
    faults += kernel_end.page_faults - kernel_start.page_faults;
  }
  const Memory after = memory();
  const double frame_ms = cpu.worst_of_medians(2 * (kFrames - 1));
  const double given_kB = after.given_kB - before.given_kB, grown_kB = after.process_kB - before.process_kB;
  fmt::print(
      "{}: {} frames after {}\n  memory: malloc {:+.1f} kB, process {:+.1f} kB of {:.0f}, {} page faults\n"
      "  cpu:  {}\n  cpu of the {} undisturbed calls: {}\n"
      "  cpu of the slowest frame, median of its repetitions: {:.3f} ms\n  wall: {}\n",
      name, frames, warm_up, given_kB, grown_kB, after.process_kB, faults, cpu.text(), undisturbed.size(),
      undisturbed.text(), frame_ms, wall.text());
  return given_kB < kMostGrowth_kB ? EXIT_SUCCESS : EXIT_FAILURE;
}

int soak_pipeline(const std::string& preset, steady::Camera camera, std::size_t frames) {
  const steady::Recording recording(camera, kScene, kFrames);
  Pipeline pipeline(load_pipeline(preset, builtin_filters()));
  return soak(preset + ", " + to_string(camera), frames,
              [&](std::size_t n) { pipeline.before_pose(recording.view(n)); });
}

int soak_facade(std::size_t frames) {
  const steady::Recording recording(steady::Camera::Rgbd, kScene, kFrames);
  char error[500];
  dynfilter_filter* filter = dynfilter_create("dynfilter", error, sizeof(error));
  if (filter == nullptr) throw Error(error);
  std::vector<dynfilter_keypoint> keypoints;
  std::vector<dynfilter_box> boxes;
  const int result = soak("C facade, dynfilter, rgbd", frames, [&](std::size_t n) {
    const FrameView view = recording.view(n);
    keypoints.clear(), boxes.clear();
    for (const cv::KeyPoint& k : view.keypoints)
      keypoints.push_back({k.pt.x, k.pt.y, k.size, k.angle, k.response, k.octave});
    for (const Detection& d : view.detections->detections)
      boxes.push_back({d.box.x, d.box.y, d.box.br().x, d.box.br().y, d.score, d.class_id, -1,
                       d.class_name.c_str(), nullptr, 0});
    dynfilter_frame frame;
    dynfilter_frame_init(&frame);
    frame.id = view.id, frame.timestamp_s = view.timestamp_s;
    frame.keypoint_count = keypoints.size(), frame.keypoints = keypoints.data();
    frame.width_px = view.grey.cols, frame.height_px = view.grey.rows;
    frame.grey = view.grey.data, frame.grey_stride_bytes = view.grey.step[0];
    frame.depth = view.depth.data, frame.depth_stride_bytes = view.depth.step[0];
    frame.depth_type = DYNFILTER_DEPTH_U16, frame.depth_unit_m = view.depth_unit_m;
    frame.has_camera = 1;
    frame.fx_px = view.camera->fx_px, frame.fy_px = view.camera->fy_px;
    frame.cx_px = view.camera->cx_px, frame.cy_px = view.camera->cy_px;
    frame.has_boxes = 1, frame.box_count = boxes.size(), frame.boxes = boxes.data();
    dynfilter_verdicts verdicts;
    if (dynfilter_process(filter, &frame, DYNFILTER_BEFORE_POSE, &verdicts) != 0)
      throw Error(dynfilter_last_error(filter));
  });
  dynfilter_destroy(filter);
  return result;
}

int soak_orb_slam(std::size_t frames) {
  const steady::Recording recording(steady::Camera::Rgbd, kScene, kFrames);
  OrbSlamSettings settings;
  settings.pipeline = load_pipeline("dynfilter", builtin_filters());
  OrbSlam adapter(std::move(settings), HostSensor::RgbD);
  return soak("ORB-SLAM2 adapter, dynfilter, rgbd", frames, [&](std::size_t n) {
    const FrameView view = recording.view(n);
    host::v2::Frame frame;
    frame.mnId = n, frame.mTimeStamp = view.timestamp_s;
    frame.N = static_cast<int>(view.size());
    frame.mvKeys.assign(view.keypoints.begin(), view.keypoints.end());
    frame.mvKeysUn = frame.mvKeys;
    frame.mDescriptors = view.descriptors.clone();
    frame.mvDepth.assign(view.depth_m.begin(), view.depth_m.end());
    frame.mvuRight.assign(view.size(), -1);
    frame.mvpMapPoints.assign(view.size(), nullptr);
    frame.mvbOutlier.assign(view.size(), false);
    frame.mK = (cv::Mat_<float>(3, 3) << view.camera->fx_px, 0, view.camera->cx_px, 0, view.camera->fy_px,
                view.camera->cy_px, 0, 0, 1);
    frame.mDistCoef = cv::Mat::zeros(4, 1, CV_32F);
    adapter.set_depth_unit_m(view.depth_unit_m);
    adapter.before_tracking(frame, view.grey, view.depth, true);
  });
}

int run(const std::string& host, std::size_t frames) {
  cv::setNumThreads(1);
  if (host == "c_facade") return soak_facade(frames);
  if (host == "orb_slam") return soak_orb_slam(frames);
  for (const auto camera : {steady::Camera::Rgbd, steady::Camera::Stereo, steady::Camera::Mono})
    if (host.size() > 1 && host == std::string("dynfilter_") + to_string(camera))
      return soak_pipeline("dynfilter", camera, frames);
  return soak_pipeline(host, host == "dynfilter_mono" ? steady::Camera::Mono : steady::Camera::Rgbd, frames);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) {
    fmt::print(
        "steady_soak HOST FRAMES: HOST is c_facade, orb_slam, dynfilter_rgbd, dynfilter_stereo, or a "
        "preset\n");
    return 2;
  }
  try {
    return run(argv[1], std::strtoul(argv[2], nullptr, 10));
  } catch (const std::exception& error) {
    fmt::print("{}\n", error.what());
    return 2;
  }
}
