// SPDX-License-Identifier: MIT
#include <dynfilter/detectors/dnn_network.hpp>

#include <cctype>
#include <cstddef>
#include <dynfilter/core/error.hpp>
#include <dynfilter/detectors/image_file.hpp>
#include <exception>
#include <utility>

namespace dynfilter {

DnnNetwork::DnnNetwork(const std::filesystem::path& network, const std::filesystem::path& config,
                       std::vector<std::string> outputs)
    : file_(network.string()), format_(network_format(network)), outputs_(std::move(outputs)) {
  if (format_ != NetworkFormat::Onnx && format_ != NetworkFormat::TensorFlow && config.empty())
    throw IoError(file_ + ": a " + to_string(format_) + " network also needs its configuration (`config`)");
  const Bytes weights = io::detail::read_bytes(network);
  const Bytes text = config.empty() ? Bytes() : io::detail::read_bytes(config);
  check_files(weights, config, std::string(text.begin(), text.end()));
  guarded("cannot load this " + to_string(format_) + " network", [&] { load(weights, text); });
  guarded("cannot use this network", [&] {
    if (net_.empty()) throw Error("it is empty");
    net_.setPreferableBackend(cv::dnn::DNN_BACKEND_OPENCV);
    net_.setPreferableTarget(cv::dnn::DNN_TARGET_CPU);
    if (outputs_.empty()) outputs_ = net_.getUnconnectedOutLayersNames();
    for (const std::string& name : outputs_)
      if (net_.getLayerId(name) < 0) throw Error("it has no output `" + name + "`");
  });
}

const std::vector<cv::Mat>& DnnNetwork::forward(const cv::Mat& blob) {
  guarded("cannot run this network on an input of 1x" + std::to_string(blob.size[1]) + "x" +
              std::to_string(blob.size[2]) + "x" + std::to_string(blob.size[3]) +
              " (channels, height, width)",
          [&] {
            net_.setInput(blob);
            results_.clear();
            net_.forward(results_, outputs_);
          });
  return results_;
}

inline void DnnNetwork::check_files(const Bytes& weights, const std::filesystem::path& config,
                                    const std::string& text) const {
  const auto refuse = [](const std::string& file, const std::string& fault) {
    if (!fault.empty()) throw IoError(file + ": " + fault);
  };
  if (format_ == NetworkFormat::Darknet) {
    std::string fault;
    try {
      fault = darknet_fault(text, weights);
    } catch (const Error& error) {
      throw IoError(config.string() + ": " + error.what());
    }
    return refuse(file_, fault);
  }
  refuse(file_, protobuf_fault(weights));
  if (!config.empty()) refuse(config.string(), protobuf_text_fault(text));
}

inline void DnnNetwork::load(const Bytes& weights, const Bytes& text) {
  switch (format_) {
    case NetworkFormat::Darknet: {
      Bytes lines;  // Windows line ends crash the reader
      for (const unsigned char c : text)
        if (c != '\r') lines.push_back(c);
      net_ = cv::dnn::readNetFromDarknet(lines, weights);
      return;
    }
    case NetworkFormat::Onnx:
      net_ = cv::dnn::readNetFromONNX(weights);
      return;
    case NetworkFormat::Caffe:
      net_ = cv::dnn::readNetFromCaffe(text, weights);
      return;
    case NetworkFormat::TensorFlow:
      net_ = cv::dnn::readNetFromTensorflow(weights, text);
  }
}

template <class F>
void DnnNetwork::guarded(const std::string& what, const F& f) {
  try {
    f();
  } catch (const cv::Exception& error) {
    throw IoError(file_ + ": OpenCV " + CV_VERSION + " " + what + ": " + one_line(error.err));
  } catch (const std::exception& error) {
    throw IoError(file_ + ": " + one_line(error.what()));
  }
}

inline std::string DnnNetwork::one_line(const std::string& text) {
  constexpr std::size_t kMost = 400;
  std::string line;
  for (const char c : text) {
    const bool blank = std::isspace(static_cast<unsigned char>(c)) != 0;
    if (!blank && !(line.empty() && c == '>')) line += c;
    if (blank && !line.empty() && line.back() != ' ') line += ' ';
  }
  if (line.size() > kMost) line = line.substr(0, kMost) + "...";
  return line;
}

}  // namespace dynfilter
