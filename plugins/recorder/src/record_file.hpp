// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <dynfilter/core/error.hpp>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

namespace dynfilter::recorder {

/// What a record is about.
enum class RecordKind : std::uint32_t { Pipeline = 1, Frame, Verdict, Images, Pose, Reset, End, Lost };
inline constexpr std::uint32_t kRecordKinds = 8;

/// Before each record. Numbers are little-endian.
struct RecordHeader {
  std::uint32_t kind = 0;
  std::uint32_t packed_bytes = 0;  ///< of the LZ4 frame that follows, with its checksum
  std::uint32_t raw_bytes = 0;     ///< of the content
  std::uint32_t check = 0;         ///< FNV-1a of the other members
  std::uint64_t call = 0;          ///< number of the pipeline's call, from 1

  std::uint32_t own_check() const;
};
static_assert(sizeof(RecordHeader) == 24, "no padding");

/// The first bytes of a file.
struct FileHeader {
  char magic[8] = {'d', 'y', 'n', 'f', 'r', 'e', 'c', '\n'};
  std::uint32_t version = 0, reserved = 0;
};
static_assert(sizeof(FileHeader) == 16, "no padding");

struct CloseFile {
  void operator()(std::FILE* file) const {
    if (file != nullptr) std::fclose(file);
  }
};
using FilePtr = std::unique_ptr<std::FILE, CloseFile>;

/// The content of a record and its compressed form. Memory is kept from record to record: fresh pages cost
/// more than the bytes.
struct RecordBuffer {
  std::vector<char> raw, packed;
};

/// A file that only grows. Each record is handed to the system as a whole. Used from two threads.
class RecordFile {
 public:
  enum class State { Open, Full, Failed };

  /// Throws IoError.
  RecordFile(const std::string& path, std::uint64_t max_bytes);

  /// Compresses and writes a record. False: the file is full or cannot be written, and nothing was.
  bool append(RecordKind kind, std::uint64_t call, RecordBuffer& buffer);
  State state() const;
  const std::string& path() const { return path_; }

 private:
  /// Room for the last record.
  static constexpr std::uint64_t kEndBytes = 4096;

  mutable std::mutex mutex_;
  std::string path_;
  FilePtr file_;
  std::uint64_t max_bytes_, written_ = 0;
  State state_ = State::Open;
};

/// Reads LZ4 frames as append() writes them. Its memory is bounded, whatever a frame says of its blocks.
class Unpacker {
 public:
  Unpacker();
  ~Unpacker();
  Unpacker(const Unpacker&) = delete;
  Unpacker& operator=(const Unpacker&) = delete;
  /// Fills `raw`, whose size is that of the content. Throws Error.
  void unpack(const std::vector<char>& packed, std::vector<char>& raw);

 private:
  struct Context;
  std::unique_ptr<Context> context_;
};

}  // namespace dynfilter::recorder
