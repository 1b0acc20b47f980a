// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

namespace layering {

/// What each folder of include/dynfilter may include besides itself, in the order in which data flows.
/// CONTRIBUTING.md has the same table, which the test writes.
using Rooms = std::vector<std::pair<std::string, std::set<std::string>>>;
inline const Rooms& rooms() {
  using Folders = std::set<std::string>;
  const auto and_also = [](Folders folders, const Folders& more) {
    folders.insert(more.begin(), more.end());
    return folders;
  };
  static const Folders basics{"core", "config"};
  static const Folders measures = and_also(basics, {"correspondence", "geometry", "cluster"});
  static const Folders evidence = and_also(measures, {"late", "evidence"});
  static const Folders judges = and_also(evidence, {"motion", "filters"});
  static const Folders pipelines = and_also(judges, {"pipeline"});
  static const Rooms table{
      {"core", {}},
      {"config", {"core"}},
      {"correspondence", basics},
      {"geometry", {"core"}},
      {"cluster", {"core"}},
      {"late", and_also(basics, {"correspondence", "geometry"})},
      {"evidence", and_also(measures, {"late"})},
      {"motion", and_also(basics, {"geometry", "cluster"})},
      {"filters", and_also(evidence, {"motion"})},
      {"pipeline", judges},
      {"semantic", measures},
      {"plugin", and_also(judges, {"semantic"})},
      {"keyframe", basics},
      {"mapping", measures},
      {"hosts", and_also(pipelines, {"semantic", "plugin"})},
      {"facade", {}},                                      // C++11 and C: not even core/
      {"facade/detail", and_also(pipelines, {"facade"})},  // sources of the shared library
      {"testing", {"core", "correspondence", "evidence"}},
      {"", and_also(pipelines, {"plugin"})},
  };
  return table;
}

inline const std::map<std::string, std::set<std::string>>& allowed_folders() {
  static const std::map<std::string, std::set<std::string>> table(rooms().begin(), rooms().end());
  return table;
}

/// The same for CONTRIBUTING.md.
inline std::string table_of_rooms() {
  std::string text = "| folder | may include |\n|---|---|\n";
  for (const auto& [folder, below] : rooms()) {
    std::string names;
    for (const auto& [other, unused] : rooms())
      if (below.count(other) != 0) names += (names.empty() ? "`" : " `") + other + "`";
    text += "| " + (folder.empty() ? "`dynfilter.hpp`" : "`" + folder + "`") + " | " +
            (names.empty() ? "no other folder" : names) + " |\n";
  }
  return text;
}

/// External headers that only these folders may include.
inline const std::map<std::string, std::string>& gatekeepers() {
  static const std::map<std::string, std::string> table{
      {"flann/", "filters"}, {"ceres/", "geometry"},   {"opencv2/dnn", "plugins"},
      {"png.h", "plugins"},  {"jpeglib.h", "plugins"}, {"dlfcn.h", "plugin pipeline facade/detail"}};
  return table;
}

inline bool starts_with(const std::string& text, const std::string& start) {
  return text.compare(0, start.size(), start) == 0;
}

/// The names between <> or "" of the #include lines of a text, in order.
inline std::vector<std::string> includes_of(const std::string& text) {
  std::vector<std::string> names;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    line.erase(std::remove_if(line.begin(), line.end(), [](char c) { return c == ' ' || c == '\t'; }),
               line.end());
    if (!starts_with(line, "#include")) continue;
    const std::size_t begin = line.find_first_of("<\""), end = line.find_first_of(">\"", begin + 1);
    if (begin != std::string::npos && end != std::string::npos)
      names.push_back(line.substr(begin + 1, end - begin - 1));
  }
  return names;
}

/// "core/camera.hpp" -> "core", "version.hpp" -> "".
inline std::string folder_of(const std::string& path) {
  const std::size_t slash = path.find('/');
  return slash == std::string::npos ? "" : path.substr(0, slash);
}

/// "io/ply.hpp" -> "io/detail/ply-inl.hpp", which contains the header's functions.
inline std::string bodies_of(const std::string& header) {
  const std::size_t name = header.rfind('/') + 1;
  return header.substr(0, name) + "detail/" + header.substr(name, header.size() - name - 4) + "-inl.hpp";
}

inline bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

/// Faults in how a header and the file of its functions include each other, and others' details.
inline std::vector<std::string> faults_of_bodies(const std::string& path, const std::string& text) {
  std::vector<std::string> faults;
  const std::vector<std::string> names = includes_of(text);
  for (const std::string& name : names) {
    if (!contains(name, "/detail/")) continue;
    if (folder_of(name.substr(10)) != folder_of(path))
      faults.push_back("includes <" + name + "> of another folder");
    if (contains(name, "-inl.hpp") && name != "dynfilter/" + bodies_of(path))
      faults.push_back("includes <" + name + ">, which only its own header includes");
  }
  if (contains(path, "-inl.hpp") &&
      (names.empty() || "dynfilter/" + path != "dynfilter/" + bodies_of(names.front().substr(10))))
    faults.push_back("does not include its own header first");
  return faults;
}

/// Folders that decide on features, or make the scenes by which decisions are compared.
inline bool decides(const std::string& folder) {
  static const std::set<std::string> folders{"core",    "config",   "correspondence", "geometry",
                                             "cluster", "late",     "evidence",       "motion",
                                             "filters", "pipeline", "testing"};
  return folders.count(folder) != 0;
}

/// Code whose results or crashes depend on the processor, the compiler or the C library.
inline std::vector<std::string> faults_of_portability(const std::string& path, const std::string& text) {
  const std::string folder = folder_of(path);
  static const std::regex vectors("_mm[0-9]*_|vector_size|mmintrin|arm_neon|__builtin_ia32");
  static const std::regex aligned(
      "_mm[0-9]*_(load|store|stream)_|aligned\\s*\\(|\\baligned__|assume_aligned");
  static const std::regex inexact(
      "std::(exp|exp2|expm1|log|log2|log10|log1p|pow|sin|cos|tan|asin|acos|atan|atan2|sinh|cosh|tanh|cbrt|"
      "hypot|erf|"
      "erfc|tgamma|lgamma|fma)[fl]?\\(|AngleAxis|Rotation2D|computeDirect|eulerAngles|slerp");
  std::vector<std::string> faults;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    line = line.substr(0, line.find("//"));
    if (std::regex_search(line, aligned))
      faults.push_back("states an alignment: use core/simd.hpp: " + line);
    else if (path != "core/simd.hpp" && std::regex_search(line, vectors))
      faults.push_back("has vectors or instructions of its own: use core/simd.hpp: " + line);
    if (decides(folder) && std::regex_search(line, inexact))
      faults.push_back("takes a function whose bits depend on the processor: use core/portable_math.hpp: " +
                       line);
  }
  return faults;
}

/// Faults of a header, one per line. `path` is relative to include/dynfilter.
inline std::vector<std::string> complaints_about(const std::string& path, const std::string& text) {
  std::vector<std::string> complaints;
  const auto complain = [&](const std::string& what) { complaints.push_back(path + ": " + what); };
  const std::string folder = starts_with(path, "facade/detail/") ? "facade/detail" : folder_of(path);
  const auto allowed = allowed_folders().find(folder);
  if (allowed == allowed_folders().end()) {
    complain("the folder is not in the table of test/layering/include_check.hpp");
    return complaints;
  }
  if (!starts_with(text, "// SPDX-License-Identifier: MIT\n#pragma once\n"))
    complain("does not begin with the licence line and #pragma once");
  for (const std::string& fault : faults_of_bodies(path, text)) complain(fault);
  for (const std::string& fault : faults_of_portability(path, text)) complain(fault);
  for (const std::string& name : includes_of(text)) {
    if (starts_with(name, "dynfilter/")) {
      const std::string target = folder_of(name.substr(10));
      if (!target.empty() && target != folder && allowed->second.count(target) == 0)
        complain("includes <" + name + ">, but " + (folder.empty() ? "the top" : folder + "/") +
                 " may not use " + target + "/");
      if (name == "dynfilter/dynfilter.hpp") complain("includes the header that is for users only");
    } else if (name.find(".hpp") != std::string::npos && !starts_with(name, "opencv2/")) {
      complain("includes <" + name + ">: write <dynfilter/...> in full");
    } else if (name == "opencv2/opencv.hpp") {
      complain("includes all of OpenCV: include the narrow headers");
    }
    for (const auto& [start, keeper] : gatekeepers())
      if (starts_with(name, start) && !contains(" " + keeper + " ", " " + folder + " "))
        complain("includes <" + name + ">, which is for " + keeper + "/");
  }
  return complaints;
}

inline std::string read_text(const std::filesystem::path& file) {
  std::ifstream in(file);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

/// Faults of all headers under include/dynfilter, sorted.
inline std::vector<std::string> complaints_about_tree(const std::filesystem::path& include_dynfilter) {
  std::vector<std::string> complaints;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(include_dynfilter)) {
    if (!entry.is_regular_file()) continue;
    const std::string path = entry.path().lexically_relative(include_dynfilter).generic_string();
    const std::string text = read_text(entry.path());
    for (std::string& line : complaints_about(path, text)) complaints.push_back(std::move(line));
    if (contains(path, "/detail/")) continue;
    const std::string bodies = bodies_of(path);
    const std::string last = "\n#ifdef DYNFILTER_HEADER_ONLY\n#include <dynfilter/" + bodies + ">\n#endif\n";
    if (std::filesystem::exists(include_dynfilter / bodies) && !contains(text, last))
      complaints.push_back(path + ": does not include " + bodies + " when header-only");
  }
  std::sort(complaints.begin(), complaints.end());
  return complaints;
}

}  // namespace layering
