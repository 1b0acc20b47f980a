// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/core/parameters.hpp>
#include <dynfilter/semantic/child_process.hpp>
#include <dynfilter/semantic/process_protocol.hpp>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace dynfilter {

struct ProcessProviderParams {
  std::vector<std::string> command;
  double timeout_s = 3;
  double start_timeout_s = 30;
  int restarts = 3;

  static const FieldTable<ProcessProviderParams>& fields() {
    using P = ProcessProviderParams;
    static const FieldTable<P> table{
        words("command", &P::command, "program and arguments, e.g. [dynfilter, serve, yolo.yaml]"),
        real("timeout_s", &P::timeout_s, "s", {0.001, 3600},
             "longest time for an answer, after which the program is killed"),
        real("start_timeout_s", &P::start_timeout_s, "s", {0.001, 3600},
             "longest time for the first line, after which the program is killed"),
        integer("restarts", &P::restarts, "", {0, 1000},
                "how often the program is restarted after it ended or was killed"),
    };
    return table;
  }
};

/// A provider in a separate program, in any language (docs/reference/provider_process.md has the protocol).
/// Its threads, memory and crashes do not affect the tracker.
/// A network there can use any number of threads.
/// In the tracker's process, cv::setNumThreads would also affect the tracker.
/// A program that hangs, ends or violates the protocol is killed with its process group.
/// This is reported by an exception. The next image starts it again, up to `restarts` times.
class ProcessProvider final : public SemanticProvider {
 public:
  using Params = ProcessProviderParams;
  static constexpr const char* kName = "process";
  static constexpr const char* kSummary = "a separate program that implements a small protocol";

  /// Starts the program and waits for its first line. Throws Error with one line that names it.
  explicit ProcessProvider(Params params) : params_(std::move(params)) {
    check_parameters(params_, kName);
    start();
  }

  std::string name() const override { return kName; }

  std::optional<SemanticResult> infer(const SemanticImage& image) override {
    if (!child_) {
      if (starts_ > params_.restarts)
        throw Error(title() + ": not started again after " + std::to_string(params_.restarts) + " restarts");
      start();
    }
    return talk(params_.timeout_s, [&] {
      protocol::write_image(*stream_, image);
      return protocol::read_result(*stream_);
    });
  }

 private:
  std::string title() const { return params_.command.empty() ? "command" : params_.command[0]; }

  void start() {
    ++starts_;
    child_ = std::make_unique<ChildProcess>(params_.command);
    stream_.emplace(child_->socket(), child_->socket());
    talk(params_.start_timeout_s, [&] {
      const std::string line = stream_->read_line();
      if (line != protocol::kHello)
        throw protocol::unexpected("`" + std::string(protocol::kHello) + "`", line);
      return 0;
    });
  }

  /// After an error that the program itself reports, it continues to run.
  template <class Talk>
  auto talk(double timeout_s, const Talk& exchange) -> decltype(exchange()) {
    try {
      stream_->set_deadline(timeout_s);
      return exchange();
    } catch (const protocol::Told& error) {
      throw Error(title() + ": " + error.what());
    } catch (const EndOfStream&) {
      const std::string how = end();
      throw Error(title() + ": ended" + (how.empty() ? "" : " with " + how) + " instead of answering");
    } catch (const std::exception& error) {
      end();
      throw Error(title() + ": killed: " + error.what());
    }
  }
  std::string end() {
    std::string how = child_->kill_now();
    stream_.reset();
    child_.reset();
    return how;
  }

  Params params_;
  std::unique_ptr<ChildProcess> child_;
  std::optional<MessageStream> stream_;
  int starts_ = 0;
};

}  // namespace dynfilter
