// SPDX-License-Identifier: MIT
#include "png_image.hpp"

#include <png.h>

#include <cstring>
#include "c_codec.hpp"
#include "exif.hpp"

namespace dynfilter::io::detail {

class PngDecoder : private CCodec {
 public:
  PngDecoder(const Bytes& bytes, ImageAs as) : next_(bytes.data()), left_(bytes.size()), as_(as) {}
  PngDecoder(const PngDecoder&) = delete;
  PngDecoder& operator=(const PngDecoder&) = delete;
  ~PngDecoder() { png_destroy_read_struct(&png_, &info_, nullptr); }

  ImageHeader read_header() {
    run([this] {
      start();
      png_read_info(png_, info_);
    });
    return {cv::Size(static_cast<int>(png_get_image_width(png_, info_)),
                     static_cast<int>(png_get_image_height(png_, info_))),
            orientation()};
  }

  /// The image after read_header().
  DecodedImage read_pixels() {
    DecodedImage image;
    const ImageFormat format = choose_format();
    image.pixels.create(static_cast<int>(png_get_image_height(png_, info_)),
                        static_cast<int>(png_get_image_width(png_, info_)), format.type());
    run([&] {
      convert_to(format);
      const int passes = png_set_interlace_handling(png_);
      png_read_update_info(png_, info_);
      if (png_get_rowbytes(png_, info_) !=
          static_cast<std::size_t>(image.pixels.cols) * image.pixels.elemSize())
        leave("is damaged (size of a row)");
      for (int pass = 0; pass < passes; ++pass)
        for (int y = 0; y < image.pixels.rows; ++y) png_read_row(png_, image.pixels.ptr(y), nullptr);
      png_read_end(png_, info_);
    });
    image.orientation = orientation();  // Exif data may follow the pixels
    return image;
  }

 private:
  /// What is made of the samples of the file.
  struct ImageFormat {
    int channels = 3;
    bool wide = false;  ///< 16 bits
    int type() const { return CV_MAKETYPE(wide ? CV_16U : CV_8U, channels); }
  };

  void start() {
    /// Bytes of a chunk of metadata, and number of chunks that libpng keeps. Only Exif data are kept.
    constexpr png_alloc_size_t kMaxChunkBytes = 8'000'000;
    constexpr png_uint_32 kMaxChunks = 16;
    png_ = png_create_read_struct(PNG_LIBPNG_VER_STRING, this, on_error, on_error);
    if (png_ == nullptr) leave("cannot be decoded: libpng does not start");
    info_ = png_create_info_struct(png_);
    if (info_ == nullptr) leave("cannot be decoded: libpng does not start");
    png_set_read_fn(png_, this, on_read);
    png_set_crc_action(png_, PNG_CRC_ERROR_QUIT, PNG_CRC_ERROR_QUIT);
    png_set_user_limits(png_, PNG_UINT_31_MAX, PNG_UINT_31_MAX);  // ours name the file's size
    png_set_chunk_malloc_max(png_, kMaxChunkBytes);
    png_set_chunk_cache_max(png_, kMaxChunks);
    constexpr int kAllAncillary = -1;
    png_set_keep_unknown_chunks(png_, PNG_HANDLE_CHUNK_NEVER, nullptr, kAllAncillary);
#ifdef PNG_eXIf_SUPPORTED
    png_set_keep_unknown_chunks(png_, PNG_HANDLE_CHUNK_AS_DEFAULT, reinterpret_cast<png_const_bytep>("eXIf"),
                                1);
#endif
  }

  ImageFormat choose_format() {
    if (as_ == ImageAs::Colour) return {};
    const unsigned colours = png_get_color_type(png_, info_);
    const bool alpha =
        (colours & PNG_COLOR_MASK_ALPHA) != 0 || png_get_valid(png_, info_, PNG_INFO_tRNS) != 0;
    ImageFormat format;
    format.wide = png_get_bit_depth(png_, info_) == 16;
    // One value that is transparent does not make a grey image one of four channels.
    format.channels = colours == PNG_COLOR_TYPE_GRAY ? 1 : alpha ? 4 : 3;
    return format;
  }

  void convert_to(const ImageFormat& format) {
    const unsigned colours = png_get_color_type(png_, info_);
    if (!format.wide) png_set_strip_16(png_);
    if (format.wide && little_endian()) png_set_swap(png_);
    if (colours == PNG_COLOR_TYPE_PALETTE) png_set_palette_to_rgb(png_);
    if (colours == PNG_COLOR_TYPE_GRAY) png_set_expand_gray_1_2_4_to_8(png_);
    if (format.channels == 4) {
      png_set_tRNS_to_alpha(png_);
    } else {
      png_set_strip_alpha(png_);
    }
    if (format.channels > 1 && (colours & PNG_COLOR_MASK_COLOR) == 0) png_set_gray_to_rgb(png_);
    if ((colours & PNG_COLOR_MASK_COLOR) != 0) png_set_bgr(png_);
  }

  int orientation() {
#ifdef PNG_eXIf_SUPPORTED
    png_uint_32 size = 0;
    png_bytep data = nullptr;
    if (png_get_eXIf_1(png_, info_, &size, &data) != 0) return exif_orientation(data, size);
#endif
    return kUpright;
  }

  static void on_error(png_structp png, png_const_charp message) {
    static_cast<PngDecoder*>(png_get_error_ptr(png))->leave_damaged("libpng", message);
  }

  static void on_read(png_structp png, png_bytep to, std::size_t n) {
    PngDecoder& decoder = *static_cast<PngDecoder*>(png_get_io_ptr(png));
    if (n > decoder.left_) decoder.leave("is truncated");
    std::memcpy(to, decoder.next_, n);
    decoder.next_ += n;
    decoder.left_ -= n;
  }

  const unsigned char* next_;
  std::size_t left_;
  ImageAs as_;
  png_structp png_ = nullptr;
  png_infop info_ = nullptr;
};

DecodedImage decode_png(const Bytes& bytes, ImageAs as, const AcceptHeader& accept) {
  PngDecoder decoder(bytes, as);
  accept(decoder.read_header());
  return decoder.read_pixels();
}

}  // namespace dynfilter::io::detail
