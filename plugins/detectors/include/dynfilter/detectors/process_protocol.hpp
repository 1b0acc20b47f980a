// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <dynfilter/core/error.hpp>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/detectors/message_stream.hpp>
#include <dynfilter/semantic/provider.hpp>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>

namespace dynfilter {

/// Messages between a provider in another process and its host (docs/reference/provider_process.md).
/// Lines of text, then raw pixels. Version 1.
namespace protocol {

inline constexpr const char* kHello = "dynfilter-provider 1";

/// An exception of the provider, reported by the protocol.
class Told : public Error {
 public:
  using Error::Error;  ///< made from the program's message
};

/// One answer of the program.
struct Answer {
  std::optional<std::int64_t> frame_id;  ///< of its line `result ID`; unset: it has none
  std::optional<SemanticResult> result;
  std::string error;  ///< why there is no result; empty: it did not fail
};

/// What came instead; control characters are replaced.
Error unexpected(const std::string& expected, std::string line);

void write_rows(MessageStream& stream, const cv::Mat& image);  ///< pixels of the image, row by row
void read_rows(MessageStream& stream, cv::Mat& image);         ///< into an image of the right size and type

/// Writes `image ID TIMESTAMP WIDTH HEIGHT CHANNELS`, then the rows. Throws Error for other types of images.
void write_image(MessageStream& stream, const SemanticImage& image);

/// The host's next image, as write_image() wrote it; throws Error.
void read_image(MessageStream& stream, SemanticImage& image);

/// Writes `result ID` if the result has a frame id, `detections N` with N lines `CLASS_ID SCORE X1 Y1 X2 Y2
/// CLASS NAME`, and `labels WIDTH HEIGHT` with the rows. Each part is optional. Ends with `end`.
void write_result(MessageStream& stream, const std::optional<SemanticResult>& result);

/// Control characters of the class name become `?`.
Detection read_detection(const std::string& line);

/// Reads the next answer. One with boxes that cannot be is an error of the program:
/// a score out of [0, 1], or coordinates of a million pixels and more.
/// Throws Error if it violates the protocol.
Answer read_answer(MessageStream& stream);

/// Reads the answer to this image. Answers to other images are dropped.
Answer read_answer(MessageStream& stream, std::int64_t frame_id);

/// The next answer's result. Throws Told if the program failed.
std::optional<SemanticResult> read_result(MessageStream& stream);

/// The provider's side: answers images on `in` until the host closes the stream.
/// Exceptions of the provider are reported to the host.
/// Throws Error if the input violates the protocol.
void serve(SemanticProvider& provider, int in, int out);

}  // namespace protocol

}  // namespace dynfilter
