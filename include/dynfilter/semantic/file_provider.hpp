// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <dynfilter/core/error.hpp>
#include <dynfilter/core/parameters.hpp>
#include <dynfilter/io/detections.hpp>
#include <dynfilter/io/image_file.hpp>
#include <dynfilter/io/text_lines.hpp>
#include <dynfilter/semantic/provider.hpp>
#include <dynfilter/semantic/provider_registry.hpp>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace dynfilter {

struct FileProviderParams {
  std::string detections, masks;

  static const FieldTable<FileProviderParams>& fields() {
    using P = FileProviderParams;
    static const FieldTable<P> table{
        text("detections", &P::detections, "file of boxes by timestamp (io/detections.hpp)"),
        text("masks", &P::masks, "folder of 8-bit PNGs named by timestamp; 0 is the background"),
    };
    return table;
  }
};

/// Earlier results of a network: boxes and masks from files, by image timestamp.
/// Timestamps match within half a millisecond.
/// An image in neither file has no result.
/// Throws IoError if a file cannot be read or no mask in the folder has a number as its name.
class FileProvider final : public SemanticProvider {
 public:
  using Params = FileProviderParams;
  static constexpr const char* kName = "files";
  static constexpr const char* kSummary = "boxes and masks from files, by timestamp";

  FileProvider(const Params& params, const ProviderFiles& files) {
    if (params.detections.empty() && params.masks.empty())
      throw ConfigError("detections", "expected a file of boxes, a folder of `masks`, or both");
    if (!params.detections.empty())
      boxes_ = io::read_detections(files.find(params.detections, "a file of boxes"));
    if (!params.masks.empty()) list_masks(files.find(params.masks, "a folder of masks"));
  }

  std::string name() const override { return kName; }

  std::optional<SemanticResult> infer(const SemanticImage& image) override {
    SemanticResult result;
    result.frame_id = image.frame_id;
    result.timestamp_s = image.timestamp_s;
    if (const std::vector<Detection>* found = boxes_.at(image.timestamp_s)) result.detections = *found;
    if (const std::filesystem::path* file = mask_at(image.timestamp_s)) {
      result.labels = io::read_image(*file, cv::IMREAD_UNCHANGED);
      if (result.labels->type() != CV_8UC1) throw IoError(file->string() + ": is not an 8-bit label image");
    }
    if (!result.detections && !result.labels) return std::nullopt;
    return result;
  }

 private:
  static constexpr double kSameStamp_s = 5e-4;

  void list_masks(const std::filesystem::path& folder) {
    std::error_code failed;
    for (std::filesystem::directory_iterator entry(folder, failed), end; !failed && entry != end;
         entry.increment(failed)) {
      const auto stamp_s = io::parse_number(entry->path().stem().string());
      if (entry->path().extension() == ".png" && stamp_s) masks_[*stamp_s] = entry->path();
    }
    if (failed) throw IoError(folder.string() + ": cannot be read: " + failed.message());
    if (masks_.empty()) throw IoError(folder.string() + ": expected PNG masks named by their timestamps");
  }

  const std::filesystem::path* mask_at(double timestamp_s) const {
    auto next = masks_.lower_bound(timestamp_s);
    if (next != masks_.begin() &&
        (next == masks_.end() || timestamp_s - std::prev(next)->first < next->first - timestamp_s))
      --next;
    return next != masks_.end() && std::abs(next->first - timestamp_s) <= kSameStamp_s ? &next->second
                                                                                       : nullptr;
  }

  io::DetectionTrack boxes_;
  std::map<double, std::filesystem::path> masks_;
};

}  // namespace dynfilter
