// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <dynfilter/core/error.hpp>
#include <filesystem>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <string>
#include <string_view>

namespace dynfilter::io {

/// Frames of a video file or a camera, one after another. Prints nothing.
class VideoReader {
 public:
  virtual ~VideoReader() = default;

  /// From the first frame. Opened when it is made, and then to read a file again.
  virtual void open() = 0;
  virtual bool is_open() const = 0;
  /// Frames that the header counts, which is an estimate in some containers. 0: it does not say.
  virtual std::size_t claimed_frames() const = 0;
  /// Packets of the file, counted without decoding them.
  virtual std::size_t count_packets() const = 0;
  virtual double rate_hz() const = 0;
  /// Goes on to the next frame. False at the end.
  virtual bool grab() = 0;
  /// The frame, CV_8UC3. Empty if it cannot be decoded or is no 8-bit image.
  virtual cv::Mat retrieve() = 0;
  /// Of a file its stamp, of a camera the time since it was opened.
  virtual double position_s() const = 0;
};

class VideoWriter {
 public:
  virtual ~VideoWriter() = default;

  /// `codec`: four characters. False if it cannot be encoded here.
  virtual bool open(const std::filesystem::path& file, std::string_view codec, double rate_hz,
                    cv::Size size) = 0;
  virtual void write(const cv::Mat& picture) = 0;
  virtual void close() = 0;
};

class PictureWindow {
 public:
  virtual ~PictureWindow() = default;  ///< closes it

  virtual void show(const cv::Mat& picture) = 0;
  virtual void resize(cv::Size size) = 0;
  /// The code of a key that was pressed meanwhile, as highgui has it, or a negative number.
  virtual int wait_ms(int ms) = 0;
  /// False once the user has closed it.
  virtual bool is_open() const = 0;
};

/// What OpenCV's videoio and highgui do, from a module that is loaded when a video or a window is asked for.
/// They bring two hundred libraries, with which the command took 141 instead of 13 ms to start.
struct Media {
  const char* version;  ///< DYNFILTER_VERSION of the module
  /// `camera`: the address is the number of a camera, its device file or a stream's.
  std::unique_ptr<VideoReader> (*reader)(const std::string& address, bool camera);
  std::unique_ptr<VideoWriter> (*writer)();
  /// Null without highgui.
  std::unique_ptr<PictureWindow> (*window)(const std::string& title);
  /// In a process of its own, because highgui aborts if the display does not answer.
  bool (*display_answers)();
};

/// Why there is no module: "it was built without OpenCV's videoio".
class NoMedia : public Error {
 public:
  using Error::Error;
};

/// Loads the module with the first call. Throws NoMedia.
const Media& media();

}  // namespace dynfilter::io
