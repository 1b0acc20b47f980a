// SPDX-License-Identifier: MIT
#pragma once

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "terminal.hpp"

namespace dynfilter::command {

/// The allowed words of an option, {a,b,c}; empty if any value is allowed.
inline std::vector<std::string> choices_of(const CLI::Option& option) {
  const std::string type = option.get_type_name();
  const std::size_t begin = type.find('{'), end = type.find('}', begin + 1);
  if (begin == std::string::npos || end == std::string::npos) return {};
  return CLI::detail::split(type.substr(begin + 1, end - begin - 1), ',');
}

/// Type of an option's value, such as "FILE" or "N"; "" for a flag.
inline std::string value_name(const CLI::Option& option) {
  if (option.get_type_size() == 0) return "";
  const std::string type = option.get_type_name();
  return type.substr(0, type.find(':'));
}

/// "-p,--pipeline PIPELINE"
inline std::string option_head(const CLI::Option& option) {
  if (option.get_positional() && !option.nonpositional())
    return option.get_name(true) + (option.get_expected_max() > 1 ? "..." : "");
  const std::string value = value_name(option);
  return option.get_name(false, true) + (value.empty() ? "" : " " + value);
}

/// Description of an option with its default and its rules.
inline std::string option_text(const CLI::Option& option) {
  std::string text = option.get_description();
  const auto join = [](const std::vector<std::string>& words) { return CLI::detail::join(words, ", "); };
  const auto names = [&](const auto& options) {
    std::vector<std::string> all;
    for (const CLI::Option* other : options) all.push_back(other->get_name());
    std::sort(all.begin(), all.end());
    return join(all);
  };
  const auto add = [&](const std::string& rule) { text += (text.empty() ? "" : "; ") + rule; };
  const std::string type = option.get_type_name();
  const std::size_t in = type.find(" in [");
  if (!choices_of(option).empty()) add("one of " + join(choices_of(option)));
  if (in != std::string::npos) {
    std::string range = type.substr(in + 5, type.find(']', in) - in - 5);
    const std::size_t dash = range.find(" - ");
    if (dash != std::string::npos) range.replace(dash, 3, " to ");
    add(range);
  }
  if (!option.get_default_str().empty()) add("default " + option.get_default_str());
  if (option.get_required() && option.nonpositional()) add("required");
  if (!option.get_needs().empty()) add("only with " + names(option.get_needs()));
  if (!option.get_excludes().empty()) add("not with " + names(option.get_excludes()));
  return text;
}

/// The first sentence.
inline std::string first_sentence(const std::string& text) {
  const std::size_t end = text.find(". ");
  return end == std::string::npos ? text : text.substr(0, end + 1);
}

/// Visible subcommands, in the order of the help.
inline std::vector<const CLI::App*> shown_subcommands(const CLI::App& app) {
  std::vector<const CLI::App*> shown;
  for (const CLI::App* sub : app.get_subcommands({}))
    if (!sub->get_group().empty()) shown.push_back(sub);
  return shown;
}

/// Wraps the help at the terminal's width.
class HelpFormatter final : public CLI::Formatter {
 public:
  std::string make_description(const CLI::App* app) const override {
    return wrapped(app->get_description(), text_columns()) + "\n";
  }
  std::string make_footer(const CLI::App* app) const override {
    return app->get_footer().empty() ? "" : wrapped(app->get_footer(), text_columns());
  }
  std::string make_option(const CLI::Option* option, bool) const override {
    return entry(option_head(*option), option_text(*option));
  }
  std::string make_subcommand(const CLI::App* sub) const override {
    return entry(sub->get_name(), first_sentence(sub->get_description()));
  }

 private:
  static std::string entry(const std::string& head, const std::string& text) {
    constexpr std::size_t kTextAt = 28;
    const std::string body = wrapped(text, text_columns(), kTextAt), left = "  " + head;
    if (body.empty() || left.size() + 2 > kTextAt) return left + "\n" + body;
    return left + body.substr(left.size());
  }
};

}  // namespace dynfilter::command
