// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/core/error.hpp>
#include <filesystem>
#include <initializer_list>
#include <string>
#include <system_error>

namespace dynfilter::command {

/// Throws IoError if the `--out` folder contains results, unless they may be replaced.
inline void check_free(const std::string& folder, bool force, std::initializer_list<const char*> results) {
  if (folder.empty() || force) return;
  std::error_code error;
  for (const char* name : results)
    if (std::filesystem::exists(std::filesystem::path(folder) / name, error))
      throw IoError("--out " + folder + ": holds the results of another run (" + name +
                    "): choose another folder, or replace them with --force");
}

}  // namespace dynfilter::command
