// SPDX-License-Identifier: MIT
#include "io/atomic_file.hpp"

#include <dynfilter/core/error.hpp>
#include <fstream>
#include <ios>
#include <locale>
#include <random>
#include <string>
#include <system_error>

#include "io/durable.hpp"

namespace dynfilter::io {

namespace detail {

std::filesystem::path temporary_beside(const std::filesystem::path& path) {
  std::random_device device;
  std::string name = "." + path.filename().string() + kPartial;
  for (std::size_t i = 0; i < kPartialDigits; ++i) name += "0123456789abcdef"[device() % 16];
  return path.parent_path() / name;
}

void rename_or_throw(const std::filesystem::path& from, const std::filesystem::path& to) {
  std::error_code error;
  std::filesystem::rename(from, to, error);
  if (error) throw IoError(to.string() + ": cannot write: " + error.message());
}

}  // namespace detail

void write_file_atomically(const std::filesystem::path& path,
                           const std::function<void(std::ostream&)>& write) {
  const std::filesystem::path temporary = detail::temporary_beside(path);
  try {
    std::ofstream out(temporary, std::ios::binary);
    if (!out) throw IoError(path.string() + ": cannot write here");
    out.imbue(std::locale::classic());
    write(out);
    out.close();
    if (!out) throw IoError(path.string() + ": writing failed (disk full?)");
    make_durable(temporary);
    detail::rename_or_throw(temporary, path);
    make_durable(std::filesystem::absolute(path).parent_path());
  } catch (...) {
    std::error_code ignored;
    std::filesystem::remove(temporary, ignored);
    throw;
  }
}

}  // namespace dynfilter::io
