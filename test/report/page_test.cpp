// SPDX-License-Identifier: MIT
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "doctest/doctest.h"
#include "report/base64.hpp"
#include "report/map_sample.hpp"
#include "report/page.hpp"
#include "report/picture.hpp"
#include "report_data.hpp"

using namespace dynfilter_test;
namespace command = dynfilter::command;
namespace report = dynfilter::command::report;

namespace {

std::string base64(const std::string& text) {
  return report::base64(reinterpret_cast<const std::uint8_t*>(text.data()), text.size());
}

cv::Mat noise(int width_px, int height_px) {
  cv::Mat picture(height_px, width_px, CV_8UC3);
  cv::RNG(1).fill(picture, cv::RNG::UNIFORM, 0, 256);
  return picture;
}

/// A long run of the largest pictures that compress worst.
report::RunRecord long_run(std::size_t frames, const report::RunShare& share = report::RunShare(1)) {
  report::RunRecord run;
  run.summary.sequence = "long", run.summary.pipeline = "p";
  run.reasons.push_back({"a+b", std::vector<std::size_t>(frames, 123)});
  run.stages.push_back({"before_pose", "a", "before_pose/0", 0, std::vector<double>(frames, 1.2345678)});
  const std::size_t step = report::picture_step(frames, share.pictures);
  const std::vector<std::uint8_t> jpeg =
      report::PictureEncoder(share.picture_bytes / ((frames + step - 1) / step)).encode(noise(960, 780));
  for (std::size_t k = 0; k < frames; ++k) {
    command::FrameRow row;
    row.index = k, row.timestamp_s = 1.7e9 + static_cast<double>(k) / 30, row.state = "tracked";
    row.features = 1000, row.of_static = 500, row.dynamic = 400, row.unknown = 100;
    row.extraction_ms = row.filters_ms = row.tracking_ms = 12.3456789;
    row.note = "background_motion: background: 512 of 803 points, motion as predicted, one of 3";
    run.rows.push_back(row);
    run.age_frames.push_back(3), run.restored.push_back(0), run.errors_m.push_back(0.0123456789);
    run.positions_m.push_back(Eigen::Vector3d::Constant(123.456789));
    run.marks.push_back({k, "late", "boxes or masks are 3 frames old"});
    if (k % step == 0) run.pictures.push_back({k, jpeg});
  }
  for (int i = 0; i < 60'000; ++i) {
    run.map_m.emplace_back(std::sin(i), std::cos(3 * i), std::sin(7 * i));
    run.map_bgr.emplace_back(1, 2, 3);
  }
  run.map_points = run.map_m.size();
  return run;
}

}  // namespace

TEST_CASE("base64 as in RFC 4648, section 10") {
  CHECK(base64("").empty());
  CHECK(base64("f") == "Zg==");
  CHECK(base64("fo") == "Zm8=");
  CHECK(base64("foo") == "Zm9v");
  CHECK(base64("foobar") == "Zm9vYmFy");
  CHECK(base64("\xFB\xFF") == "+/8=");
}

TEST_CASE("pictures: how many, and none larger than it may be") {
  CHECK(report::picture_step(500, 100) == 5);
  CHECK(report::picture_step(501, 100) == 6);
  CHECK(report::picture_step(50, 100) == 1);
  CHECK(report::picture_step(1, 0) == 1);
  CHECK(report::picture_step(0, 100) == 1);
  CHECK(report::picture_step(500, 100, 10) == 10);       // only 50 are drawn
  CHECK(report::picture_step(3000, 100, 20) % 20 == 0);  // no picture that is not drawn anyway
  const std::vector<std::uint8_t> jpeg = report::PictureEncoder(100'000).encode(noise(1920, 1080));
  CHECK(jpeg.size() <= 100'000);
  const cv::Mat read = cv::imdecode(jpeg, cv::IMREAD_COLOR);
  REQUIRE_FALSE(read.empty());
  CHECK(std::abs(static_cast<double>(read.cols) / read.rows - 1920.0 / 1080) < 0.02);
  CHECK(
      cv::imdecode(report::PictureEncoder(100'000).encode(cv::Mat(12, 16, CV_8UC3, cv::Scalar(1))), 1).cols ==
      16);
}

TEST_CASE("a sample of the map is even, whatever the density of its parts") {
  // Two squares of 1 m: one of 500 x 500 points, one of 50 x 50.
  std::vector<cv::Point3f> points;
  for (int i = 0; i < 500; ++i)
    for (int j = 0; j < 500; ++j)
      points.emplace_back(0.002F * static_cast<float>(i), 0.002F * static_cast<float>(j), 0.F);
  for (int i = 0; i < 50; ++i)
    for (int j = 0; j < 50; ++j)
      points.emplace_back(-2 + 0.02F * static_cast<float>(i), 0.02F * static_cast<float>(j), 0.F);
  const std::vector<std::size_t> sample = report::map_sample(points, 1000);
  CHECK(sample.size() <= 1000);
  CHECK(sample.size() > 500);
  const auto dense = std::count_if(sample.begin(), sample.end(), [](std::size_t i) { return i < 250'000; });
  CHECK(std::abs(2 * dense - static_cast<std::ptrdiff_t>(sample.size())) < 200);
  CHECK(report::map_sample({points[0], points[1], points[0]}, 10).size() == 1);  // within a centimetre
  CHECK(report::map_sample({}, 10).empty());
}

TEST_CASE("a page is below 10 MB, with pictures of noise and a map, whatever the number of frames and runs") {
  CHECK(report::run_page(long_run(report::kMostRows), {}).size() < 10'000'000);
  for (const std::size_t runs : {std::size_t{4}, std::size_t{24}}) {
    const report::RunShare share(runs);
    CHECK(share.pictures >= report::kLeastPictures);
    CHECK(share.rows * runs <= report::kMostRows);
    std::vector<report::RunRecord> records(runs, long_run(share.rows, share));
    for (report::RunRecord& run : records) {
      run.map_m.resize(report::kMapPointsOfAllRuns / runs);
      run.map_bgr.resize(run.map_m.size());
    }
    const std::string page = report::compare_page(records, Json::array());
    CAPTURE(runs);
    CAPTURE(page.size());
    CHECK(page.size() < 10'000'000);
  }
}

TEST_CASE("the page of 500 frames has 100 pictures and the map") {
  const std::string page = report::run_page(long_run(500), {});
  const Json run = data_of(page)["runs"][0];
  CHECK(run["frames"]["index"].size() == 500);
  CHECK(run["pictures"].size() == 100);
  CHECK(run["map"]["shown"] == 60'000);
}

TEST_CASE("names are text, wherever they are") {
  const std::string name = "</script><script>alert(1)</script><img src=x onerror=alert(1)>\"'&@DATA@";
  report::RunRecord run = long_run(2);
  run.summary.sequence = run.summary.pipeline = name;
  run.summary.notes = {name, "caf\xE9"};
  run.rows[0].note = run.reasons[0].name = run.stages[0].name = run.marks[0].text = name;
  for (const std::string& page : {report::run_page(run, {}), report::compare_page({run}, Json::array())}) {
    CHECK(times(page, "<script") == 2);
    CHECK(times(page, "<img") == 0);
    CHECK(data_of(page)["runs"][0]["summary"]["sequence"] == name);
  }
  CHECK(report::escaped("<a b=\"c\" d='e'>&") == "&lt;a b=&quot;c&quot; d=&#39;e&#39;&gt;&amp;");
}

TEST_CASE("what is not known is null: no truth, nothing tracked, no features") {
  report::RunRecord run = long_run(1);
  run.summary = {};
  run.rows[0].state = "no_map", run.rows[0].features = run.rows[0].unknown = 0;
  run.positions_m[0] = Eigen::Vector3d::Constant(NAN), run.errors_m[0] = NAN;
  run.age_frames[0] = NAN, run.stages[0].ms[0] = NAN;
  run.map_m.clear(), run.map_bgr.clear();
  const std::string page = report::run_page(run, {});
  const Json data = data_of(page)["runs"][0];
  CHECK(data["summary"]["ate_rmse_m"].is_null());
  for (const char* key : {"error_m", "age_frames", "recall", "precision", "static_kept"}) {
    CAPTURE(key);
    CHECK(data["frames"][key][0].is_null());
  }
  CHECK(data["position_m"][2][0].is_null());
  CHECK(data["stages"][0]["ms"][0].is_null());
  CHECK(data["map"].is_null());
}
