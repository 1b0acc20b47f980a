// SPDX-License-Identifier: MIT
#include <spawn.h>
#include <sys/stat.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <fstream>
#include <functional>
#include <thread>
#include <vector>

#include "run_command.hpp"
#include "walking.hpp"

using namespace dynfilter_test;
namespace fs = std::filesystem;

namespace {

constexpr std::chrono::seconds kPatience{60};  // on a busy machine

/// The command in the background.
class Background {
 public:
  Background(const fs::path& folder, const std::string& arguments) : err_(folder / "err") {
    const std::string line =
        "exec '" DYNFILTER_COMMAND "' " + arguments + " >/dev/null 2>'" + err_.string() + "'";
    const char* argv[] = {"/bin/sh", "-c", line.c_str(), nullptr};
    REQUIRE(::posix_spawn(&pid_, argv[0], nullptr, nullptr, const_cast<char**>(argv), environ) == 0);
  }
  Background(const Background&) = delete;
  Background& operator=(const Background&) = delete;
  ~Background() {
    if (pid_ > 0) end_by(SIGKILL);
  }

  void wait_until(const std::function<bool()>& reached) const {
    const auto end = std::chrono::steady_clock::now() + kPatience;
    while (!reached() && std::chrono::steady_clock::now() < end)
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    REQUIRE(reached());
  }
  /// Returns the signal that ended it, or 0.
  int end_by(int signal) {
    ::kill(pid_, signal);
    int status = 0;
    ::waitpid(pid_, &status, 0);
    pid_ = -1;
    return WIFSIGNALED(status) ? WTERMSIG(status) : 0;
  }
  std::string err() const { return read_text(err_); }

 private:
  fs::path err_;
  pid_t pid_ = -1;
};

/// `.out.partial-01234567`, or nothing.
fs::path partial_of(const fs::path& out) {
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(out.parent_path(), error))
    if (entry.path().filename().string().rfind("." + out.filename().string() + ".partial-", 0) == 0)
      return entry.path();
  return {};
}

/// Hidden entries of a folder and of all folders in it.
std::vector<std::string> hidden_in(const fs::path& folder) {
  std::vector<std::string> hidden;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.path().filename().string().front() == '.') hidden.push_back(entry.path().string());
  return hidden;
}

/// A detector that takes 0.2 s for an image: the command is still busy when a signal comes.
std::string slow_detector(const fs::path& folder) {
  write_text(folder / "slow.sh",
             "echo dynfilter-provider 1\nwhile read word id time width height channels; do\n"
             "head -c $((width * height * channels)) > /dev/null\nsleep 0.2\necho end\ndone\n");
  write_text(folder / "slow.yaml", "%YAML:1.0\n---\ndetector:\n  type: process\n  command: [ /bin/sh, \"" +
                                       (folder / "slow.sh").string() + "\" ]\n");
  return " --detector '" + (folder / "slow.yaml").string() + "' ";
}

/// A detector that never answers, or that never says that it has started. It writes its number to `pid`.
std::string hung_detector(const fs::path& folder, bool starts) {
  write_text(folder / "hung.sh", "echo $$ > '" + (folder / "pid").string() + "'\n" +
                                     (starts ? "echo dynfilter-provider 1\n" : "") + "exec sleep 1000\n");
  write_text(folder / "hung.yaml",
             "%YAML:1.0\n---\ndetector:\n  type: process\n  timeout_s: 900\n  start_timeout_s: 900\n"
             "  command: [ /bin/sh, \"" +
                 (folder / "hung.sh").string() + "\" ]\n");
  return " --detector '" + (folder / "hung.yaml").string() + "' ";
}

bool is_alive(long pid) {
  std::ifstream in("/proc/" + std::to_string(pid) + "/stat");
  std::string number, name, state;
  return in >> number >> name >> state && state != "Z" && state != "X";
}

std::string walking() {
  return "'" + Walking::shared().folder().string() + "' ";
}

void write_manifest(const fs::path& file) {
  write_text(file,
             "%YAML:1.0\n---\ndownload: \"from nowhere\"\npipelines: [none, rts_slam, dynfilter, ds_slam]\n"
             "sequences:\n  - { name: walking, folder: walking }\n");
}

}  // namespace

TEST_CASE("a signal ends a command that writes a folder, and nothing incomplete remains") {
  for (const int signal : {SIGINT, SIGTERM}) {
    const TemporaryFolder folder;
    const fs::path out = folder.path() / "out";
    const std::string slow = slow_detector(folder.path()), to = "--out '" + out.string() + "'";
    for (const std::string& arguments :
         {"run " + walking() + "--pipeline none" + slow + to,
          "compare " + walking() + "--pipelines none" + slow + to, "detect " + walking() + slow + to,
          "masks " + walking() + "'" + out.string() + "'" + slow,
          "synth walking_static '" + out.string() + "' --frames 5000"}) {
      CAPTURE(arguments);
      Background command(folder.path(), arguments);
      command.wait_until([&] { return !partial_of(out).empty(); });
      CHECK(command.end_by(signal) == signal);
      CHECK(command.err().rfind("dynfilter: stopped by ", 0) == 0);
      CHECK_FALSE(fs::exists(out));
      CHECK(hidden_in(folder.path()).empty());
    }
  }
}

TEST_CASE("a signal ends a command within half a second while it waits for a detector") {
  using Clock = std::chrono::steady_clock;
  for (const char* command : {"run", "detect"}) {
    for (const bool starts : {false, true}) {
      CAPTURE(command);
      CAPTURE(starts);
      std::chrono::duration<double> quickest{1e9};
      for (int k = 0; k < 5 && quickest.count() > 0.5; ++k) {  // the machine may be busy
        const TemporaryFolder folder;
        const std::string pipeline = std::string(command) == "run" ? "--pipeline none " : "";
        Background running(folder.path(), command + (" " + walking()) + pipeline +
                                              hung_detector(folder.path(), starts) + "--out '" +
                                              (folder.path() / "out").string() + "'");
        long pid = 0;
        running.wait_until([&] { return bool(std::ifstream(folder.path() / "pid") >> pid); });
        std::this_thread::sleep_for(std::chrono::milliseconds(200));
        const Clock::time_point sent = Clock::now();
        CHECK(running.end_by(SIGINT) == SIGINT);
        quickest = std::min<std::chrono::duration<double>>(quickest, Clock::now() - sent);
        CHECK(running.err().rfind("dynfilter: stopped by ", 0) == 0);
        CHECK(hidden_in(folder.path()).empty());
        CHECK_FALSE(is_alive(pid));
      }
      CHECK(quickest.count() < 0.5);
    }
  }
}

TEST_CASE("a signal leaves the results of an earlier run as they were") {
  const TemporaryFolder folder;
  const fs::path out = folder.path() / "out";
  const std::string run = "run " + walking() + "--pipeline none --out '" + out.string() + "' ";
  REQUIRE(run_dynfilter(run + "--frames 2").exit_code == 0);
  const std::string before = read_text(out / "summary.json");
  {
    Background command(folder.path(), run + "--force" + slow_detector(folder.path()));
    command.wait_until([&] { return !partial_of(out).empty(); });
    CHECK(command.end_by(SIGTERM) == SIGTERM);
  }
  CHECK(read_text(out / "summary.json") == before);
  CHECK(hidden_in(folder.path()).empty());
}

TEST_CASE("map: a signal leaves no files") {
  const TemporaryFolder folder;
  const fs::path map = folder.path() / "map.ply";
  Background command(folder.path(),
                     "map " + walking() + "'" + (Walking::shared().folder() / "groundtruth.txt").string() +
                         "' --pipeline none --map '" + map.string() + "'" + slow_detector(folder.path()));
  command.wait_until([&] { return fs::exists(folder.path() / ".map.ply.lock"); });
  check_refused("map " + walking() + "'" + (Walking::shared().folder() / "groundtruth.txt").string() +
                    "' --pipeline none --map '" + map.string() + "'",
                "map.ply: another program is writing here");
  CHECK(command.end_by(SIGTERM) == SIGTERM);
  CHECK_FALSE(fs::exists(map));
  CHECK(hidden_in(folder.path()).empty());
}

TEST_CASE("bench: a signal removes the run that was not complete, and the next call continues") {
  const TemporaryFolder folder;
  const fs::path out = folder.path() / "out";
  write_manifest(folder.path() / "one.yaml");
  const std::string bench = "bench '" + (folder.path() / "one.yaml").string() + "' --data '" +
                            Walking::shared().root().string() + "' --out '" + out.string() + "'";
  {
    Background command(folder.path(), bench);
    command.wait_until([&] { return fs::exists(out / "bench.json"); });
    check_refused(bench, "out: another program is writing here");
    CHECK(command.end_by(SIGTERM) == SIGTERM);
  }
  CHECK(hidden_in(folder.path()).empty());
  CHECK(run_dynfilter(bench + " --pipelines none").exit_code == 0);
  CHECK(fs::exists(out / "walking" / "none" / "summary.json"));
}

TEST_CASE("two commands into one folder: the second is refused, the first is not disturbed") {
  const TemporaryFolder folder;
  const fs::path out = folder.path() / "out";
  const std::string to = "--force --out '" + out.string() + "'";
  Background first(folder.path(), "run " + walking() + "--pipeline none" + slow_detector(folder.path()) + to);
  first.wait_until([&] { return !partial_of(out).empty(); });
  for (const std::string& second :
       {"run " + walking() + "--pipeline none " + to, "compare " + walking() + "--pipelines none " + to,
        "detect " + walking() + "--detector files " + to, "synth static_desk '" + out.string() + "'"}) {
    check_refused(second, "another program is writing here");
  }
  CHECK_FALSE(partial_of(out).empty());
  // Killed: what it leaves is removed by the next command.
  CHECK(first.end_by(SIGKILL) == SIGKILL);
  CHECK_FALSE(partial_of(out).empty());
  CHECK(run_dynfilter("run " + walking() + "--pipeline none --frames 2 " + to).exit_code == 0);
  CHECK(hidden_in(folder.path()).empty());
}

TEST_CASE("nohup: an ignored signal remains ignored") {
  const TemporaryFolder folder;
  const fs::path out = folder.path() / "out";
  const std::string run = "run " + walking() + "--pipeline none --frames 3 --out '" + out.string() + "'";
  const std::string line = "trap '' HUP; '" DYNFILTER_COMMAND "' " + run +
                           " >/dev/null & pid=$!; "
                           "until [ -e '" +
                           (folder.path() / ".out.lock").string() +
                           "' ]; do sleep 0.01; done; "
                           "kill -HUP $pid; wait $pid";
  CHECK(std::system(line.c_str()) == 0);
  CHECK(fs::exists(out / "summary.json"));
}
