// SPDX-License-Identifier: MIT
#include "mask_output.hpp"

#include <cstdint>
#include <dynfilter/core/error.hpp>
#include <dynfilter/detectors/image_encoder.hpp>
#include <filesystem>
#include <fstream>
#include <map>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <set>
#include <system_error>

namespace dynfilter::command {
namespace {

constexpr std::size_t kPictures = 50;

/// Masked pixels red, objects that stay with a green outline.
cv::Mat picture_of(const cv::Mat& colour, const cv::Mat& moving, const cv::Mat& standing) {
  const cv::Scalar red(40, 40, 255), green(80, 220, 60);
  cv::Mat picture = colour.clone(), tinted;
  cv::addWeighted(picture, 0.45, cv::Mat(picture.size(), CV_8UC3, red), 0.55, 0, tinted);
  tinted.copyTo(picture, moving);
  const auto outline = [&](const cv::Mat& mask, const cv::Scalar& ink) {
    if (mask.empty()) return;
    std::vector<std::vector<cv::Point>> contours;
    cv::findContours(mask.clone(), contours, cv::RETR_LIST, cv::CHAIN_APPROX_NONE);
    cv::drawContours(picture, contours, -1, ink, 1);
  };
  outline(standing, green);
  outline(moving, red);
  return picture;
}

Json read_transforms(const std::filesystem::path& file) {
  std::ifstream in(file);
  const Json read = Json::parse(in, nullptr, false);
  if (!read.is_object() || !read.contains("frames") || !read["frames"].is_array())
    throw IoError(file.string() + ": is not nerfstudio's: no JSON with a list `frames`");
  return read;
}

std::string stem_of(const Json& frame) {
  if (!frame.is_object() || !frame.contains("file_path") || !frame["file_path"].is_string()) return "";
  return std::filesystem::path(frame["file_path"].get<std::string>()).stem().string();
}

}  // namespace

Json to_json(const MaskSummary& s) {
  Json objects = Json::array();
  for (const MaskedObject& o : s.objects)
    objects.push_back({{"class", o.class_name},
                       {"first_s", o.first_s},
                       {"last_s", o.last_s},
                       {"images", o.images},
                       {"masked", o.masked}});
  Json truth(nullptr);
  if (s.truth)
    truth = {{"iou", number_or_null(s.truth->intersection_over_union())},
             {"movers_masked", number_or_null(s.truth->movers_masked())},
             {"static_lost", number_or_null(s.truth->static_lost())}};
  return {{"sequence", s.sequence},
          {"tool", s.tool},
          {"shape", s.shape},
          {"pipeline", s.pipeline},
          {"images", s.images},
          {"frames", s.frames},
          {"masked_share", s.masked_share},
          {"objects", objects},
          {"truth", truth},
          {"notes", s.notes},
          {"failure", s.failure.empty() ? Json(nullptr) : Json(s.failure)}};
}

MaskOutput::MaskOutput(const RunOptions& options, const masks::MaskForm& form)
    : form_(form),
      folder_(options.out, options.force, {"masks.json", "masks", "overlay", "images", "transforms.json"}) {
  for (const char* name : {"masks", "overlay"}) std::filesystem::create_directory(folder_.path() / name);
}

void MaskOutput::set_frames(std::size_t frames) {
  every_ = (frames + kPictures - 1) / kPictures;
}

void MaskOutput::add(std::size_t k, const std::string& image, const cv::Mat& moving, const cv::Mat& standing,
                     const cv::Mat& colour) {
  write_image("masks/" + form_.file_of(image), form_.image_of(moving));
  if (wants_picture(k))
    write_image("overlay/" + std::filesystem::path(image).stem().string() + ".jpg",
                picture_of(colour, moving, standing));
}

void MaskOutput::add_image(const std::string& image, const cv::Mat& colour) {
  std::filesystem::create_directory(folder_.path() / kImages);
  write_image(std::string(kImages) + "/" + image, colour);
}

void MaskOutput::finish(const io::Sequence& sequence, const std::vector<std::size_t>& order,
                        const MaskSummary& summary) {
  if (form_.tool == "nerfstudio") add_transforms(sequence, order);
  folder_.write("masks.json", json_text(to_json(summary)));
  folder_.commit();
}

void MaskOutput::write_image(const std::string& name, const cv::Mat& image) const {
  io::write_image(folder_.path() / name, image);
}

/// nerfstudio reads masks only if every frame of transforms.json names its own.
void MaskOutput::add_transforms(const io::Sequence& sequence, const std::vector<std::size_t>& order) const {
  const std::filesystem::path file = sequence.folder() / "transforms.json";
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error)) return;
  std::set<std::string> written;
  for (const std::size_t i : order) written.insert(sequence.image_name(i));
  Json transforms = read_transforms(file);
  for (Json& frame : transforms["frames"]) {
    const std::string stem = stem_of(frame);
    if (written.count(stem) == 0)
      throw IoError(
          file.string() + ": the frame `" + stem +
          "` has no mask, and nerfstudio wants one for every frame: leave out --start and --frames");
    frame["mask_path"] = "masks/" + form_.file_of(stem + ".png");
  }
  folder_.write("transforms.json", json_text(transforms));
}

}  // namespace dynfilter::command
