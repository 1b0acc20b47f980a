// SPDX-License-Identifier: MIT
#include <dynfilter/detectors/process_protocol.hpp>

#include <cmath>
#include <cstddef>
#include <dynfilter/config/numbers.hpp>
#include <dynfilter/core/limits.hpp>
#include <dynfilter/core/printable_text.hpp>
#include <exception>
#include <istream>
#include <opencv2/core.hpp>
#include <sstream>
#include <utility>
#include <vector>

namespace dynfilter {

namespace protocol {

Error unexpected(const std::string& expected, std::string line) {
  if (line.size() > 60) line = line.substr(0, 60) + "...";
  for (char& c : line)
    if (static_cast<unsigned char>(c) < 32 || static_cast<unsigned char>(c) > 126) c = '?';
  return Error("expected " + expected + ", got `" + line + "`");
}

void write_rows(MessageStream& stream, const cv::Mat& image) {
  for (int r = 0; r < image.rows; ++r)
    stream.write_bytes(image.ptr(r), static_cast<std::size_t>(image.cols) * image.elemSize());
}

void read_rows(MessageStream& stream, cv::Mat& image) {
  for (int r = 0; r < image.rows; ++r)
    stream.read_bytes(image.ptr(r), static_cast<std::size_t>(image.cols) * image.elemSize());
}

void write_image(MessageStream& stream, const SemanticImage& image) {
  if (image.pixels.type() != CV_8UC1 && image.pixels.type() != CV_8UC3)
    throw Error("an image must have 1 or 3 channels of 8 bits");
  std::ostringstream line = classic_output();
  line << "image " << image.frame_id << ' ' << fixed_text(image.timestamp_s, 9) << ' ' << image.pixels.cols
       << ' ' << image.pixels.rows << ' ' << image.pixels.channels() << '\n';
  stream.write_text(line.str());
  write_rows(stream, image.pixels);
}

inline bool fits(int width, int height) {
  return width > 0 && height > 0 && width <= limits::kMaxImageSide_px && height <= limits::kMaxImageSide_px &&
         std::int64_t{width} * height <= limits::kMaxImagePixels;
}

void read_image(MessageStream& stream, SemanticImage& image) {
  const std::string line = stream.read_line();
  std::istringstream in = classic_input(line);
  std::string word;
  int width = 0, height = 0, channels = 0;
  in >> word >> image.frame_id >> image.timestamp_s >> width >> height >> channels;
  const bool empty = width == 0 && height == 0;
  if (!in || word != "image" || (!empty && !fits(width, height)) || (channels != 1 && channels != 3))
    throw unexpected("`image ID TIMESTAMP WIDTH HEIGHT CHANNELS`", line);
  image.pixels.create(height, width, channels == 1 ? CV_8UC1 : CV_8UC3);
  read_rows(stream, image.pixels);
}

inline void write_frame_id(MessageStream& stream, std::int64_t frame_id) {
  if (frame_id >= 0) stream.write_text("result " + std::to_string(frame_id) + "\n");
}

void write_result(MessageStream& stream, const std::optional<SemanticResult>& result) {
  if (result) write_frame_id(stream, result->frame_id);
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

Detection read_detection(const std::string& line) {
  std::istringstream in = classic_input(line);
  Detection d;
  float x1 = 0, y1 = 0, x2 = 0, y2 = 0;
  in >> d.class_id >> d.score >> x1 >> y1 >> x2 >> y2 >> std::ws;
  if (in.fail()) throw unexpected("`CLASS_ID SCORE X1 Y1 X2 Y2 CLASS NAME`", line);
  std::getline(in, d.class_name);
  d.class_name = without_controls(d.class_name);
  d.box = {x1, y1, x2 - x1, y2 - y1};
  return d;
}

/// Says what is wrong with a detection, "" if nothing is.
inline std::string fault(const Detection& d) {
  constexpr float kMostPx = 1e6F;
  if (!(d.score >= 0 && d.score <= 1))
    return "a score of " + number_text(static_cast<double>(d.score)) + ", expected 0 to 1";
  for (const float px : {d.box.x, d.box.y, d.box.width, d.box.height})
    if (!(std::abs(px) < kMostPx))
      return "a coordinate of " + number_text(static_cast<double>(px)) +
             ", expected less than a million pixels";
  return "";
}

inline std::vector<Detection> read_detections(MessageStream& stream, std::size_t n, std::string& error) {
  std::vector<Detection> detections;
  for (std::size_t i = 0; i < n; ++i) {
    detections.push_back(read_detection(stream.read_line()));
    if (error.empty()) error = fault(detections.back());
  }
  return detections;
}

inline cv::Mat read_labels(MessageStream& stream, int width, int height) {
  cv::Mat labels(height, width, CV_8UC1);
  read_rows(stream, labels);
  return labels;
}

Answer read_answer(MessageStream& stream) {
  Answer answer;
  SemanticResult result;
  for (bool first = true;; first = false) {
    const std::string line = stream.read_line();
    std::istringstream in = classic_input(line);
    std::string word;
    in >> word;
    if (line == "end") break;
    if (word == "error") {
      answer.error = line.size() > 6 ? without_controls(line.substr(6)) : "an error without a word";
      return answer;
    }
    if (word == "result" && first) {
      std::int64_t frame_id = 0;
      in >> frame_id;
      if (!in) throw unexpected("`result ID`", line);
      answer.frame_id = frame_id;
    } else if (word == "detections" && !result.detections) {
      long long n = -1;
      in >> n;
      if (!in || n < 0 || n > static_cast<long long>(limits::kMaxBoxes))
        throw unexpected("`detections N`", line);
      result.detections = read_detections(stream, static_cast<std::size_t>(n), answer.error);
    } else if (word == "labels" && !result.labels) {
      int width = 0, height = 0;
      in >> width >> height;
      if (!in || !fits(width, height)) throw unexpected("`labels WIDTH HEIGHT`", line);
      result.labels = read_labels(stream, width, height);
    } else {
      throw unexpected("`detections`, `labels`, `error` or `end`", line);
    }
  }
  result.frame_id = answer.frame_id.value_or(-1);
  if (answer.error.empty() && (result.detections || result.labels)) answer.result = std::move(result);
  return answer;
}

Answer read_answer(MessageStream& stream, std::int64_t frame_id) {
  for (;;) {
    Answer answer = read_answer(stream);
    if (!answer.frame_id || *answer.frame_id == frame_id) return answer;
  }
}

std::optional<SemanticResult> read_result(MessageStream& stream) {
  Answer answer = read_answer(stream);
  if (!answer.error.empty()) throw Told(answer.error);
  return answer.result;
}

void serve(SemanticProvider& provider, int in, int out) {
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
        write_frame_id(stream, image.frame_id);
        stream.write_text("error " + text.substr(0, 1000) + "\n");
        continue;
      }
      if (!result) write_frame_id(stream, image.frame_id);
      if (result) result->frame_id = image.frame_id;
      write_result(stream, result);
    }
  } catch (const EndOfStream&) {
    return;
  }
}

}  // namespace protocol

}  // namespace dynfilter
