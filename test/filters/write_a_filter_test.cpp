// SPDX-License-Identifier: MIT
#include <array>
#include <dynfilter/config/registry.hpp>
#include <dynfilter/core/error.hpp>
#include <dynfilter/core/filter.hpp>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/span.hpp>
#include <dynfilter/core/verdict.hpp>
#include <dynfilter/core/votes.hpp>
#include <dynfilter/evidence/frame_evidence.hpp>
#include <dynfilter/pipeline/builtin_filters.hpp>
#include <dynfilter/pipeline/pipeline_yaml.hpp>
#include <dynfilter/testing/exact_scene.hpp>
#include <dynfilter/testing/exact_scene_frame.hpp>
#include <dynfilter/testing/exact_scene_motion.hpp>
#include <dynfilter/testing/exact_scene_presets.hpp>
#include <dynfilter/testing/judge.hpp>
#include <filesystem>
#include <fstream>
#include <memory>
#include <sstream>
#include <string>

#include "../../examples/06_filter_recipes/recipes.hpp"
#include "doctest/doctest.h"

namespace write_a_filter_test {

using namespace dynfilter;
namespace fs = std::filesystem;

namespace {

std::string read(const fs::path& path) {
  std::ifstream file(path);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

/// The text of each fenced block of a page that is in this language.
std::vector<std::string> code_blocks(const std::string& page, const std::string& language) {
  std::vector<std::string> blocks;
  const std::string fence = "\n```";
  for (std::size_t at = page.find(fence); at != std::string::npos; at = page.find(fence, at)) {
    const std::size_t line_end = page.find('\n', at + 1), close = page.find(fence, line_end - 1);
    if (close == std::string::npos) break;
    if (page.substr(at + fence.size(), line_end - at - fence.size()) == language)
      blocks.push_back(page.substr(line_end + 1, close - line_end));
    at = close + fence.size();
  }
  return blocks;
}

/// Frames are judged by a filter after an earlier stage, as in a sequence.
class Behind {
 public:
  Behind(Filter& filter, std::size_t features) : filter_(filter), features_(features) {}

  /// `dynamic`: what the earlier stage rejects.
  Votes next(const std::vector<cv::Point2f>& pixels, const std::vector<std::size_t>& dynamic) {
    std::vector<cv::KeyPoint> keypoints;
    for (const cv::Point2f& px : pixels) keypoints.emplace_back(px, 31.0F);
    std::vector<std::int32_t> same(features_);
    for (std::size_t i = 0; i < features_; ++i) same[i] = static_cast<std::int32_t>(i);
    FrameView view;
    view.id = id_++;
    view.keypoints = keypoints;
    if (view.id > 0) view.matches = HostMatches{view.id - 1, same};
    evidence_.begin(view, CallPoint::BeforePose);
    Votes earlier, votes;
    earlier.reset(features_), votes.reset(features_);
    for (const std::size_t i : dynamic) earlier.cast(i, Vote::Dynamic);
    evidence_.earlier_votes().learn(earlier);
    filter_.apply(evidence_, votes);
    evidence_.end(false);
    return votes;
  }

 private:
  Filter& filter_;
  std::size_t features_;
  FrameEvidence evidence_;
  std::int64_t id_ = 0;
};

}  // namespace

TEST_CASE("write_a_filter.md: its code is that of the example, word for word, and names ten recipes") {
  const fs::path source = DYNFILTER_SOURCE_DIR, example = source / "examples/06_filter_recipes";
  const std::string page = read(source / "docs/tutorials/write_a_filter.md");
  REQUIRE(!page.empty());
  std::string files;
  for (const auto& entry : fs::directory_iterator(example)) files += read(entry.path()) + "\n";
  int blocks = 0;
  for (const char* language : {"cpp", "yaml", "cmake"}) {
    for (const std::string& block : code_blocks(page, language)) {
      CAPTURE(block);
      CHECK(files.find(block) != std::string::npos);
      ++blocks;
    }
  }
  CHECK(blocks >= 4);
  // The page's table has every recipe of the source: `| 3 | `OffTheLine` | ...`.
  const std::string code = read(example / "recipes.hpp"), mark = "// recipe ",
                    final_class = " final : public";
  int recipes = 0;
  for (std::size_t at = code.find(mark); at != std::string::npos; at = code.find(mark, at + 1)) {
    const std::size_t number = at + mark.size(), end = code.find(final_class, at);
    const std::size_t begin = code.rfind(' ', end - 1) + 1;
    const std::string row = "\n| " + code.substr(number, code.find('\n', number) - number) + " | `" +
                            code.substr(begin, end - begin) + "` | ";
    CAPTURE(row);
    CHECK(page.find(row) != std::string::npos);
    ++recipes;
  }
  CHECK(recipes == 10);
}

TEST_CASE("recipe 1: depth decides, none is unknown; from YAML, with its range checked") {
  const testing::ExactScene scene = testing::preset(testing::Preset::General).missing_depth(0.2);
  recipes::TooNearParams params;
  params.min_depth_m = 2.4;
  recipes::TooNear filter(params);
  const Votes votes = testing::judge(filter, scene, 1);
  const testing::ExactFrame frame = scene.frame(1);
  std::array<int, 3> seen{};
  for (std::size_t i = 0; i < votes.size(); ++i) {
    const float z = frame.depth_m[i];
    CHECK(votes[i] == (!(z > 0) ? Vote::Unknown : z < 2.4F ? Vote::Dynamic : Vote::Static));
    ++seen[static_cast<std::size_t>(votes[i])];
  }
  for (const int n : seen) CHECK(n > 0);

  Registry registry;
  registry.add<recipes::TooNear>();
  CHECK(registry.find("too_near")->card.parameters.at(0).unit == "m");
  CHECK_THROWS_WITH_AS(
      pipeline_from_text("pipeline: { before_pose: [ { too_near: { min_depth_m: -1 } } ] }", registry),
      "pipeline.before_pose[0].too_near.min_depth_m: expected 0 to 100, got `-1`", ConfigError);
}

TEST_CASE("recipe 2: features in a person's box are suspects, and no more") {
  const testing::ExactScene scene = testing::preset(testing::Preset::General).with_detections();
  recipes::BoxSuspects filter;
  const Votes votes = testing::judge(filter, scene, 3);
  const testing::ExactFrame frame = scene.frame(3);
  CHECK(votes.count(Vote::Unknown) == votes.size());
  CHECK(votes.count_prior() >= 60);
  for (std::size_t i = 0; i < votes.size(); ++i)
    CHECK(votes.prior(i) == frame.detections->at(0).box.contains(frame.keypoints[i].pt));
}

TEST_CASE("recipes 3 to 5: what does not follow the camera's motion is found, the rest stays") {
  const testing::ExactScene scene =
      testing::preset(testing::Preset::General).pixel_noise(0.2).depth_noise(0.0014).with_poses();
  const testing::ExactScene far_back = testing::ExactScene(scene).gap(5);
  recipes::OffTheLine line;
  recipes::OffTheMotion motion;
  recipes::OffTheHostsPose pose;
  const testing::Score by_line(testing::judge(line, scene, 8), scene.frame(8)),
      by_motion(testing::judge(motion, far_back, 8), far_back.frame(8)),
      by_pose(testing::judge(pose, far_back, 8), far_back.frame(8));
  for (const testing::Score& score : {by_line, by_motion, by_pose}) {
    CHECK(score.dynamic_count > 40);
    CHECK(score.recall() > 0.9);
    CHECK(score.static_kept() > 0.9);
  }
  // A mover of 12 mm a frame shows five frames back, not after one.
  const auto slow = testing::MovingBox(60).at({-0.3, -0.35, 2.5}).moving({0.012, 0, 0});
  const testing::ExactScene crawling = testing::ExactScene().mover(slow).with_poses();
  const auto found = [&](int gap) {
    const testing::ExactScene watched = testing::ExactScene(crawling).gap(gap);
    return testing::Score(testing::judge(pose, watched, 8), watched.frame(8)).recall();
  };
  CHECK(found(5) == 1);
  CHECK(found(1) == 0);
}

TEST_CASE("recipe 6: a match of unlike descriptors is rejected") {
  // Two views of one point differ in at most 20 of 256 bits, two points in about 128.
  const testing::ExactScene scene =
      testing::preset(testing::Preset::Rigid).with_descriptors(10).mismatches(0.1).missing_matches(0.1);
  recipes::UnlikeMatches filter;
  const Votes votes = testing::judge(filter, scene, 2);
  const testing::ExactFrame frame = scene.frame(2);
  for (std::size_t i = 0; i < votes.size(); ++i) {
    const Vote wanted = frame.reference_index[i] < 0 ? Vote::Unknown
                        : frame.mismatched[i] != 0   ? Vote::Dynamic
                                                     : Vote::Static;
    CHECK(votes[i] == wanted);
  }
  CHECK(votes.count(Vote::Dynamic) > 10);
}

TEST_CASE("recipe 7: features that share a match are rejected") {
  recipes::SharedMatches filter;
  FrameEvidence evidence;
  const std::vector<cv::KeyPoint> keypoints{{10, 10, 31}, {50, 10, 31}, {90, 10, 31}, {130, 10, 31}};
  const std::vector<std::int32_t> matches{2, 0, 2, -1};
  Votes votes;
  for (std::int64_t id = 0; id < 2; ++id) {
    FrameView view;
    view.id = id;
    view.keypoints = keypoints;
    if (id > 0) view.matches = HostMatches{0, matches};
    evidence.begin(view, CallPoint::BeforePose);
    votes.reset(4);
    filter.apply(evidence, votes);
    evidence.end(false);
  }
  const Vote wanted[] = {Vote::Dynamic, Vote::Static, Vote::Dynamic, Vote::Unknown};
  for (std::size_t i = 0; i < 4; ++i) CHECK(votes[i] == wanted[i]);
}

TEST_CASE("recipe 8: against the last keyframe, once there is one") {
  const testing::ExactScene scene = testing::preset(testing::Preset::General).pixel_noise(0.2).gap(6);
  recipes::AgainstTheKeyframe filter;
  FrameEvidence evidence;
  evidence.set_history(1);
  Votes votes;
  testing::ExactFrame frame;
  for (int k = 0; k <= 6; ++k) {
    frame = scene.frame(k);
    FrameView view = frame.view();
    if (k < 6) view.matches.reset();
    evidence.begin(view, CallPoint::BeforePose);
    votes.reset(frame.size());
    filter.apply(evidence, votes);
    if (k == 0) CHECK(votes.notes() == "no keyframe yet");
    evidence.end(k == 0);  // the first frame is the keyframe
  }
  const testing::Score score(votes, frame);
  CHECK(score.recall() > 0.9);
  CHECK(score.static_kept() > 0.95);
}

TEST_CASE("recipe 9: what is surrounded by rejected features is rejected, too") {
  // Feature 0 has three neighbours of which two are rejected; feature 4 has one.
  const std::vector<cv::Point2f> pixels{{100, 100}, {110, 100}, {90, 100},
                                        {100, 130}, {300, 100}, {310, 100}};
  recipes::SpreadToNeighbours filter;
  Behind behind(filter, pixels.size());
  const Votes votes = behind.next(pixels, {1, 2, 5});
  CHECK(votes[0] == Vote::Dynamic);
  CHECK(votes[4] == Vote::Unknown);
  CHECK(votes.count(Vote::Dynamic) == 2);  // feature 3 sees the two and feature 0
}

TEST_CASE("recipe 10: a track that was rejected four times stays rejected for a frame, until reset") {
  recipes::RejectedBefore filter;
  const std::vector<cv::Point2f> pixels{{100, 100}, {200, 100}};
  Behind behind(filter, 2);
  for (int k = 0; k < 4; ++k) behind.next(pixels, {0});  // 1 - 0.8^4 = 0.59
  const Votes missed = behind.next(pixels, {});          // 0.47
  CHECK(missed[0] == Vote::Dynamic);
  CHECK(missed.suspicion(0) == doctest::Approx(0.8 * (1 - 0.8 * 0.8 * 0.8 * 0.8)));
  CHECK(missed[1] == Vote::Unknown);
  CHECK(behind.next(pixels, {})[0] == Vote::Unknown);  // 0.38
  for (int k = 0; k < 4; ++k) behind.next(pixels, {0});
  filter.reset();
  CHECK(behind.next(pixels, {})[0] == Vote::Unknown);
}

}  // namespace write_a_filter_test
