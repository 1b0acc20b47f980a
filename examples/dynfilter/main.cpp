// SPDX-License-Identifier: MIT
#include <fcntl.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <cstring>
#include <dynfilter/config/near_miss.hpp>
#include <dynfilter/config/parameters.hpp>
#include <dynfilter/core/error.hpp>
#include <dynfilter/core/printable_text.hpp>
#include <dynfilter/version.hpp>
#include <exception>
#include <iostream>
#include <memory>
#include <string>
#include <vector>
#ifdef __GLIBC__
#include <malloc.h>
#endif

#include "commands/command.hpp"
#include "running/interruption.hpp"
#include "text/help_text.hpp"

namespace {

using namespace dynfilter::command;

int print_error(std::string message, int exit_code) {
  while (!message.empty() && (message.back() == '\n' || message.back() == ' ')) message.pop_back();
  std::replace(message.begin(), message.end(), '\n', ' ');
  // It may quote a file or another program.
  std::fprintf(stderr, "dynfilter: %s\n", dynfilter::without_controls(message).c_str());
  return exit_code;
}

// CLI11 itself only reports that a subcommand is missing.
void check_subcommand(const CLI::App& app, const std::string& name) {
  if (name.empty() || name[0] == '-') return;
  for (const CLI::App* sub : app.get_subcommands({}))
    if (sub->get_name() == name) return;
  std::vector<std::string> known;
  for (const CLI::App* sub : shown_subcommands(app)) known.push_back(sub->get_name());
  throw dynfilter::Error(dynfilter::unknown_name("subcommand", name, known));
}

// CLI11 reports a missing option before an unknown one, and has no suggestions.
void check_options(const CLI::App& app, const std::vector<std::string>& words) {
  if (words.empty()) return;
  const auto subs =
      app.get_subcommands([&](const CLI::App* sub) { return sub->get_name() == words.front(); });
  if (subs.empty()) return;
  std::vector<std::string> known;
  for (const CLI::Option* option : subs.front()->get_options())
    for (const std::string& name : option->get_lnames()) known.push_back("--" + name);
  for (const std::string& word : words) {
    const std::string name = word.substr(0, word.find('='));
    if (name.size() < 3 || name.compare(0, 2, "--") != 0) continue;
    if (std::find(known.begin(), known.end(), name) == known.end())
      throw dynfilter::Error("unknown option " + dynfilter::in_backticks(name) +
                             dynfilter::did_you_mean(name, known) + "; `dynfilter help " + words.front() +
                             "` lists them");
  }
}

// `help X` is the same as `X --help`.
std::vector<std::string> words_of(int argc, char** argv) {
  std::vector<std::string> words(argv + std::min(argc, 1), argv + argc);
  if (words.empty() || words.front() != "help") return words;
  words.erase(words.begin());
  words.emplace_back("--help");
  return words;
}

int dispatch(int argc, char** argv) {
  CLI::App app("Rejects features on moving objects for visual SLAM: run it, measure it, see why.",
               "dynfilter");
  app.formatter(std::make_shared<HelpFormatter>());  // also for all subcommands
  app.set_version_flag("--version", DYNFILTER_VERSION);
  app.require_subcommand(1);
  Action action;
  add_filters(app, action);
  add_check(app, action);
  add_presets(app, action);
  add_synth(app, action);
  add_run(app, action);
  add_replay(app, action);
  add_compare(app, action);
  add_bench(app, action);
  add_map(app, action);
  add_masks(app, action);
  add_eval(app, action);
  add_detect(app, action);
  add_motion(app, action);
  add_serve(app, action);
  add_completion(app, action);
  add_man(app, action);
  app.footer("`dynfilter help SUBCOMMAND` prints the options of a subcommand.");  // of the command only
  std::vector<std::string> words = words_of(argc, argv);
  check_subcommand(app, words.empty() ? "" : words.front());
  std::vector<std::string> reversed(words.rbegin(), words.rend());  // as CLI11 expects
  try {
    app.parse(reversed);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);  // --help, --version
    check_options(app, words);
    const std::string what = error.what();
    const bool pipeline =
        what.find("--pipeline") != std::string::npos && what.find("required") != std::string::npos;
    const bool known = !words.empty() && words.front().front() != '-';
    const std::string hint = pipeline ? "`dynfilter presets` lists the names"
                             : known  ? "`dynfilter help " + words.front() + "` explains"
                                      : "`dynfilter help` lists them";
    return print_error(what + " (" + hint + ")", kBadInput);
  }
  return action();
}

// If a standard stream is closed, the next opened file would get its number.
// Results would then be printed to that file. This descriptor rejects writing instead.
void occupy_closed_streams() {
  for (int opened = 0; opened >= 0 && opened <= STDERR_FILENO;) {
    opened = ::open("/dev/null", O_RDONLY);
    if (opened > STDERR_FILENO) ::close(opened);
  }
}

[[noreturn]] void end_by(int signal) {
  print_error(std::string("stopped by ") + ::strsignal(signal) + ": what was incomplete is removed", kFailed);
  std::fflush(stdout);
  Interruption::end_by(signal);
}

int run(int argc, char** argv) {
  try {
    return dispatch(argc, argv);
  } catch (const dynfilter::Error& error) {
    if (Interruption::noted() != 0) end_by(Interruption::noted());  // it ended the wait for an answer
    return print_error(error.what(), kBadInput);
  } catch (const Interrupted& interrupted) {
    end_by(interrupted.signal);
  } catch (const std::exception& error) {
    if (std::ferror(stdout) != 0) return kFailed;  // main() reports it
    return print_error(std::string("internal error: ") + error.what(), kFailed);
  }
}

// Every frame needs images of the same sizes again. glibc returns their pages to the system each time, and to
// get them back takes a quarter of the time of `run --out`.
void keep_freed_memory() {
#ifdef __GLIBC__
  constexpr int kMostMappedAlone = 32 << 20;  // the most that glibc accepts: larger images are rare
  constexpr int kKept = 256 << 20;            // more than all images of a frame
  mallopt(M_MMAP_THRESHOLD, kMostMappedAlone);
  mallopt(M_TRIM_THRESHOLD, kKept);
#endif
}

}  // namespace

int main(int argc, char** argv) {
  keep_freed_memory();
  occupy_closed_streams();
  const int exit_code = run(argc, argv);
  std::cout.flush();
  if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0 && std::cout) return exit_code;
  return print_error("standard output cannot be written: it is closed, or its device is full", kFailed);
}
