// SPDX-License-Identifier: MIT
#include <dynfilter/detectors/dnn_provider.hpp>

#include <algorithm>
#include <cstdint>
#include <dynfilter/config/parameters.hpp>
#include <dynfilter/core/error.hpp>
#include <dynfilter/semantic/box_masks.hpp>
#include <filesystem>
#include <opencv2/core.hpp>
#include <utility>

namespace dynfilter {

const FieldTable<DnnParams>& DnnParams::fields() {
  using P = DnnParams;
  static const FieldTable<P> table = [] {
    FieldTable<P> t{
        text("network", &P::network, "file with the weights: .weights, .onnx, .caffemodel or .pb"),
        text("config", &P::config,
             "configuration file: .cfg of Darknet, .prototxt of Caffe or .pbtxt of TensorFlow (optional)"),
        choice("decoder", &P::decoder,
               {{"yolo_regions", NetworkDecoder::YoloRegions},
                {"yolov5", NetworkDecoder::YoloV5},
                {"yolov8", NetworkDecoder::YoloV8},
                {"ssd", NetworkDecoder::Ssd},
                {"class_scores", NetworkDecoder::ClassScores}},
               "layout of the network's output"),
        words("outputs", &P::outputs, "layers to read; empty: all layers without a successor"),
    };
    include_fields(t, &P::input);
    t.push_back(words("classes", &P::classes, "class names in the network's order"));
    t.push_back(
        text("class_file", &P::class_file, "file with one class name per line, used instead of `classes`"));
    t.push_back(integer("first_label", &P::first_label, "", {0, 1000},
                        "the network's number of the first name; 1 if 0 is an unnamed background"));
    t.push_back(words("keep", &P::keep, "classes that are used; empty: all"));
    t.push_back(real("min_score", &P::min_score, "", {0, 1}, "smallest score of a box that is used"));
    t.push_back(real("max_overlap", &P::max_overlap, "", {0, 1},
                     "largest intersection over union of two boxes of one class; beyond it, the one with "
                     "the lower score is removed"));
    t.push_back(real("foreground_bias", &P::foreground_bias, "", {-1e6, 1e6},
                     "for class_scores, added to all classes except the background; for two classes of "
                     "logits, b selects pixels above probability 1 / (1 + e^b)"));
    return t;
  }();
  return table;
}

DnnProvider::DnnProvider(Params params, const ProviderFiles& files)
    : params_(std::move(params)), input_(checked(params_).input), network_(opened(params_, files)) {
  naming_the_network([&] { classes_ = class_list(files); });
  const int middle_grey = 128;
  SemanticImage blank;
  blank.pixels = cv::Mat(input_.size(), CV_8UC3, cv::Scalar::all(middle_grey));
  infer(blank);
}

std::optional<SemanticResult> DnnProvider::infer(const SemanticImage& image) {
  if (image.pixels.empty() || (image.pixels.type() != CV_8UC3 && image.pixels.type() != CV_8UC1))
    throw Error(network_.file() + ": expected an image of 8-bit colour or grey, got one of " +
                std::to_string(image.pixels.cols) + "x" + std::to_string(image.pixels.rows) +
                " pixels, type " + cv::typeToString(image.pixels.type()));
  SemanticResult result;
  result.frame_id = image.frame_id;
  result.timestamp_s = image.timestamp_s;
  const std::vector<cv::Mat>& outputs = network_.forward(input_.tensor(image.pixels, fit_));
  naming_the_network([&] {
    if (params_.decoder == NetworkDecoder::ClassScores)
      result.labels = label_image(outputs);
    else
      detect(outputs, result);
  });
  return result;
}

inline const DnnProvider::Params& DnnProvider::checked(const Params& params) {
  check_parameters(params);
  if (params.network.empty()) throw ConfigError("network", "expected the name of a network file");
  if (params.classes.empty() == params.class_file.empty())
    throw ConfigError("classes", "expected the class names, either here or in a `class_file`");
  if (params.decoder == NetworkDecoder::ClassScores && params.first_label != 0)
    throw ConfigError("first_label", "expected 0, because a segmenter's maps are named from the first one");
  return params;
}

inline DnnNetwork DnnProvider::opened(const Params& params, const ProviderFiles& files) {
  const std::filesystem::path network = files.find(params.network, "a network file");
  return {network,
          params.config.empty() ? std::filesystem::path() : files.find(params.config, "its configuration"),
          params.outputs};
}

template <class F>
void DnnProvider::naming_the_network(const F& f) const {
  try {
    f();
  } catch (const IoError&) {
    throw;
  } catch (const Error& error) {
    throw IoError(network_.file() + ": " + error.what());
  }
}

ClassList DnnProvider::class_list(const ProviderFiles& files) const {
  std::vector<std::string> names = params_.classes;
  if (names.empty()) names = ClassList::from_file(files.find(params_.class_file, "a list of class names"));
  return {std::move(names), params_.first_label, params_.keep};
}

inline cv::Mat DnnProvider::label_image(const std::vector<cv::Mat>& outputs) {
  if (outputs.size() != 1)
    throw Error("it has " + std::to_string(outputs.size()) +
                " outputs, expected one: name it with `outputs`");
  decode_class_scores(outputs[0], classes_.size(), kMinForeground,
                      static_cast<float>(params_.foreground_bias), labels_);
  if (classes_.size() > 1) {
    cv::Mat kept(1, 256, CV_8UC1, cv::Scalar(0));
    for (int label = 1; label < classes_.size(); ++label)
      if (classes_.kept(label)) kept.at<std::uint8_t>(label) = static_cast<std::uint8_t>(label);
    cv::LUT(labels_, kept, labels_);
  }
  return image_part(labels_, fit_).clone();
}

inline void DnnProvider::detect(const std::vector<cv::Mat>& outputs, SemanticResult& result) {
  boxes_.clear();
  const cv::Mat* head = nullptr;
  std::optional<PrototypeMasks> masks;
  switch (params_.decoder) {
    case NetworkDecoder::YoloRegions:
      for (const cv::Mat& output : outputs) decode_yolo_regions(output, layout(0), boxes_);
      break;
    case NetworkDecoder::Ssd:
      decode_ssd(only(outputs), layout(0), boxes_);
      break;
    default:
      head = &head_of(outputs, masks);
      decode_head(*head, layout(masks ? masks->coefficients() : 0));
  }
  suppress_doubles(boxes_, static_cast<float>(params_.max_overlap));
  result.detections.emplace();
  for (const NetworkBox& box : boxes_) {
    classes_.check(box.label);
    if (classes_.kept(box.label)) add(box, head, masks, *result.detections);
  }
  if (masks) result.labels = merged_masks(*result.detections, fit_.image);
}

inline const cv::Mat& DnnProvider::only(const std::vector<cv::Mat>& outputs) {
  if (outputs.size() != 1)
    throw Error("it has " + std::to_string(outputs.size()) +
                " outputs, expected one: name it with `outputs`");
  return outputs[0];
}

inline const cv::Mat& DnnProvider::head_of(const std::vector<cv::Mat>& outputs,
                                           std::optional<PrototypeMasks>& masks) const {
  const cv::Mat* head = nullptr;
  for (const cv::Mat& output : outputs) {
    if (output.dims == 4 && outputs.size() == 2)
      masks.emplace(output);
    else
      head = &output;
  }
  if (head == nullptr || outputs.size() > 2 || (outputs.size() == 2 && !masks))
    throw Error("it has " + std::to_string(outputs.size()) +
                " outputs, expected the boxes and at most 1xKxHxW mask prototypes: name them with `outputs`");
  return *head;
}

inline void DnnProvider::add(const NetworkBox& found, const cv::Mat* head,
                             std::optional<PrototypeMasks>& masks, std::vector<Detection>& detections) {
  Detection detection;
  detection.box = fit_.to_image(found.box);
  if (!(detection.box.width > 0) || !(detection.box.height > 0)) return;
  detection.class_id = found.label;
  detection.class_name = classes_.name(found.label);
  detection.score = std::min(found.score, 1.0F);
  if (masks) {
    const bool in_columns = params_.decoder == NetworkDecoder::YoloV8;
    detection.mask = masks->mask(mask_coefficients(*head, found.anchor, masks->coefficients(), in_columns),
                                 detection.box, fit_);
  }
  detections.push_back(std::move(detection));
}

}  // namespace dynfilter
