// SPDX-License-Identifier: MIT
#include "run_command.hpp"

using namespace dynfilter_test;
namespace fs = std::filesystem;

namespace {

/// With a redirection.
CommandResult dynfilter_to(const std::string& redirection, const std::string& arguments) {
  const TemporaryFolder folder;
  const std::string err = (folder.path() / "err").string();
  const int status =
      std::system(("'" DYNFILTER_COMMAND "' " + arguments + " 2>'" + err + "' " + redirection).c_str());
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, "", read_text(err)};
}

const std::string kReplacement = "\xEF\xBF\xBD";  // U+FFFD in UTF-8

}  // namespace

TEST_CASE("standard output that cannot be written is a failure, and one line says so") {
  for (const char* redirection : {">/dev/full", ">&-"})
    for (const std::string arguments :
         {"filters", "filters --json", "check rts_slam", "--help", "--version"}) {
      CAPTURE(redirection);
      CAPTURE(arguments);
      const CommandResult result = dynfilter_to(redirection, arguments);
      CHECK(result.exit_code == 1);
      CHECK(result.err ==
            "dynfilter: standard output cannot be written: it is closed, or its device is full\n");
    }
  CHECK(dynfilter_to(">/dev/null", "filters").exit_code == 0);
}

TEST_CASE("bytes that are not UTF-8 lose no results") {
  const TemporaryFolder folder;
  const fs::path odd = folder.path() / "caf\xE9";
  fs::create_directories(odd);
  write_text(odd / "p.yaml",
             "%YAML:1.0\n---\npipeline:\n  name: \"na\xFFme\"\n  before_pose:\n    - epipolar\n");
  const CommandResult check = run_dynfilter("check '" + (odd / "p.yaml").string() + "' --json");
  CHECK(check.exit_code == 0);
  CHECK(contains(check.out, "caf" + kReplacement + "/p.yaml"));
  CHECK(contains(check.out, "\"pipeline\": \"na" + kReplacement + "me\""));

  // A provider with an error message in Latin-1, and a sequence in a folder with such a name.
  write_text(odd / "d.yaml", "%YAML:1.0\n---\ndetector:\n  type: process\n  command: [ /bin/sh, \"" +
                                 (odd / "d.sh").string() + "\" ]\n  restarts: 100\n");
  write_text(odd / "d.sh",
             "echo dynfilter-provider 1\nread line\nhead -c 576 > /dev/null\n"
             "printf 'error d\\351faut\\n'\n");
  write_tum_folder(odd / "sequence", 3);  // too small to be tracked
  const CommandResult run =
      run_dynfilter("run '" + (odd / "sequence").string() + "' --pipeline none --detector '" +
                    (odd / "d.yaml").string() + "' --json --out '" + (odd / "out").string() + "'");
  CAPTURE(run.err);
  CHECK(run.exit_code == 1);
  CHECK(contains(run.err, "no frame could be tracked"));
  CHECK(contains(run.out, "d" + kReplacement + "faut"));
  CHECK(contains(read_text(odd / "out/summary.json"), "d" + kReplacement + "faut"));
}
