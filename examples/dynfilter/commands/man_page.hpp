// SPDX-License-Identifier: MIT
#pragma once

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <dynfilter/version.hpp>
#include <string>

#include "completion.hpp"
#include "text/help_text.hpp"

namespace dynfilter::command {

/// Escapes a text for roff.
inline std::string roff(const std::string& text) {
  std::string result;
  bool at_line_begin = true;
  for (const char c : text) {
    if (at_line_begin && (c == '.' || c == '\'')) result += "\\&";
    if (c == '\\')
      result += "\\e";
    else if (c == '-')
      result += "\\-";
    else
      result += c;
    at_line_begin = c == '\n';
  }
  return result;
}

/// Paragraphs of a page, separated by empty lines.
inline std::string roff_paragraphs(const std::string& text) {
  std::string result;
  for (const char c : wrapped(text, 78)) {
    if (c == '\n' && !result.empty() && result.back() == '\n')
      result += ".PP\n";
    else
      result += c;
  }
  std::string escaped, line;
  std::istringstream lines(result);
  while (std::getline(lines, line)) escaped += (line == ".PP" ? line : roff(line)) + "\n";
  return escaped;
}

inline std::string man_head(const std::string& name, const std::string& what) {
  std::string upper = name;
  for (char& c : upper) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return fmt::format(".TH {} 1 \"\" \"dynfilter {}\" \"User Commands\"\n.SH NAME\n{} \\- {}\n", roff(upper),
                     DYNFILTER_VERSION, roff(name), roff(what));
}

/// The text for the section NAME: first letter in lower case, no full stop.
inline std::string man_summary(const CLI::App& command) {
  std::string text = first_sentence(command.get_description());
  if (!text.empty() && text.back() == '.') text.pop_back();
  if (text.size() > 1 && std::islower(static_cast<unsigned char>(text[1])) != 0)
    text[0] = static_cast<char>(std::tolower(static_cast<unsigned char>(text[0])));
  return wrapped(text, 1000).substr(0, wrapped(text, 1000).find('\n'));
}

inline std::string man_entries(const std::vector<const CLI::Option*>& options) {
  std::string text;
  for (const CLI::Option* option : options)
    text += fmt::format(".TP\n\\fB{}\\fR\n{}", roff(option_head(*option)),
                        roff(wrapped(option_text(*option), 78)));
  return text;
}

/// The page of a subcommand, dynfilter-NAME(1).
inline std::string man_page_of(const CLI::App& command) {
  const std::string name = "dynfilter-" + command.get_name();
  const Arguments arguments(command);
  std::string text = man_head(name, man_summary(command));
  text += fmt::format(".SH SYNOPSIS\n\\fBdynfilter {}\\fR", roff(command.get_name()));
  for (const CLI::Option* option : arguments.positionals) {
    const std::string head = roff(option_head(*option));
    text += option->get_required() ? fmt::format(" \\fI{}\\fR", head) : fmt::format(" [\\fI{}\\fR]", head);
  }
  text += " [\\fIoptions\\fR]\n.SH DESCRIPTION\n" + roff_paragraphs(command.get_description());
  if (!arguments.positionals.empty()) text += ".SH ARGUMENTS\n" + man_entries(arguments.positionals);
  text += ".SH OPTIONS\n" + man_entries(arguments.options);
  text += ".SH EXIT STATUS\n0: done. 1: a result that failed. 2: bad usage or input.\n";
  return text + ".SH SEE ALSO\n.BR dynfilter (1)\n";
}

/// dynfilter(1)
inline std::string man_page(const CLI::App& app) {
  std::string text = man_head("dynfilter", "reject features on moving objects for visual SLAM");
  text += ".SH SYNOPSIS\n\\fBdynfilter\\fR \\fIcommand\\fR [\\fIarguments\\fR]\n.SH DESCRIPTION\n" +
          roff_paragraphs(app.get_description()) + ".SH COMMANDS\n";
  for (const CLI::App* command : shown_subcommands(app))
    text += fmt::format(".TP\n.BR dynfilter\\-{} (1)\n{}", roff(command->get_name()),
                        roff(wrapped(first_sentence(command->get_description()), 78)));
  text += ".SH OPTIONS\n" + man_entries(Arguments(app).options);
  text +=
      ".SH ENVIRONMENT\n.TP\n\\fBDYNFILTER_PRESETS\\fR\nfolders with pipelines and detectors that are found "
      "by "
      "their names,\nwith colons between\n.TP\n\\fBCOLUMNS\\fR\nhow wide help and tables are\n";
  return text + ".SH EXIT STATUS\n0: done. 1: a result that failed. 2: bad usage or input.\n";
}

}  // namespace dynfilter::command
