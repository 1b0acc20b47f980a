// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <dynfilter/core/error.hpp>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

namespace dynfilter {

/// Class names of a network in its order, and the selection of them.
class ClassList {
 public:
  ClassList() = default;
  /// `first_label`: the network's number of the first name.
  /// `keep`: selected names; empty: all. Throws Error for a name that is not in the list.
  ClassList(std::vector<std::string> names, int first_label, const std::vector<std::string>& keep)
      : names_(std::move(names)), first_label_(first_label), kept_(names_.size(), keep.empty()) {
    for (const std::string& name : keep) {
      const auto it = std::find(names_.begin(), names_.end(), name);
      if (it == names_.end()) throw Error("keep: there is no class `" + name + "` in the class list");
      kept_[static_cast<std::size_t>(it - names_.begin())] = true;
    }
  }

  /// Reads one name per line. A name may contain blanks. Throws IoError.
  static std::vector<std::string> from_file(const std::filesystem::path& path) {
    std::ifstream in(path);
    if (!in) throw IoError(path.string() + ": cannot be read");
    std::vector<std::string> names;
    for (std::string line; std::getline(in, line);) {
      while (!line.empty() && (line.back() == '\r' || line.back() == ' ' || line.back() == '\t'))
        line.pop_back();
      names.push_back(line);
    }
    while (!names.empty() && names.back().empty()) names.pop_back();
    if (names.empty()) throw IoError(path.string() + ": expected a class name on each line");
    return names;
  }

  int size() const { return static_cast<int>(names_.size()); }
  bool has(int label) const { return label >= first_label_ && label - first_label_ < size(); }
  /// Throws Error for a label that is not in the list, because the list is of another network.
  void check(int label) const {
    if (!has(label))
      throw Error("its output has class " + std::to_string(label) + ", but the class list has " +
                  std::to_string(size()) + " names, from class " + std::to_string(first_label_) + " on");
  }
  bool kept(int label) const { return has(label) && kept_[index(label)]; }
  const std::string& name(int label) const { return names_[index(label)]; }

 private:
  std::size_t index(int label) const { return static_cast<std::size_t>(label - first_label_); }

  std::vector<std::string> names_;
  int first_label_ = 0;
  std::vector<bool> kept_;
};

}  // namespace dynfilter
