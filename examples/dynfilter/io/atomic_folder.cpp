// SPDX-License-Identifier: MIT
#include "io/atomic_folder.hpp"

#include <fcntl.h>
#include <algorithm>
#include <cstdio>
#include <dynfilter/core/error.hpp>
#include <string>
#include <system_error>

#include "io/atomic_file.hpp"
#include "io/durable.hpp"

namespace dynfilter::io {

namespace detail {

/// Without copying: the new names are hard links, where the file system has them.
inline void link_tree(const std::filesystem::path& from, const std::filesystem::path& to) {
  using std::filesystem::copy_options;
  if (std::filesystem::is_directory(std::filesystem::symlink_status(from))) {
    std::filesystem::create_directory(to, from);  // with its permissions
    for (const auto& entry : std::filesystem::directory_iterator(from))
      link_tree(entry.path(), to / entry.path().filename());
    return;
  }
  std::error_code error;
  std::filesystem::create_hard_link(from, to, error);
  if (error) std::filesystem::copy(from, to, copy_options::copy_symlinks);
}

}  // namespace detail

AtomicFolder::AtomicFolder(const std::filesystem::path& folder, OtherEntries others)
    : final_(resolved(folder)), lock_(final_), place_(detail::place_beside(final_)), others_(others) {
  remove_abandoned();
  path_ = detail::temporary_beside(place_ / final_.filename());
  std::error_code error;
  if (!std::filesystem::create_directory(path_, error)) {
    throw IoError(final_.string() + ": cannot write here");
  }
}

AtomicFolder::~AtomicFolder() {
  std::error_code ignored;
  if (!path_.empty()) std::filesystem::remove_all(path_, ignored);
}

void AtomicFolder::commit() {
  try {
    make_tree_durable(path_);
    std::error_code error;
    if (!std::filesystem::exists(final_, error)) {
      detail::rename_or_throw(path_, final_);
    } else if (!exchange()) {
      replace_entries();
      make_durable(final_);
    }
    make_durable(place_);
    std::filesystem::remove_all(path_, error);
    path_.clear();
  } catch (const std::filesystem::filesystem_error& error) {
    throw IoError(final_.string() + ": cannot write: " + error.what());
  }
}

/// Without a slash at the end and without symbolic links, which a rename would replace.
inline std::filesystem::path AtomicFolder::resolved(const std::filesystem::path& folder) {
  const std::filesystem::path whole = std::filesystem::absolute(folder).lexically_normal();
  std::filesystem::path named = whole.has_filename() ? whole : whole.parent_path();
  std::error_code error;
  std::filesystem::path real = std::filesystem::canonical(named, error);
  if (error) return named;
  if (!std::filesystem::is_directory(real)) throw IoError(named.string() + ": exists and is not a folder");
  return real;
}

/// What a killed program left. The lock says that nobody writes there now.
inline void AtomicFolder::remove_abandoned() const {
  const std::string begin = "." + final_.filename().string() + detail::kPartial;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(place_, error)) {
    const std::string name = entry.path().filename().string();
    const bool ours =
        name.size() == begin.size() + detail::kPartialDigits && name.rfind(begin, 0) == 0 &&
        std::all_of(name.begin() + static_cast<std::ptrdiff_t>(begin.size()), name.end(),
                    [](char c) { return std::string("0123456789abcdef").find(c) != std::string::npos; });
    if (ours && entry.is_directory(error)) std::filesystem::remove_all(entry.path(), error);
  }
}

inline bool AtomicFolder::exchange() {
  std::error_code error;
  const bool is_working_directory =
      std::filesystem::equivalent(final_, std::filesystem::current_path(error), error);
  if (is_working_directory || place_ == final_) return false;
#ifdef RENAME_EXCHANGE
  if (others_ == OtherEntries::Keep) take_over_others();
  std::filesystem::permissions(path_, std::filesystem::status(final_).permissions());
  return ::renameat2(AT_FDCWD, path_.c_str(), AT_FDCWD, final_.c_str(), RENAME_EXCHANGE) == 0;
#else
  return false;
#endif
}

inline void AtomicFolder::take_over_others() const {
  for (const auto& entry : std::filesystem::directory_iterator(final_)) {
    const std::filesystem::path target = path_ / entry.path().filename();
    if (!std::filesystem::exists(std::filesystem::symlink_status(target)))
      detail::link_tree(entry.path(), target);
  }
  make_tree_durable(path_);
}

inline void AtomicFolder::replace_entries() const {
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(final_)) {
    const bool other =
        !std::filesystem::exists(std::filesystem::symlink_status(path_ / entry.path().filename()));
    if (other && others_ == OtherEntries::Remove && entry.path() != path_)
      std::filesystem::remove_all(entry.path());
  }
  for (const auto& entry : std::filesystem::directory_iterator(path_)) {
    const std::filesystem::path target = final_ / entry.path().filename();
    if (std::filesystem::is_directory(target, error)) std::filesystem::remove_all(target, error);
    detail::rename_or_throw(entry.path(), target);
  }
}

}  // namespace dynfilter::io
