// SPDX-License-Identifier: MIT
#pragma once

#include <stdexcept>
#include <string>

namespace dynfilter {

/// Base of everything the library throws on purpose. One line, no trailing full stop, made to be shown to a
/// user. Odd *data* never throws: filters abstain on it.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A configuration that cannot be used: names the YAML path and what was expected there.
class ConfigError : public Error {
 public:
  ConfigError(const std::string& path, const std::string& message)
      : Error(path.empty() ? message : path + ": " + message), path_(path) {}
  const std::string& path() const noexcept { return path_; }

 private:
  std::string path_;
};

/// A plugin that cannot be loaded: names the file and the reason.
class PluginError : public Error {
 public:
  using Error::Error;
};

/// Files or folders that cannot be read or written: names the path.
class IoError : public Error {
 public:
  using Error::Error;
};

}  // namespace dynfilter
