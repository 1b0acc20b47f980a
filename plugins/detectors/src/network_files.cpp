// SPDX-License-Identifier: MIT
#include <dynfilter/detectors/network_files.hpp>

#include <algorithm>
#include <dynfilter/config/numbers.hpp>
#include <dynfilter/config/text_lines.hpp>
#include <dynfilter/core/error.hpp>
#include <map>
#include <sstream>

namespace dynfilter {

std::string to_string(NetworkFormat format) {
  constexpr const char* kNames[] = {"Darknet", "ONNX", "Caffe", "TensorFlow"};
  return kNames[static_cast<std::size_t>(format)];
}

NetworkFormat network_format(const std::filesystem::path& network) {
  const std::string suffix = network.extension().string();
  if (suffix == ".weights") return NetworkFormat::Darknet;
  if (suffix == ".onnx") return NetworkFormat::Onnx;
  if (suffix == ".caffemodel") return NetworkFormat::Caffe;
  if (suffix == ".pb") return NetworkFormat::TensorFlow;
  throw Error(
      network.string() +
      ": expected a network file: .weights (Darknet), .onnx, .caffemodel (Caffe) or .pb (TensorFlow)");
}

namespace detail {

std::optional<std::uint64_t> varint(const Bytes& bytes, std::size_t& at) {
  std::uint64_t value = 0;
  for (unsigned shift = 0; shift < 70 && at < bytes.size(); shift += 7) {
    const std::uint64_t byte = bytes[at++];
    if (shift < 64) value |= (byte & 0x7FU) << shift;
    if (byte < 0x80) return value;
  }
  return std::nullopt;
}

struct ConfigSection {
  std::string type;
  int line = 0;
  std::map<std::string, std::string> values;

  int number(const std::string& key, int otherwise) const {
    const auto it = values.find(key);
    const auto value = it == values.end() ? std::nullopt : io::parse_number(it->second);
    return value && *value >= -1e6 && *value <= 1e6 ? static_cast<int>(*value) : otherwise;
  }
};

std::string without_blanks(std::string text) {
  text.erase(
      std::remove_if(text.begin(), text.end(), [](char c) { return c == ' ' || c == '\t' || c == '\r'; }),
      text.end());
  return text;
}

/// Parses the sections of a Darknet .cfg. Throws Error with the line.
inline std::vector<ConfigSection> darknet_sections(const std::string& config) {
  std::vector<ConfigSection> sections;
  std::istringstream lines(config);
  int number = 0;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    line = without_blanks(line);
    if (line.empty() || line[0] == '#' || line[0] == ';') continue;
    const auto equals = line.find('=');
    if (line[0] == '[' && line.back() == ']')
      sections.push_back({line.substr(1, line.size() - 2), number, {}});
    else if (equals == std::string::npos || sections.empty())
      throw Error("line " + std::to_string(number) + ": expected `[section]` or `key=value`, got `" +
                  line.substr(0, 40) + "`");
    else
      sections.back().values[line.substr(0, equals)] = line.substr(equals + 1);
  }
  if (sections.empty() || (sections[0].type != "net" && sections[0].type != "network"))
    throw Error("expected a Darknet configuration that begins with [net]");
  return sections;
}

/// The layers that a [route] or [shortcut] names, absolute or relative to layer `here`.
inline std::vector<std::size_t> layers_named(const ConfigSection& section, const char* key,
                                             std::size_t here) {
  std::vector<std::size_t> layers;
  const auto it = section.values.find(key);
  std::istringstream words(it == section.values.end() ? "" : it->second);
  for (std::string word; std::getline(words, word, ',');) {
    const double value = io::parse_number(word).value_or(1e9);
    const double layer = value < 0 ? static_cast<double>(here) + value : value;
    if (!(layer >= 0 && layer < static_cast<double>(here)))
      throw Error("line " + std::to_string(section.line) + ": [" + section.type + "] names layer `" + word +
                  "`, which does not come before it");
    layers.push_back(static_cast<std::size_t>(layer));
  }
  return layers;
}

/// Computes the channels after each layer and the total number of weights.
class DarknetCount {
 public:
  explicit DarknetCount(const std::vector<ConfigSection>& sections) {
    current_ = sections[0].number("channels", 3);
    for (std::size_t i = 1; i < sections.size() && known_; ++i) {
      add(sections[i], i - 1);
      channels_.push_back(current_);
    }
  }
  /// nullopt if the number of weights of some layer is unknown here.
  std::optional<std::size_t> weights() const { return known_ ? std::make_optional(weights_) : std::nullopt; }

 private:
  void add(const ConfigSection& section, std::size_t here) {
    static const std::vector<std::string> plain{"maxpool", "avgpool", "upsample", "dropout",  "yolo",
                                                "region",  "softmax", "cost",     "detection"};
    if (section.type == "convolutional")
      convolution(section);
    else if (section.type == "route")
      route(section, here);
    else if (section.type == "shortcut" && section.values.count("weights_type") == 0)
      layers_named(section, "from", here);
    else
      known_ = std::find(plain.begin(), plain.end(), section.type) != plain.end();
  }
  void convolution(const ConfigSection& section) {
    const int filters = section.number("filters", 1), size = section.number("size", 1);
    const int groups = std::max(section.number("groups", 1), 1);
    if (filters <= 0 || size <= 0 || current_ < groups)
      throw Error("line " + std::to_string(section.line) + ": [convolutional] with filters, size or groups " +
                  "that cannot be");
    const bool normalised = section.number("batch_normalize", 0) != 0;
    weights_ += static_cast<std::size_t>(filters) * (normalised ? 4U : 1U) +
                static_cast<std::size_t>(filters) * static_cast<std::size_t>(current_ / groups) *
                    static_cast<std::size_t>(size) * static_cast<std::size_t>(size);
    current_ = filters;
  }
  void route(const ConfigSection& section, std::size_t here) {
    int sum = 0;
    for (const std::size_t layer : layers_named(section, "layers", here)) sum += channels_[layer];
    current_ = sum / std::max(section.number("groups", 1), 1);
  }

  std::vector<int> channels_;
  std::size_t weights_ = 0;
  int current_ = 3;
  bool known_ = true;
};

}  // namespace detail

std::string protobuf_fault(const Bytes& bytes) {
  if (bytes.empty()) return "is empty";
  std::size_t at = 0;
  while (at < bytes.size()) {
    const auto key = detail::varint(bytes, at);
    if (!key) return "is truncated";
    const std::uint64_t left = bytes.size() - at;
    std::uint64_t skip = 0;
    if (*key >> 3U == 0) return "is no protobuf file";
    switch (*key & 7U) {
      case 0:
        if (!detail::varint(bytes, at)) return "is truncated";
        continue;
      case 1:
        skip = 8;
        break;
      case 5:
        skip = 4;
        break;
      case 2: {
        const auto length = detail::varint(bytes, at);
        if (!length || *length > bytes.size() - at) return "is truncated";
        skip = *length;
        break;
      }
      default:
        return "is no protobuf file";
    }
    if (skip > left) return "is truncated";
    at += static_cast<std::size_t>(skip);
  }
  return "";
}

std::string protobuf_text_fault(const std::string& text) {
  int depth = 0;
  bool quoted = false, comment = false, any = false;
  for (const char c : text) {
    if (c == '\n') comment = false;
    if (comment) continue;
    if (static_cast<unsigned char>(c) < 9) return "is not a text";
    if (c == '"') quoted = !quoted;
    if (quoted) continue;
    comment = c == '#';
    depth += c == '{' ? 1 : c == '}' ? -1 : 0;
    any = any || c == ':' || c == '{';
    if (depth < 0) return "has a `}` too much";
  }
  if (!any) return text.empty() ? "is empty" : "is not a protobuf text";
  return depth > 0 || quoted ? "is truncated" : "";
}

std::string darknet_fault(const std::string& config, const Bytes& weights) {
  const auto count = detail::DarknetCount(detail::darknet_sections(config)).weights();
  if (weights.size() < 16) return weights.empty() ? "is empty" : "is truncated";
  // major, minor, revision; then the number of training images, 8 bytes since version 0.2.
  const std::int32_t version = static_cast<std::int32_t>(weights[0]) * 10 + weights[4];
  const std::size_t header = version >= 2 ? 20 : 16;
  if (!count || weights.size() == header + 4 * *count) return "";
  return "has " + std::to_string(weights.size()) + " bytes, but its configuration needs " +
         std::to_string(header + 4 * *count);
}

}  // namespace dynfilter
