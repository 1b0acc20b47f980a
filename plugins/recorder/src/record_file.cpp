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
constexpr LZ4F_blockSizeID_t kBlockSize = LZ4F_max256KB;

/// Behind room for the header. Returns the bytes of both, 0 if the content cannot be compressed.
std::size_t pack(RecordBuffer& buffer) {
  LZ4F_preferences_t preferences{};
  preferences.frameInfo.contentChecksumFlag = LZ4F_contentChecksumEnabled;
  preferences.frameInfo.blockSizeID = kBlockSize;
  preferences.frameInfo.contentSize = buffer.raw.size();
  preferences.compressionLevel = kFastLevel;
  const std::size_t room = LZ4F_compressFrameBound(buffer.raw.size(), &preferences);
  if (buffer.packed.size() < sizeof(RecordHeader) + room) buffer.packed.resize(sizeof(RecordHeader) + room);
  const std::size_t size = LZ4F_compressFrame(buffer.packed.data() + sizeof(RecordHeader), room,
                                              buffer.raw.data(), buffer.raw.size(), &preferences);
  return LZ4F_isError(size) != 0 ? 0 : sizeof(RecordHeader) + size;
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

bool RecordFile::append(RecordKind kind, std::uint64_t call, RecordBuffer& buffer) {
  if (buffer.raw.size() > std::numeric_limits<std::uint32_t>::max() / 2) return false;
  const std::size_t size = pack(buffer);
  RecordHeader header;
  header.kind = static_cast<std::uint32_t>(kind), header.call = call;
  header.raw_bytes = static_cast<std::uint32_t>(buffer.raw.size());
  header.packed_bytes = static_cast<std::uint32_t>(size - sizeof header);
  header.check = header.own_check();
  std::memcpy(buffer.packed.data(), &header, sizeof header);
  const std::lock_guard<std::mutex> lock(mutex_);
  const bool last = kind == RecordKind::End;
  if (state_ == State::Failed || size == 0 || (state_ == State::Full && !last)) return false;
  if (written_ + size + (last ? 0 : kEndBytes) > max_bytes_) {
    state_ = State::Full;
    return false;
  }
  written_ += size;
  if (std::fwrite(buffer.packed.data(), size, 1, file_.get()) == 1) return true;
  state_ = State::Failed;
  return false;
}

RecordFile::State RecordFile::state() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return state_;
}

struct Unpacker::Context {
  Context() {
    if (LZ4F_isError(LZ4F_createDecompressionContext(&lz4, LZ4F_VERSION)) != 0) throw Error("out of memory");
  }
  Context(const Context&) = delete;
  Context& operator=(const Context&) = delete;
  ~Context() { LZ4F_freeDecompressionContext(lz4); }
  LZ4F_dctx* lz4 = nullptr;
};

Unpacker::Unpacker() : context_(std::make_unique<Context>()) {}
Unpacker::~Unpacker() = default;

void Unpacker::unpack(const std::vector<char>& packed, std::vector<char>& raw) {
  LZ4F_dctx* const lz4 = context_->lz4;
  LZ4F_resetDecompressionContext(lz4);
  LZ4F_frameInfo_t info{};
  std::size_t from = packed.size();
  if (LZ4F_isError(LZ4F_getFrameInfo(lz4, &info, packed.data(), &from)) != 0 ||
      info.blockSizeID > kBlockSize || info.contentChecksumFlag != LZ4F_contentChecksumEnabled)
    throw Error("it is no LZ4 frame as recorders write them");
  for (std::size_t to = 0;;) {
    std::size_t taken = packed.size() - from, given = raw.size() - to;
    const std::size_t hint =
        LZ4F_decompress(lz4, raw.data() + to, &given, packed.data() + from, &taken, nullptr);
    if (LZ4F_isError(hint) != 0) throw Error("its checksum differs");
    from += taken, to += given;
    if (hint == 0 && from == packed.size() && to == raw.size()) return;
    if (hint == 0 || (taken == 0 && given == 0)) throw Error("it is not as long as it says");
  }
}

}  // namespace dynfilter::recorder
