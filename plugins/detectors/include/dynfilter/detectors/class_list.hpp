// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <dynfilter/core/error.hpp>
#include <filesystem>
#include <string>
#include <vector>

namespace dynfilter {

/// Class names of a network in its order, and the selection of them.
class ClassList {
 public:
  ClassList() = default;
  /// `first_label`: the network's number of the first name.
  /// `keep`: selected names; empty: all. Throws Error for a name that is not in the list.
  ClassList(std::vector<std::string> names, int first_label, const std::vector<std::string>& keep);

  /// Reads one name per line. A name may contain blanks. Throws IoError.
  static std::vector<std::string> from_file(const std::filesystem::path& path);

  int size() const { return static_cast<int>(names_.size()); }
  /// Whether the list has a name for it.
  bool has(int label) const { return label >= first_label_ && label - first_label_ < size(); }
  /// Throws Error for a label that is not in the list, because the list is of another network.
  void check(int label) const;
  /// Whether it is in the list and selected.
  bool kept(int label) const { return has(label) && kept_[index(label)]; }
  /// Of a label that is in the list.
  const std::string& name(int label) const { return names_[index(label)]; }

 private:
  std::size_t index(int label) const { return static_cast<std::size_t>(label - first_label_); }

  std::vector<std::string> names_;
  int first_label_ = 0;
  std::vector<bool> kept_;
};

}  // namespace dynfilter
