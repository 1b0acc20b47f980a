// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/core/error.hpp>
#include <filesystem>
#include <initializer_list>
#include <ostream>
#include <string>
#include <system_error>

#include "interruption.hpp"
#include "io/atomic_file.hpp"
#include "io/atomic_folder.hpp"

namespace dynfilter::command {

/// The `--out` folder of a command. Its files appear together after commit(), or not at all.
/// It belongs to one command at a time.
class ResultsFolder {
 public:
  /// Throws IoError if the folder contains one of these results, unless they may be replaced, or if another
  /// program writes to it.
  ResultsFolder(const std::string& folder, bool force, std::initializer_list<const char*> results)
      : folder_((Interruption::watch(), folder)) {
    if (!force) check_free(folder, results);
  }

  /// The folder to write to until commit().
  const std::filesystem::path& path() const { return folder_.path(); }

  void write(const char* name, const std::string& text) const {
    io::write_file_atomically(path() / name, [&](std::ostream& out) { out << text; });
  }

  void commit() {
    Interruption::check();
    folder_.commit();
  }

 private:
  static void check_free(const std::string& folder, std::initializer_list<const char*> results) {
    std::error_code error;
    for (const char* name : results)
      if (std::filesystem::exists(std::filesystem::path(folder) / name, error))
        throw IoError("--out " + folder + ": holds the results of another run (" + name +
                      "): choose another folder, or replace them with --force");
  }

  io::AtomicFolder folder_;
};

}  // namespace dynfilter::command
