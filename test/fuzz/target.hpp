// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

/// Every target is one function. libFuzzer calls it, or replay_main.cpp with the files of a corpus.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace fuzz {

/// Ends the program with the property that does not hold.
[[noreturn]] inline void fail(const std::string& property, const std::string& detail = "") {
  std::fprintf(stderr, "property does not hold: %s%s%s\n", property.c_str(), detail.empty() ? "" : ": ",
               detail.c_str());
  std::abort();
}

/// Of dynfilter::Error. Written again, so that the limit cannot change unnoticed.
inline constexpr std::size_t kMostMessageBytes = 1024;

inline void require(bool holds, const char* property) {
  if (!holds) fail(property);
}

/// The presets and test/fuzz/pipelines, in the order of their names.
inline std::vector<std::string> pipeline_files(const std::string& source_dir) {
  std::vector<std::string> files;
  for (const char* folder : {"/examples/pipelines", "/test/fuzz/pipelines"})
    for (const auto& entry : std::filesystem::directory_iterator(source_dir + folder))
      if (entry.path().stem() != "oracle") files.push_back(entry.path().string());  // needs labels
  std::sort(files.begin(), files.end());
  return files;
}

/// A message is one line of a bounded length, as core/error.hpp promises.
inline void require_one_line(const char* message) {
  require(*message != '\0', "an error has a message");
  if (std::strlen(message) > kMostMessageBytes) fail("an error's message is short", message);
  for (const char* c = message; *c != '\0'; ++c)
    if (*c == '\n') fail("an error's message is one line", message);
}

}  // namespace fuzz
