// SPDX-License-Identifier: MIT
#pragma once

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <string>
#include <vector>

#include "text/help_text.hpp"

namespace dynfilter::command {

/// All names of a subcommand's options, and its positional arguments.
struct Arguments {
  std::vector<const CLI::Option*> options, positionals;

  explicit Arguments(const CLI::App& command) {
    for (const CLI::Option* option : command.get_options()) {
      if (option->get_positional() && !option->nonpositional())
        positionals.push_back(option);
      else
        options.push_back(option);
    }
  }
};

/// All names of an option with their dashes: "--camera", "-p".
inline std::vector<std::string> dashed_names(const CLI::Option& option) {
  std::vector<std::string> names;
  for (const std::string& name : option.get_snames()) names.push_back("-" + name);
  for (const std::string& name : option.get_lnames()) names.push_back("--" + name);
  return names;
}

/// False for flags.
inline bool takes_value(const CLI::Option& option) {
  return option.get_type_size() != 0 && option.get_expected_max() > 0;
}

namespace detail_completion {

/// Quotes a text for a shell, with single quotes.
inline std::string quoted(std::string text) {
  for (std::size_t at = text.find('\''); at != std::string::npos; at = text.find('\'', at + 4))
    text.replace(at, 1, "'\\''");
  return "'" + text + "'";
}

/// Kind of names that `dynfilter completion KIND` lists for this option; "" for other values.
inline std::string name_list(const std::string& value) {
  if (value.rfind("PIPELINE", 0) == 0) return "pipelines";
  if (value == "DETECTOR") return "detectors";
  if (value == "FILTER") return "filters";
  if (value == "SCENE") return "scenes";
  return "";
}

inline std::string bash_values(const CLI::Option& option) {
  const std::string value = value_name(option), list = name_list(value);
  if (const auto choices = choices_of(option); !choices.empty())
    return fmt::format("_dynfilter_words {}", quoted(fmt::format("{}", fmt::join(choices, " "))));
  if (!list.empty()) return "_dynfilter_names " + list;
  if (value == "FOLDER") return "_dynfilter_files -d";
  return value == "FILE" || value == "INPUT" ? "_dynfilter_files -f" : "true";
}

inline std::string zsh_values(const CLI::Option& option) {
  const std::string value = value_name(option), list = name_list(value);
  if (const auto choices = choices_of(option); !choices.empty())
    return fmt::format("({})", fmt::join(choices, " "));
  if (!list.empty()) return "{_dynfilter_names " + list + "}";
  if (value == "FOLDER") return "_files -/";
  return value == "FILE" || value == "INPUT" ? "_files" : " ";
}

/// Escapes a text for the [...] of a specification of zsh's _arguments.
inline std::string zsh_text(std::string text) {
  std::string result;
  for (const char c : text) {
    if (c == '[' || c == ']' || c == ':' || c == '\\') result += '\\';
    result += c == '\n' ? ' ' : c;
  }
  return result;
}

/// `text` with @NAMES@ and @CASES@ replaced.
inline std::string filled(std::string text, const std::string& names, const std::string& cases) {
  text.replace(text.find("@NAMES@"), 7, names);
  return text.replace(text.find("@CASES@"), 7, cases);
}

// clang-format off
inline constexpr const char* kBash = R"sh(# bash completion for dynfilter
_dynfilter_words() {
  mapfile -t COMPREPLY < <(compgen -W "$1" -- "$current")
}
# A name, or several with commas between; files as well.
_dynfilter_names() {
  local before=""
  [[ $current == *,* ]] && before="${current%,*},"
  mapfile -t COMPREPLY < <(
    compgen -P "$before" -W "$("${COMP_WORDS[0]}" completion "$1" 2>/dev/null)" -- "${current##*,}"
    compgen -f -- "$current")
}
_dynfilter_files() {
  compopt -o filenames 2>/dev/null
  mapfile -t COMPREPLY < <(compgen "$1" -- "$current")
}
_dynfilter() {
  local current=${COMP_WORDS[COMP_CWORD]} previous=${COMP_WORDS[COMP_CWORD-1]}
  COMPREPLY=()
  if [[ $COMP_CWORD == 1 || ($COMP_CWORD == 2 && $previous == help) ]]; then
    _dynfilter_words @NAMES@
    return
  fi
  case ${COMP_WORDS[1]} in
@CASES@  esac
}
complete -F _dynfilter dynfilter
)sh";

inline constexpr const char* kZsh = R"sh(#compdef dynfilter
_dynfilter_names() {
  local -a names
  names=(${(f)"$(dynfilter completion $1 2>/dev/null)"})
  compset -P '*,'
  _alternative "${1}:${1}:compadd -a names" 'files:file:_files'
}
_dynfilter() {
  local -a commands
  commands=(
@NAMES@    'help:Prints the help of a subcommand.'
  )
  if (( CURRENT == 2 )) || [[ $words[2] == help ]]; then
    _describe -t commands 'dynfilter command' commands
    return
  fi
  shift words
  (( CURRENT-- ))
  case $words[1] in
@CASES@  esac
}
_dynfilter "$@"
)sh";
// clang-format on

}  // namespace detail_completion

/// The completion script of bash, for ~/.bashrc or share/bash-completion/completions.
inline std::string bash_completion(const CLI::App& app) {
  using namespace detail_completion;
  std::vector<std::string> names{"help"};
  std::string cases;
  for (const CLI::App* command : shown_subcommands(app)) {
    names.push_back(command->get_name());
    const Arguments arguments(*command);
    std::vector<std::string> options;
    std::string values;
    for (const CLI::Option* option : arguments.options) {
      const std::vector<std::string> dashed = dashed_names(*option);
      options.insert(options.end(), dashed.begin(), dashed.end());
      if (!takes_value(*option)) continue;
      values += fmt::format("        {}) {}; return ;;\n", fmt::join(dashed, "|"), bash_values(*option));
    }
    const std::string first =
        arguments.positionals.empty() ? "true" : bash_values(*arguments.positionals.front());
    cases += fmt::format(
        "    {})\n      case $previous in\n{}      esac\n"
        "      if [[ $current == -* ]]; then _dynfilter_words {}; else {}; fi\n      ;;\n",
        command->get_name(), values, quoted(fmt::format("{}", fmt::join(options, " "))), first);
  }
  return filled(kBash, quoted(fmt::format("{}", fmt::join(names, " "))), cases);
}

/// The completion file `_dynfilter` of zsh, for a folder of $fpath.
inline std::string zsh_completion(const CLI::App& app) {
  using namespace detail_completion;
  std::string commands, cases;
  for (const CLI::App* command : shown_subcommands(app)) {
    commands += fmt::format(
        "    {}\n", quoted(command->get_name() + ":" + zsh_text(first_sentence(command->get_description()))));
    const Arguments arguments(*command);
    std::string specs;
    for (const CLI::Option* option : arguments.options) {
      const std::string value =
          takes_value(*option) ? fmt::format(":{}:{}", value_name(*option), zsh_values(*option)) : "";
      for (const std::string& name : dashed_names(*option))
        specs += fmt::format(" \\\n        {}",
                             quoted(fmt::format("{}[{}]{}", name, zsh_text(option_text(*option)), value)));
    }
    for (const CLI::Option* option : arguments.positionals) {
      const bool many = option->get_expected_max() > 1;
      specs += fmt::format(" \\\n        {}", quoted(fmt::format("{}:{}:{}", many ? "*" : "",
                                                                 option->get_name(), zsh_values(*option))));
    }
    cases += fmt::format("    {})\n      _arguments -s{}\n      ;;\n", command->get_name(), specs);
  }
  return filled(kZsh, commands, cases);
}

}  // namespace dynfilter::command
