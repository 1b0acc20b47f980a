// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <stdexcept>
#include <string>

namespace dynfilter {

/// Base of all exceptions that the library throws on purpose. The message is one line that can be shown to a
/// user. Control characters are replaced, and the middle of a longer text than kMaxBytes is left out. Unusual
/// frame data never throws: filters abstain on it.
class Error : public std::runtime_error {
 public:
  static constexpr std::size_t kMaxBytes = 1024;  ///< room for a path, the fault and the known names
  explicit Error(const std::string& message);     ///< cleaned and cut, as above
};

/// A configuration that cannot be used. Names the YAML path and what was expected there.
class ConfigError : public Error {
 public:
  ConfigError(const std::string& path, const std::string& message);  ///< says `path: message`
  const std::string& path() const noexcept { return path_; }         ///< the place in the YAML, or ""

 private:
  std::string path_;
};

/// A plugin that cannot be loaded. Names the file and the reason.
class PluginError : public Error {
 public:
  using Error::Error;
};

/// A file or folder that cannot be read or written. Names the path.
class IoError : public Error {
 public:
  using Error::Error;
};

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/core/detail/error-inl.hpp>
#endif
