// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/core/detection.hpp>
#include <dynfilter/core/error.hpp>
#include <dynfilter/semantic/message_stream.hpp>
#include <dynfilter/semantic/provider.hpp>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>

namespace dynfilter {

/// Messages between a provider in another process and its host (docs/reference/provider_process.md).
/// Lines of text, then raw pixels. Version 1.
namespace protocol {

inline constexpr const char* kHello = "dynfilter-provider 1";
inline constexpr int kMaxSide = 16384;
inline constexpr int kMaxDetections = 10000;

/// An exception of the provider, reported by the protocol.
class Told : public Error {
 public:
  using Error::Error;
};

Error unexpected(const std::string& expected, std::string line);

void write_rows(MessageStream& stream, const cv::Mat& image);
void read_rows(MessageStream& stream, cv::Mat& image);

/// Writes `image ID TIMESTAMP WIDTH HEIGHT CHANNELS`, then the rows.
void write_image(MessageStream& stream, const SemanticImage& image);

void read_image(MessageStream& stream, SemanticImage& image);

/// Writes `detections N` with N lines `CLASS_ID SCORE X1 Y1 X2 Y2 CLASS NAME`,
/// and `labels WIDTH HEIGHT` with the rows. Each part is optional. Ends with `end`.
void write_result(MessageStream& stream, const std::optional<SemanticResult>& result);

Detection read_detection(const std::string& line);

std::optional<SemanticResult> read_result(MessageStream& stream);

/// The provider's side: answers images on `in` until the host closes the stream.
/// Exceptions of the provider are reported to the host.
/// Throws Error if the input violates the protocol.
void serve(SemanticProvider& provider, int in, int out);

}  // namespace protocol

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/semantic/detail/process_protocol-inl.hpp>
#endif
