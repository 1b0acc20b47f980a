// SPDX-License-Identifier: MIT
#pragma once

#include <functional>

namespace CLI {
class App;
}

namespace dynfilter::command {

/// Runs the selected subcommand and returns the exit code.
using Action = std::function<int()>;

enum ExitCode { kDone = 0, kFailed = 1, kBadInput = 2 };

// One file per subcommand. Each adds its options to `app` and sets `action` if it is selected.
void add_bench(CLI::App& app, Action& action);
void add_check(CLI::App& app, Action& action);
void add_compare(CLI::App& app, Action& action);
void add_completion(CLI::App& app, Action& action);
void add_detect(CLI::App& app, Action& action);
void add_eval(CLI::App& app, Action& action);
void add_filters(CLI::App& app, Action& action);
void add_man(CLI::App& app, Action& action);
void add_map(CLI::App& app, Action& action);
void add_masks(CLI::App& app, Action& action);
void add_motion(CLI::App& app, Action& action);
void add_presets(CLI::App& app, Action& action);
void add_replay(CLI::App& app, Action& action);
void add_run(CLI::App& app, Action& action);
void add_serve(CLI::App& app, Action& action);
void add_synth(CLI::App& app, Action& action);

}  // namespace dynfilter::command
