// SPDX-License-Identifier: MIT
#include <cstdint>
#include <cstring>
#include <dynfilter/pipeline/builtin_filters.hpp>
#include <dynfilter/pipeline/frame_observer.hpp>
#include <dynfilter/pipeline/pipeline_yaml.hpp>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include "recorder/recorded_host.hpp"
#include "run_command.hpp"

using namespace dynfilter_test;
namespace fs = std::filesystem;

namespace {

std::string preset_text(const std::string& name) {
  return read_text(std::string(DYNFILTER_SOURCE_DIR) + "/examples/pipelines/" + name + ".yaml");
}

/// What a host recorded: 8 frames in 19 calls, a reset before frame 5.
class Recording {
 public:
  explicit Recording(dynfilter::PipelineConfig config) {
    dynfilter::Pipeline pipeline(std::move(config));
    pipeline.set_observer(dynfilter::open_recording(file().string()));
    RecordedHost(SceneSensor::RgbD).play(pipeline, [](const dynfilter::Verdict&) {});
  }
  explicit Recording(const std::string& preset)
      : Recording(dynfilter::pipeline_from_text(preset_text(preset), dynfilter::builtin_filters())) {}
  fs::path file() const { return root_.path() / "run.dfr"; }
  fs::path beside(const std::string& name) const { return root_.path() / name; }
  std::string replay(const std::string& arguments = "") const {
    return "replay '" + file().string() + "' " + arguments;
  }
  void write(const std::string& bytes) const { write_text(file(), bytes); }

 private:
  TemporaryFolder root_;
};

/// The recording cut off within its last record of images. A thread of its own writes them, each after the
/// frame's record. At any other byte it is chance whether a frame lacks its images.
std::string cut_within_last_images(const std::string& bytes) {
  constexpr std::size_t kFileHeaderBytes = 16, kRecordHeaderBytes = 24;
  constexpr std::uint32_t kImages = 4;  // plugins/recorder/src/record_file.hpp
  std::size_t last = 0;
  for (std::size_t at = kFileHeaderBytes; at + kRecordHeaderBytes <= bytes.size();) {
    std::uint32_t kind_and_bytes[2];
    std::memcpy(kind_and_bytes, bytes.data() + at, sizeof(kind_and_bytes));
    if (kind_and_bytes[0] == kImages) last = at;
    at += kRecordHeaderBytes + kind_and_bytes[1];
  }
  REQUIRE(last > 0);
  return bytes.substr(0, last + kRecordHeaderBytes);
}

std::size_t lines_in(const fs::path& file) {
  const std::string text = read_text(file);
  return static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
}

}  // namespace

TEST_CASE("replay: the recorded pipeline gives the recorded verdicts, another one others") {
  const Recording recording("dynfilter");
  const CommandResult same = run_dynfilter(recording.replay());
  CHECK(same.exit_code == 0);
  CAPTURE(same.out);
  CHECK(contains(same.out, "dynfilter on run.dfr, rgbd, the recorded pipeline"));
  CHECK(contains(same.out, "judged        8 frames, 8 of them with a pose of the host"));
  CHECK(contains(same.out, "verdicts      all 19 as recorded, bit for bit"));
  const CommandResult other = run_dynfilter(recording.replay("--pipeline none --json"));
  CHECK(other.exit_code == 0);  // that is no failure
  CHECK(number_in(other.out, "\"replay\"", "compared") == 19);
  CHECK(number_in(other.out, "\"replay\"", "differ") >= 4);
  CHECK(number_in(other.out, "\"replay\"", "decisions") > 0);
  CHECK(contains(other.out, "\"call_point\": \"before_pose\""));
}

TEST_CASE("replay: verdicts that the recorded pipeline does not give any more are a failure") {
  dynfilter::PipelineConfig config =
      dynfilter::pipeline_from_text(preset_text("dynfilter"), dynfilter::builtin_filters());
  config.yaml = preset_text("none");
  const CommandResult result = run_dynfilter(Recording(std::move(config)).replay());
  CHECK(result.exit_code == 1);
  CHECK(contains(result.out, " differ from the recorded ones, in "));
  CHECK(contains(result.out, "last in frame 7 (id 7, "));
}

TEST_CASE("replay --out writes what run writes, and where verdicts differ") {
  const Recording recording("dynfilter");
  const fs::path out = recording.beside("out");
  CHECK(run_dynfilter(recording.replay("--pipeline rts_slam --out '" + out.string() + "'")).exit_code == 0);
  for (const char* name : {"summary.json", "frames.csv", "verdicts.csv", "report.html", "trajectory.txt"})
    CHECK(fs::exists(out / name));
  CHECK(fs::exists(out / "overlay" / "000000.png"));
  CHECK(lines_in(out / "frames.csv") == 9);
  CHECK(lines_in(out / "trajectory.txt") == 9);  // the host's poses, below a comment
  CHECK(lines_in(out / "differences.csv") > 4);
  CHECK(contains(read_text(out / "differences.csv"), "frame,id,call_point,features,decisions,any,report\n"));
  CHECK(contains(read_text(out / "report.html"), "rts_slam on run.dfr"));
  CHECK(contains(read_text(out / "frames.csv"), "differs from the recording in "));
  check_refused(recording.replay("--out '" + out.string() + "'"), "--force");
}

TEST_CASE("replay --cut makes a case that replays by itself, and says what it lost") {
  const Recording recording("dynfilter");
  const std::string file = "'" + recording.beside("case.dfr").string() + "'";
  const CommandResult cut = run_dynfilter(recording.replay(file + " --cut 2:4"));
  CHECK(cut.exit_code == 0);
  CAPTURE(cut.out);
  CHECK(contains(cut.out, "cut           frames 2 to 4, with the verdicts of this replay"));
  CHECK(contains(cut.out, "the history before them is lost, so its first frames are cold"));
  CHECK(contains(cut.out, "differ from the recorded ones"));
  CHECK(fs::file_size(recording.beside("case.dfr")) < fs::file_size(recording.file()));
  const CommandResult again = run_dynfilter("replay " + file);
  CHECK(again.exit_code == 0);
  CHECK(contains(again.out, "judged        3 frames"));
  CHECK(contains(again.out, "all 7 as recorded, bit for bit"));
  check_refused(recording.replay(file + " --cut 2:4"), "is there already");
  CHECK(run_dynfilter(recording.replay(file + " --cut 0:7 --force")).exit_code == 0);
  const CommandResult whole = run_dynfilter("replay " + file);
  CHECK(contains(whole.out, "all 19 as recorded, bit for bit"));
}

TEST_CASE("replay: wrong ranges are refused, and nothing is written") {
  const Recording recording("none");
  const fs::path file = recording.beside("case.dfr");
  const auto cut = [&](const std::string& range) {
    return recording.replay(file.string() + " --cut " + range);
  };
  check_refused(cut("2"), "expected two frame numbers, as --cut 40:60");
  check_refused(cut("a:b"), "expected two frame numbers");
  check_refused(cut("4:2"), "the first frame is after the last");
  check_refused(cut("6:8"), "--cut 6:8: the recording has only 8 frames");
  check_refused(cut("50:60"), "--cut begins at frame 50");
  check_refused(recording.replay("--cut 2:4"), "CASE");
  check_refused(recording.replay(file.string()), "--cut");
  CHECK(std::distance(fs::directory_iterator(file.parent_path()), {}) == 1);
}

TEST_CASE("replay: what is no recording, of another version or damaged is refused in one line") {
  const Recording recording("none");
  const std::string bytes = read_text(recording.file()), out = recording.beside("out").string();
  const std::string replay = recording.replay("--out '" + out + "'");
  std::string other = bytes;
  other[8] = 7;
  recording.write(other);
  check_refused(replay, "run.dfr: is a recording of format 7, and this dynfilter reads format 3");
  recording.write("timestamp x y z\n");
  check_refused(replay, "run.dfr: is no recording of dynfilter");
  recording.write(bytes.substr(0, 20));
  check_refused(replay, "run.dfr: the recording ends before its first record");
  std::string damaged = bytes;
  damaged[bytes.size() / 2] = static_cast<char>(damaged[bytes.size() / 2] ^ 1);
  recording.write(damaged);
  check_refused(replay, "is damaged: ");
  check_refused("replay /nowhere/run.dfr", "/nowhere/run.dfr: cannot be opened");
  CHECK(!fs::exists(out));
  recording.write(cut_within_last_images(bytes));
  const CommandResult cut_off = run_dynfilter(recording.replay());
  CHECK(cut_off.exit_code == 0);
  CHECK(contains(cut_off.out, "note: the recording was cut off at byte "));
  CHECK(contains(cut_off.out, "without their images"));
}

TEST_CASE("replay: a pipeline that was made in code needs the name of one") {
  dynfilter::PipelineConfig config;
  config.name = "mine";
  const Recording recording(std::move(config));
  check_refused(recording.replay(), "--pipeline replays with another pipeline");
  CHECK(run_dynfilter(recording.replay("--pipeline dynfilter")).exit_code == 0);
}
