// SPDX-License-Identifier: MIT
#pragma once

#include <opencv2/core/version.hpp>

#if defined(__SANITIZE_THREAD__) && CV_VERSION_MAJOR * 100 + CV_VERSION_MINOR >= 405
#include <algorithm>
#include <memory>
#include <opencv2/core/parallel/parallel_backend.hpp>
#include <thread>
#include <vector>

/// cv::parallel_for_ with threads of the standard library. OpenCV's own are not compiled with the thread
/// sanitizer. It does not see how they wait for each other, and would call every result of theirs a race.
class StdThreads final : public cv::parallel::ParallelForAPI {
 public:
  void parallel_for(int tasks, FN_parallel_for_body_cb_t body, void* data) override {
    std::vector<std::thread> threads;
    const int n = std::min(tasks, threads_);
    for (int k = 0; k < n; ++k) threads.emplace_back([=] { body(tasks * k / n, tasks * (k + 1) / n, data); });
    for (std::thread& thread : threads) thread.join();
  }
  int getThreadNum() const override { return 0; }
  int getNumThreads() const override { return threads_; }
  int setNumThreads(int threads) override { return std::exchange(threads_, std::max(1, threads)); }
  const char* getName() const override { return "std::thread"; }

 private:
  int threads_ = 4;
};
inline const bool kStdThreads = (cv::parallel::setParallelForBackend(std::make_shared<StdThreads>()), true);
#endif
