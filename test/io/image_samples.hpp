// SPDX-License-Identifier: MIT
#pragma once

#include <png.h>
#include <zlib.h>

#include <cstdint>
#include <cstring>
#include <functional>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <random>
#include <string>
#include <vector>

/// Small valid image files of every format and kind that is read, and parts to build others.
namespace dynfilter_test {

using Bytes = std::vector<unsigned char>;

inline Bytes text_bytes(const std::string& text) {
  return {text.begin(), text.end()};
}

inline Bytes operator+(Bytes a, const Bytes& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

inline Bytes big_endian(std::uint32_t value, int bytes) {
  Bytes result;
  for (int k = bytes - 1; k >= 0; --k) result.push_back(static_cast<unsigned char>(value >> (8 * k)));
  return result;
}

inline Bytes little_endian(std::uint32_t value, int bytes) {
  const Bytes big = big_endian(value, bytes);
  return {big.rbegin(), big.rend()};
}

inline Bytes noise(std::size_t n, unsigned seed = 1) {
  std::mt19937 random(seed);
  Bytes bytes(n);
  for (unsigned char& byte : bytes) byte = static_cast<unsigned char>(random());
  return bytes;
}

/// TIFF data with nothing but an orientation.
inline Bytes exif(int orientation, bool little) {
  const auto integer = [&](std::uint32_t v, int n) {
    return little ? little_endian(v, n) : big_endian(v, n);
  };
  return text_bytes(little ? "II" : "MM") + integer(42, 2) + integer(8, 4) + integer(1, 2) +
         integer(0x0112, 2) + integer(3, 2) + integer(1, 4) +
         integer(static_cast<std::uint32_t>(orientation), 2) + Bytes{0, 0} + integer(0, 4);
}

inline Bytes png_chunk(const std::string& type, const Bytes& data) {
  const Bytes checked = text_bytes(type) + data;
  const auto sum = static_cast<std::uint32_t>(crc32(0, checked.data(), static_cast<uInt>(checked.size())));
  return big_endian(static_cast<std::uint32_t>(data.size()), 4) + checked + big_endian(sum, 4);
}

inline Bytes deflated(const Bytes& data) {
  uLongf size = compressBound(static_cast<uLong>(data.size()));
  Bytes result(size);
  compress2(result.data(), &size, data.data(), static_cast<uLong>(data.size()), 9);
  result.resize(size);
  return result;
}

inline const Bytes kPngSignature{0x89, 'P', 'N', 'G', '\r', '\n', 0x1A, '\n'};

inline Bytes png_header(std::uint32_t width, std::uint32_t height, int depth, int colours) {
  return png_chunk(
      "IHDR", big_endian(width, 4) + big_endian(height, 4) +
                  Bytes{static_cast<unsigned char>(depth), static_cast<unsigned char>(colours), 0, 0, 0});
}

struct PngKind {
  int depth = 8, colours = PNG_COLOR_TYPE_RGB;
  bool interlaced = false, transparent = false;
  Bytes before, after;  ///< chunks before and after the pixels
};

/// Written by libpng, with random samples.
inline Bytes png_file(cv::Size size, const PngKind& kind) {
  Bytes file;
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png_create_info_struct(png);
  const auto write = [](png_structp p, png_bytep data, std::size_t n) {
    auto& to = *static_cast<Bytes*>(png_get_io_ptr(p));
    to.insert(to.end(), data, data + n);
  };
  png_set_write_fn(png, &file, write, nullptr);
  png_set_IHDR(png, info, static_cast<png_uint_32>(size.width), static_cast<png_uint_32>(size.height),
               kind.depth, kind.colours, kind.interlaced ? PNG_INTERLACE_ADAM7 : PNG_INTERLACE_NONE,
               PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  const int entries = 1 << std::min(kind.depth, 8);
  std::vector<png_color> palette(static_cast<std::size_t>(entries));
  const Bytes shades = noise(palette.size() * 3, 7);
  std::memcpy(palette.data(), shades.data(), shades.size());
  if (kind.colours == PNG_COLOR_TYPE_PALETTE) png_set_PLTE(png, info, palette.data(), entries);
  png_color_16 seen_through{};
  const Bytes alphas = noise(static_cast<std::size_t>(entries), 8);
  if (kind.transparent && kind.colours == PNG_COLOR_TYPE_PALETTE)
    png_set_tRNS(png, info, alphas.data(), entries / 2, nullptr);
  else if (kind.transparent)
    png_set_tRNS(png, info, nullptr, 0, &seen_through);
  png_write_info(png, info);
  Bytes pixels = noise(png_get_rowbytes(png, info) * static_cast<std::size_t>(size.height), 9);
  // A pixel of the transparent colour, and in the grey and colour images some that are equal.
  std::fill(pixels.begin(), pixels.begin() + static_cast<std::ptrdiff_t>(pixels.size() / 8), 0);
  std::vector<png_bytep> rows;
  for (int y = 0; y < size.height; ++y)
    rows.push_back(pixels.data() + png_get_rowbytes(png, info) * static_cast<std::size_t>(y));
  png_write_image(png, rows.data());
  png_write_end(png, nullptr);
  png_destroy_write_struct(&png, &info);
  const std::ptrdiff_t header = 8 + 25, end = static_cast<std::ptrdiff_t>(file.size()) - 12;
  return Bytes(file.begin(), file.begin() + header) + kind.before +
         Bytes(file.begin() + header, file.begin() + end) + kind.after +
         Bytes(file.begin() + end, file.end());
}

inline cv::Mat noise_image(cv::Size size, int type, unsigned seed = 2) {
  cv::Mat image(size, type);
  const Bytes bytes = noise(image.total() * image.elemSize(), seed);
  std::memcpy(image.data, bytes.data(), bytes.size());
  return image;
}

inline Bytes encoded(const char* suffix, const cv::Mat& image, const std::vector<int>& options = {}) {
  Bytes bytes;
  cv::imencode(suffix, image, bytes, options);
  return bytes;
}

inline Bytes jpeg_segment(int marker, const Bytes& data) {
  return Bytes{0xFF, static_cast<unsigned char>(marker)} +
         big_endian(static_cast<std::uint32_t>(data.size()) + 2, 2) + data;
}

/// Segments after the first marker of a JPEG.
inline Bytes with_segments(const Bytes& jpeg, const Bytes& segments) {
  return Bytes(jpeg.begin(), jpeg.begin() + 2) + segments + Bytes(jpeg.begin() + 2, jpeg.end());
}

inline Bytes exif_segment(int orientation, bool little) {
  return jpeg_segment(0xE1, Bytes{'E', 'x', 'i', 'f', 0, 0} + exif(orientation, little));
}

/// A grey JPEG of equal blocks of 2 bits: so few bytes for so many pixels.
inline Bytes flat_jpeg(int width, int height, const Bytes& before = {}, bool progressive = false) {
  const auto side = [](int px) { return big_endian(static_cast<std::uint32_t>(px), 2); };
  const Bytes one_code = Bytes{1} + Bytes(15, 0) + Bytes{0};
  const std::size_t blocks =
      static_cast<std::size_t>((width + 7) / 8) * static_cast<std::size_t>((height + 7) / 8);
  return Bytes{0xFF, 0xD8} + before + jpeg_segment(0xDB, Bytes{0} + Bytes(64, 1)) +
         jpeg_segment(progressive ? 0xC2 : 0xC0,
                      Bytes{8} + side(height) + side(width) + Bytes{1, 1, 0x11, 0}) +
         jpeg_segment(0xC4, Bytes{0x00} + one_code) + jpeg_segment(0xC4, Bytes{0x10} + one_code) +
         jpeg_segment(0xDA, progressive ? Bytes{1, 1, 0, 0, 0, 0} : Bytes{1, 1, 0, 0, 63, 0}) +
         Bytes((blocks * (progressive ? 1 : 2) + 7) / 8, 0) + Bytes{0xFF, 0xD9};
}

inline Bytes bmp_file(int width, int height, int bits, const Bytes& rest, std::uint32_t palette_entries = 0) {
  const std::uint32_t begin = 54 + 4 * palette_entries;
  return text_bytes("BM") + little_endian(begin + static_cast<std::uint32_t>(rest.size()), 4) +
         little_endian(0, 4) + little_endian(begin, 4) + little_endian(40, 4) +
         little_endian(static_cast<std::uint32_t>(width), 4) +
         little_endian(static_cast<std::uint32_t>(height), 4) + little_endian(1, 2) +
         little_endian(static_cast<std::uint32_t>(bits), 2) + Bytes(16, 0) +
         little_endian(palette_entries, 4) + Bytes(4, 0) + rest;
}

struct ImageSample {
  std::string name;
  Bytes bytes;
  bool png = false;
};

/// Valid files. `size` is of their pixels, before they are turned.
inline std::vector<ImageSample> image_samples(cv::Size size) {
  std::vector<ImageSample> samples;
  const auto add = [&](const std::string& name, const Bytes& bytes) {
    samples.push_back({name, bytes, name.rfind("png", 0) == 0});
  };
  for (const auto& [colours, depths] :
       std::vector<std::pair<int, std::vector<int>>>{{PNG_COLOR_TYPE_GRAY, {1, 2, 4, 8, 16}},
                                                     {PNG_COLOR_TYPE_RGB, {8, 16}},
                                                     {PNG_COLOR_TYPE_PALETTE, {1, 2, 4, 8}},
                                                     {PNG_COLOR_TYPE_GRAY_ALPHA, {8, 16}},
                                                     {PNG_COLOR_TYPE_RGB_ALPHA, {8, 16}}})
    for (const int depth : depths)
      for (const bool interlaced : {false, true})
        for (const bool transparent : {false, true}) {
          if (transparent && (colours & PNG_COLOR_MASK_ALPHA) != 0) continue;
          PngKind kind;
          kind.depth = depth, kind.colours = colours;
          kind.interlaced = interlaced, kind.transparent = transparent;
          add("png_" + std::to_string(colours) + "_" + std::to_string(depth) +
                  (interlaced ? "_interlaced" : "") + (transparent ? "_transparent" : ""),
              png_file(size, kind));
        }
  for (int orientation = 1; orientation <= 8; ++orientation) {
    const std::string name = std::to_string(orientation);
    PngKind before, after;
    before.before = png_chunk("eXIf", exif(orientation, orientation % 2 == 0));
    after.after = png_chunk("eXIf", exif(orientation, orientation % 2 == 1));
    add("png_exif_before_" + name, png_file(size, before));
    add("png_exif_after_" + name, png_file(size, after));
    add("jpeg_exif_" + name, with_segments(encoded(".jpg", noise_image(size, CV_8UC3)),
                                           exif_segment(orientation, orientation % 2 == 0)));
  }
  PngKind commented;
  commented.before = png_chunk("tEXt", text_bytes("Comment") + Bytes{0} + text_bytes("none")) +
                     png_chunk("gAMA", big_endian(45455, 4));
  commented.after = png_chunk("tIME", Bytes{7, 0xEA, 1, 1, 0, 0, 0});
  add("png_commented", png_file(size, commented));
  for (const int type : {CV_8UC1, CV_8UC3})
    for (const auto& [name, options] : std::vector<std::pair<std::string, std::vector<int>>>{
             {"", {}},
             {"_progressive", {cv::IMWRITE_JPEG_PROGRESSIVE, 1}},
             {"_restart", {cv::IMWRITE_JPEG_RST_INTERVAL, 2}},
             {"_coarse", {cv::IMWRITE_JPEG_QUALITY, 20, cv::IMWRITE_JPEG_OPTIMIZE, 1}}})
      add((type == CV_8UC1 ? "jpeg_grey" : "jpeg_colour") + name,
          encoded(".jpg", noise_image(size, type), options));
  add("jpeg_flat", flat_jpeg(size.width, size.height));
  add("jpeg_exif_behind_xmp",
      with_segments(encoded(".jpg", noise_image(size, CV_8UC1)),
                    jpeg_segment(0xE1, text_bytes("http://ns.adobe.com/xap/1.0/")) + exif_segment(6, true)));
  const auto n = static_cast<std::size_t>(size.area());
  const std::string sides = std::to_string(size.width) + " " + std::to_string(size.height);
  for (const int most : {255, 100, 65535, 4095}) {
    const std::string header = sides + "\n" + std::to_string(most) + "\n", name = "_" + std::to_string(most);
    const std::size_t sample = most > 255 ? 2 : 1;
    add("pgm" + name, text_bytes("P5\n" + header) + noise(n * sample));
    add("ppm" + name, text_bytes("P6\n" + header) + noise(3 * n * sample));
  }
  add("pgm_commented", text_bytes("P5 # one\n# two\n " + sides + "\n# three\n255\n") + noise(n));
  const auto rows = [&](int bits) {
    return noise(static_cast<std::size_t>((size.width * bits + 31) / 32 * 4 * size.height));
  };
  Bytes greys, colours = noise(1024, 3);
  for (int k = 0; k < 256; ++k) greys = greys + Bytes(3, static_cast<unsigned char>(255 - k)) + Bytes{0};
  for (const int upright : {1, -1}) {
    const std::string name = upright == 1 ? "" : "_from_top";
    const int height = upright * size.height;
    add("bmp_24" + name, bmp_file(size.width, height, 24, rows(24)));
    add("bmp_32" + name, bmp_file(size.width, height, 32, rows(32)));
    add("bmp_grey" + name, bmp_file(size.width, height, 8, greys + rows(8), 256));
    add("bmp_palette" + name, bmp_file(size.width, height, 8, colours + rows(8), 256));
  }
  add("bmp_opencv_grey", encoded(".bmp", noise_image(size, CV_8UC1)));
  add("bmp_opencv_colour", encoded(".bmp", noise_image(size, CV_8UC3)));
  return samples;
}

}  // namespace dynfilter_test
