// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cctype>
#include <cstddef>
#include <dynfilter/core/printable_text.hpp>
#include <string>
#include <vector>

namespace dynfilter {

/// ASCII letters only.
inline std::string lower_case(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

/// Number of letters to change, add, remove or swap with a neighbour to turn `a` into `b`.
/// This is the optimal string alignment distance. Case is ignored.
inline std::size_t edit_distance(const std::string& a, const std::string& b) {
  const std::string x = lower_case(a), y = lower_case(b);
  std::vector<std::size_t> before(y.size() + 1), last(y.size() + 1), row(y.size() + 1);
  for (std::size_t j = 0; j <= y.size(); ++j) last[j] = j;
  for (std::size_t i = 1; i <= x.size(); ++i) {
    row[0] = i;
    for (std::size_t j = 1; j <= y.size(); ++j) {
      const std::size_t changed = last[j - 1] + (x[i - 1] == y[j - 1] ? 0 : 1);
      row[j] = std::min({changed, last[j] + 1, row[j - 1] + 1});
      if (i > 1 && j > 1 && x[i - 1] == y[j - 2] && x[i - 2] == y[j - 1])
        row[j] = std::min(row[j], before[j - 2] + 1);
    }
    before = last;
    last = row;
  }
  return last[y.size()];
}

/// The name closest to `word`, if at most a third of its letters differ.
/// Else the first name that begins with `word`, as `max_distance_px` with `max_dist`. Else "".
inline std::string near_miss(const std::string& word, const std::vector<std::string>& names) {
  // Longer words match no name, and the distance takes quadratic time.
  constexpr std::size_t kLongest = 100;
  std::string nearest;
  std::size_t least = word.size() / 3 + 1;
  for (const std::string& name : names) {
    const std::size_t distance = word.size() > kLongest ? least : edit_distance(word, name);
    if (distance >= least) continue;
    least = distance;
    nearest = name;
  }
  if (!nearest.empty()) return nearest;
  // Three letters are the shortest word of which the rest of a name can be guessed.
  constexpr std::size_t kShortest = 3;
  const std::string begin = lower_case(word);
  for (const std::string& name : names)
    if (begin.size() >= kShortest && lower_case(name).rfind(begin, 0) == 0) return name;
  return "";
}

/// Suffix for an error message: " (did you mean `limit`?)" or "".
inline std::string did_you_mean(const std::string& word, const std::vector<std::string>& names) {
  const std::string nearest = near_miss(word, names);
  return nearest.empty() ? "" : " (did you mean `" + nearest + "`?)";
}

/// The words with ", " between them.
inline std::string joined(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : ", ") + word;
  return text;
}

// The texts of all errors about a name that is not known.

/// "unknown key `x` (did you mean `y`?); known keys: y, z". `what` is singular: "key", "filter".
inline std::string unknown_name(const std::string& what, const std::string& word,
                                const std::vector<std::string>& known) {
  return "unknown " + what + " " + in_backticks(word) + did_you_mean(word, known) + "; known " + what +
         "s: " + (known.empty() ? "none" : joined(known));
}

/// "expected one of y, z, got `x` (did you mean `y`?)".
inline std::string expected_one_of(const std::vector<std::string>& known, const std::string& word) {
  return "expected one of " + joined(known) + ", got " + in_backticks(word) + did_you_mean(word, known);
}

}  // namespace dynfilter
