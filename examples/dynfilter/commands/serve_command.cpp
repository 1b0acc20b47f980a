// SPDX-License-Identifier: MIT
#include <unistd.h>
#include <dynfilter/semantic/provider.hpp>

#include <CLI/CLI.hpp>
#include <dynfilter/detectors/process_protocol.hpp>
#include <memory>
#include <string>
#include <vector>

#include "command.hpp"
#include "running/command_registry.hpp"

namespace dynfilter::command {
namespace {

struct ServeOptions {
  std::string detector, network_dir;
  std::vector<std::string> plugins;
  int threads = 1;
};

int serve(const ServeOptions& options) {
  cv::setNumThreads(options.threads);
  const std::unique_ptr<SemanticProvider> provider =
      load_detector(options.detector, options.network_dir, options.plugins).make();
  // Output of libraries must not mix with the answers.
  const int answers = ::dup(STDOUT_FILENO);
  ::dup2(STDERR_FILENO, STDOUT_FILENO);
  protocol::serve(*provider, STDIN_FILENO, answers);
  return kDone;
}

}  // namespace

void add_serve(CLI::App& app, Action& action) {
  auto options = std::make_shared<ServeOptions>();
  CLI::App* command =
      app.add_subcommand("serve",
                         "Runs a detector for another program. It reads images from its standard input and "
                         "writes boxes and masks to its standard output, as a provider of type `process`.");
  command
      ->add_option("DETECTOR", options->detector,
                   "a detector's YAML file or preset (of type `process` it starts a program)")
      ->required()
      ->type_name("DETECTOR");
  command
      ->add_option("--network-dir", options->network_dir,
                   "folder of the files that the detector's YAML names; without it the folder of the YAML")
      ->type_name("FOLDER");
  command->add_option("--plugin", options->plugins, "load providers from this module as well (runs its code)")
      ->type_name("FILE");
  command->add_option("--threads", options->threads, "OpenCV's threads, of this process only")
      ->type_name("N")
      ->check(CLI::Range(1, 64))
      ->capture_default_str();
  command->callback([options, &action] { action = [options] { return serve(*options); }; });
}

}  // namespace dynfilter::command
