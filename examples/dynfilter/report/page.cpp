// SPDX-License-Identifier: MIT
#include "page.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <dynfilter/version.hpp>
#include <fstream>
#include <string_view>
#include <system_error>
#include <utility>

#include "assets.hpp"
#include "record_json.hpp"

namespace dynfilter::command::report {
namespace {

using Texts = std::vector<std::pair<std::string_view, std::string>>;

/// The template with each @NAME@ replaced, once and in one pass: what is filled in is not searched.
std::string filled(std::string_view page, const Texts& texts) {
  std::string result;
  for (std::size_t at = 0; at < page.size();) {
    const std::size_t begin = page.find('@', at);
    const std::size_t end = begin == std::string_view::npos ? begin : page.find('@', begin + 1);
    if (end == std::string_view::npos) return result.append(page.substr(at));
    result.append(page.substr(at, begin - at));
    const std::string_view name = page.substr(begin + 1, end - begin - 1);
    const auto text =
        std::find_if(texts.begin(), texts.end(), [&](const auto& t) { return t.first == name; });
    result.append(text != texts.end() ? std::string_view(text->second) : page.substr(begin, end - begin + 1));
    at = end + 1;
  }
  return result;
}

/// JSON within a script element, which `</script` or `<!--` would end.
std::string embedded(const Json& json) {
  const std::string text = json.dump(-1, ' ', false, Json::error_handler_t::replace);
  std::string safe;
  safe.reserve(text.size());
  for (const char c : text) c == '<' ? safe.append("\\u003c") : safe.append(1, c);
  return safe;
}

std::string figure(double value, const char* format) {
  return std::isfinite(value) ? fmt::format(fmt::runtime(format), value) : "-";
}

/// For readers without scripts, such as the preview of a file manager.
std::string plain_table(const std::vector<const Summary*>& runs) {
  std::string rows;
  for (const Summary* s : runs)
    rows += fmt::format(
        "<tr><td>{}</td><td>{}</td><td>{} of {}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td></tr>\n",
        escaped(s->sequence), escaped(s->pipeline), s->tracked_frames, s->frames,
        figure(s->ate_rmse_m, "{:.4f}"), figure(s->rpe_trans_rmse_m, "{:.4f}"), figure(s->recall, "{:.3f}"),
        figure(s->total_ms, "{:.1f}"));
  return "<table>\n<tr><th>sequence</th><th>pipeline</th><th>tracked</th><th>ATE m</th><th>RPE m</th>"
         "<th>recall</th><th>ms</th></tr>\n" +
         rows + "</table>";
}

std::string page_of(const std::string& title, const Json& data, const std::vector<const Summary*>& runs) {
  // In UTF-8 whatever bytes a folder's name has: the JSON writer replaces what is not.
  const Json clean = Json::parse(Json(title).dump(-1, ' ', false, Json::error_handler_t::replace));
  const std::string table = plain_table(runs);
  const Json clean_table = Json::parse(Json(table).dump(-1, ' ', false, Json::error_handler_t::replace));
  return filled(assets::page(), {{"TITLE", escaped(clean.get<std::string>())},
                                 {"STYLE", std::string(assets::style())},
                                 {"STYLE_HASH", std::string(assets::kStyleHash)},
                                 {"SCRIPT", std::string(assets::script())},
                                 {"SCRIPT_HASH", std::string(assets::kScriptHash)},
                                 {"FIGURES", clean_table.get<std::string>()},
                                 {"DATA", embedded(data)}});
}

Json common(const char* kind) {
  return {{"kind", kind}, {"version", DYNFILTER_VERSION}, {"has_plots", assets::kHasPlots}};
}

/// nullopt-like null for what is not a summary.
Json read_summary(const std::filesystem::path& file) {
  std::ifstream in(file);
  Json json = in ? Json::parse(in, nullptr, false) : Json();
  return json.is_object() ? json : Json();
}

bool same_frames(const Json& other, const Summary& own) {
  const auto is = [&](const char* key, const Json& value) {
    return other.contains(key) && other[key] == value;
  };
  return is("sequence", own.sequence) && is("scene", own.scene) && is("frames", own.frames) &&
         is("first_s", own.first_s) && is("last_s", own.last_s);
}

}  // namespace

std::string escaped(const std::string& text) {
  std::string safe;
  for (const char c : text) {
    switch (c) {
      case '&':
        safe += "&amp;";
        break;
      case '<':
        safe += "&lt;";
        break;
      case '>':
        safe += "&gt;";
        break;
      case '"':
        safe += "&quot;";
        break;
      case '\'':
        safe += "&#39;";
        break;
      default:
        safe += c;
    }
  }
  return safe;
}

std::string run_page(const RunRecord& run, const std::vector<Json>& beside) {
  Json data = common("run");
  data["runs"] = Json::array({to_json(run)});
  data["beside"] = beside;
  return page_of(run.summary.pipeline + " on " + run.summary.sequence, data, {&run.summary});
}

std::string compare_page(const std::vector<RunRecord>& runs, const Json& medians) {
  Json data = common("compare");
  data["runs"] = Json::array();
  data["medians"] = medians;
  std::vector<const Summary*> summaries;
  for (const RunRecord& run : runs) {
    data["runs"].push_back(to_json(run));
    summaries.push_back(&run.summary);
  }
  return page_of("Pipelines compared", data, summaries);
}

std::vector<Json> reference_summaries(const std::filesystem::path& out, const Summary& own) {
  std::error_code error;
  const std::filesystem::path parent = std::filesystem::absolute(out, error).lexically_normal().parent_path();
  std::vector<std::filesystem::path> folders;
  for (std::filesystem::directory_iterator entry(parent, error), end; !error && entry != end;
       entry.increment(error))
    folders.push_back(entry->path());
  std::sort(folders.begin(), folders.end());
  std::vector<Json> found;
  for (const char* reference : {"none", "oracle"}) {
    if (own.pipeline == reference) continue;
    for (const std::filesystem::path& folder : folders) {
      Json summary = read_summary(folder / "summary.json");
      if (!same_frames(summary, own) || summary.value("pipeline", "") != reference) continue;
      found.push_back(std::move(summary));
      break;
    }
  }
  return found;
}

}  // namespace dynfilter::command::report
