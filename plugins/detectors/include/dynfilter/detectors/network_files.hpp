// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

/// Checks of a network's files before a parser reads them.
/// cv::dnn reads beyond the end of truncated weights, and protobuf writes to stderr.
namespace dynfilter {

/// Format of the weights file.
enum class NetworkFormat { Darknet, Onnx, Caffe, TensorFlow };

std::string to_string(NetworkFormat format);  ///< its name, as in messages

/// Determined by the suffix of the weights file. Throws Error.
NetworkFormat network_format(const std::filesystem::path& network);

using Bytes = std::vector<unsigned char>;

namespace detail {

/// Reads a base-128 number at `at` and advances `at`. nullopt if the bytes end inside it.
std::optional<std::uint64_t> varint(const Bytes& bytes, std::size_t& at);

std::string without_blanks(std::string text);

}  // namespace detail

/// Checks that the bytes are complete protobuf fields, as in ONNX, TensorFlow and Caffe files.
/// Returns "" or the fault. Checks the outermost fields only.
std::string protobuf_fault(const Bytes& bytes);

/// Checks that the text may be protobuf text (.prototxt, .pbtxt): its braces are balanced.
/// Returns "" or the fault.
std::string protobuf_text_fault(const std::string& text);

/// Checks that a Darknet weights file has the size that its configuration requires.
/// Returns "" or the fault; "" also if the number of weights of some layer is unknown here.
/// Throws Error for an invalid configuration.
std::string darknet_fault(const std::string& config, const Bytes& weights);

}  // namespace dynfilter
