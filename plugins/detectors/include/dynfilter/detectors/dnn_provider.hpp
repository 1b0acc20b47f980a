// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/config/field_table.hpp>
#include <dynfilter/core/error.hpp>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/detectors/class_list.hpp>
#include <dynfilter/detectors/decode_boxes.hpp>
#include <dynfilter/detectors/decode_masks.hpp>
#include <dynfilter/detectors/dnn_network.hpp>
#include <dynfilter/detectors/input_fit.hpp>
#include <dynfilter/detectors/network_boxes.hpp>
#include <dynfilter/detectors/network_input.hpp>
#include <dynfilter/semantic/provider.hpp>
#include <dynfilter/semantic/provider_registry.hpp>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <vector>

namespace dynfilter {

/// Layout of a network's output.
enum class NetworkDecoder { YoloRegions, YoloV5, YoloV8, Ssd, ClassScores };

struct DnnParams {
  std::string network, config;
  NetworkDecoder decoder = NetworkDecoder::YoloRegions;
  std::vector<std::string> outputs;
  NetworkInputParams input;
  std::vector<std::string> classes;
  std::string class_file;
  int first_label = 0;
  std::vector<std::string> keep;
  double min_score = 0.4, max_overlap = 0.45, foreground_bias = 0;

  static const FieldTable<DnnParams>& fields();
};

/// A network that cv::dnn runs on the CPU.
/// A detector returns boxes, and masks if it has prototypes. A segmenter returns a label image.
///
/// Files:   Darknet, ONNX, Caffe, TensorFlow (`network_files.hpp`), checked before OpenCV reads them.
/// Input:   resized or letterboxed, (pixel - mean) * scale / std, three channels.
/// Output:  boxes in pixels of the image, clipped at its borders,
///          with non-maximum suppression per class.
///          The label image of a segmenter covers the image at the network's resolution.
///          Instance masks are also merged into a label image, label = class id + 1.
/// Errors:  IoError naming the network file.
///          The constructor runs the network once on a grey image,
///          to detect a wrong layout or class list before the first frame.
/// Threads: OpenCV's own. Their number is a setting of the process and is not changed here.
class DnnProvider final : public SemanticProvider {
 public:
  using Params = DnnParams;
  static constexpr const char* kName = "dnn";
  static constexpr const char* kSummary = "a network file, run by OpenCV's dnn module";

  /// Opens and tries the network; throws IoError and ConfigError.
  DnnProvider(Params params, const ProviderFiles& files);

  std::string name() const override { return kName; }

  std::optional<SemanticResult> infer(const SemanticImage& image) override;

 private:
  /// Of a foreground map, the only output of class_scores with one class: a probability, as trained.
  static constexpr float kMinForeground = 0.5F;

  static const Params& checked(const Params& params);

  static DnnNetwork opened(const Params& params, const ProviderFiles& files);

  template <class F>
  void naming_the_network(const F& f) const;

  ClassList class_list(const ProviderFiles& files) const;

  cv::Mat label_image(const std::vector<cv::Mat>& outputs);

  void detect(const std::vector<cv::Mat>& outputs, SemanticResult& result);

  BoxLayout layout(int coefficients) const {
    return {input_.size(), classes_.size(), coefficients, static_cast<float>(params_.min_score)};
  }
  static const cv::Mat& only(const std::vector<cv::Mat>& outputs);
  void decode_head(const cv::Mat& head, const BoxLayout& layout) {
    params_.decoder == NetworkDecoder::YoloV5 ? decode_yolov5(head, layout, boxes_)
                                              : decode_yolov8(head, layout, boxes_);
  }
  /// The output with the boxes. A second output with four dimensions contains mask prototypes.
  const cv::Mat& head_of(const std::vector<cv::Mat>& outputs, std::optional<PrototypeMasks>& masks) const;

  void add(const NetworkBox& found, const cv::Mat* head, std::optional<PrototypeMasks>& masks,
           std::vector<Detection>& detections);

  Params params_;
  NetworkInput input_;
  DnnNetwork network_;
  ClassList classes_;
  InputFit fit_;
  std::vector<NetworkBox> boxes_;
  cv::Mat labels_;
};

}  // namespace dynfilter
