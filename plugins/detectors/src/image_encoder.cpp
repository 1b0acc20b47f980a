// SPDX-License-Identifier: MIT
#include <dynfilter/detectors/image_encoder.hpp>

#include <png.h>
#include <zlib.h>

#include <cstdio>  // before jpeglib.h, which needs it
#include <cstdlib>
#include <dynfilter/core/error.hpp>
#include <fstream>
#include <new>
#include <opencv2/imgproc.hpp>
#include <string>
#include <utility>

#include <jpeglib.h>

#include "c_codec.hpp"

namespace dynfilter::io {
namespace {

class PngEncoder : private detail::CCodec {
 public:
  explicit PngEncoder(const cv::Mat& image) : image_(image) {}
  PngEncoder(const PngEncoder&) = delete;
  PngEncoder& operator=(const PngEncoder&) = delete;
  ~PngEncoder() { png_destroy_write_struct(&png_, &info_); }

  std::vector<std::uint8_t> encode() {
    run([this] {
      start();
      png_write_info(png_, info_);
      if (image_.channels() == 3) png_set_bgr(png_);
      if (image_.depth() == CV_16U && little_endian()) png_set_swap(png_);
      for (int y = 0; y < image_.rows; ++y) png_write_row(png_, image_.ptr(y));
      png_write_end(png_, info_);
    });
    return std::move(bytes_);
  }

 private:
  void start() {
    png_ = png_create_write_struct(PNG_LIBPNG_VER_STRING, this, on_error, on_error);
    if (png_ == nullptr) leave("libpng does not start");
    info_ = png_create_info_struct(png_);
    if (info_ == nullptr) leave("libpng does not start");
    png_set_write_fn(png_, this, on_write, on_flush);
    png_set_IHDR(png_, info_, static_cast<png_uint_32>(image_.cols), static_cast<png_uint_32>(image_.rows),
                 image_.depth() == CV_16U ? 16 : 8,
                 image_.channels() == 3 ? PNG_COLOR_TYPE_RGB : PNG_COLOR_TYPE_GRAY, PNG_INTERLACE_NONE,
                 PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    // Of a rendered frame of 640 x 480 half of the time of zlib's own strategy, and fewer bytes.
    png_set_filter(png_, PNG_FILTER_TYPE_BASE, PNG_FILTER_SUB);
    png_set_compression_level(png_, Z_BEST_SPEED);
    png_set_compression_strategy(png_, Z_RLE);
  }

  static void on_error(png_structp png, png_const_charp message) {
    static_cast<PngEncoder*>(png_get_error_ptr(png))->leave(message);
  }
  static void on_write(png_structp png, png_bytep from, std::size_t n) {
    PngEncoder& encoder = *static_cast<PngEncoder*>(png_get_io_ptr(png));
    if (!encoder.append(from, n)) encoder.leave("not enough memory");
  }
  bool append(const png_byte* from, std::size_t n) {
    try {
      bytes_.insert(bytes_.end(), from, from + n);
      return true;
    } catch (const std::bad_alloc&) {
      return false;
    }
  }
  static void on_flush(png_structp) {}

  const cv::Mat& image_;
  std::vector<std::uint8_t> bytes_;
  png_structp png_ = nullptr;
  png_infop info_ = nullptr;
};

class JpegEncoder : private detail::CCodec {
 public:
  explicit JpegEncoder(const cv::Mat& image) : image_(image) {}
  JpegEncoder(const JpegEncoder&) = delete;
  JpegEncoder& operator=(const JpegEncoder&) = delete;
  ~JpegEncoder() {
    jpeg_destroy_compress(&jpeg_);
    std::free(bytes_);
  }

  std::vector<std::uint8_t> encode(int quality) {
    run([&] {
      start(quality);
      jpeg_start_compress(&jpeg_, TRUE);
      while (jpeg_.next_scanline < jpeg_.image_height) {
        JSAMPROW row = const_cast<JSAMPROW>(image_.ptr(static_cast<int>(jpeg_.next_scanline)));
        jpeg_write_scanlines(&jpeg_, &row, 1);
      }
      jpeg_finish_compress(&jpeg_);
    });
    return {bytes_, bytes_ + size_};
  }

 private:
  void start(int quality) {
    jpeg_.err = jpeg_std_error(&errors_);
    errors_.error_exit = on_error;
    jpeg_.client_data = this;
    jpeg_create_compress(&jpeg_);
    jpeg_mem_dest(&jpeg_, &bytes_, &size_);
    jpeg_.image_width = static_cast<JDIMENSION>(image_.cols);
    jpeg_.image_height = static_cast<JDIMENSION>(image_.rows);
    jpeg_.input_components = image_.channels();
    jpeg_.in_color_space = image_.channels() == 3 ? JCS_RGB : JCS_GRAYSCALE;
    jpeg_set_defaults(&jpeg_);
    jpeg_set_quality(&jpeg_, quality, TRUE);
  }

  static void on_error(j_common_ptr jpeg) {
    char message[JMSG_LENGTH_MAX];
    jpeg->err->format_message(jpeg, message);
    static_cast<JpegEncoder*>(jpeg->client_data)->leave(message);
  }

  const cv::Mat& image_;  // RGB
  jpeg_compress_struct jpeg_{};
  jpeg_error_mgr errors_{};
  unsigned char* bytes_ = nullptr;  // libjpeg's
  unsigned long size_ = 0;
};

template <class Encode>
std::vector<std::uint8_t> encoded(const Encode& encode) {
  try {
    return encode();
  } catch (const detail::ImageFault& fault) {
    throw IoError(std::string("an image cannot be encoded: ") + fault.what());
  }
}

}  // namespace

std::vector<std::uint8_t> encode_png(const cv::Mat& image) {
  if (image.type() != CV_8UC1 && image.type() != CV_16UC1 && image.type() != CV_8UC3)
    throw IoError("a PNG image of 8 or 16 bits grey or 8 bits colour is written, not of another type");
  return encoded([&] { return PngEncoder(image).encode(); });
}

std::vector<std::uint8_t> encode_jpeg(const cv::Mat& image, int quality) {
  if (image.type() != CV_8UC1 && image.type() != CV_8UC3)
    throw IoError("a JPEG image of 8 bits grey or colour is written, not of another type");
  if (image.channels() == 1 || image.empty())
    return encoded([&] { return JpegEncoder(image).encode(quality); });
  cv::Mat rgb;
  cv::cvtColor(image, rgb, cv::COLOR_BGR2RGB);
  return encoded([&] { return JpegEncoder(rgb).encode(quality); });
}

void write_image(const std::filesystem::path& path, const cv::Mat& image) {
  try {
    const std::vector<std::uint8_t> bytes =
        path.extension() == ".jpg" ? encode_jpeg(image) : encode_png(image);
    std::ofstream out(path, std::ios::binary);
    out.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    out.close();
    if (!out) throw IoError("is the disk full?");
  } catch (const IoError& error) {
    throw IoError(path.string() + ": cannot write the picture: " + error.what());
  }
}

}  // namespace dynfilter::io
