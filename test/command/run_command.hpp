// SPDX-License-Identifier: MIT
#pragma once

#include <sys/wait.h>

#include <algorithm>
#include <cstdlib>
#include <string>

#include "doctest/doctest.h"
#include "io/tum_folder.hpp"

namespace dynfilter_test {

struct CommandResult {
  int exit_code = -1;
  std::string out, err;
};

/// Runs the built `dynfilter` with these arguments (shell syntax).
inline CommandResult run_dynfilter(const std::string& arguments) {
  const TemporaryFolder folder;
  const std::string out = (folder.path() / "out").string(), err = (folder.path() / "err").string();
  const int status = std::system(("'" DYNFILTER_COMMAND "' " + arguments + " >" + out + " 2>" + err).c_str());
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, read_text(out), read_text(err)};
}

/// Checks for bad usage or input: exit code 2, empty stdout, one line on stderr with this reason.
inline void check_refused(const std::string& arguments, const std::string& reason) {
  CAPTURE(arguments);
  const CommandResult result = run_dynfilter(arguments);
  CAPTURE(result.err);
  CHECK(result.exit_code == 2);
  CHECK(result.out.empty());
  CHECK(std::count(result.err.begin(), result.err.end(), '\n') == 1);
  CHECK(result.err.rfind("dynfilter: ", 0) == 0);
  CHECK(result.err.find(reason) != std::string::npos);
}

inline bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

/// The number after `"key": `, after `section` begins in JSON text.
inline double number_in(const std::string& json, const std::string& section, const std::string& key) {
  const auto from = json.find(section);
  REQUIRE(from != std::string::npos);
  const auto at = json.find("\"" + key + "\": ", from);
  REQUIRE(at != std::string::npos);
  return std::atof(json.c_str() + at + key.size() + 4);
}

}  // namespace dynfilter_test
