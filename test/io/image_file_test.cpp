// SPDX-License-Identifier: MIT
#include <dynfilter/core/limits.hpp>
#include <dynfilter/detectors/image_file.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <optional>

#include "doctest/doctest.h"
#include "io/image_samples.hpp"
#include "io/tum_folder.hpp"
#include "support/allocated_bytes.hpp"

namespace image_file_test {

using namespace dynfilter::io;
using namespace dynfilter_test;
namespace fs = std::filesystem;
namespace limits = dynfilter::limits;

namespace {

/// Less than any image, more than decoders need to read a header.
constexpr std::size_t kMegabyte = 1024 * 1024;

struct Outcome {
  cv::Mat image;
  std::string fault;  ///< "" if the image was read
  std::size_t allocated = 0;
};

/// Reads the image, and checks what holds for all. The size is known before decoding and does not change.
/// Memory is within the bound for that size.
Outcome read(const Bytes& bytes, ImageAs as) {
  Outcome outcome;
  cv::Size told, decoded_at;
  const AllocatedBytes allocated;
  try {
    outcome.image = detail::decode_image(bytes, as, [&](const cv::Size& size) { told = size; });
  } catch (const detail::ImageFault& fault) {
    outcome.fault = fault.what();
    CHECK_FALSE(outcome.fault.empty());
  }
  outcome.allocated = allocated.bytes();
  if (outcome.fault.empty()) CHECK(outcome.image.size() == told);
  const auto pixels = static_cast<std::size_t>(told.area());
  CHECK(outcome.allocated <= pixels * detail::kMaxDecodingBytesPerPixel + detail::kMaxDecodingBytes);
  return outcome;
}

bool equal(const cv::Mat& a, const cv::Mat& b) {
  if (a.type() != b.type() || a.size() != b.size()) return false;
  const std::size_t row = static_cast<std::size_t>(a.cols) * a.elemSize();
  for (int y = 0; y < a.rows; ++y)
    if (std::memcmp(a.ptr(y), b.ptr(y), row) != 0) return false;
  return true;
}

/// Every sample, and one as large as a camera's image of each format.
std::vector<ImageSample> all_samples() {
  std::vector<ImageSample> samples;
  for (const cv::Size size : {cv::Size(1, 1), cv::Size(33, 18), cv::Size(13, 40)})
    for (ImageSample& sample : image_samples(size)) {
      sample.name += " " + std::to_string(size.width) + "x" + std::to_string(size.height);
      samples.push_back(std::move(sample));
    }
  return samples;
}

/// What the size is refused with, before memory is taken for it.
void check_refused(const std::string& name, const Bytes& bytes, const std::string& fault) {
  CAPTURE(name);
  for (const ImageAs as : {ImageAs::Stored, ImageAs::Colour}) {
    const Outcome outcome = read(bytes, as);
    CAPTURE(outcome.fault);
    CHECK(outcome.fault.find(fault) != std::string::npos);
    CHECK(outcome.allocated < kMegabyte);
  }
}

Bytes pgm(const std::string& text, std::size_t pixels) {
  return text_bytes(text) + Bytes(pixels, 7);
}

}  // namespace

TEST_CASE("allocations are counted") {
  const AllocatedBytes allocated;
  const cv::Mat image(100, 100, CV_8UC1);
  CHECK(allocated.bytes() >= image.total());
  CHECK(allocated.bytes() < kMegabyte);
}

TEST_CASE("valid images of every kind are read as OpenCV reads them, bit for bit") {
  for (const ImageSample& sample : all_samples()) {
    CAPTURE(sample.name);
    const Outcome stored = read(sample.bytes, ImageAs::Stored), colour = read(sample.bytes, ImageAs::Colour);
    CHECK(stored.fault == "");
    CHECK(colour.fault == "");
    CHECK(equal(stored.image, cv::imdecode(sample.bytes, cv::IMREAD_UNCHANGED)));
    CHECK(equal(colour.image, cv::imdecode(sample.bytes, cv::IMREAD_COLOR)));
  }
}

TEST_CASE("an image that is cut anywhere is an error") {
  for (const ImageSample& sample : image_samples(cv::Size(33, 18))) {
    CAPTURE(sample.name);
    const std::size_t step = std::max<std::size_t>(1, sample.bytes.size() / 300);
    const auto cut = [&](std::size_t n) {
      const Outcome outcome =
          read(Bytes(sample.bytes.begin(), sample.bytes.begin() + static_cast<std::ptrdiff_t>(n)),
               n % 2 == 0 ? ImageAs::Stored : ImageAs::Colour);
      CAPTURE(n);
      CHECK(outcome.fault != "");
    };
    for (std::size_t n = 0; n < sample.bytes.size(); n += step) cut(n);
    for (std::size_t n = 1; n < 20 && n < sample.bytes.size(); ++n) cut(sample.bytes.size() - n);
  }
}

TEST_CASE(
    "a flipped bit is an error of a PNG, and elsewhere an error or an image of the size that was told") {
  std::mt19937 random(5);
  for (const ImageSample& sample : image_samples(cv::Size(33, 18))) {
    CAPTURE(sample.name);
    const std::size_t step = std::max<std::size_t>(1, sample.bytes.size() / 300);
    for (std::size_t at = 0; at < sample.bytes.size(); at += step) {
      Bytes flipped = sample.bytes;
      flipped[at] = static_cast<unsigned char>(flipped[at] ^ (1U << (random() % 8)));
      CAPTURE(at);
      const Outcome outcome = read(flipped, at % 2 == 0 ? ImageAs::Stored : ImageAs::Colour);
      if (sample.png) CHECK(outcome.fault != "");
    }
  }
}

TEST_CASE("a size beyond the limits is refused before memory is taken, whatever the format") {
  const std::string refused = "expected at most 16384 on a side and 67108864 pixels";
  for (const auto& [width, height] :
       {std::pair<int, int>(16385, 1), {1, 16385}, {16384, 4097}, {65500, 65500}}) {
    const auto w = static_cast<std::uint32_t>(width), h = static_cast<std::uint32_t>(height);
    check_refused("png", kPngSignature + png_header(w, h, 8, 2) + png_chunk("IDAT", {}), refused);
    check_refused(
        "jpeg",
        flat_jpeg(8, 8,
                  jpeg_segment(0xC0, Bytes{8} + big_endian(h, 2) + big_endian(w, 2) + Bytes{1, 1, 0x11, 0}) +
                      jpeg_segment(0xDA, {1, 1, 0, 0, 63, 0})),
        refused);
    for (const int sign : {1, -1}) check_refused("bmp", bmp_file(width, sign * height, 24, {}), refused);
    const std::string sides = std::to_string(width) + " " + std::to_string(height);
    for (const char* type : {"P5 ", "P6 "}) check_refused(type, pgm(type + sides + " 255 ", 0), refused);
  }
  check_refused("png", kPngSignature + png_header(0x7FFFFFFF, 0x7FFFFFFF, 1, 0) + png_chunk("IDAT", {}),
                refused);
  check_refused("bmp", bmp_file(0x7FFFFFFF, 0x7FFFFFFF, 32, {}), refused);
  check_refused("pgm", pgm("P5 999999999 999999999 255 ", 0), refused);
  check_refused("bmp", bmp_file(1, INT32_MIN, 24, {}), "is damaged");
  check_refused("bmp", bmp_file(-1, 1, 24, {}), "is damaged");
  check_refused("pgm", pgm("P5 9999999999 1 255 ", 0), "is damaged");
  for (const char* none :
       {"P5 0 1 255 x", "P5 1 1 0 x", "P5 1 1 65536 xx", "P5 -1 1 255 x", "P5 1", "P6", "P5 1x1 255 x"})
    check_refused(none, text_bytes(none), "is damaged");
  check_refused("png", kPngSignature + png_header(0, 1, 8, 2) + png_chunk("IDAT", {}), "is damaged");
}

TEST_CASE("images without compression that are shorter than their size are refused before memory is taken") {
  for (const int bits : {24, 32})
    check_refused("bmp", bmp_file(16384, 4096, bits, Bytes(100, 1)), "is truncated");
  for (const char* type : {"P5 ", "P6 "})
    for (const char* most : {"255 ", "65535 "})
      check_refused(type, pgm(std::string(type) + "16384 4096 " + most, 100), "is truncated");
}

TEST_CASE("what is not read is refused by a line that names what is") {
  const std::string names = "is not a PNG, JPEG, BMP or binary PGM or PPM image";
  for (const char* other : {"GIF89a", "P1 1 1 1", "P4 1 1 x", "P2 1 1 255 1", "P3 1 1 255 1 1 1",
                            "P7\nWIDTH 1", "II*", "RIFF    WEBP", "\x89PNX\r\n", "not a picture"})
    check_refused(other, text_bytes(other), names);
  check_refused("nothing", {}, "is empty");
  check_refused("bmp of 16 bits", bmp_file(2, 2, 16, Bytes(8, 0)),
                "is not an uncompressed BMP image of 8, 24 or 32");
}

TEST_CASE("headers that another reader would take for a small image") {
  const auto size_of = [](const Bytes& bytes) { return read(bytes, ImageAs::Stored).image.size(); };
  // A marker without a length (TEM): who expects a length there lands in a comment, with a header of 64x48.
  const Bytes fake = jpeg_segment(0xC0, Bytes{8, 0, 48, 0, 64, 1, 1, 0x11, 0});
  constexpr std::size_t kSeen = 65538;  // where such a reader comes to
  Bytes before = Bytes{0xFF, 0x01} + jpeg_segment(0xFE, Bytes(1000, 0)) + jpeg_segment(0xFE, Bytes(63998, 0));
  before = before + jpeg_segment(0xFE, Bytes(kSeen - (2 + before.size() + 4), 0) + fake + Bytes(64, 0));
  const Bytes hidden = flat_jpeg(2048, 1024, before);
  REQUIRE(Bytes(hidden.begin() + kSeen, hidden.begin() + kSeen + 10) ==
          Bytes(fake.begin(), fake.begin() + 10));
  CHECK(size_of(hidden) == cv::Size(2048, 1024));
  check_refused("jpeg", flat_jpeg(16385, 8, before), "is 16385x8");
  // A carriage return ends a comment, or not.
  CHECK(size_of(pgm("P5\n#\r3 2 255 \n64 48 255\n", 6)) == cv::Size(3, 2));
  check_refused("pgm", pgm("P5\n#\r30000 30000 255 \n64 48 255\n", 100), "is 30000x30000");
  check_refused("pbm", pgm("P4\n#\r30000 30000 \n64 48 \n", 100), "is not a PNG");
}

TEST_CASE("few bytes that decode to much take no more than their size allows") {
  // All are of 16384x4096 pixels, the most that is accepted.
  const auto colour_bytes = static_cast<std::size_t>(limits::kMaxImagePixels) * 3;
  const Outcome plain = read(flat_jpeg(16384, 4096), ImageAs::Colour);
  CHECK(plain.image.total() * plain.image.elemSize() == colour_bytes);
  const Outcome progressive = read(flat_jpeg(16384, 4096, {}, true), ImageAs::Colour);
  CHECK(progressive.image.total() * progressive.image.elemSize() == colour_bytes);
  // One bit for each pixel. Too few and too many rows of it.
  const auto png = [](std::size_t rows) {
    return kPngSignature + png_header(16384, 4096, 1, 0) +
           png_chunk("IDAT", deflated(Bytes(rows * 2049, 0))) + png_chunk("IEND", {});
  };
  CHECK(read(png(4096), ImageAs::Stored).image.total() == static_cast<std::size_t>(limits::kMaxImagePixels));
  CHECK(read(png(4095), ImageAs::Stored).fault != "");
  CHECK(read(png(4097), ImageAs::Stored).fault != "");
}

TEST_CASE("metadata take no memory and little time") {
  const PngKind plain;
  const Bytes huge = deflated(Bytes(64 * kMegabyte, 0));
  PngKind kind;
  kind.before = png_chunk("iCCP", text_bytes("p") + Bytes{0, 0} + huge) +
                png_chunk("zTXt", text_bytes("t") + Bytes{0, 0} + huge) +
                png_chunk("iTXt", text_bytes("t") + Bytes{0, 1, 0, 0, 0} + huge);
  for (int k = 0; k < 2000; ++k)
    kind.before = kind.before + png_chunk("tEXt", text_bytes("k") + Bytes{0, 'v'});
  kind.after = kind.before;
  const Outcome png = read(png_file(cv::Size(33, 18), kind), ImageAs::Colour);
  CHECK(png.fault == "");
  CHECK(png.allocated < kMegabyte);
  Bytes markers;
  for (int k = 0; k < 20000; ++k) markers.insert(markers.end(), {0xFF, 0xE1, 0, 2});
  const Outcome jpeg = read(flat_jpeg(33, 18, markers), ImageAs::Colour);
  CHECK(jpeg.fault == "");
  CHECK(jpeg.allocated < kMegabyte);
}

TEST_CASE("a JPEG of more scans than encoders write is refused") {
  // Each scan is two bytes: a run of 2^14 ends of blocks, which are all of the image.
  const Bytes whole = flat_jpeg(1024, 1024, {}, true), end{0xFF, 0xD9};
  Bytes scans =
      Bytes(whole.begin(), whole.end() - 2) + jpeg_segment(0xC4, Bytes{0x10, 1} + Bytes(15, 0) + Bytes{0xE0});
  const auto add_scans = [&](int high, int low) {
    for (unsigned char k = 1; k < 64; ++k)
      scans = scans + jpeg_segment(0xDA, Bytes{1, 1, 0, k, k, static_cast<unsigned char>(16 * high + low)}) +
              Bytes(2, 0);
  };
  add_scans(0, 1);  // 64 with the one of DC
  const Outcome few = read(scans + end, ImageAs::Colour);
  CHECK(few.fault == "");
  CHECK(equal(few.image, cv::imdecode(scans + end, cv::IMREAD_COLOR)));
  add_scans(1, 0);
  CHECK(read(scans + end, ImageAs::Colour).fault == "has more than 100 scans");
}

TEST_CASE("labels are of 8 bits and one channel") {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "a.png";
  cv::imwrite(path.string(), cv::Mat(2, 3, CV_8UC1, cv::Scalar(5)));
  CHECK(equal(read_label_image(path), cv::Mat(2, 3, CV_8UC1, cv::Scalar(5))));
  for (const int type : {CV_16UC1, CV_8UC3, CV_8UC4}) {
    cv::imwrite(path.string(), cv::Mat(2, 3, type, cv::Scalar(5)));
    CHECK_THROWS_WITH_AS(read_label_image(path), doctest::Contains("a.png: is not an 8-bit label image"),
                         dynfilter::IoError);
  }
}

TEST_CASE("the seeds of the fuzz target, written anew" * doctest::skip()) {
  const fs::path corpus = fs::path(DYNFILTER_SOURCE_DIR) / "test/fuzz/corpus/files";
  for (const ImageSample& sample : image_samples(cv::Size(9, 5))) {
    const Bytes seed = text_bytes("image\n") + sample.bytes;
    write_text(corpus / sample.name, std::string(seed.begin(), seed.end()));
  }
}

}  // namespace image_file_test
