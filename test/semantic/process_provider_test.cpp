// SPDX-License-Identifier: MIT
#include <atomic>
#include <chrono>
#include <dynfilter/core/limits.hpp>
#include <dynfilter/detectors/process_provider.hpp>
#include <dynfilter/semantic/runner.hpp>
#include <filesystem>
#include <fstream>
#include <numeric>
#include <thread>

#include "doctest/doctest.h"
#include "scripted_provider.hpp"
#include "support/comma_locale.hpp"

namespace process_provider_test {

using namespace dynfilter;
using dynfilter_test::image_of;

namespace {

/// A program for /bin/sh.
std::unique_ptr<ProcessProvider> shell(const std::string& program, double timeout_s = 20, int restarts = 0) {
  ProcessProviderParams params;
  params.command = {"/bin/sh", "-c", program};
  params.timeout_s = params.start_timeout_s = timeout_s;
  params.restarts = restarts;
  return std::make_unique<ProcessProvider>(params);
}

const std::string kHello = "echo dynfilter-provider 1; ";
/// Reads the request's line and the 12 bytes of a 2 x 2 colour image.
const std::string kRead = "read line; head -c 12 > /dev/null; ";

const cv::Mat kColour(2, 2, CV_8UC3, cv::Scalar(1, 2, 3));

template <class F>
std::string error_of(const F& f) {
  try {
    f();
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

}  // namespace

TEST_CASE("a result goes through the protocol unchanged, both ways") {
  int ends[2];
  REQUIRE(::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) == 0);
  const auto script = std::make_shared<dynfilter_test::Script>();
  cv::Mat seen;
  script->infer = [&](const SemanticImage& image) -> std::optional<SemanticResult> {
    seen = image.pixels.clone();
    if (image.frame_id == 1) return std::nullopt;
    if (image.frame_id == 2) throw std::runtime_error("out of\nmemory");
    SemanticResult result;
    Detection d;
    d.box = cv::Rect2f(-1.25F, 3.5F, 100.125F, 20);
    d.class_id = 62, d.class_name = "tv monitor", d.score = 0.1F;
    result.detections = {d};
    result.labels = cv::Mat(3, 5, CV_8UC1);
    std::iota(result.labels->begin<std::uint8_t>(), result.labels->end<std::uint8_t>(), std::uint8_t{0});
    return result;
  };
  std::thread server([&] {
    dynfilter_test::ScriptedProvider provider(script);
    protocol::serve(provider, ends[1], ends[1]);
    ::close(ends[1]);
  });
  {
    MessageStream stream(ends[0], ends[0]);
    CHECK(stream.read_line() == "dynfilter-provider 1");
    // A part of a larger image: its rows have gaps.
    cv::Mat large(400, 500, CV_8UC3);
    cv::randu(large, 0, 255);
    const cv::Mat part = large(cv::Rect(7, 9, 300, 200));
    protocol::write_image(stream, image_of(0, part));
    const std::optional<SemanticResult> result = protocol::read_result(stream);
    CHECK(cv::norm(seen, part, cv::NORM_INF) == 0);
    REQUIRE(result);
    REQUIRE(result->detections->size() == 1);
    const Detection& d = result->detections->front();
    CHECK(d.box == cv::Rect2f(-1.25F, 3.5F, 100.125F, 20));
    CHECK(d.class_id == 62);
    CHECK(d.class_name == "tv monitor");
    CHECK(d.score == 0.1F);
    REQUIRE(result->labels->size() == cv::Size(5, 3));
    CHECK(result->labels->at<std::uint8_t>(2, 4) == 14);
    protocol::write_image(stream, image_of(1, part));
    CHECK_FALSE(protocol::read_result(stream));
    protocol::write_image(stream, image_of(2, part));
    CHECK(error_of([&] { protocol::read_result(stream); }) == "out of memory");
    CHECK(error_of([&] { protocol::write_image(stream, image_of(3, cv::Mat(2, 2, CV_32FC1))); }) ==
          "an image must have 1 or 3 channels of 8 bits");
  }
  ::shutdown(ends[0], SHUT_WR);
  server.join();
  ::close(ends[0]);
}

TEST_CASE("numbers go through the protocol with a point, whatever the locale of either side") {
  const dynfilter_test::CommaLocale locale;
  if (!locale.in_c()) MESSAGE("no locale with a comma for printf and strtod here: streams only");
  int ends[2];
  REQUIRE(::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) == 0);
  MessageStream host(ends[0], ends[0]), provider(ends[1], ends[1]);
  SemanticImage image = image_of(1234567, kColour);
  image.timestamp_s = 1305031102.25;  // exact in binary
  protocol::write_image(host, image);
  CHECK(provider.read_line() == "image 1234567 1305031102.250000000 2 2 3");
  unsigned char pixels[12];
  provider.read_bytes(pixels, sizeof(pixels));

  protocol::write_image(host, image);
  SemanticImage seen;
  protocol::read_image(provider, seen);
  CHECK(seen.frame_id == 1234567);
  CHECK(seen.timestamp_s == image.timestamp_s);

  SemanticResult result;
  Detection d;
  d.box = cv::Rect2f(-1.25F, 1003.5F, 100.125F, 20);
  d.class_id = 1062, d.class_name = "tv monitor", d.score = 0.1F;
  result.detections = {d};
  protocol::write_result(provider, result);
  CHECK(host.read_line() == "detections 1");
  CHECK(host.read_line() == "1062 0.100000001 -1.25 1003.5 98.875 1023.5 tv monitor");
  CHECK(host.read_line() == "end");
  protocol::write_result(provider, result);
  const std::optional<SemanticResult> back = protocol::read_result(host);
  REQUIRE(back);
  CHECK(back->detections->front().box == d.box);
  CHECK(back->detections->front().score == d.score);
  CHECK(parse_runner_mode("rate:2.5").rate_hz == 2.5);
  CHECK_THROWS_AS(parse_runner_mode("rate:2,5"), ConfigError);
  ::close(ends[0]);
  ::close(ends[1]);
}

TEST_CASE("a program says what it found, nothing, or no word") {
  const auto provider = shell(kHello + kRead + "echo detections 0; echo end; " + kRead + "echo end; " +
                              kRead + "echo error no light; " + kRead +
                              "printf 'detections 1\\n0 0.5 1 2 11 22 person\\nend\\n'; cat > /dev/null");
  const std::optional<SemanticResult> nothing = provider->infer(image_of(0, kColour));
  REQUIRE(nothing);
  CHECK(nothing->detections->empty());
  CHECK_FALSE(provider->infer(image_of(1, kColour)));
  CHECK(error_of([&] { provider->infer(image_of(2, kColour)); }) == "/bin/sh: no light");
  const std::optional<SemanticResult> one = provider->infer(image_of(3, kColour));
  REQUIRE(one);
  CHECK(one->detections->at(0).box == cv::Rect2f(1, 2, 10, 20));
}

TEST_CASE("a program that is missing, dies, hangs or talks nonsense: one clear line") {
  const auto start = [](const std::string& program, double timeout_s) {
    return error_of([&] { shell(program, timeout_s); });
  };
  ProcessProviderParams missing;
  missing.command = {"/no/such/program"};
  CHECK(error_of([&] { const ProcessProvider provider(missing); }) ==
        "/no/such/program: cannot be started: No such file or directory");
  CHECK(error_of([] { const ProcessProvider provider((ProcessProviderParams())); }) == "no command to start");
  CHECK(start("exit 3", 20) == "/bin/sh: ended with exit code 3 instead of answering");
  CHECK(start("kill -9 $$", 20) == "/bin/sh: ended with signal 9 instead of answering");
  CHECK(start("sleep 100", 0.05) == "/bin/sh: killed: no answer within 0.05 s");
  CHECK(start("echo hello; sleep 100", 20) ==
        "/bin/sh: killed: expected `dynfilter-provider 1`, got `hello`");
  CHECK(start("head -c 100000 /dev/zero; sleep 100", 20) ==
        "/bin/sh: killed: a line of more than 4096 bytes");

  const auto answer = [](const std::string& words, double timeout_s = 20) {
    const auto provider = shell(kHello + kRead + words, timeout_s);
    return error_of([&] { provider->infer(image_of(0, kColour)); });
  };
  CHECK(answer("exit 1") == "/bin/sh: ended with exit code 1 instead of answering");
  CHECK(answer("printf 'de\\001tections 1\\n'; sleep 100").find("`de?tections 1`") != std::string::npos);
  for (const char* words : {"echo detections -1", "echo detections many", "echo detections 99999999",
                            "echo labels 0 4", "echo labels 5", "printf 'detections 1\\n0 nan\\n'", "echo"}) {
    CAPTURE(words);
    CHECK(answer(std::string(words) + "; sleep 100").rfind("/bin/sh: killed: expected `", 0) == 0);
  }
}

TEST_CASE("an answer to another image is dropped and shifts no later one") {
  const auto box = [](int id, int x) {
    return "echo result " + std::to_string(id) + "; echo detections 1; echo 0 0.5 " + std::to_string(x) +
           " 2 50 60 person; echo end; ";
  };
  // Answers image 1 twice, the second time after the next request, and an image that was never sent.
  const auto provider =
      shell(kHello + kRead + box(1, 11) + kRead + box(1, 12) + box(99, 13) +
            "echo result 98; echo error old; " + box(2, 21) + kRead + box(3, 31) + "cat > /dev/null");
  for (int k = 1; k <= 3; ++k) {
    CAPTURE(k);
    const std::optional<SemanticResult> result = provider->infer(image_of(k, kColour));
    REQUIRE(result);
    CHECK(result->frame_id == k);
    CHECK(result->detections->at(0).box.x == static_cast<float>(10 * k + 1));
  }
}

TEST_CASE("a second answer without a frame id is dropped when it is there before the next image") {
  // One write for both answers, so that the second is there with the first.
  const auto twice = [](int x) {
    const std::string box = "detections 1\\n0 0.5 " + std::to_string(x) + " 2 50 60 person\\nend\\n";
    return "printf '" + box + box + "'; ";
  };
  const auto provider =
      shell(kHello + kRead + twice(11) + kRead + twice(21) + kRead + twice(31) + "cat > /dev/null");
  for (int k = 1; k <= 3; ++k) {
    const std::optional<SemanticResult> result = provider->infer(image_of(k, kColour));
    REQUIRE(result);
    CHECK(result->detections->at(0).box.x == static_cast<float>(10 * k + 1));
  }
}

TEST_CASE("boxes that cannot be: an error of the program, which continues") {
  const auto boxes = [](const std::string& numbers) {
    return kRead + "echo detections 2; echo 0 0.5 1 2 11 22 person; echo 0 " + numbers +
           " person; echo end; ";
  };
  const auto provider =
      shell(kHello + boxes("5 1 2 11 22") + boxes("-0.1 1 2 11 22") + boxes("0.5 1 2 1e38 22") +
            boxes("0.5 -1e38 2 11 1e38") + boxes("0.5 2 2 12 22") + "cat > /dev/null");
  const auto answer = [&](int k) { return error_of([&] { provider->infer(image_of(k, kColour)); }); };
  CHECK(answer(0) == "/bin/sh: a score of 5, expected 0 to 1");
  CHECK(answer(1) == "/bin/sh: a score of -0.1, expected 0 to 1");
  CHECK(answer(2) == "/bin/sh: a coordinate of 1e+38, expected less than a million pixels");
  CHECK(answer(3) == "/bin/sh: a coordinate of -1e+38, expected less than a million pixels");
  const std::optional<SemanticResult> result = provider->infer(image_of(4, kColour));
  REQUIRE(result);
  CHECK(result->detections->size() == 2);
}

TEST_CASE("control characters of a program do not reach a terminal") {
  const auto provider = shell(
      kHello + kRead + "printf 'error \\033[31mred\\r\\302\\233m\\n'; " + kRead +
      "printf 'detections 1\\n0 0.5 1 2 11 22 per\\033[2Json stra\\303\\237e\\nend\\n'; cat > /dev/null");
  CHECK(error_of([&] { provider->infer(image_of(0, kColour)); }) == "/bin/sh: ?[31mred???m");
  const std::optional<SemanticResult> result = provider->infer(image_of(1, kColour));
  REQUIRE(result);
  CHECK(result->detections->at(0).class_name == "per?[2Json stra\303\237e");
}

TEST_CASE("what a program may send is limited before memory is taken") {
  const auto answer = [](const std::string& words) {
    const auto provider = shell(kHello + kRead + words + "; sleep 100");
    return error_of([&] { provider->infer(image_of(0, kColour)); });
  };
  const std::string killed = "/bin/sh: killed: ", expected = killed + "expected `";
  CHECK(answer("echo detections " + std::to_string(limits::kMaxBoxes + 1)).rfind(expected, 0) == 0);
  // Each side is allowed, both together are 268 million pixels.
  CHECK(answer("echo labels 16384 16384").rfind(expected, 0) == 0);
  CHECK(answer("echo labels 16385 1").rfind(expected, 0) == 0);
  CHECK(answer("echo detections 0; echo detections 0").rfind(expected, 0) == 0);
  CHECK(answer("echo result x").rfind(expected, 0) == 0);
  CHECK(answer("head -c 5000 /dev/zero; echo") == killed + "a line of more than 4096 bytes");
}

TEST_CASE("a program that hangs is killed, and started again as often as allowed") {
  ProcessProviderParams params;
  params.command = {"/bin/sh", "-c", kHello + kRead + "sleep 100 & wait"};
  params.timeout_s = 0.05;
  params.restarts = 1;
  ProcessProvider provider(params);
  const std::string killed = "/bin/sh: killed: no answer within 0.05 s";
  CHECK(error_of([&] { provider.infer(image_of(0, kColour)); }) == killed);
  CHECK(error_of([&] { provider.infer(image_of(1, kColour)); }) == killed);
  CHECK(error_of([&] { provider.infer(image_of(2, kColour)); }) ==
        "/bin/sh: not started again after 1 restarts");
}

TEST_CASE("who waits for an answer or a start can be stopped long before the time limit") {
  ProcessProviderParams params;
  params.timeout_s = params.start_timeout_s = 1000;
  params.restarts = 0;
  const std::string reads = kHello + kRead;
  for (const std::string& before : {std::string(), reads}) {
    std::atomic<bool> stop{false};
    params.command = {"/bin/sh", "-c", before + "sleep 1000 & wait"};
    std::thread other([&] {
      std::this_thread::sleep_for(std::chrono::milliseconds(200));
      stop = true;
    });
    const auto begin = std::chrono::steady_clock::now();
    CHECK(error_of([&] {
            ProcessProvider provider(params, [&] { return stop.load(); });
            provider.infer(image_of(0, kColour));
          }) == "/bin/sh: killed: stopped");
    CHECK(std::chrono::steady_clock::now() - begin < std::chrono::seconds(60));
    other.join();
  }
}

TEST_CASE("a provider that is not stopped answers as without the question") {
  ProcessProviderParams params;
  params.command = {"/bin/sh", "-c", kHello + kRead + "sleep 0.3; echo detections 0; echo end"};
  int asked = 0;
  ProcessProvider provider(params, [&] { return ++asked < 0; });
  const auto result = provider.infer(image_of(0, kColour));
  REQUIRE(result);
  CHECK(result->detections->empty());
  CHECK(asked > 2);  // at the start, for the image and again after 0.1 s
}

TEST_CASE("a killed program takes its children with it, also those that left its group") {
  const auto folder =
      std::filesystem::temp_directory_path() / ("dynfilter_children_" + std::to_string(::getpid()));
  std::filesystem::create_directories(folder);
  const auto note = [&](const char* name) { return "echo $$ > " + (folder / name).string() + "; "; };
  const auto number_in = [&](const char* name) {
    long pid = 0;
    for (int k = 0; k < 1000 && pid == 0; ++k) {
      std::ifstream(folder / name) >> pid;
      if (pid == 0) std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    return pid;
  };
  const auto is_alive = [](long pid) {  // a zombie waits for init, which may be late
    std::ifstream in("/proc/" + std::to_string(pid) + "/stat");
    std::string number, name, state;
    return in >> number >> name >> state && state != "Z" && state != "X";
  };
  const auto sleeper = [&](const std::string& before, const char* name) {
    std::ofstream(folder / (std::string(name) + ".sh")) << note(name) << before << "exec sleep 1000\n";
    return "sh " + (folder / (std::string(name) + ".sh")).string() + " & ";
  };
  const std::string grandchild = sleeper("", "grandchild");
  const std::string program = sleeper("", "child") + "setsid " + sleeper(grandchild, "leaver");
  std::vector<long> pids;
  {
    const auto provider = shell(program + kHello + "sleep 1000");
    for (const char* name : {"child", "leaver", "grandchild"}) {
      pids.push_back(number_in(name));
      CHECK(is_alive(pids.back()));
    }
  }
  for (const long pid : pids) {
    for (int k = 0; k < 400 && is_alive(pid); ++k) std::this_thread::sleep_for(std::chrono::milliseconds(5));
    CHECK_FALSE(is_alive(pid));
  }
  std::filesystem::remove_all(folder);
}

TEST_CASE("an answer after the time limit is never taken for that of a later image") {
  const auto marker =
      std::filesystem::temp_directory_path() / ("dynfilter_late_" + std::to_string(::getpid()));
  const std::string answer = "echo detections 1; echo 0 0.5 1 2 11 22 person; echo end; ";
  // The first start answers too late, the second at once with another box.
  const std::string program = kHello + "if [ -e " + marker.string() + " ]; then " + kRead +
                              "echo detections 1; echo 0 0.5 31 2 50 60 person; echo end; else touch " +
                              marker.string() + "; " + kRead + "sleep 1; " + answer + "fi; cat > /dev/null";
  ProcessProviderParams params;
  params.command = {"/bin/sh", "-c", program};
  params.start_timeout_s = 20;
  params.timeout_s = 0.2;
  params.restarts = 1;
  ProcessProvider provider(params);
  CHECK(error_of([&] { provider.infer(image_of(0, kColour)); }) == "/bin/sh: killed: no answer within 0.2 s");
  const std::optional<SemanticResult> result = provider.infer(image_of(1, kColour));
  std::filesystem::remove(marker);
  REQUIRE(result);
  CHECK(result->detections->at(0).box.x == 31.0F);
}

TEST_CASE("examples/python/lamp_provider.py is a provider") {
  if (std::system("python3 -c '' 2> /dev/null") != 0) {
    MESSAGE("skipped: no python3");
    return;
  }
  ProcessProviderParams params;
  params.command = {"python3", "-B", DYNFILTER_SOURCE_DIR "/examples/python/lamp_provider.py"};
  params.timeout_s = 30;
  ProcessProvider provider(params);
  cv::Mat dark(40, 60, CV_8UC3, cv::Scalar(9, 9, 9));
  const std::optional<SemanticResult> nothing = provider.infer(image_of(0, dark));
  REQUIRE(nothing);
  CHECK(nothing->detections->empty());
  dark(cv::Rect(20, 10, 15, 5)).setTo(cv::Scalar(255, 255, 255));
  const std::optional<SemanticResult> lamp = provider.infer(image_of(1, dark));
  REQUIRE(lamp);
  REQUIRE(lamp->detections->size() == 1);
  CHECK(lamp->detections->front().box == cv::Rect2f(20, 10, 15, 5));
  CHECK(lamp->detections->front().class_name == "lamp");
}

}  // namespace process_provider_test
