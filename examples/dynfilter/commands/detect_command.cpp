// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <dynfilter/config/numbers.hpp>
#include <dynfilter/config/text_lines.hpp>
#include <dynfilter/core/error.hpp>
#include <dynfilter/core/printable_text.hpp>
#include <dynfilter/detectors/image_file.hpp>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <dynfilter/detectors/detections.hpp>
#include <dynfilter/detectors/image_encoder.hpp>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "command.hpp"
#include "eval/statistics.hpp"
#include "io/detections_writer.hpp"
#include "io/sequence.hpp"
#include "io/sequence_source.hpp"
#include "run_options.hpp"
#include "running/command_registry.hpp"
#include "running/interruption.hpp"
#include "running/overlay.hpp"
#include "running/results_folder.hpp"
#include "text/json.hpp"
#include "text/progress.hpp"
#include "text/terminal.hpp"

namespace dynfilter::command {
namespace {

struct DetectOptions {
  std::string input, detector, network_dir, out;
  std::vector<std::string> plugins;
  std::size_t start = 0, frames = 0, step = 1;
  double scale = 1;
  int threads = 1;
  bool json = false, force = false;
};

/// One image file, or the colour and depth images of a sequence.
class Images {
 public:
  explicit Images(const DetectOptions& options) {
    std::error_code error;
    const bool is_pattern = options.input.find_first_of("*?[") != std::string::npos;
    if (io::names_an_image(options.input) && !is_pattern &&
        !std::filesystem::is_directory(options.input, error)) {
      file_ = options.input;
      return;
    }
    io::SequenceOptions given;  // no camera is needed; any camera accepts images of every size
    given.camera.emplace();
    given.camera->fx_px = given.camera->fy_px = 1;
    given.camera->width_px = given.camera->height_px = 0;
    given.scale = options.scale;
    sequence_ = io::Sequence::open(options.input, given);
    if (sequence_->is_camera() && options.frames == 0)
      throw Error(options.input + ": a camera has no end; give --frames N");
  }
  std::size_t size() const { return sequence_ ? sequence_->size() : 1; }
  std::string name(std::size_t i) const {
    return sequence_ ? sequence_->image_name(i) : file_.stem().string();
  }
  std::vector<std::string> notes() const {
    return sequence_ ? sequence_->notes() : std::vector<std::string>();
  }

  /// nullopt where a video ended.
  std::optional<SemanticImage> load(std::size_t i) const {
    SemanticImage image;
    image.frame_id = static_cast<std::int64_t>(i);
    if (!sequence_) {
      image.timestamp_s = io::parse_number(file_.stem().string()).value_or(0);
      image.pixels = io::read_image(file_, io::ImageAs::Colour);
      return image;
    }
    const std::optional<io::SequenceFrame> frame = sequence_->read(i);
    if (!frame) return std::nullopt;
    image.timestamp_s = frame->timestamp_s;
    image.pixels = frame->colour;
    image.depth = frame->depth;
    image.depth_unit_m = frame->depth_unit_m;
    return image;
  }

 private:
  std::filesystem::path file_;
  std::optional<io::Sequence> sequence_;
};

/// Number of detections of a class.
struct ClassCount {
  std::size_t boxes = 0, images = 0, images_with_two = 0;
};

struct Report {
  std::string detector, input;
  std::size_t images = 0, boxes = 0;
  std::size_t with_boxes = 0;  ///< images for which boxes were answered, possibly none
  std::size_t with_found = 0;  ///< images with at least one box
  std::size_t with_mask = 0;
  std::map<std::string, ClassCount> classes;
  std::map<int, double> label_share;  ///< share of the pixels of all masks, by label except 0
  double median_ms = 0;
  std::size_t failed = 0;  ///< images on which the detector failed
  std::string last_error;
  std::vector<std::string> notes;  ///< of the sequence

  void count(const SemanticResult& result) {
    if (result.detections) {
      ++with_boxes;
      with_found += result.detections->empty() ? 0 : 1;
      std::map<std::string, std::size_t> found;
      for (const Detection& d : *result.detections) ++found[d.class_name.empty() ? "object" : d.class_name];
      for (const auto& [name, n] : found) {
        boxes += n;
        classes[name].boxes += n;
        classes[name].images += 1;
        classes[name].images_with_two += n >= 2;
      }
    }
    if (result.labels) count_labels(*result.labels);
  }

 private:
  void count_labels(const cv::Mat& labels) {
    ++with_mask;
    std::vector<std::size_t> pixels(256, 0);
    for (int y = 0; y < labels.rows; ++y)
      for (int x = 0; x < labels.cols; ++x) ++pixels[labels.at<std::uint8_t>(y, x)];
    for (int label = 1; label < 256; ++label) {
      if (pixels[static_cast<std::size_t>(label)] > 0)
        label_share[label] += static_cast<double>(pixels[static_cast<std::size_t>(label)]) /
                              static_cast<double>(labels.total());
    }
  }
};

Json to_json(const Report& report) {
  Json classes = Json::object(), labels = Json::object();
  for (const auto& [name, n] : report.classes)
    classes[name] = {{"boxes", n.boxes}, {"images", n.images}, {"images_with_two", n.images_with_two}};
  for (const auto& [label, share] : report.label_share)
    labels[std::to_string(label)] = share / static_cast<double>(report.with_mask);
  return {{"detector", report.detector},
          {"input", report.input},
          {"images", report.images},
          {"with_boxes", report.with_found},
          {"answers", report.with_boxes},
          {"with_mask", report.with_mask},
          {"boxes", report.boxes},
          {"classes", classes},
          {"label_share", labels},
          {"failed", report.failed},
          {"last_error", report.last_error},
          {"ms", report.median_ms},
          {"notes", report.notes}};
}

void print_text(const Report& report, const std::string& out) {
  const auto count = [](std::size_t n, const char* one, const char* many) {
    return fmt::format("{} {}", n, n == 1 ? one : many);
  };
  fmt::print("{} on {}\n  {}: {} in {} of them, masks for {}; {:.1f} ms an image\n", report.detector,
             report.input, count(report.images, "image", "images"), count(report.boxes, "box", "boxes"),
             report.with_found, report.with_mask, report.median_ms);
  if (report.failed > 0)
    fmt::print("{}", wrapped(fmt::format("the detector failed on {} of them: {}", report.failed,
                                         without_controls(report.last_error)),
                             text_columns(), 2));
  for (const auto& [name, n] : report.classes)
    fmt::print("  {:<16} {}, in {}, two or more in {}\n", name, count(n.boxes, "box", "boxes"),
               count(n.images, "image", "images"), n.images_with_two);
  for (const auto& [label, share] : report.label_share)
    fmt::print("  label {:<10} {:.1f} % of the pixels\n", label,
               100 * share / static_cast<double>(report.with_mask));
  for (const std::string& note : report.notes) fmt::print("{}", wrapped("note: " + note, text_columns(), 2));
  if (!out.empty()) fmt::print("  written to {}\n", out);
}

/// Writes detections.txt, masks/ and overlay/. All appear at the end, or none.
class DetectOutput {
 public:
  explicit DetectOutput(const DetectOptions& options)
      : folder_(options.out, options.force, {"summary.json", "detections.txt", "masks", "overlay"}) {
    std::filesystem::create_directory(folder_.path() / "overlay");
  }

  void add(const SemanticImage& image, const std::string& name, const std::string& title,
           const SemanticResult& result) {
    OverlayFrame picture;
    picture.colour = image.pixels;
    picture.title = title;
    if (result.detections) {
      boxes_.push_back({image.timestamp_s, *result.detections});
      picture.detections = *result.detections;
    }
    if (result.labels) {
      std::filesystem::create_directory(folder_.path() / "masks");
      cv::Mat whole;  // in the image's size, at any network resolution
      cv::resize(*result.labels, whole, image.pixels.size(), 0, 0, cv::INTER_NEAREST);
      write(folder_.path() / "masks" / (name + ".png"), whole);
      picture.mask = whole;
    }
    write(folder_.path() / "overlay" / (name + ".png"), overlay_.draw(picture));
  }

  void finish(const Report& report) {
    std::stable_sort(boxes_.begin(), boxes_.end(),
                     [](const auto& a, const auto& b) { return a.timestamp_s < b.timestamp_s; });
    if (report.with_boxes > 0) io::write_detections(folder_.path() / "detections.txt", boxes_);
    folder_.write("summary.json", json_text(to_json(report)));
    folder_.commit();
  }

 private:
  static void write(const std::filesystem::path& path, const cv::Mat& picture) {
    io::write_image(path, picture);
  }

  ResultsFolder folder_;
  std::vector<io::StampedDetections> boxes_;
  Overlay overlay_;
};

Report detect(const DetectOptions& options) {
  std::optional<DetectOutput> output;
  if (!options.out.empty()) output.emplace(options);
  cv::setNumThreads(options.threads);
  const Images images(options);
  const DetectorConfig config = load_detector(options.detector, options.network_dir, options.plugins);
  Interruption::watch();
  const auto provider = config.make();
  if (options.start >= images.size())
    throw Error(fmt::format("--start {}: there are only {} images", options.start, images.size()));
  const std::size_t left = (images.size() - options.start + options.step - 1) / options.step;
  const std::size_t count = options.frames > 0 ? std::min(options.frames, left) : left;

  Report report;
  report.detector = config.name;
  report.input = std::filesystem::path(options.input).lexically_normal().string();
  std::vector<double> times_ms;
  Progress bar(config.name);
  for (std::size_t k = 0; k < count; ++k) {
    bar.at(k, count);
    const std::size_t i = options.start + k * options.step;
    const std::optional<SemanticImage> loaded = images.load(i);
    if (!loaded) break;
    const SemanticImage& image = *loaded;
    const auto begin = std::chrono::steady_clock::now();
    std::optional<SemanticResult> result;
    try {
      result = provider->infer(image);
    } catch (const Error& error) {
      Interruption::check();  // it may have ended the wait for an answer
      ++report.failed, report.last_error = error.what();
    }
    times_ms.push_back(
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count());
    ++report.images;
    if (!result) continue;
    report.count(*result);
    if (output)
      output->add(image, images.name(i), fmt::format("{}   {}", config.name, images.name(i)), *result);
  }
  report.median_ms = eval::median(times_ms);
  report.notes = images.notes();
  if (output) output->finish(report);
  return report;
}

int run(const DetectOptions& options) {
  const Report report = detect(options);
  if (options.json)
    fmt::print("{}", json_text(to_json(report)));
  else
    print_text(report, options.out);
  if (report.with_boxes + report.with_mask > 0) return kDone;
  if (report.failed > 0)
    fmt::print(stderr, "dynfilter: {} on {}: the detector failed on {}: {}\n", report.detector, report.input,
               report.failed == report.images ? "every image"
                                              : fmt::format("{} of {} images", report.failed, report.images),
               without_controls(report.last_error));
  else
    fmt::print(stderr, "dynfilter: nothing came from the detector for any image\n");
  return kFailed;
}

}  // namespace

void add_detect(CLI::App& app, Action& action) {
  auto options = std::make_shared<DetectOptions>();
  CLI::App* command =
      app.add_subcommand("detect",
                         "Runs a detector on an image or a sequence. Prints the number of "
                         "boxes and masks.\n\n"
                         "The folder of --out gets detections.txt (as run --detections reads it), "
                         "masks/ (as run --masks reads it), overlay/ and summary.json.");
  command
      ->add_option("INPUT", options->input,
                   "an image file, or a sequence as `run` takes it: a folder, a video, camera:N")
      ->required()
      ->type_name("INPUT");
  command
      ->add_option("--detector", options->detector,
                   "a detector's YAML file, or a preset's name (yolo_fastest, ...); "
                   "of type `process` it starts a program")
      ->required()
      ->type_name("DETECTOR");
  command
      ->add_option("--network-dir", options->network_dir,
                   "folder of the files that the YAML names; without it the folder of the YAML")
      ->type_name("FOLDER");
  command->add_option("--out", options->out, "folder for the results; they appear when all is done")
      ->type_name("FOLDER");
  command->add_flag("--force", options->force, "replace the results of another run in --out");
  command->add_option("--start", options->start, "leave out the first N images")->type_name("N");
  command->add_option("--frames", options->frames, "use at most N images")->type_name("N");
  add_thinning_options(*command, options->step, options->scale);
  command->add_option("--plugin", options->plugins, "load providers from this module as well (runs its code)")
      ->type_name("FILE");
  command->add_option("--threads", options->threads, "OpenCV's threads")
      ->type_name("N")
      ->check(CLI::Range(1, 64))
      ->capture_default_str();
  command->add_flag("--json", options->json, "print JSON");
  command->callback([options, &action] { action = [options] { return run(*options); }; });
}

}  // namespace dynfilter::command
