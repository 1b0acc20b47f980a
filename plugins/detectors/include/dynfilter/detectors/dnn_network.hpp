// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/core/error.hpp>
#include <dynfilter/detectors/network_files.hpp>
#include <filesystem>
#include <opencv2/core.hpp>
#include <opencv2/dnn/dnn.hpp>
#include <string>
#include <vector>

namespace dynfilter {

/// A network in OpenCV's cv::dnn on the CPU. No other header includes cv::dnn.
/// Files are checked before OpenCV reads them.
/// OpenCV's exceptions become one line that names the file.
class DnnNetwork {
 public:
  /// `config`: the .cfg of Darknet, .prototxt of Caffe or .pbtxt of TensorFlow (optional).
  /// Empty for ONNX.
  /// `outputs`: layer names; empty: all layers without a successor. Throws IoError.
  DnnNetwork(const std::filesystem::path& network, const std::filesystem::path& config,
             std::vector<std::string> outputs);

  const std::string& file() const { return file_; }  ///< path of the network file

  /// `blob`: 1 x C x H x W floats. The outputs are valid until the next call.
  const std::vector<cv::Mat>& forward(const cv::Mat& blob);

 private:
  void check_files(const Bytes& weights, const std::filesystem::path& config, const std::string& text) const;

  void load(const Bytes& weights, const Bytes& text);

  template <class F>
  void guarded(const std::string& what, const F& f);

  static std::string one_line(const std::string& text);

  std::string file_;
  NetworkFormat format_;
  std::vector<std::string> outputs_;
  cv::dnn::Net net_;
  std::vector<cv::Mat> results_;
};

}  // namespace dynfilter
