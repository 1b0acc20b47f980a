// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/semantic/process_protocol.hpp>

#include <cstddef>
#include <dynfilter/core/inline.hpp>
#include <dynfilter/core/numbers.hpp>
#include <exception>
#include <istream>
#include <opencv2/core.hpp>
#include <sstream>

namespace dynfilter {

namespace protocol {

DYNFILTER_INLINE Error unexpected(const std::string& expected, std::string line) {
  if (line.size() > 60) line = line.substr(0, 60) + "...";
  for (char& c : line)
    if (static_cast<unsigned char>(c) < 32 || static_cast<unsigned char>(c) > 126) c = '?';
  return Error("expected " + expected + ", got `" + line + "`");
}

DYNFILTER_INLINE void write_rows(MessageStream& stream, const cv::Mat& image) {
  for (int r = 0; r < image.rows; ++r)
    stream.write_bytes(image.ptr(r), static_cast<std::size_t>(image.cols) * image.elemSize());
}

DYNFILTER_INLINE void read_rows(MessageStream& stream, cv::Mat& image) {
  for (int r = 0; r < image.rows; ++r)
    stream.read_bytes(image.ptr(r), static_cast<std::size_t>(image.cols) * image.elemSize());
}

DYNFILTER_INLINE void write_image(MessageStream& stream, const SemanticImage& image) {
  if (image.pixels.type() != CV_8UC1 && image.pixels.type() != CV_8UC3)
    throw Error("an image must have 1 or 3 channels of 8 bits");
  std::ostringstream line = classic_output();
  line << "image " << image.frame_id << ' ' << fixed_text(image.timestamp_s, 9) << ' ' << image.pixels.cols
       << ' ' << image.pixels.rows << ' ' << image.pixels.channels() << '\n';
  stream.write_text(line.str());
  write_rows(stream, image.pixels);
}

DYNFILTER_INLINE void read_image(MessageStream& stream, SemanticImage& image) {
  const std::string line = stream.read_line();
  std::istringstream in = classic_input(line);
  std::string word;
  int width = 0, height = 0, channels = 0;
  in >> word >> image.frame_id >> image.timestamp_s >> width >> height >> channels;
  if (!in || word != "image" || width < 0 || height < 0 || width > kMaxSide || height > kMaxSide ||
      (channels != 1 && channels != 3))
    throw unexpected("`image ID TIMESTAMP WIDTH HEIGHT CHANNELS`", line);
  image.pixels.create(height, width, channels == 1 ? CV_8UC1 : CV_8UC3);
  read_rows(stream, image.pixels);
}

DYNFILTER_INLINE void write_result(MessageStream& stream, const std::optional<SemanticResult>& result) {
  if (result && result->detections) {
    stream.write_text("detections " + std::to_string(result->detections->size()) + "\n");
    for (const Detection& d : *result->detections) {
      std::ostringstream numbers = classic_output();
      numbers.precision(9);  // enough for every float
      numbers << d.class_id << ' ' << d.score << ' ' << d.box.x << ' ' << d.box.y << ' '
              << d.box.x + d.box.width << ' ' << d.box.y + d.box.height << ' ';
      stream.write_text(numbers.str() + d.class_name + "\n");
    }
  }
  if (result && result->labels) {
    stream.write_text("labels " + std::to_string(result->labels->cols) + " " +
                      std::to_string(result->labels->rows) + "\n");
    write_rows(stream, *result->labels);
  }
  stream.write_text("end\n");
}

DYNFILTER_INLINE Detection read_detection(const std::string& line) {
  std::istringstream in = classic_input(line);
  Detection d;
  float x1 = 0, y1 = 0, x2 = 0, y2 = 0;
  in >> d.class_id >> d.score >> x1 >> y1 >> x2 >> y2 >> std::ws;
  if (in.fail()) throw unexpected("`CLASS_ID SCORE X1 Y1 X2 Y2 CLASS NAME`", line);
  std::getline(in, d.class_name);
  d.box = {x1, y1, x2 - x1, y2 - y1};
  return d;
}

DYNFILTER_INLINE std::optional<SemanticResult> read_result(MessageStream& stream) {
  SemanticResult result;
  for (;;) {
    const std::string line = stream.read_line();
    std::istringstream in = classic_input(line);
    std::string word;
    in >> word;
    if (line == "end") break;
    if (word == "error") throw Told(line.size() > 6 ? line.substr(6) : "an error without a word");
    if (word == "detections") {
      int n = -1;
      in >> n;
      if (!in || n < 0 || n > kMaxDetections) throw unexpected("`detections N`", line);
      result.detections.emplace();
      for (int i = 0; i < n; ++i) result.detections->push_back(read_detection(stream.read_line()));
    } else if (word == "labels") {
      int width = 0, height = 0;
      in >> width >> height;
      if (!in || width < 1 || height < 1 || width > kMaxSide || height > kMaxSide)
        throw unexpected("`labels WIDTH HEIGHT`", line);
      result.labels = cv::Mat(height, width, CV_8UC1);
      read_rows(stream, *result.labels);
    } else {
      throw unexpected("`detections`, `labels`, `error` or `end`", line);
    }
  }
  if (!result.detections && !result.labels) return std::nullopt;
  return result;
}

DYNFILTER_INLINE void serve(SemanticProvider& provider, int in, int out) {
  MessageStream stream(in, out);
  stream.write_text(std::string(kHello) + "\n");
  SemanticImage image;
  try {
    for (;;) {
      read_image(stream, image);
      std::optional<SemanticResult> result;
      try {
        result = provider.infer(image);
      } catch (const std::exception& error) {
        std::string text = error.what();
        for (char& c : text)
          if (c == '\n') c = ' ';
        stream.write_text("error " + text.substr(0, 1000) + "\n");
        continue;
      }
      write_result(stream, result);
    }
  } catch (const EndOfStream&) {
    return;
  }
}

}  // namespace protocol

}  // namespace dynfilter
