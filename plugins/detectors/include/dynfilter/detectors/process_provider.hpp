// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/config/field_table.hpp>
#include <dynfilter/core/error.hpp>
#include <dynfilter/detectors/child_process.hpp>
#include <dynfilter/detectors/message_stream.hpp>
#include <dynfilter/detectors/process_protocol.hpp>
#include <dynfilter/semantic/provider.hpp>
#include <exception>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace dynfilter {

struct ProcessProviderParams {
  std::vector<std::string> command;
  double timeout_s = 3;
  double start_timeout_s = 30;
  int restarts = 3;

  static const FieldTable<ProcessProviderParams>& fields();
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
  /// `stop` is called ten times a second while the provider waits for the program, in the waiting thread.
  /// If it returns true, the program is killed and the wait ends with an Error. A signal handler may set it.
  explicit ProcessProvider(Params params, std::function<bool()> stop = {});

  std::string name() const override { return kName; }

  std::optional<SemanticResult> infer(const SemanticImage& image) override;

 private:
  std::string title() const { return params_.command.empty() ? "command" : params_.command[0]; }

  void start();

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
  std::string end();

  Params params_;
  std::function<bool()> stop_;
  std::unique_ptr<ChildProcess> child_;
  std::optional<MessageStream> stream_;
  int starts_ = 0;
  bool numbered_ = false;  ///< its answers name their image
};

}  // namespace dynfilter
