// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "layering/include_check.hpp"

namespace layering {

/// What include/dynfilter consists of: paths relative to it, and their texts.
using House = std::map<std::string, std::string>;

inline House house_at(const std::filesystem::path& include_dynfilter) {
  House house;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(include_dynfilter))
    if (entry.is_regular_file())
      house[entry.path().lexically_relative(include_dynfilter).generic_string()] = read_text(entry.path());
  return house;
}

inline std::size_t line_count(const std::string& text) {
  return static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
}

/// Files and their lines.
struct Size {
  std::size_t files = 0, lines = 0;
};
inline Size size_of(const House& house) {
  Size size;
  for (const auto& [path, text] : house) ++size.files, size.lines += line_count(text);
  return size;
}

/// The headers of the house that a compiled library's caller reads with `header`, itself included.
inline House reached_from(const House& house, const std::string& header) {
  House seen;
  std::vector<std::string> open{header};
  while (!open.empty()) {
    const std::string path = open.back();
    open.pop_back();
    const auto at = house.find(path);
    if (at == house.end() || contains(path, "-inl.hpp") || !seen.insert(*at).second) continue;
    for (const std::string& name : includes_of(at->second))
      if (starts_with(name, "dynfilter/")) open.push_back(name.substr(10));
  }
  return seen;
}

/// "filters/detail/x-inl.hpp" and "filters/detail/x.hpp" -> "filters/x.hpp".
inline std::string unit_of(std::string path) {
  for (const std::string& part : {std::string("detail/"), std::string("-inl")}) {
    const std::size_t at = path.find(part);
    if (at != std::string::npos) path.erase(at, part.size());
  }
  return path;
}

/// Rooms whose headers serve several others.
inline bool is_shared(const std::string& folder) {
  static const std::set<std::string> folders{"core",    "config", "correspondence", "geometry",
                                             "cluster", "late",   "evidence"};
  return folders.count(folder) != 0;
}

/// Who uses a header of a shared room at last, perhaps through other shared headers: filters, or whole other
/// rooms.
inline std::set<std::string> users_of(const House& house, const std::string& header) {
  std::set<std::string> users, seen;
  std::vector<std::string> open{header};
  while (!open.empty()) {
    const std::string next = open.back();
    open.pop_back();
    if (!seen.insert(next).second) continue;
    for (const auto& [path, text] : house) {
      const std::string user = unit_of(path), room = folder_of(path);
      if (user == next || !contains(text, "#include <dynfilter/" + next + ">")) continue;
      if (is_shared(room))
        open.push_back(user);
      else
        users.insert(room == "filters" ? user : room + "/");
    }
  }
  return users;
}

/// Headers of shared rooms that only one filter uses: they belong beside it.
inline std::vector<std::string> faults_of_sharing(const House& house) {
  std::vector<std::string> faults;
  for (const auto& [path, text] : house) {
    if (!is_shared(folder_of(path)) || path != unit_of(path)) continue;
    const std::set<std::string> users = users_of(house, path);
    if (users.size() == 1 && starts_with(*users.begin(), "filters/"))
      faults.push_back(path + ": only " + *users.begin() + " uses it");
  }
  return faults;
}

/// Rooms below pipeline/ keep no time and no memory of stages.
inline std::vector<std::string> faults_of_clocks(const House& house) {
  static const std::set<std::string> below{"core", "config",   "correspondence", "geometry", "cluster",
                                           "late", "evidence", "motion",         "filters"};
  std::vector<std::string> faults;
  for (const auto& [path, text] : house)
    if (below.count(folder_of(path)) != 0)
      for (const std::string& name : includes_of(text))
        if (name == "chrono" || name == "ctime" || starts_with(name, "dynfilter/pipeline/"))
          faults.push_back(path + ": includes <" + name + ">");
  return faults;
}

/// Units (a header and the file of its functions) that are too small to be found: they belong to their
/// neighbour.
inline std::vector<std::string> faults_of_small_units(const House& house, std::size_t least_lines,
                                                      const std::set<std::string>& exceptions) {
  std::vector<std::string> faults;
  for (const auto& [path, text] : house) {
    if (contains(path, "-inl.hpp") || path.find(".hpp") == std::string::npos || exceptions.count(path) != 0)
      continue;
    const auto bodies = house.find(bodies_of(path));
    const std::size_t lines = line_count(text) + (bodies == house.end() ? 0 : line_count(bodies->second));
    if (lines < least_lines) faults.push_back(path + ": " + std::to_string(lines) + " lines");
  }
  return faults;
}

}  // namespace layering
