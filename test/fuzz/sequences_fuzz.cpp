// SPDX-License-Identifier: MIT
// Recorded sequences of every layout. An input is a folder: lines `@@ PATH`, each followed by that file.
#include <unistd.h>
#include <dynfilter/core/error.hpp>
#include <filesystem>
#include <fstream>
#include <string>

#include "io/sequence.hpp"
#include "target.hpp"

namespace {

using namespace dynfilter;
namespace fs = std::filesystem;

/// A folder that is removed with all that is in it.
class Folder {
 public:
  Folder() : path_(root() / ("dynfilter_fuzz_" + std::to_string(::getpid()))) {
    fs::create_directories(path_);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  ~Folder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }

  const fs::path& path() const { return path_; }

  /// Only below the folder, in few levels, with plain names.
  void write(const std::string& name, const std::string& content) const {
    int levels = 0;
    for (const char c : name) {
      levels += c == '/' ? 1 : 0;
      if (std::isalnum(static_cast<unsigned char>(c)) == 0 && c != '/' && c != '.' && c != '_') return;
    }
    if (name.empty() || name.size() > 60 || levels > 3 || name.front() == '/' ||
        name.find("..") != std::string::npos)
      return;
    std::error_code ignored;
    fs::create_directories((path_ / name).parent_path(), ignored);
    std::ofstream(path_ / name, std::ios::binary) << content;
  }

 private:
  static fs::path root() {
    const fs::path memory = "/dev/shm";
    return fs::is_directory(memory) ? memory : fs::temp_directory_path();
  }
  fs::path path_;
};

void unpack(const std::string& input, const Folder& folder) {
  const std::string mark = "@@ ";
  int files = 0;
  for (std::size_t at = input.rfind(mark, 0) == 0 ? 0 : std::string::npos;
       at != std::string::npos && files < 24; ++files) {
    const std::size_t name = at + mark.size(), line_end = input.find('\n', name);
    if (line_end == std::string::npos) return;
    const std::size_t next = input.find("\n" + mark, line_end);
    const std::size_t end = next == std::string::npos ? input.size() : next + 1;
    folder.write(input.substr(name, line_end - name), input.substr(line_end + 1, end - line_end - 1));
    at = next == std::string::npos ? next : next + 1;
  }
}

void load(const io::Sequence& sequence) {
  for (std::size_t i = 0; i < sequence.size() && i < 3; ++i) {
    try {
      const io::SequenceFrame frame = sequence.load(i);
      fuzz::require(frame.grey.size() == frame.colour.size(), "images of a frame are of one size");
      fuzz::require(frame.depth.empty() || frame.depth.size() == frame.grey.size(),
                    "depth has the size of the image");
      fuzz::require(frame.right.empty() || frame.right.size() == frame.grey.size(),
                    "right has the size of the image");
    } catch (const Error& error) {
      fuzz::require_one_line(error.what());
    }
  }
}

void open(const fs::path& folder) {
  const io::Sequence sequence = io::Sequence::open(folder);
  fuzz::require(sequence.size() > 0, "a sequence that is opened has a frame");
  for (std::size_t i = 1; i < sequence.size(); ++i)
    fuzz::require(sequence.timestamp_s(i) > sequence.timestamp_s(i - 1), "stamps of frames ascend");
  load(sequence);
  (void)sequence.ground_truth();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const Folder folder;
  unpack(std::string(reinterpret_cast<const char*>(data), size), folder);
  try {
    open(folder.path());
  } catch (const Error& error) {
    fuzz::require_one_line(error.what());
  }
  return 0;
}
