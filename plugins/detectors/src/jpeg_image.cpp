// SPDX-License-Identifier: MIT
#include "jpeg_image.hpp"

#include <cstdio>  // before jpeglib.h, which needs it
#include <cstring>
#include "c_codec.hpp"
#include "exif.hpp"

#include <jpeglib.h>

#include <utility>

namespace dynfilter::io::detail {

class JpegDecoder : private CCodec {
 public:
  JpegDecoder(const Bytes& bytes, ImageAs as) : bytes_(bytes), as_(as) {}
  JpegDecoder(const JpegDecoder&) = delete;
  JpegDecoder& operator=(const JpegDecoder&) = delete;
  ~JpegDecoder() { jpeg_destroy_decompress(&jpeg_); }

  ImageHeader read_header() {
    run([this] {
      start();
      jpeg_read_header(&jpeg_, TRUE);
      if (jpeg_.num_components != 1 && jpeg_.num_components != 3)
        leave("is a JPEG image of neither 1 nor 3 components (CMYK is not read)");
    });
    return {cv::Size(static_cast<int>(jpeg_.image_width), static_cast<int>(jpeg_.image_height)),
            orientation_};
  }

  /// The image after read_header().
  DecodedImage read_pixels() {
    DecodedImage image;
    image.orientation = orientation_;
    const bool colour = as_ == ImageAs::Colour || jpeg_.num_components == 3;
    image.pixels.create(static_cast<int>(jpeg_.image_height), static_cast<int>(jpeg_.image_width),
                        colour ? CV_8UC3 : CV_8UC1);
    run([&] {
      jpeg_.mem->max_memory_to_use = coefficient_bytes();
      jpeg_.out_color_space = colour ? JCS_RGB : JCS_GRAYSCALE;
      jpeg_start_decompress(&jpeg_);
      if (static_cast<int>(jpeg_.output_width) != image.pixels.cols ||
          static_cast<int>(jpeg_.output_height) != image.pixels.rows ||
          jpeg_.output_components != image.pixels.channels())
        leave("is damaged (size of a row)");
      while (jpeg_.output_scanline < jpeg_.output_height) {
        JSAMPROW row = image.pixels.ptr(static_cast<int>(jpeg_.output_scanline));
        jpeg_read_scanlines(&jpeg_, &row, 1);
        if (colour) exchange_red_and_blue(row, image.pixels.cols);
      }
      jpeg_finish_decompress(&jpeg_);
    });
    return image;
  }

 private:
  /// Encoders write about ten. Each costs time for the whole image, however few bytes it has.
  static constexpr int kMaxScans = 100;

  void start() {
    jpeg_.err = jpeg_std_error(&errors_);
    errors_.error_exit = on_error;
    errors_.emit_message = on_message;
    jpeg_.client_data = this;
    jpeg_create_decompress(&jpeg_);
    progress_.progress_monitor = on_progress;
    jpeg_.progress = &progress_;
    jpeg_mem_src(&jpeg_, bytes_.data(), static_cast<unsigned long>(bytes_.size()));
    jpeg_set_marker_processor(&jpeg_, kExifMarker, on_exif);
  }

  /// A progressive image's coefficients of 2 bytes, for blocks that cover it, and the rows in work.
  long coefficient_bytes() const {
    constexpr long kLargestBlock_px = 32, kWork = 8L * 1024 * 1024;
    const long width = static_cast<long>(jpeg_.image_width) + kLargestBlock_px,
               height = static_cast<long>(jpeg_.image_height) + kLargestBlock_px;
    return 2L * jpeg_.num_components * width * height + kWork;
  }

  static void exchange_red_and_blue(JSAMPROW row, int pixels) {
    for (const JSAMPROW end = row + 3 * static_cast<std::ptrdiff_t>(pixels); row != end; row += 3)
      std::swap(row[0], row[2]);
  }

  static JpegDecoder& decoder(j_common_ptr jpeg) { return *static_cast<JpegDecoder*>(jpeg->client_data); }

  static void on_error(j_common_ptr jpeg) {
    char message[JMSG_LENGTH_MAX];
    jpeg->err->format_message(jpeg, message);
    decoder(jpeg).leave_damaged("libjpeg", message);
  }

  static void on_message(j_common_ptr jpeg, int level) {
    if (level < 0) on_error(jpeg);  // a warning; others are traces
  }

  static void on_progress(j_common_ptr jpeg) {
    if (decoder(jpeg).jpeg_.input_scan_number > kMaxScans) decoder(jpeg).leave("has more than 100 scans");
  }

  /// Reads a marker with metadata in place. libjpeg's own function would keep a copy of every one.
  /// Exif data are in the first, as their standard requires.
  static boolean on_exif(j_decompress_ptr jpeg) {
    static constexpr unsigned char kExif[6] = {'E', 'x', 'i', 'f', 0, 0};
    JpegDecoder& self = decoder(reinterpret_cast<j_common_ptr>(jpeg));
    jpeg_source_mgr& source = *jpeg->src;  // has the whole file
    const JOCTET* data = source.next_input_byte;
    if (source.bytes_in_buffer < 2) self.leave("is truncated");
    const std::size_t length = (std::size_t{data[0]} << 8) | data[1];
    if (length < 2) self.leave("is damaged (length of a marker)");
    if (length > source.bytes_in_buffer) self.leave("is truncated");
    if (!self.has_metadata_ && length >= 2 + sizeof(kExif) &&
        std::memcmp(data + 2, kExif, sizeof(kExif)) == 0) {
      self.orientation_ = exif_orientation(data + 2 + sizeof(kExif), length - 2 - sizeof(kExif));
    }
    self.has_metadata_ = true;
    source.next_input_byte += length;
    source.bytes_in_buffer -= length;
    return TRUE;
  }

  static constexpr int kExifMarker = JPEG_APP0 + 1;

  const Bytes& bytes_;
  ImageAs as_;
  jpeg_decompress_struct jpeg_{};
  jpeg_error_mgr errors_{};
  jpeg_progress_mgr progress_{};
  bool has_metadata_ = false;
  int orientation_ = kUpright;
};

DecodedImage decode_jpeg(const Bytes& bytes, ImageAs as, const AcceptHeader& accept) {
  JpegDecoder decoder(bytes, as);
  accept(decoder.read_header());
  return decoder.read_pixels();
}

}  // namespace dynfilter::io::detail
