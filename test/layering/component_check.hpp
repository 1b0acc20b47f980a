// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "layering/include_check.hpp"

namespace layering {

/// A call of dynfilter_component in cmake/components.cmake.
struct Component {
  std::set<std::string> components, opencv, headers;
};
using Components = std::map<std::string, Component>;

/// "${name}" -> the words that set(name ...) and list(APPEND name ...) give it; other words stay.
inline std::vector<std::string> expanded(const std::string& cmake, const std::string& word) {
  if (!starts_with(word, "${")) return {word};
  const std::string variable = word.substr(2, word.size() - 3);
  std::vector<std::string> values;
  for (const std::string& start : {"set(" + variable + " ", "list(APPEND " + variable + " "}) {
    const std::size_t at = cmake.find(start);
    if (at == std::string::npos) continue;
    std::istringstream words(cmake.substr(at + start.size(), cmake.find(')', at) - at - start.size()));
    for (std::string value; words >> value;) values.push_back(value);
  }
  return values;
}

/// The components of a CMake file, by name.
inline Components components_of(const std::string& cmake) {
  Components all;
  const std::string call = "\ndynfilter_component(", nested = "\n  dynfilter_component(";
  for (const std::string& start : {call, nested}) {
    for (std::size_t at = cmake.find(start); at != std::string::npos; at = cmake.find(start, at + 1)) {
      const std::size_t begin = at + start.size();
      std::istringstream words(cmake.substr(begin, cmake.find(')', begin) - begin));
      std::string name, word, key;
      words >> name;
      Component& component = all[name];
      while (words >> word) {
        if (word == "COMPONENTS" || word == "OPENCV" || word == "LINK" || word == "HEADERS" ||
            word == "WITHOUT" || word == "PARTS")
          key = word;
        else if (key == "COMPONENTS")
          component.components.insert(word);
        else if (key == "OPENCV" || key == "HEADERS")
          for (const std::string& value : expanded(cmake, word))
            (key == "OPENCV" ? component.opencv : component.headers).insert(value);
      }
    }
  }
  return all;
}

/// What a component links, directly and through others.
inline std::set<std::string> linked(const Components& all, const std::string& name) {
  std::set<std::string> seen;
  std::vector<std::string> open{name};
  while (!open.empty()) {
    const std::string next = open.back();
    open.pop_back();
    for (const std::string& below : all.at(next).components)
      if (seen.insert(below).second) open.push_back(below);
  }
  return seen;
}

/// "detail/x-inl.hpp" and "x.hpp" of a folder -> "folder/x".
inline std::string stem_of(std::string path) {
  for (const std::string& part : {std::string("/detail"), std::string("-inl.hpp"), std::string(".hpp")}) {
    const std::size_t at = path.find(part);
    if (at != std::string::npos) path.erase(at, part.size());
  }
  return path;
}

/// The component that a header belongs to: its folder, unless another component lists it.
inline std::string component_of(const Components& all, const std::string& path) {
  for (const auto& [name, component] : all)
    if (component.headers.count(stem_of(path))) return name;
  return folder_of(path);
}

/// A text without what it includes only beside a component that need not be there.
inline std::string without_optional(std::string text) {
  for (std::size_t at; (at = text.find("#ifdef DYNFILTER_HAS_")) != std::string::npos;)
    text.erase(at, text.find("#endif", at) - at);
  return text;
}

/// The folders and the OpenCV modules that a component's headers include.
struct Includes {
  std::set<std::string> components, opencv;
};

/// Faults of the components whose headers are `files` (path -> text), one per line.
/// A header without functions of its own needs no library.
inline std::vector<std::string> faults_of_components(const Components& all,
                                                     const std::map<std::string, std::string>& files) {
  std::map<std::string, Includes> includes;
  for (const auto& [path, text] : files) {
    const std::string self = component_of(all, path);
    if (!all.count(self)) continue;
    for (const std::string& name : includes_of(without_optional(text))) {
      if (starts_with(name, "opencv2/")) {
        const std::string module = name.substr(8);
        includes[self].opencv.insert(module.substr(0, module.find_first_of("/.")));
      } else if (starts_with(name, "dynfilter/")) {
        const std::string header = name.substr(10), other = component_of(all, header);
        if (other == self || !all.count(other)) continue;
        if (files.count(bodies_of(header)) || linked(all, self).count(other))
          includes[self].components.insert(other);
      }
    }
  }
  std::vector<std::string> faults;
  for (const auto& [name, component] : all) {
    const std::set<std::string> below = linked(all, name);
    for (const std::string& used : includes[name].components)
      if (!below.count(used))
        faults.push_back(name + " includes headers of " + used + " and does not link it");
    for (const std::string& link : component.components)
      if (!includes[name].components.count(link))
        faults.push_back(name + " links " + link + " and includes nothing of it");
    std::set<std::string> modules = component.opencv;
    for (const std::string& other : below)
      modules.insert(all.at(other).opencv.begin(), all.at(other).opencv.end());
    for (const std::string& used : includes[name].opencv)
      if (!modules.count(used))
        faults.push_back(name + " includes opencv2/" + used + " and does not link it");
    for (const std::string& module : component.opencv)
      if (!includes[name].opencv.count(module))
        faults.push_back(name + " links opencv_" + module + " and includes nothing of it");
  }
  return faults;
}

}  // namespace layering
