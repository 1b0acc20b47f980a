// SPDX-License-Identifier: MIT
#pragma once

#include <condition_variable>
#include <cstdint>
#include <dynfilter/semantic/provider.hpp>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

namespace dynfilter_test {

/// A number that increases, and a way to wait for it.
class Counter {
 public:
  void up() {
    const std::lock_guard<std::mutex> lock(mutex_);
    ++value_;
    changed_.notify_all();
  }
  void wait_for(int value) {
    std::unique_lock<std::mutex> lock(mutex_);
    changed_.wait(lock, [&] { return value_ >= value; });
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  int value_ = 0;
};

/// State shared by test and provider.
struct Script {
  Counter entered, go, deleted;
  std::function<std::optional<dynfilter::SemanticResult>(const dynfilter::SemanticImage&)> infer;
  bool gated = false;  ///< each image waits for one go
  std::vector<std::int64_t> seen;
};

class ScriptedProvider final : public dynfilter::SemanticProvider {
 public:
  explicit ScriptedProvider(std::shared_ptr<Script> script) : script_(std::move(script)) {}
  ~ScriptedProvider() override { script_->deleted.up(); }
  std::string name() const override { return "scripted"; }

  std::optional<dynfilter::SemanticResult> infer(const dynfilter::SemanticImage& image) override {
    script_->seen.push_back(image.frame_id);
    script_->entered.up();
    if (script_->gated) script_->go.wait_for(++looked_);
    if (script_->infer) return script_->infer(image);
    dynfilter::SemanticResult result;
    dynfilter::Detection detection;
    detection.box =
        cv::Rect2f(static_cast<float>(image.frame_id), image.pixels.at<unsigned char>(0, 0), 1, 1);
    result.detections = {detection};
    return result;
  }

 private:
  std::shared_ptr<Script> script_;
  int looked_ = 0;
};

inline dynfilter::SemanticImage image_of(std::int64_t id, const cv::Mat& pixels) {
  dynfilter::SemanticImage image;
  image.frame_id = id;
  image.timestamp_s = static_cast<double>(id) / 30;
  image.pixels = pixels;
  return image;
}
/// Grey, of the brightness `id`.
inline dynfilter::SemanticImage image_of(std::int64_t id) {
  return image_of(id, cv::Mat(2, 2, CV_8UC1, cv::Scalar(static_cast<double>(id))));
}

}  // namespace dynfilter_test
