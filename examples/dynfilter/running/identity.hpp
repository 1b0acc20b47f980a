// SPDX-License-Identifier: MIT
#pragma once

#include <fmt/format.h>

#include <cstdint>
#include <dynfilter/core/error.hpp>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <system_error>

#include "presets.hpp"

// What produced a result, so that no other one is taken for it.
namespace dynfilter::command {

/// The absolute path without links; the path itself where that fails.
inline std::string canonical_text(const std::filesystem::path& path) {
  std::error_code error;
  const std::filesystem::path whole = std::filesystem::weakly_canonical(path, error);
  return (error ? path : whole).lexically_normal().string();
}

/// FNV-1a, 64 bits.
inline std::string digest_of(const std::string& bytes) {
  constexpr std::uint64_t kOffset = 0xcbf29ce484222325U, kPrime = 0x100000001b3U;
  std::uint64_t hash = kOffset;
  for (const char byte : bytes) hash = (hash ^ static_cast<unsigned char>(byte)) * kPrime;
  return fmt::format("{:016x}", hash);
}

struct PipelineSource {
  std::string file;    ///< canonical path; "" for YAML text
  std::string digest;  ///< of the text: it changes when the file is edited
};

inline PipelineSource pipeline_source(const std::string& pipeline) {
  try {
    const std::string file = canonical_text(find_pipeline(pipeline));
    std::ifstream in(file, std::ios::binary);
    return {file, digest_of({std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()})};
  } catch (const ConfigError&) {
    return {"", digest_of(pipeline)};
  }
}

}  // namespace dynfilter::command
