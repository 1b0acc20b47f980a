// SPDX-License-Identifier: MIT
// Sequences of odd frames through every preset and every combinator, with the properties of verdicts.
// Their memory is taken back after each call (lent_memory.hpp).
#include <algorithm>
#include <cmath>
#include <ctime>
#include <dynfilter/core/verdict.hpp>
#include <dynfilter/pipeline/builtin_filters.hpp>
#include <dynfilter/pipeline/pipeline.hpp>
#include <dynfilter/pipeline/pipeline_yaml.hpp>
#include <filesystem>
#include <opencv2/core/utility.hpp>
#include <optional>

#include "bytes.hpp"
#include "frames.hpp"
#include "lent_memory.hpp"
#include "target.hpp"
#include "turned.hpp"

namespace {

using namespace dynfilter;
using namespace fuzz;

/// Prints how many frames were judged in a second of processor time, if DYNFILTER_FUZZ_RATE is set.
class Rate {
 public:
  void count() {
    if (frames_++ == 0) start_ = std::clock();
  }
  ~Rate() {
    if (std::getenv("DYNFILTER_FUZZ_RATE") == nullptr) return;
    const double s = static_cast<double>(std::clock() - start_) / CLOCKS_PER_SEC;
    std::fprintf(stderr, "frames: %zu in %.1f s of processor time, %.0f a second\n", frames_, s,
                 static_cast<double>(frames_) / s);
  }

 private:
  std::size_t frames_ = 0;
  std::clock_t start_ = 0;
};
Rate rate;

/// Two pipelines of one file. Both see other sequences before, so that reset() must forget them.
struct Subject {
  std::string name;
  FloorParams floor;
  Pipeline first, second;
};

Subject subject(const std::filesystem::path& file) {
  PipelineConfig config = pipeline_from_file(file.string(), builtin_filters());
  const FloorParams floor = config.floor;
  return {file.stem().string(), floor, Pipeline(std::move(config)),
          Pipeline(pipeline_from_file(file.string(), builtin_filters()))};
}

std::vector<Subject>& subjects() {
  static std::vector<Subject> all = [] {
    std::vector<Subject> made;
    for (const std::string& file : pipeline_files(DYNFILTER_SOURCE_DIR)) made.push_back(subject(file));
    return made;
  }();
  return all;
}

void check_report(const Verdict& verdict) {
  const std::vector<StageReport>& stages = verdict.report.stages;
  for (const StageReport& stage : stages) {
    if (stage.failed) fail("no stage throws", stage.path + ": " + stage.note);
    require(!stage.name.empty(), "a stage has a name");
    require(stage.judged <= verdict.size() && stage.dynamic + stage.unknown <= stage.judged,
            "a stage votes once on each feature that it judges");
  }
  for (std::size_t i = 0; i < verdict.size(); ++i) {
    for (std::uint64_t k = 0; k < 64; ++k) {
      if ((verdict.reasons[i] >> k & 1U) == 0) continue;
      require(k < stages.size(), "reasons name stages of the report");
      require(!stages[k].skipped, "reasons name stages that ran");
    }
    require(verdict.keep(i) || verdict.reasons[i] != 0, "a dynamic feature has a reason");
    require(verdict.suspicion[i] >= 0 && verdict.suspicion[i] <= 1, "a suspicion is in [0, 1]");
    require(verdict.restored[i] == 0 || verdict.decision[i] == Vote::Unknown,
            "restored features are unknown");
  }
}

void check_verdict(const Subject& subject, const FrameView& frame, const HostLimits& limits,
                   const Verdict& verdict) {
  const std::size_t n = frame.size();
  require(verdict.size() == n && verdict.suspicion.size() == n && verdict.prior.size() == n &&
              verdict.restored.size() == n && verdict.reasons.size() == n,
          "a verdict has an entry per feature");
  require(verdict.report.features == n && verdict.report.rejected == n - verdict.kept(),
          "the report's counts");
  const double share = std::ceil(subject.floor.min_share * static_cast<double>(n));
  const double least = std::max(
      {static_cast<double>(subject.floor.min_features), share, static_cast<double>(limits.min_features)});
  require(static_cast<double>(verdict.kept()) >= std::min(least, static_cast<double>(n)), "the floor holds");
  check_report(verdict);
}

std::string where(const Subject& subject, int frame, std::size_t feature) {
  return subject.name + ", frame " + std::to_string(frame) + ", feature " + std::to_string(feature);
}

/// `place[i]` is where feature i of `a` is in `b`.
void same(const Verdict& a, const Verdict& b, const std::vector<std::size_t>& place, const char* property,
          const Subject& subject, int frame) {
  require(a.size() == b.size(), property);
  for (std::size_t i = 0; i < a.size(); ++i) {
    const std::size_t j = place.empty() ? i : place[i];
    if (a.decision[i] == b.decision[j] && a.suspicion[i] == b.suspicion[j] && a.prior[i] == b.prior[j] &&
        a.restored[i] == b.restored[j] && a.reasons[i] == b.reasons[j])
      continue;
    fail(property, where(subject, frame, i) + ": " + to_string(a.decision[i]) + " " +
                       std::to_string(a.suspicion[i]) + " " + a.reason(i) + ", then " +
                       to_string(b.decision[j]) + " " + std::to_string(b.suspicion[j]) + " " + b.reason(j));
  }
}

/// These fit a model to samples that they draw from the features by index, with a fixed seed. In another
/// order of the features the same numbers draw other samples. The model may then change, and with it a vote
/// near the limit.
bool draws_samples(const Verdict& verdict) {
  constexpr const char* kSamplers[] = {"epipolar", "depth_consistency", "trajectory_consistency"};
  for (const StageReport& stage : verdict.report.stages)
    for (const char* name : kSamplers)
      if (stage.name == name) return true;
  return false;
}

enum class Property { Repeat, Threads, Permuted, Mirrored };

const char* text(Property property) {
  switch (property) {
    case Property::Repeat:
      return "same input, same verdict";
    case Property::Threads:
      return "one thread and two give the same verdict";
    case Property::Permuted:
      return "permuted features get permuted verdicts";
    default:
      return "a mirrored frame gets mirrored verdicts";
  }
}

/// With DYNFILTER_FUZZ_SHOW, what is in each frame: to understand an input that was found.
void show(const Subject& subject, Property property, const OwnedFrame& f) {
  static const bool wanted = std::getenv("DYNFILTER_FUZZ_SHOW") != nullptr;
  if (!wanted) return;
  std::fprintf(stderr,
               "%s, %s: id %lld, %.3f s, grey %dx%d depth %dx%d, camera %d, pose %d, matches %d with %lld\n",
               subject.name.c_str(), text(property), static_cast<long long>(f.id), f.timestamp_s, f.grey.cols,
               f.grey.rows, f.depth.cols, f.depth.rows, f.has_camera ? 1 : 0, static_cast<int>(f.provenance),
               f.has_matches ? 1 : 0, static_cast<long long>(f.match_id));
  for (std::size_t i = 0; i < f.size(); ++i)
    std::fprintf(stderr, "  %zu: %g %g, depth %g, right %g, id %lld, match %d\n", i,
                 static_cast<double>(f.keypoints[i].pt.x), static_cast<double>(f.keypoints[i].pt.y),
                 i < f.depth_m.size() ? static_cast<double>(f.depth_m[i]) : 0.0,
                 i < f.right_u_px.size() ? static_cast<double>(f.right_u_px[i]) : 0.0,
                 i < f.map_point_ids.size() ? static_cast<long long>(f.map_point_ids[i]) : -9,
                 i < f.match_index.size() ? f.match_index[i] : -9);
}

/// With memory that is filled with garbage right after the call. The two pipelines have different hosts:
/// memory that one of them reads later makes a difference, and AddressSanitizer sees it.
const Verdict& process(Pipeline& pipeline, const FrameView& frame, Host host, std::uint8_t garbage,
                       CallPoint point, const HostLimits& limits) {
  LentFrame lent(frame, host, garbage);
  const Verdict& verdict = pipeline.process(lent.view(), point, limits);
  require(lent.take_back() == 0, "no image is referred to after the call");
  return verdict;
}

void run(Bytes& in) {
  Subject& subject = subjects()[in.byte() % subjects().size()];
  auto property = static_cast<Property>(in.below(4));
  if (property == Property::Mirrored && subject.name != "mirror") property = Property::Repeat;
  subject.first.reset();
  subject.second.reset();
  Frames frames(in);
  Turner turner;
  for (int k = 0, n = 2 + in.below(6); k < n; ++k) {
    OwnedFrame frame = frames.next();
    show(subject, property, frame);
    OwnedFrame other = frame;
    std::vector<std::size_t> place;
    if (property == Property::Permuted) place = turner.permute(other);
    if (property == Property::Mirrored) turner.mirror(frame, other);
    const HostLimits limits{in.below(4) == 0 ? in.byte() : 0};
    const int calls = in.below(8);
    for (const CallPoint point : {CallPoint::BeforePose, CallPoint::AfterPose, CallPoint::AtKeyframe}) {
      if (point != CallPoint::BeforePose && (calls >> static_cast<int>(point) & 1) == 0) continue;
      if (property == Property::Threads) cv::setNumThreads(1);
      const FrameView view = frame.view();
      const Verdict& a = process(subject.first, view, Host::Frees, 0x00, point, limits);
      check_verdict(subject, view, limits, a);
      if (property == Property::Threads) cv::setNumThreads(2);
      const Verdict& b = process(subject.second, other.view(), Host::Reuses, 0xff, point, limits);
      rate.count(), rate.count();
      const bool promised = property != Property::Permuted || !draws_samples(a);
      if (promised && turner.comparable()) same(a, b, place, text(property), subject, k);
    }
    if (in.below(32) == 31) subject.first.reset(), subject.second.reset();
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Bytes in(data, size);
  run(in);
  return 0;
}
