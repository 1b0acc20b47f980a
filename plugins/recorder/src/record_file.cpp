// SPDX-License-Identifier: MIT
#include "record_file.hpp"

#include <lz4frame.h>
#include <cerrno>
#include <cstring>
#include <dynfilter/recorder/recording.hpp>
#include <limits>

namespace dynfilter::recorder {

std::uint32_t RecordHeader::own_check() const {
  constexpr std::uint32_t kOffset = 2166136261U, kPrime = 16777619U;
  std::uint32_t hash = kOffset;
  const auto add = [&](std::uint64_t value, int bytes) {
    for (int k = 0; k < bytes; ++k) hash = (hash ^ static_cast<std::uint8_t>(value >> (8 * k))) * kPrime;
  };
  add(kind, 4), add(packed_bytes, 4), add(raw_bytes, 4), add(call, 8);
  return hash;
}

namespace {

/// Descriptors and pixels hardly compress: LZ4 then gives up early, which halves its time.
constexpr int kFastLevel = -8;

/// After a header's room. Empty: it cannot be compressed.
std::vector<char> packed_record(const std::vector<char>& raw) {
  LZ4F_preferences_t preferences{};
  preferences.frameInfo.contentChecksumFlag = LZ4F_contentChecksumEnabled;
  preferences.frameInfo.blockSizeID = LZ4F_max256KB;
  preferences.frameInfo.contentSize = raw.size();
  preferences.compressionLevel = kFastLevel;
  std::vector<char> bytes(sizeof(RecordHeader) + LZ4F_compressFrameBound(raw.size(), &preferences));
  const std::size_t size =
      LZ4F_compressFrame(bytes.data() + sizeof(RecordHeader), bytes.size() - sizeof(RecordHeader), raw.data(),
                         raw.size(), &preferences);
  if (LZ4F_isError(size) != 0) return {};
  bytes.resize(sizeof(RecordHeader) + size);
  return bytes;
}

}  // namespace

RecordFile::RecordFile(const std::string& path, std::uint64_t max_bytes)
    : path_(path), file_(std::fopen(path.c_str(), "wb")), max_bytes_(max_bytes) {
  FileHeader header;
  header.version = kVersion;
  errno = file_ ? 0 : errno;
  if (file_) std::setvbuf(file_.get(), nullptr, _IONBF, 0);  // records are whole already
  if (!file_ || std::fwrite(&header, sizeof header, 1, file_.get()) != 1)
    throw IoError(path + ": the recording cannot be written: " + std::strerror(errno));
  written_ = sizeof header;
}

bool RecordFile::append(RecordKind kind, std::uint64_t call, const std::vector<char>& raw) {
  if (raw.size() > std::numeric_limits<std::uint32_t>::max() / 2) return false;
  std::vector<char> bytes = packed_record(raw);
  RecordHeader header;
  header.kind = static_cast<std::uint32_t>(kind), header.call = call;
  header.raw_bytes = static_cast<std::uint32_t>(raw.size());
  const std::lock_guard<std::mutex> lock(mutex_);
  const bool last = kind == RecordKind::End;
  if (state_ == State::Failed || bytes.empty() || (state_ == State::Full && !last)) return false;
  if (written_ + bytes.size() + (last ? 0 : kEndBytes) > max_bytes_) {
    state_ = State::Full;
    return false;
  }
  header.packed_bytes = static_cast<std::uint32_t>(bytes.size() - sizeof header);
  header.check = header.own_check();
  std::memcpy(bytes.data(), &header, sizeof header);
  written_ += bytes.size();
  if (std::fwrite(bytes.data(), bytes.size(), 1, file_.get()) == 1) return true;
  state_ = State::Failed;
  return false;
}

RecordFile::State RecordFile::state() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return state_;
}

void unpack(const std::vector<char>& packed, std::vector<char>& raw) {
  LZ4F_dctx* made = nullptr;
  if (LZ4F_isError(LZ4F_createDecompressionContext(&made, LZ4F_VERSION)) != 0) throw Error("out of memory");
  const std::unique_ptr<LZ4F_dctx, LZ4F_errorCode_t (*)(LZ4F_dctx*)> context(made,
                                                                             &LZ4F_freeDecompressionContext);
  std::size_t from = 0, to = 0;
  for (;;) {
    std::size_t taken = packed.size() - from, given = raw.size() - to;
    const std::size_t hint =
        LZ4F_decompress(context.get(), raw.data() + to, &given, packed.data() + from, &taken, nullptr);
    if (LZ4F_isError(hint) != 0) throw Error("its checksum differs");
    from += taken, to += given;
    if (hint == 0) break;
    if (taken == 0 && given == 0) throw Error("it is incomplete");
  }
  if (from != packed.size() || to != raw.size()) throw Error("it is not as long as it says");
}

}  // namespace dynfilter::recorder
