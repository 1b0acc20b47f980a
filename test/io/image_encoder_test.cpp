// SPDX-License-Identifier: MIT
#include <dynfilter/core/error.hpp>
#include <dynfilter/detectors/image_encoder.hpp>
#include <dynfilter/detectors/image_file.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "doctest/doctest.h"
#include "io/tum_folder.hpp"

namespace image_encoder_test {

using namespace dynfilter;

namespace {

/// Smooth, with noise, and a different one for each size and type.
cv::Mat picture(cv::Size size, int type) {
  cv::Mat image(size, type);
  cv::RNG random(static_cast<std::uint64_t>(size.width * 131 + size.height * 17 + type));
  random.fill(image, cv::RNG::UNIFORM, 0, CV_MAT_DEPTH(type) == CV_16U ? 65536 : 256);
  if (size.width > 8) cv::blur(image, image, {5, 5});
  return image;
}

bool equal(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() && a.type() == b.type() && cv::norm(a, b, cv::NORM_INF) == 0;
}

const cv::Size kSizes[] = {{1, 1}, {1, 7}, {9, 1}, {17, 5}, {64, 48}, {333, 217}};

}  // namespace

TEST_CASE("PNG images are what was written, for OpenCV and for ours") {
  for (const cv::Size& size : kSizes) {
    for (const int type : {CV_8UC1, CV_16UC1, CV_8UC3}) {
      const cv::Mat image = picture(size, type);
      const std::vector<std::uint8_t> bytes = io::encode_png(image);
      CHECK(equal(cv::imdecode(bytes, cv::IMREAD_UNCHANGED), image));
      CHECK(equal(io::detail::decode_image(bytes, io::ImageAs::Stored), image));
    }
  }
  const cv::Mat large = picture({80, 60}, CV_8UC3);
  const cv::Mat part = large(cv::Rect(3, 5, 21, 13));  // rows that do not follow each other
  CHECK(equal(cv::imdecode(io::encode_png(part), cv::IMREAD_UNCHANGED), part));
}

TEST_CASE("JPEG images are those that OpenCV writes") {
  for (const cv::Size& size : kSizes) {
    for (const int type : {CV_8UC1, CV_8UC3}) {
      for (const int quality : {25, io::kGoodQuality}) {
        const cv::Mat image = picture(size, type);
        std::vector<std::uint8_t> theirs;
        cv::imencode(".jpg", image, theirs, {cv::IMWRITE_JPEG_QUALITY, quality});
        const cv::Mat before = image.clone();
        const std::vector<std::uint8_t> bytes = io::encode_jpeg(image, quality);
        CHECK(equal(image, before));
        CHECK(equal(cv::imdecode(bytes, cv::IMREAD_UNCHANGED), cv::imdecode(theirs, cv::IMREAD_UNCHANGED)));
      }
    }
  }
}

TEST_CASE("images that no file can have, and files that cannot be written, are an error with the path") {
  for (const cv::Mat& image :
       {cv::Mat(), cv::Mat(4, 4, CV_32FC1), cv::Mat(4, 4, CV_8UC4), cv::Mat(4, 4, CV_16UC3)}) {
    CHECK_THROWS_AS(io::encode_png(image), IoError);
    CHECK_THROWS_AS(io::encode_jpeg(image), IoError);
  }
  CHECK_THROWS_AS(io::encode_jpeg(cv::Mat(4, 4, CV_16UC1)), IoError);
  const cv::Mat long_row = cv::Mat::zeros(1, 70'000, CV_8UC1);  // JPEG counts to 65,535
  CHECK_THROWS_AS(io::encode_jpeg(long_row), IoError);
  CHECK(equal(cv::imdecode(io::encode_png(long_row), cv::IMREAD_UNCHANGED), long_row));
  const dynfilter_test::TemporaryFolder folder;
  const std::filesystem::path path = folder.path() / "none/1.png";
  CHECK_THROWS_WITH_AS(io::write_image(path, picture({4, 4}, CV_8UC1)),
                       doctest::Contains((path.string() + ": cannot write the picture").c_str()), IoError);
  CHECK_THROWS_WITH_AS(io::write_image("/dev/full", picture({4, 4}, CV_8UC1)), doctest::Contains("full"),
                       IoError);
}

TEST_CASE("the name of the file says what is written") {
  const dynfilter_test::TemporaryFolder folder;
  const cv::Mat image = picture({40, 30}, CV_8UC3);
  io::write_image(folder.path() / "1.png", image);
  io::write_image(folder.path() / "2.jpg", image);
  CHECK(equal(io::read_image(folder.path() / "1.png", io::ImageAs::Colour), image));
  CHECK(equal(io::read_image(folder.path() / "2.jpg", io::ImageAs::Colour),
              cv::imdecode(io::encode_jpeg(image), cv::IMREAD_COLOR)));
}

}  // namespace image_encoder_test
