// SPDX-License-Identifier: MIT
#include <dynfilter/detectors/process_provider.hpp>

#include <dynfilter/config/parameters.hpp>
#include <utility>

namespace dynfilter {

const FieldTable<ProcessProviderParams>& ProcessProviderParams::fields() {
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

ProcessProvider::ProcessProvider(Params params, std::function<bool()> stop)
    : params_(std::move(params)), stop_(std::move(stop)) {
  check_parameters(params_, kName);
  start();
}

std::optional<SemanticResult> ProcessProvider::infer(const SemanticImage& image) {
  if (!child_) {
    if (starts_ > params_.restarts)
      throw Error(title() + ": not started again after " + std::to_string(params_.restarts) + " restarts");
    start();
  }
  return talk(params_.timeout_s, [&] {
    // What is unread now is a second answer to an earlier image.
    if (!numbered_) stream_->discard_unread();
    protocol::write_image(*stream_, image);
    protocol::Answer answer = protocol::read_answer(*stream_, image.frame_id);
    numbered_ = answer.frame_id.has_value();
    if (!answer.error.empty()) throw protocol::Told(answer.error);
    return answer.result;
  });
}

inline void ProcessProvider::start() {
  ++starts_;
  numbered_ = false;
  child_ = std::make_unique<ChildProcess>(params_.command);
  stream_.emplace(child_->socket(), child_->socket());
  stream_->set_stop(stop_);
  talk(params_.start_timeout_s, [&] {
    const std::string line = stream_->read_line();
    if (line != protocol::kHello) throw protocol::unexpected("`" + std::string(protocol::kHello) + "`", line);
    return 0;
  });
}

std::string ProcessProvider::end() {
  std::string how = child_->kill_now();
  stream_.reset();
  child_.reset();
  return how;
}

}  // namespace dynfilter
