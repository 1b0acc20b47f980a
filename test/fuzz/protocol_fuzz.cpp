// SPDX-License-Identifier: MIT
// The messages between a detector's process and its host. The first byte tells which side reads the rest, or
// that results made of it are written and read again.
#include <cstdint>
#include <dynfilter/core/error.hpp>
#include <dynfilter/core/limits.hpp>
#include <dynfilter/detectors/message_stream.hpp>
#include <dynfilter/detectors/process_protocol.hpp>
#include <dynfilter/semantic/provider.hpp>
#include <optional>
#include <string>

#include "bytes.hpp"
#include "memory_file.hpp"
#include "target.hpp"

namespace {

using namespace dynfilter;
using fuzz::Bytes;
using fuzz::MemoryFile;
using fuzz::require;

constexpr int kMaxMessages = 16;

/// Answers what the first pixels of the image say.
class Provider final : public SemanticProvider {
 public:
  std::string name() const override { return "fuzz"; }
  std::optional<SemanticResult> infer(const SemanticImage& image) override {
    if (image.pixels.empty()) throw Error("an empty\nimage");
    const int first = image.pixels.ptr(0)[0];
    if (first % 4 == 0) return std::nullopt;
    SemanticResult result;
    if (first % 4 != 1) result.detections.emplace(static_cast<std::size_t>(first), Detection());
    if (first % 4 != 2) result.labels = image.pixels;
    return result;
  }
};

void host_reads(const std::string& bytes) {
  const MemoryFile file(bytes);
  MessageStream stream(file.fd(), file.fd());
  for (int k = 0; k < kMaxMessages; ++k) {
    const protocol::Answer answer =
        k % 2 == 0 ? protocol::read_answer(stream) : protocol::read_answer(stream, k);
    require(answer.error.empty() || !answer.result, "an answer is an error or a result");
    if (!answer.result || !answer.result->detections) continue;
    require(answer.result->detections->size() <= limits::kMaxBoxes, "boxes per frame have a limit");
    for (const Detection& d : *answer.result->detections) {
      require(d.score >= 0 && d.score <= 1, "scores are in [0, 1]");
      for (const char c : d.class_name)
        require(static_cast<unsigned char>(c) >= 32 && c != 127, "names have no control characters");
    }
  }
}

void provider_reads(const std::string& bytes) {
  const MemoryFile images(bytes), answers;
  Provider provider;
  protocol::serve(provider, images.fd(), answers.fd());
}

void result_is_read_again(Bytes& in) {
  SemanticResult result;
  result.frame_id = in.take<std::int64_t>() & INT64_MAX;
  if (in.flag()) {
    result.detections.emplace();
    for (int n = in.below(8); n > 0; --n) {
      const float x = in.take<std::int16_t>(), y = in.take<std::int16_t>();
      result.detections->push_back({{x, y, static_cast<float>(in.byte()), static_cast<float>(in.byte())},
                                    in.take<std::int32_t>(),
                                    "a b",
                                    static_cast<float>(in.byte()) / 255.0F,
                                    -1,
                                    {}});
    }
  }
  if (in.flag()) result.labels = cv::Mat(1 + in.below(9), 1 + in.below(9), CV_8UC1, cv::Scalar(in.byte()));
  const MemoryFile file;
  MessageStream stream(file.fd(), file.fd());
  protocol::write_result(stream, result);
  file.rewind();
  const protocol::Answer answer = protocol::read_answer(stream, result.frame_id);
  require(answer.error.empty() && answer.frame_id == result.frame_id, "a result is read again");
  require(answer.result.has_value() == (result.detections || result.labels), "what was sent arrives");
  if (!answer.result) return;
  require(answer.result->detections.has_value() == result.detections.has_value() &&
              answer.result->labels.has_value() == result.labels.has_value(),
          "boxes and labels arrive");
  if (result.labels)
    require(cv::norm(*result.labels, *answer.result->labels) == 0, "labels arrive unchanged");
  if (!result.detections) return;
  require(answer.result->detections->size() == result.detections->size(), "every box arrives");
  for (std::size_t k = 0; k < result.detections->size(); ++k) {
    const Detection &a = (*result.detections)[k], &b = (*answer.result->detections)[k];
    require(a.box == b.box && a.score == b.score && a.class_id == b.class_id && a.class_name == b.class_name,
            "a box arrives unchanged");
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Bytes in(data, size);
  const int way = in.below(3);
  if (way == 2) {
    result_is_read_again(in);
    return 0;
  }
  try {
    way == 0 ? host_reads(in.rest()) : provider_reads(in.rest());
  } catch (const Error& error) {
    fuzz::require_one_line(error.what());
  }
  return 0;
}
