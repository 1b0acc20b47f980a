// SPDX-License-Identifier: MIT
#include <dynfilter/detectors/file_provider.hpp>

#include <cmath>
#include <dynfilter/config/numbers.hpp>
#include <dynfilter/config/parameters.hpp>
#include <dynfilter/config/text_lines.hpp>
#include <dynfilter/core/error.hpp>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/detectors/image_file.hpp>
#include <iterator>
#include <opencv2/core.hpp>
#include <system_error>
#include <vector>

namespace dynfilter {

const FieldTable<FileProviderParams>& FileProviderParams::fields() {
  using P = FileProviderParams;
  static const FieldTable<P> table{
      text("detections", &P::detections, "file of boxes by timestamp (io/detections.hpp)"),
      text("masks", &P::masks, "folder of 8-bit PNGs named by timestamp; 0 is the background"),
  };
  return table;
}

FileProvider::FileProvider(const Params& params, const ProviderFiles& files) {
  if (params.detections.empty() && params.masks.empty())
    throw ConfigError("detections", "expected a file of boxes, a folder of `masks`, or both");
  if (!params.detections.empty())
    boxes_ = io::read_detections(files.find(params.detections, "a file of boxes"));
  if (!params.masks.empty()) list_masks(files.find(params.masks, "a folder of masks"));
}

std::optional<SemanticResult> FileProvider::infer(const SemanticImage& image) {
  SemanticResult result;
  result.frame_id = image.frame_id;
  result.timestamp_s = image.timestamp_s;
  if (const std::vector<Detection>* found = boxes_.at(image.timestamp_s)) result.detections = *found;
  if (const std::filesystem::path* file = mask_at(image.timestamp_s)) {
    result.labels = io::read_label_image(*file);
  }
  if (!result.detections && !result.labels) return std::nullopt;
  return result;
}

inline void FileProvider::list_masks(const std::filesystem::path& folder) {
  std::error_code failed;
  for (std::filesystem::directory_iterator entry(folder, failed), end; !failed && entry != end;
       entry.increment(failed)) {
    const auto stamp_s = io::parse_number(entry->path().stem().string());
    if (entry->path().extension() == ".png" && stamp_s) masks_[*stamp_s] = entry->path();
  }
  if (failed) throw IoError(folder.string() + ": cannot be read: " + failed.message());
  if (masks_.empty()) throw IoError(folder.string() + ": expected PNG masks named by their timestamps");
}

inline const std::filesystem::path* FileProvider::mask_at(double timestamp_s) const {
  auto next = masks_.lower_bound(timestamp_s);
  if (next != masks_.begin() &&
      (next == masks_.end() || timestamp_s - std::prev(next)->first < next->first - timestamp_s))
    --next;
  return next != masks_.end() && std::abs(next->first - timestamp_s) <= kSameStamp_s ? &next->second
                                                                                     : nullptr;
}

}  // namespace dynfilter
