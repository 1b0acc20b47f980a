// SPDX-License-Identifier: MIT
#include <dynfilter/detectors/image_file.hpp>

#include <cstdint>
#include <cstring>
#include <dynfilter/core/limits.hpp>
#include <fstream>
#include <ios>
#include <opencv2/core.hpp>
#include <string>
#include <system_error>
#include "bmp_image.hpp"
#include "exif.hpp"
#include "jpeg_image.hpp"
#include "png_image.hpp"
#include "pnm_image.hpp"

namespace dynfilter::io {

namespace detail {

Bytes read_bytes(const std::filesystem::path& path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) throw IoError(path.string() + ": no such file");
  std::ifstream in(path, std::ios::binary | std::ios::ate);
  if (!in) throw IoError(path.string() + ": cannot be read");
  const auto size = static_cast<std::size_t>(in.tellg());
  if (size > limits::kMaxImageBytes)
    throw IoError(path.string() + ": has more than " + std::to_string(limits::kMaxImageBytes) + " bytes");
  Bytes bytes(size);
  in.seekg(0);
  in.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  if (!in) throw IoError(path.string() + ": cannot be read");
  return bytes;
}

inline void check_limits(const cv::Size& size) {
  if (size.width <= limits::kMaxImageSide_px && size.height <= limits::kMaxImageSide_px &&
      std::int64_t{size.width} * size.height <= limits::kMaxImagePixels)
    return;
  throw ImageFault("is " + std::to_string(size.width) + "x" + std::to_string(size.height) +
                   ", expected at most " + std::to_string(limits::kMaxImageSide_px) + " on a side and " +
                   std::to_string(limits::kMaxImagePixels) + " pixels");
}

/// A format that is read, and the bytes that its files begin with.
struct ImageDecoder {
  const char* signature;
  std::size_t bytes;
  DecodedImage (*decode)(const Bytes&, ImageAs, const AcceptHeader&);
};

inline const ImageDecoder& decoder_of(const Bytes& bytes) {
  static constexpr ImageDecoder kDecoders[] = {{"\x89PNG\r\n\x1A\n", 8, decode_png},
                                               {"\xFF\xD8", 2, decode_jpeg},
                                               {"BM", 2, decode_bmp},
                                               {"P5", 2, decode_pnm},
                                               {"P6", 2, decode_pnm}};
  if (bytes.empty()) throw ImageFault("is empty");
  for (const ImageDecoder& decoder : kDecoders)
    if (bytes.size() >= decoder.bytes && std::memcmp(bytes.data(), decoder.signature, decoder.bytes) == 0)
      return decoder;
  throw ImageFault("is not a PNG, JPEG, BMP or binary PGM or PPM image");
}

cv::Mat decode_image(const Bytes& bytes, ImageAs as, const CheckSize& check) {
  cv::Size told;
  const AcceptHeader accept = [&](const ImageHeader& header) {
    check_limits(header.size);
    told = as == ImageAs::Colour ? turned(header.size, header.orientation) : header.size;
    if (check) check(told);
  };
  DecodedImage image = decoder_of(bytes).decode(bytes, as, accept);
  if (as == ImageAs::Colour) turn(image.pixels, image.orientation);
  if (check && image.pixels.size() != told) check(image.pixels.size());  // orientation behind the pixels
  return image.pixels;
}

}  // namespace detail

cv::Mat read_image(const std::filesystem::path& path, ImageAs as, const CheckSize& check) {
  const detail::Bytes bytes = detail::read_bytes(path);
  try {
    return detail::decode_image(bytes, as, check);
  } catch (const detail::ImageFault& fault) {
    throw IoError(path.string() + ": " + fault.what());
  } catch (const cv::Exception&) {  // OpenCV's when there is no memory
    throw IoError(path.string() + ": cannot be decoded: not enough memory");
  }
}

cv::Mat read_label_image(const std::filesystem::path& path) {
  cv::Mat image = read_image(path, ImageAs::Stored);
  if (image.type() != CV_8UC1) throw IoError(path.string() + ": is not an 8-bit label image");
  return image;
}

}  // namespace dynfilter::io
