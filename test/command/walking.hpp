// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>

#include "run_command.hpp"

namespace dynfilter_test {

/// One short walking sequence for all tests. A test that damages it uses a copy.
class Walking {
 public:
  Walking() : folder_(root_.path() / "walking") {
    const CommandResult result =
        run_dynfilter("synth walking_static '" + folder_.string() + "' --frames 14 --seed 3");
    REQUIRE(result.exit_code == 0);
  }
  const std::filesystem::path& folder() const { return folder_; }
  const std::filesystem::path& root() const { return root_.path(); }
  static const Walking& shared() {
    static const Walking walking;
    return walking;
  }

 private:
  TemporaryFolder root_;
  std::filesystem::path folder_;
};

/// A value of JSON text, as text.
inline std::string value_of(const std::string& json, const std::string& key) {
  const std::size_t at = json.find("\"" + key + "\": ");
  if (at == std::string::npos) return "absent";
  const std::size_t begin = at + key.size() + 4;
  return json.substr(begin, json.find_first_of(",\n}", begin) - begin);
}

}  // namespace dynfilter_test
