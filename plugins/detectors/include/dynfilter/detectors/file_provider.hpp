// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/config/field_table.hpp>
#include <dynfilter/core/error.hpp>
#include <dynfilter/detectors/detections.hpp>
#include <dynfilter/semantic/provider.hpp>
#include <dynfilter/semantic/provider_registry.hpp>
#include <filesystem>
#include <map>
#include <optional>
#include <string>

namespace dynfilter {

struct FileProviderParams {
  std::string detections, masks;

  static const FieldTable<FileProviderParams>& fields();
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

  FileProvider(const Params& params, const ProviderFiles& files);  ///< reads the files; throws IoError

  std::string name() const override { return kName; }

  std::optional<SemanticResult> infer(const SemanticImage& image) override;

 private:
  static constexpr double kSameStamp_s = 5e-4;

  void list_masks(const std::filesystem::path& folder);

  const std::filesystem::path* mask_at(double timestamp_s) const;

  io::DetectionTrack boxes_;
  std::map<double, std::filesystem::path> masks_;
};

}  // namespace dynfilter
