// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <dynfilter/config/field_table.hpp>
#include <dynfilter/core/error.hpp>
#include <dynfilter/detectors/input_fit.hpp>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
#include <vector>

namespace dynfilter {

/// Order of a pixel's channels in the input.
enum class ChannelOrder { Rgb, Bgr };

struct NetworkInputParams {
  int width_px = 0, height_px = 0;
  ImageFit fit = ImageFit::Stretch;
  double scale = 1;
  std::vector<double> mean{0}, std{1};
  ChannelOrder channels = ChannelOrder::Rgb;
  int padding = 114;

  static const FieldTable<NetworkInputParams>& fields();
};

/// Converts images to a network's input tensor, 1 x 3 x H x W floats.
/// Buffers are reused from image to image.
class NetworkInput {
 public:
  /// Throws ConfigError if a parameter is out of range.
  explicit NetworkInput(NetworkInputParams params);

  cv::Size size() const { return {params_.width_px, params_.height_px}; }

  /// `image`: CV_8UC3 (BGR) or CV_8UC1, not empty. The tensor is valid until the next call.
  const cv::Mat& tensor(const cv::Mat& image, InputFit& fit);

 private:
  static double of_channel(const std::vector<double>& list, std::size_t c) {
    return list.size() == 1 ? list[0] : list[c];
  }

  void fill_tensor();

  NetworkInputParams params_;
  cv::Mat colour_, fitted_, tensor_;
};

}  // namespace dynfilter
