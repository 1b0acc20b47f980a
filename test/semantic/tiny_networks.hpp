// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

/// Networks of a few numbers, written byte by byte, so that tests download nothing.
namespace tiny {

inline std::string varint(std::uint64_t value) {
  std::string bytes;
  for (; value >= 0x80; value >>= 7U) bytes += static_cast<char>((value & 0x7FU) | 0x80U);
  return bytes + static_cast<char>(value);
}
inline std::string number(unsigned field, std::uint64_t value) {
  return varint(field << 3U) + varint(value);
}
inline std::string bytes(unsigned field, const std::string& content) {
  return varint(field << 3U | 2U) + varint(content.size()) + content;
}

template <class T>
std::string raw(const std::vector<T>& values) {
  std::string text(values.size() * sizeof(T), '\0');
  std::memcpy(text.data(), values.data(), text.size());
  return text;
}

/// onnx.proto: TensorProto, its ValueInfoProto and NodeProto.
inline std::string tensor(const std::string& name, const std::vector<std::int64_t>& shape, int type,
                          const std::string& data) {
  std::string text;
  for (const std::int64_t size : shape) text += number(1, static_cast<std::uint64_t>(size));
  return text + number(2, static_cast<std::uint64_t>(type)) + bytes(8, name) + bytes(9, data);
}
inline std::string floats(const std::string& name, const std::vector<std::int64_t>& shape,
                          const std::vector<float>& values) {
  return tensor(name, shape, 1, raw(values));
}
inline std::string integers(const std::string& name, const std::vector<std::int64_t>& values) {
  return tensor(name, {static_cast<std::int64_t>(values.size())}, 7, raw(values));
}
inline std::string value_info(const std::string& name, const std::vector<std::int64_t>& shape) {
  std::string dims;
  for (const std::int64_t size : shape) dims += bytes(1, number(1, static_cast<std::uint64_t>(size)));
  return bytes(1, name) + bytes(2, bytes(1, number(1, 1) + bytes(2, dims)));
}
inline std::string node(const std::string& type, const std::vector<std::string>& inputs,
                        const std::string& output) {
  std::string text;
  for (const std::string& input : inputs) text += bytes(1, input);
  return text + bytes(2, output) + bytes(3, output + "_node") + bytes(4, type);
}
inline std::string model(const std::string& graph) {
  return number(1, 7) + bytes(7, graph) + bytes(8, bytes(1, "") + number(2, 12));
}

/// A 1 x 1 convolution.
/// Output k of a pixel is bias[k] + red * weights[3 k] + green * ... + blue * ...
struct PixelMap {
  std::vector<float> bias, weights;
  std::int64_t outputs() const { return static_cast<std::int64_t>(bias.size()); }
};

inline std::string convolution(const PixelMap& map, const std::string& name) {
  const std::string kernel_shape =
      bytes(5, bytes(1, "kernel_shape") + number(8, 1) + number(8, 1) + number(20, 7));
  return bytes(1, node("Conv", {"image", name + "_w", name + "_b"}, name) + kernel_shape) +
         bytes(5, floats(name + "_w", {map.outputs(), 3, 1, 1}, map.weights)) +
         bytes(5, floats(name + "_b", {map.outputs()}, map.bias));
}

/// Image -> map, 1 x outputs x height x width.
inline std::string onnx_map(const PixelMap& map, std::int64_t height, std::int64_t width) {
  return model(convolution(map, "scores") + bytes(2, "tiny") +
               bytes(11, value_info("image", {1, 3, height, width})) +
               bytes(12, value_info("scores", {1, map.outputs(), height, width})));
}

/// Image -> a head with one column per pixel, 1 x outputs x pixels.
/// With `prototypes`, a second output of 1 x K x height x width.
inline std::string onnx_head(const PixelMap& head, std::int64_t height, std::int64_t width,
                             const PixelMap& prototypes = {}) {
  std::string graph = convolution(head, "columns") + bytes(1, node("Reshape", {"columns", "shape"}, "head")) +
                      bytes(5, integers("shape", {1, head.outputs(), height * width}));
  if (prototypes.outputs() > 0) graph += convolution(prototypes, "prototypes");
  graph += bytes(2, "tiny") + bytes(11, value_info("image", {1, 3, height, width})) +
           bytes(12, value_info("head", {1, head.outputs(), height * width}));
  if (prototypes.outputs() > 0)
    graph += bytes(12, value_info("prototypes", {1, prototypes.outputs(), height, width}));
  return model(graph);
}

/// One [yolo] layer after one convolution; an anchor of 2 x 2 pixels per one-pixel cell, one class.
inline std::string darknet_config(int height, int width) {
  return "[net]\nwidth=" + std::to_string(width) + "\nheight=" + std::to_string(height) +
         "\nchannels=3\n\n[convolutional]\nsize=1\nstride=1\npad=0\nfilters=6\nactivation=linear\n\n"
         "[yolo]\nmask=0\nanchors=2,2\nclasses=1\nnum=1\n";
}
/// Weights for it: an object where red is above 0.5, with the box in the middle of the cell.
inline std::string darknet_weights() {
  std::vector<float> values{0, 0, 0, 0, -20, 20};  // x y w h objectness class
  std::vector<float> weights(6 * 3, 0.0F);
  weights[4 * 3] = 40;
  values.insert(values.end(), weights.begin(), weights.end());
  return raw(std::vector<std::int32_t>{0, 2, 0, 0, 0}) + raw(values);
}

}  // namespace tiny
