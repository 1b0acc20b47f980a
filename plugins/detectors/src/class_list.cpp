// SPDX-License-Identifier: MIT
#include <dynfilter/detectors/class_list.hpp>

#include <algorithm>
#include <dynfilter/config/text_lines.hpp>
#include <dynfilter/core/error.hpp>
#include <dynfilter/core/printable_text.hpp>
#include <utility>

namespace dynfilter {

ClassList::ClassList(std::vector<std::string> names, int first_label, const std::vector<std::string>& keep)
    : names_(std::move(names)), first_label_(first_label), kept_(names_.size(), keep.empty()) {
  for (const std::string& name : keep) {
    const auto it = std::find(names_.begin(), names_.end(), name);
    if (it == names_.end()) throw Error("keep: there is no class `" + name + "` in the class list");
    kept_[static_cast<std::size_t>(it - names_.begin())] = true;
  }
}

std::vector<std::string> ClassList::from_file(const std::filesystem::path& path) {
  io::LineReader reader(path);
  std::vector<std::string> names;
  for (std::string line; reader.next(line);) {
    while (!line.empty() && (line.back() == '\r' || line.back() == ' ' || line.back() == '\t'))
      line.pop_back();
    names.push_back(without_controls(line));
  }
  while (!names.empty() && names.back().empty()) names.pop_back();
  if (names.empty()) throw IoError(path.string() + ": expected a class name on each line");
  return names;
}

void ClassList::check(int label) const {
  if (!has(label))
    throw Error("its output has class " + std::to_string(label) + ", but the class list has " +
                std::to_string(size()) + " names, from class " + std::to_string(first_label_) + " on");
}

}  // namespace dynfilter
