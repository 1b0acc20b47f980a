// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <dynfilter/core/error.hpp>
#include <filesystem>
#include <string>
#include <system_error>
#include <vector>

namespace dynfilter::command {

/// A pipeline or a sequence of a comparison: the name in its rows, and how the user named it.
struct NamedSource {
  std::string name, source;
};

/// Rows of a comparison are told apart by names. Throws Error if two are the same.
inline void check_distinct(const std::vector<NamedSource>& all) {
  for (std::size_t i = 0; i < all.size(); ++i)
    for (std::size_t k = i + 1; k < all.size(); ++k) {
      if (all[i].name != all[k].name) continue;
      if (all[i].source == all[k].source) throw Error("`" + all[i].source + "` is given twice");
      throw Error("`" + all[i].source + "` and `" + all[k].source + "` are both named `" + all[i].name +
                  "`: their rows could not be told apart; rename one");
    }
}

namespace detail_names {

inline std::filesystem::path whole_path(const std::string& folder) {
  std::error_code error;
  const std::filesystem::path whole = std::filesystem::weakly_canonical(folder, error);
  const std::filesystem::path path = (error ? std::filesystem::path(folder) : whole).lexically_normal();
  return path.has_filename() ? path : path.parent_path();
}

/// The last `parts` parts: "bonn/walking".
inline std::string end_of(const std::filesystem::path& path, std::size_t parts) {
  std::filesystem::path end = path.filename(), rest = path.parent_path();
  for (std::size_t k = 1; k < parts && rest.has_filename(); ++k, rest = rest.parent_path())
    end = rest.filename() / end;
  return end.generic_string();
}

}  // namespace detail_names

/// Names of folders: the last part, and as many parents as tell it from the others.
/// Throws Error if a folder is given twice, under whatever paths.
inline std::vector<std::string> distinct_names(const std::vector<std::string>& folders) {
  std::vector<std::filesystem::path> paths;
  for (const std::string& folder : folders) paths.push_back(detail_names::whole_path(folder));
  std::vector<std::string> names;
  for (std::size_t i = 0; i < paths.size(); ++i) {
    std::size_t parts = 1;
    for (std::size_t k = 0; k < paths.size(); ++k) {
      if (k == i) continue;
      if (paths[k] == paths[i])
        throw Error(folders[i] == folders[k]
                        ? "`" + folders[i] + "` is given twice"
                        : "`" + folders[i] + "` and `" + folders[k] + "` are one folder");
      while (detail_names::end_of(paths[i], parts) == detail_names::end_of(paths[k], parts)) ++parts;
    }
    names.push_back(detail_names::end_of(paths[i], parts));
  }
  return names;
}

}  // namespace dynfilter::command
