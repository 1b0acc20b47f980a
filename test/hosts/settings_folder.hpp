// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "io/tum_folder.hpp"

namespace dynfilter_test {

/// A folder with a host's settings and the files that they name.
class SettingsFolder : public TemporaryFolder {
 public:
  std::string write(const std::string& name, const std::string& text) const {
    write_text(path() / name, text);
    return (path() / name).string();
  }
};

}  // namespace dynfilter_test
