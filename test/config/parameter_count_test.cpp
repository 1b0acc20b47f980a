// SPDX-License-Identifier: MIT
// Every parameter is a promise to keep and a question to every user. A new one needs a preset or an example
// that sets it, or a sentence on its card about when to change it.
#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "doctest/doctest.h"

namespace parameter_count_test {

namespace fs = std::filesystem;

namespace {

constexpr int kMostParameters = 140;

std::string text_of(const fs::path& file) {
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

std::vector<fs::path> files_in(const std::string& folder, const std::vector<std::string>& extensions) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(fs::path(DYNFILTER_SOURCE_DIR) / folder))
    if (std::find(extensions.begin(), extensions.end(), entry.path().extension()) != extensions.end())
      files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

/// A parameter, the YAML key of the map that holds it, and the page with its table.
struct Parameter {
  std::string owner, name, page;
};

/// The rows of the generated tables of a page.
/// A table's owner is its marker's, the combinator's, or for a card the rejector's.
std::vector<Parameter> parameters_on(const std::string& page, const std::string& card) {
  static const std::regex marker("<!-- parameters(?: of (\\w+))? -->"),
      combinator("\\| `(\\w+)` \\| default \\|.*"), row("\\| `(\\w+)` \\|.*");
  std::vector<Parameter> found;
  std::istringstream lines(page);
  std::string owner;
  std::smatch match;
  for (std::string line; std::getline(lines, line);) {
    if (std::regex_match(line, match, marker))
      owner = match[1].matched ? match[1].str() : card;
    else if (std::regex_match(line, match, combinator))
      owner = match[1];
    else if (line.rfind("<!-- end", 0) == 0)
      owner.clear();
    else if (!owner.empty() && std::regex_match(line, match, row))
      found.push_back({owner, match[1], page});
  }
  return found;
}

std::vector<Parameter> all_parameters() {
  std::vector<Parameter> all;
  for (const fs::path& file : files_in("docs", {".md"}))
    for (const Parameter& parameter : parameters_on(text_of(file), file.stem().string()))
      if (parameter.name != "flow" && parameter.name != "descriptors") all.push_back(parameter);  // groups
  return all;
}

std::string without_comments(const std::string& yaml) {
  return std::regex_replace(yaml, std::regex("(^|\\s)#[^\n]*"), "$1");
}

/// What follows `key:`: up to its closing bracket, or all lines that are indented more.
std::string value_of(const std::string& text, std::size_t key, std::size_t colon) {
  const std::size_t begin = text.find_first_not_of(" \n", colon + 1);
  if (begin == std::string::npos) return "";
  if (text[begin] == '{') {
    int depth = 0;
    for (std::size_t i = begin; i < text.size(); ++i) {
      depth += text[i] == '{' ? 1 : text[i] == '}' ? -1 : 0;
      if (depth == 0) return text.substr(begin, i - begin);
    }
  }
  const std::size_t line = text.rfind('\n', key) + 1;
  const std::size_t indent = text.find_first_not_of(" -", line) - line;
  std::size_t end = text.find('\n', key);
  while (end != std::string::npos) {
    const std::size_t first = text.find_first_not_of(' ', end + 1);
    if (first != std::string::npos && text[first] != '\n' && first - end - 1 < indent + 1) break;
    end = text.find('\n', end + 1);
  }
  return text.substr(begin, end == std::string::npos ? end : end - begin);
}

bool has_key(const std::string& text, const std::string& key) {
  return std::regex_search(text, std::regex("(^|[^\\w.])" + key + ":"));
}

/// A detector's parameters are in the map `detector` that has its name as `type`.
bool sets(const std::string& text, const Parameter& parameter) {
  static const std::vector<std::string> types{"dnn", "files", "process"};
  const bool detector = std::find(types.begin(), types.end(), parameter.owner) != types.end();
  const std::string key = detector ? "detector" : parameter.owner;
  const std::regex start("(^|[^\\w.])" + key + ":");
  for (std::sregex_iterator at(text.begin(), text.end(), start), end; at != end; ++at) {
    const auto begin = static_cast<std::size_t>(at->position()) + static_cast<std::size_t>(at->length(1));
    const std::string value = value_of(text, begin, begin + key.size());
    if (detector && !std::regex_search(value, std::regex("type: *" + parameter.owner + "\\b"))) continue;
    if (has_key(value, parameter.name)) return true;
  }
  return parameter.owner == "orb_slam" && text.find("DynFilter." + parameter.name + ":") != std::string::npos;
}

/// A list item "- `name`: ..." under a heading "When to change", with a condition.
bool explains(const std::string& page, const std::string& name) {
  static const std::regex condition("\\b(if|when|where|for|until|before|after|while|without)\\b",
                                    std::regex::icase);
  std::istringstream lines(page);
  bool inside = false;
  std::string item;
  const auto about_it = [&] {
    return item.rfind("- ", 0) == 0 &&
           item.substr(0, item.find(':')).find("`" + name + "`") != std::string::npos &&
           item.find(':') != std::string::npos && std::regex_search(item.substr(item.find(':')), condition);
  };
  for (std::string line; std::getline(lines, line);) {
    if (inside && (line.empty() || line[0] == '#' || line.rfind("- ", 0) == 0) && about_it()) return true;
    if (!line.empty() && line[0] == '#') inside = line.find("When to change") != std::string::npos;
    item = line.rfind("- ", 0) == 0 ? line : line.empty() || line[0] == '#' ? "" : item + line;
  }
  return inside && about_it();
}

}  // namespace

TEST_CASE("there are at most 140 parameters") {
  const std::vector<Parameter> all = all_parameters();
  MESSAGE(all.size() << " parameters, at most " << kMostParameters);
  CHECK(static_cast<int>(all.size()) <= kMostParameters);
  CHECK(all.size() > 100);  // else the tables were not found
}

TEST_CASE("every parameter of the sources is in one table of the docs") {
  static const std::regex entry("\\b(\\w+)\\(\\s*\"(\\w+)\",\\s*&\\w+::");
  std::map<std::string, int> in_sources, in_docs;
  for (const char* folder : {"include", "plugins"})
    for (const fs::path& file : files_in(folder, {".hpp", ".cpp"})) {
      const std::string text = text_of(file);
      for (std::sregex_iterator at(text.begin(), text.end(), entry), end; at != end; ++at)
        if ((*at)[1] != "group" && (*at)[1] != "def_readonly" && (*at)[1] != "def_readwrite" &&
            (*at)[1] != "def" && text.find("FieldTable<") != std::string::npos)
          ++in_sources[(*at)[2]];
    }
  for (const Parameter& parameter : all_parameters()) ++in_docs[parameter.name];
  in_docs.erase("pipeline");  // DynFilter.pipeline is read apart
  for (const auto& [name, count] : in_sources) {
    const auto& shown = name;  // clang 14 captures no structured binding
    CAPTURE(shown);
    CHECK(in_docs[name] == count);
  }
  for (const auto& [name, count] : in_docs) {
    const auto& shown = name;
    CAPTURE(shown);
    CHECK(in_sources[name] == count);
  }
}

TEST_CASE("every parameter is set in a preset or an example, or its card says when to change it") {
  std::vector<std::string> examples;
  for (const fs::path& file : files_in("examples", {".yaml", ".sh"}))
    examples.push_back(without_comments(text_of(file)));
  REQUIRE(examples.size() > 30);
  for (const Parameter& parameter : all_parameters()) {
    const bool set = std::any_of(examples.begin(), examples.end(),
                                 [&](const std::string& text) { return sets(text, parameter); });
    if (set || explains(parameter.page, parameter.name)) continue;
    FAIL_CHECK(
        parameter.owner << "." << parameter.name
                        << ": set in no file under examples/, and no item under `When to change` on its "
                           "page says when");
  }
}

TEST_CASE("a parameter that is neither set nor explained is found") {
  const std::string page =
      "# x\n\n<!-- parameters -->\n| parameter | default |\n|---|---|\n| `a` | 1 |\n| `b_px` | 2 |\n<!-- end "
      "-->\n";
  const std::vector<Parameter> two = parameters_on(page, "x");
  REQUIRE(two.size() == 2);
  CHECK(two[1].owner == "x");
  CHECK(two[1].name == "b_px");
  CHECK_FALSE(explains(page, "b_px"));
  CHECK_FALSE(explains(page + "\n## When to change\n\n- `b_px`: a radius.\n", "b_px"));
  CHECK_FALSE(explains(page + "\n## Other\n\n- `b_px`: raise it if.\n", "b_px"));
  CHECK(explains(page + "\n## When to change\n\n- `a`, `b_px`: raise them\n  if x.\n", "b_px"));
  CHECK(sets("pipeline:\n  before_pose:\n    - x: { a: 1, b_px: 2 }\n", two[1]));
  CHECK(sets("  before_pose:\n    - x:\n        b_px: 2\n        a: 1\n    - y: { c: 1 }\n", two[1]));
  CHECK_FALSE(sets("  before_pose:\n    - x: { a: 1 }\n    - y: { b_px: 2 }\n", two[1]));
  CHECK_FALSE(sets("  before_pose:\n    - x:\n        a: 1\n    - y:\n        b_px: 2\n", two[1]));
  CHECK_FALSE(sets("x: { b_px_more: 1 }\n", two[1]));
}

}  // namespace parameter_count_test
