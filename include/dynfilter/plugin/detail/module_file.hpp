// SPDX-License-Identifier: MIT
#pragma once

#include <elf.h>
#include <link.h>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <ios>
#include <string>
#include <system_error>

namespace dynfilter::detail {

/// Compares what an ELF file's tables say with its size.
/// dlopen() maps a truncated file, and the program ends by SIGBUS at the first missing page.
class ModuleFile {
 public:
  explicit ModuleFile(const std::filesystem::path& file) : in_(file, std::ios::binary) {
    std::error_code failed;
    size_ = std::filesystem::file_size(file, failed);
    if (failed) size_ = 0;
  }

  /// Empty: none was found.
  std::string fault() {
    ElfW(Ehdr) header{};
    if (!read(0, header) || std::memcmp(header.e_ident, ELFMAG, SELFMAG) != 0) return "not an ELF file";
    if (header.e_ident[EI_CLASS] != kClass) return "built for another word size";
    if (!has(header.e_phoff, std::uint64_t{header.e_phnum} * header.e_phentsize) ||
        !has(header.e_shoff, std::uint64_t{header.e_shnum} * header.e_shentsize))
      return truncated();
    for (unsigned k = 0; k < header.e_phnum; ++k) {
      ElfW(Phdr) segment{};
      if (!read(header.e_phoff + std::uint64_t{k} * header.e_phentsize, segment) ||
          !has(segment.p_offset, segment.p_filesz))
        return truncated();
    }
    for (unsigned k = 0; k < header.e_shnum; ++k) {
      ElfW(Shdr) section{};
      if (!read(header.e_shoff + std::uint64_t{k} * header.e_shentsize, section)) return truncated();
      const bool in_file = section.sh_type != SHT_NOBITS && section.sh_type != SHT_NULL;
      if (in_file && !has(section.sh_offset, section.sh_size)) return truncated();
    }
    return "";
  }

 private:
  static constexpr unsigned char kClass = sizeof(void*) == 8 ? ELFCLASS64 : ELFCLASS32;

  bool has(std::uint64_t offset, std::uint64_t bytes) const {
    return offset <= size_ && bytes <= size_ - offset;
  }
  template <class T>
  bool read(std::uint64_t offset, T& to) {
    if (!has(offset, sizeof(to))) return false;
    in_.seekg(static_cast<std::streamoff>(offset));
    return static_cast<bool>(in_.read(reinterpret_cast<char*>(&to), sizeof(to)));
  }
  std::string truncated() const {
    return "truncated: its tables lead beyond its " + std::to_string(size_) + " bytes";
  }

  std::ifstream in_;
  std::uint64_t size_ = 0;
};

/// Why a file cannot be loaded as a module. Empty: nothing is known against it.
inline std::string fault_of_module(const std::filesystem::path& file) {
  return ModuleFile(file).fault();
}

}  // namespace dynfilter::detail
