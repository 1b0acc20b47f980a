// SPDX-License-Identifier: MIT
#include <atomic>
#include <chrono>
#include <dynfilter/semantic/async_runner.hpp>
#include <opencv2/core.hpp>
#include <optional>
#include <stdexcept>
#include <thread>

#include "doctest/doctest.h"
#include "scripted_provider.hpp"

namespace runner_test {

using namespace dynfilter;
using dynfilter_test::image_of;
using dynfilter_test::Script;
using dynfilter_test::ScriptedProvider;

namespace {

std::unique_ptr<ScriptedProvider> provider(const std::shared_ptr<Script>& script) {
  return std::make_unique<ScriptedProvider>(script);
}

/// The frame whose result is available after each of n frames at 30 Hz; -1: none.
std::vector<std::int64_t> available(const std::string& mode, int n, std::shared_ptr<Script> script = {}) {
  if (!script) script = std::make_shared<Script>();
  const std::unique_ptr<SemanticRunner> runner = make_runner(provider(script), parse_runner_mode(mode));
  std::vector<std::int64_t> ids;
  for (int k = 0; k < n; ++k) {
    runner->submit(image_of(k));
    const SemanticRunner::Result result = runner->latest();
    ids.push_back(result ? result->frame_id : -1);
  }
  return ids;
}

using Ids = std::vector<std::int64_t>;

/// Waits until the condition is true, and fails after a timeout.
template <class Condition>
void until(const Condition& condition) {
  while (!condition()) std::this_thread::yield();
}

}  // namespace

TEST_CASE("sync, late and rate hand results out when they say") {
  CHECK(available("sync", 4) == Ids{0, 1, 2, 3});
  CHECK(available("late:0", 4) == Ids{0, 1, 2, 3});
  CHECK(available("late:1", 4) == Ids{-1, 0, 1, 2});
  CHECK(available("late:3", 6) == Ids{-1, -1, -1, 0, 1, 2});
  // 10 Hz on frames of 30 Hz: the result of image 0 arrives with frame 3, which is processed next.
  const auto script = std::make_shared<Script>();
  CHECK(available("rate:10", 8, script) == Ids{-1, -1, -1, 0, 0, 0, 3, 3});
  CHECK(script->seen == Ids{0, 3, 6});
  // Quicker than the frames, but never at once.
  CHECK(available("rate:1000", 4) == Ids{-1, 0, 1, 2});
}

TEST_CASE("a provider may write its result to the same images again") {
  cv::Mat labels(4, 6, CV_8UC1), instance(4, 6, CV_8UC1);
  for (const char* mode : {"sync", "late:2", "rate:10"}) {
    CAPTURE(std::string(mode));
    const auto script = std::make_shared<Script>();
    script->infer = [&](const SemanticImage& image) {
      labels.setTo(cv::Scalar(static_cast<double>(image.frame_id)));
      labels.copyTo(instance);
      SemanticResult result;
      result.labels = labels;
      result.detections.emplace(1);
      result.detections->front().mask = instance;
      return std::optional<SemanticResult>(result);
    };
    const std::unique_ptr<SemanticRunner> runner = make_runner(provider(script), parse_runner_mode(mode));
    for (int k = 0; k < 8; ++k) {
      runner->submit(image_of(k));
      const SemanticRunner::Result result = runner->latest();
      if (!result) continue;
      const auto id = static_cast<double>(result->frame_id);
      CHECK(cv::countNonZero(*result->labels != id) == 0);
      CHECK(cv::countNonZero(result->detections->front().mask != id) == 0);
    }
  }
}

TEST_CASE("modes that cannot be read are refused") {
  for (const char* text : {"", "asink", "late", "late:", "late:-1", "late:1.5", "late:x", "rate:0", "rate:2x",
                           "rate", "sync:1", "async:2", "late:nan", "rate:nan"}) {
    CAPTURE(text);
    CHECK_THROWS_AS(parse_runner_mode(text), ConfigError);
  }
  CHECK(parse_runner_mode("rate:2").rate_hz == 2);
  CHECK(parse_runner_mode("late:10").late_frames == 10);
  RunnerParams params;
  params.timeout_s = 0;
  CHECK_THROWS_AS(AsyncRunner(provider(std::make_shared<Script>()), params), ConfigError);
}

TEST_CASE("none came, nothing found and an error are different") {
  for (const char* mode : {"sync", "async"}) {
    CAPTURE(mode);
    const auto script = std::make_shared<Script>();
    script->infer = [](const SemanticImage& image) -> std::optional<SemanticResult> {
      if (image.frame_id == 0) return std::nullopt;
      if (image.frame_id == 2) throw std::runtime_error("no memory left");
      if (image.frame_id == 3) throw 7;  // NOLINT: what others' code may do
      SemanticResult nothing;
      nothing.detections.emplace();
      return nothing;
    };
    const auto runner = make_runner(provider(script), parse_runner_mode(mode));
    CHECK(runner->latest() == nullptr);
    runner->submit(image_of(0));
    until([&] { return runner->status().silent == 1; });
    CHECK(runner->latest() == nullptr);
    runner->submit(image_of(1));
    until([&] { return runner->status().results == 1; });
    const SemanticRunner::Result found = runner->take();
    REQUIRE(found);
    CHECK(found->frame_id == 1);
    CHECK(found->timestamp_s == doctest::Approx(1.0 / 30));
    REQUIRE(found->detections);
    CHECK(found->detections->empty());
    CHECK_FALSE(found->labels);
    CHECK(runner->take() == nullptr);
    runner->submit(image_of(2));
    until([&] { return runner->status().failed == 1; });
    CHECK(runner->status().last_error == "no memory left");
    CHECK(runner->latest() == found);  // still valid
    runner->submit(image_of(3));
    until([&] { return runner->status().failed == 2; });
    runner->submit(image_of(4));  // the runner continues
    until([&] { return runner->status().results == 2; });
    CHECK(runner->take()->frame_id == 4);
    CHECK(runner->status().looked_at == 5);
  }
}

TEST_CASE("async: the newest image wins, one waits at most, and its pixels are copied") {
  const auto script = std::make_shared<Script>();
  script->gated = true;
  AsyncRunner runner(provider(script), {});
  cv::Mat buffer(2, 2, CV_8UC1, cv::Scalar(40));
  runner.submit(image_of(0, buffer));
  script->entered.wait_for(1);  // busy with frame 0
  for (int k = 1; k < 10; ++k) {
    buffer.setTo(cv::Scalar(40 + k));
    runner.submit(image_of(k, buffer));
  }
  buffer.setTo(cv::Scalar(0));
  CHECK(runner.status().skipped == 8);
  CHECK(runner.latest() == nullptr);
  script->go.up();
  script->entered.wait_for(2);  // 0 is done, busy with 9
  REQUIRE(runner.latest());
  CHECK(runner.latest()->frame_id == 0);
  CHECK((*runner.latest()->detections)[0].box.y == 40.0F);
  script->go.up();
  until([&] { return runner.status().results == 2; });
  CHECK(runner.latest()->frame_id == 9);
  CHECK((*runner.latest()->detections)[0].box.y == 49.0F);
  CHECK(script->seen == Ids{0, 9});
  CHECK(runner.status().submitted == 10);
  CHECK(runner.status().looked_at == 2);
}

TEST_CASE("a reset forgets results, those under way too") {
  const auto script = std::make_shared<Script>();
  script->gated = true;
  AsyncRunner runner(provider(script), {});
  runner.submit(image_of(0));
  script->entered.wait_for(1);
  runner.submit(image_of(1));
  runner.reset();
  script->go.up();
  until([&] { return runner.status().results == 1; });
  CHECK(runner.latest() == nullptr);
  CHECK(runner.status().skipped == 1);
  runner.submit(image_of(2));
  script->go.up();
  until([&] { return runner.status().results == 2; });
  CHECK(runner.latest()->frame_id == 2);
  runner.reset();
  CHECK(runner.latest() == nullptr);

  const auto late = make_runner(provider(std::make_shared<Script>()), parse_runner_mode("late:1"));
  late->submit(image_of(0));
  late->reset();
  late->submit(image_of(1));
  CHECK(late->latest() == nullptr);
  late->submit(image_of(2));
  CHECK(late->latest()->frame_id == 1);
}

TEST_CASE("a provider that hangs is abandoned, and deleted by its own thread should it ever return") {
  const auto script = std::make_shared<Script>();
  script->gated = true;
  const auto now_s = std::make_shared<std::atomic<double>>(0.0);
  RunnerParams params;
  params.timeout_s = 2;
  {
    AsyncRunner runner(provider(script), params, [now_s] { return now_s->load(); });
    runner.submit(image_of(0));
    script->go.up();
    until([&] { return runner.status().results == 1; });
    runner.submit(image_of(1));
    script->entered.wait_for(2);
    runner.submit(image_of(2));
    *now_s = 1.9;
    CHECK_FALSE(runner.status().abandoned);
    *now_s = 2.1;
    CHECK(runner.status().abandoned);
    CHECK(runner.status().last_error == "took longer than 2 s for one image: abandoned");
    CHECK(runner.latest()->frame_id == 0);
    runner.submit(image_of(3));
    CHECK(runner.status().submitted == 4);
    CHECK(runner.status().skipped == 2);
    CHECK(runner.status().looked_at == 2);
    CHECK(runner.latest()->frame_id == 0);
    runner.reset();
    CHECK(runner.latest() == nullptr);
  }
  script->go.up();  // it returns now
  script->deleted.wait_for(1);
  CHECK(script->seen == Ids{0, 1});
}

TEST_CASE("shutdown waits for the image under way, but not for ever") {
  const auto quick = std::make_shared<Script>();
  {
    AsyncRunner runner(provider(quick), {});
    runner.submit(image_of(0));
    quick->entered.wait_for(1);
  }
  quick->deleted.wait_for(1);
  AsyncRunner(provider(std::make_shared<Script>()), {});  // never used

  const auto hung = std::make_shared<Script>();
  hung->gated = true;
  RunnerParams params;
  params.shutdown_s = 0.05;
  auto runner = std::make_unique<AsyncRunner>(provider(hung), params);
  runner->submit(image_of(0));
  hung->entered.wait_for(1);
  const auto start = std::chrono::steady_clock::now();
  runner.reset();
  CHECK(std::chrono::steady_clock::now() - start < std::chrono::seconds(5));
  hung->go.up();
  hung->deleted.wait_for(1);
}

}  // namespace runner_test
