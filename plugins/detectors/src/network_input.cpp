// SPDX-License-Identifier: MIT
#include <dynfilter/detectors/network_input.hpp>

#include <array>
#include <cstdint>
#include <dynfilter/config/parameters.hpp>
#include <dynfilter/core/error.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <utility>

namespace dynfilter {

const FieldTable<NetworkInputParams>& NetworkInputParams::fields() {
  using P = NetworkInputParams;
  static const FieldTable<P> table{
      integer("width_px", &P::width_px, "px", {1, 8192}, "width of the network's input"),
      integer("height_px", &P::height_px, "px", {1, 8192}, "height of the network's input"),
      choice("fit", &P::fit, {{"stretch", ImageFit::Stretch}, {"letterbox", ImageFit::Letterbox}},
             "stretch scales both sides independently; letterbox uses one scale and fills the rest"),
      real("scale", &P::scale, "", {1e-9, 1e9}, "input = (pixel - mean) * scale / std, pixels 0 to 255"),
      reals("mean", &P::mean, "", {-1e6, 1e6}, "one number, or one per channel in the network's order"),
      reals("std", &P::std, "", {1e-9, 1e9}, "one number, or one per channel in the network's order"),
      choice("channels", &P::channels, {{"rgb", ChannelOrder::Rgb}, {"bgr", ChannelOrder::Bgr}},
             "channel order of the network"),
      integer("padding", &P::padding, "", {0, 255}, "grey value of the filled borders, for letterbox"),
  };
  return table;
}

NetworkInput::NetworkInput(NetworkInputParams params) : params_(std::move(params)) {
  check_parameters(params_);
  for (const auto& [name, list] : {std::pair{"mean", &params_.mean}, {"std", &params_.std}})
    if (list->size() != 1 && list->size() != 3)
      throw ConfigError(name, "expected one number or three, got " + std::to_string(list->size()));
}

const cv::Mat& NetworkInput::tensor(const cv::Mat& image, InputFit& fit) {
  fit = InputFit::of(image.size(), size(), params_.fit);
  const cv::Mat* colour = &image;
  if (image.channels() == 1) {
    cv::cvtColor(image, colour_, cv::COLOR_GRAY2BGR);
    colour = &colour_;
  }
  fitted_.create(size(), CV_8UC3);
  const cv::Rect area = fit.area();
  if (area.size() != size()) fitted_.setTo(cv::Scalar::all(params_.padding));
  cv::Mat part = fitted_(area);
  cv::resize(*colour, part, area.size(), 0, 0, cv::INTER_LINEAR);
  fill_tensor();
  return tensor_;
}

inline void NetworkInput::fill_tensor() {
  const std::array<int, 4> shape{1, 3, params_.height_px, params_.width_px};
  tensor_.create(4, shape.data(), CV_32FC1);
  const std::size_t n = fitted_.total();
  const auto* pixels = fitted_.ptr<std::uint8_t>();
  for (std::size_t c = 0; c < 3; ++c) {
    const auto gain = static_cast<float>(params_.scale / of_channel(params_.std, c));
    const auto mean = static_cast<float>(of_channel(params_.mean, c));
    const std::size_t from = params_.channels == ChannelOrder::Rgb ? 2 - c : c;
    float* to = tensor_.ptr<float>() + c * n;
    for (std::size_t i = 0; i < n; ++i) to[i] = (static_cast<float>(pixels[3 * i + from]) - mean) * gain;
  }
}

}  // namespace dynfilter
