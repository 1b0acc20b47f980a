// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <dynfilter/core/error.hpp>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <memory>
#include <string>
#include <system_error>
#include <vector>

#include "bench/manifest.hpp"
#include "bench/page.hpp"
#include "bench/results.hpp"
#include "command.hpp"
#include "io/output_lock.hpp"
#include "running/distinct_names.hpp"
#include "running/identity.hpp"
#include "running/interruption.hpp"
#include "running/presets.hpp"
#include "running/sequence_run.hpp"
#include "text/json.hpp"
#include "text/progress.hpp"
#include "text/table.hpp"

namespace dynfilter::command {
namespace {

inline constexpr PresetKind kBenchmarks{"benchmark", "benchmarks"};

struct BenchOptions {
  std::string manifest, data, out;
  std::vector<std::string> pipelines;  ///< empty: those of the manifest
  std::size_t frames = 0;
  bool force = false, json = false, markdown = false;
};

/// Runs what is not there yet.
class Bench {
 public:
  Bench(const BenchOptions& options, Manifest manifest)
      : options_(options),
        manifest_(std::move(manifest)),
        settings_{manifest_.name, options.frames},
        lock_(created(options.out)),
        batch_(0) {
    Interruption::watch();
    if (!options_.pipelines.empty()) manifest_.pipelines = options_.pipelines;
    check_names();
    batch_ = Batch(manifest_.sequences.size() * manifest_.pipelines.size());
    check_settings(options_.out, settings_, options_.force);
    write_results(options_.out, settings_, rows_);
  }

  void run() {
    std::size_t k = 0;
    for (const BenchSequence& sequence : manifest_.sequences) {
      for (const std::string& pipeline : manifest_.pipelines) {
        batch_.at(k++);
        rows_.push_back(run(sequence, pipeline));
        write_results(options_.out, settings_, rows_);
      }
      add_published(sequence);
    }
    write_results(options_.out, settings_, rows_);
    write_text(std::filesystem::path(options_.out) / "report.html", bench_page(manifest_, rows_));
  }

  const std::vector<BenchRow>& rows() const { return rows_; }
  bool any(const std::string& state) const {
    return std::any_of(rows_.begin(), rows_.end(), [&](const BenchRow& row) { return row.state == state; });
  }
  const Manifest& manifest() const { return manifest_; }

 private:
  static std::filesystem::path created(const std::string& folder) {
    std::filesystem::create_directories(folder);
    return std::filesystem::canonical(folder);
  }

  static std::string system_of(const std::string& pipeline) {
    return std::filesystem::path(pipeline).stem().string();
  }

  /// Rows and folders of results are told apart by names. A paper may have a system with both alignments.
  void check_names() const {
    std::vector<NamedSource> systems, published, sequences;
    for (const std::string& pipeline : manifest_.pipelines)
      systems.push_back({system_of(pipeline), pipeline});
    for (const PublishedSystem& system : manifest_.published) {
      const std::string source = "published: " + system.name;
      published.push_back({system.name + ", " + system.alignment, source + ", " + system.alignment});
      if (std::none_of(systems.begin(), systems.end(),
                       [&](const NamedSource& known) { return known.source == source; }))
        systems.push_back({system.name, source});
    }
    for (const BenchSequence& sequence : manifest_.sequences)
      sequences.push_back({sequence.name, sequence.folder});
    check_distinct(systems);
    check_distinct(published);
    check_distinct(sequences);
  }

  BenchRow run(const BenchSequence& sequence, const std::string& pipeline) {
    BenchRow row;
    row.sequence = sequence.name, row.system = system_of(pipeline);
    const std::filesystem::path data = std::filesystem::path(options_.data) / sequence.folder;
    const std::filesystem::path place = std::filesystem::path(sequence.name) / row.system;
    const std::filesystem::path results = options_.out / place;
    row.link = (place / "report.html").generic_string();
    std::error_code error;
    if (!std::filesystem::exists(data, error)) return without_run(row, "missing", "");
    try {
      const RunIdentity identity{canonical_text(data), pipeline_source(pipeline).digest};
      if (!options_.force && read_run(results, identity, row) && row.state.empty()) return row;
      play(data, pipeline, results);
      if (!read_run(results, identity, row))
        return without_run(row, "failed", "its summary.json is not of this run");
      return row;
    } catch (const Error& failed) {
      return without_run(row, "failed", failed.what());
    }
  }

  static BenchRow without_run(BenchRow row, const char* state, const std::string& note) {
    row.state = state, row.note = note;
    row.link.clear();
    return row;
  }

  void play(const std::filesystem::path& data, const std::string& pipeline,
            const std::filesystem::path& results) {
    std::filesystem::create_directories(results.parent_path());
    RunOptions run;
    run.sequence = data.string(), run.pipeline = pipeline, run.out = results.string();
    run.frames = options_.frames, run.force = true;
    Progress bar(fmt::format("{} on {}", pipeline, data.filename().string()), &batch_);
    run_sequence(run, [&](std::size_t done, std::size_t total) { bar.at(done, total); });
  }

  void add_published(const BenchSequence& sequence) {
    for (const PublishedSystem& system : manifest_.published) {
      const auto found = system.ate_m.find(sequence.name);
      if (found == system.ate_m.end()) continue;
      BenchRow row;
      row.sequence = sequence.name, row.system = system.name, row.alignment = system.alignment;
      row.state = "published", row.note = system.note, row.ate_rmse_m = found->second;
      rows_.push_back(row);
    }
  }

  BenchOptions options_;
  Manifest manifest_;
  BenchSettings settings_;
  io::OutputLock lock_;
  Batch batch_;
  std::vector<BenchRow> rows_;
};

void print(const BenchOptions& options, const Bench& bench) {
  if (options.json) {
    Json json{{"rows", Json::array()}};
    for (const BenchRow& row : bench.rows()) json["rows"].push_back(to_json(row));
    fmt::print("{}", json_text(json));
    return;
  }
  if (options.markdown) {
    fmt::print("{}", bench_table(bench.rows()).markdown());
    return;
  }
  print_table(bench_table(bench.rows()), true);
  for (const BenchRow& row : bench.rows())
    if (row.state == "failed") fmt::print("failed: {} on {}: {}\n", row.system, row.sequence, row.note);
  if (bench.any("missing")) fmt::print("missing: {}\n", bench.manifest().download);
  fmt::print("report: {}\n", (std::filesystem::path(options.out) / "report.html").string());
}

int bench(const BenchOptions& options) {
  std::error_code error;
  if (!std::filesystem::is_directory(options.data, error))
    throw IoError("--data " + options.data + ": no such folder");
  Bench bench(options, read_manifest(find_preset(options.manifest, kBenchmarks)));
  bench.run();
  print(options, bench);
  return bench.any("failed") ? kFailed : kDone;
}

}  // namespace

void add_bench(CLI::App& app, Action& action) {
  auto options = std::make_shared<BenchOptions>();
  CLI::App* command = app.add_subcommand(
      "bench",
      "Runs the sequences and pipelines of a manifest and writes one report with published figures beside. "
      "Continues where it stopped. Sequences that are not there are named, and left out.");
  command
      ->add_option("MANIFEST", options->manifest,
                   "a benchmark's name (" + fmt::format("{}", fmt::join(preset_names(kBenchmarks), ", ")) +
                       ") or a manifest file")
      ->required()
      ->type_name("MANIFEST");
  command->add_option("--data", options->data, "folder with the sequences, as downloaded and unpacked")
      ->required()
      ->type_name("FOLDER");
  command
      ->add_option("--out", options->out,
                   "folder for report.html, bench.json and the results of each run; the next call with the "
                   "same folder continues")
      ->required()
      ->type_name("FOLDER");
  command->add_option("--pipelines", options->pipelines, "instead of the manifest's, with commas between")
      ->delimiter(',')
      ->type_name("PIPELINE,...");
  command->add_option("--frames", options->frames, "play at most N frames of each sequence")->type_name("N");
  command->add_flag("--force", options->force, "run everything again");
  CLI::Option* json = command->add_flag("--json", options->json, "print JSON");
  command->add_flag("--markdown", options->markdown, "print the table as Markdown")->excludes(json);
  command->callback([options, &action] { action = [options] { return bench(*options); }; });
}

}  // namespace dynfilter::command
