// SPDX-License-Identifier: MIT
#include <unistd.h>
#include <dynfilter/core/error.hpp>

#include <algorithm>
#include <cstdlib>
#include <dynfilter/pipeline/builtin_filters.hpp>
#include <dynfilter/pipeline/presets.hpp>
#include <filesystem>
#include <fstream>

#include "doctest/doctest.h"

namespace preset_names_test {

using namespace dynfilter;
namespace fs = std::filesystem;

namespace {

/// An empty folder, and DYNFILTER_PRESETS unset, for as long as this lives.
class Shelf {
 public:
  Shelf() {
    fs::create_directories(root_);
    ::unsetenv("DYNFILTER_PRESETS");
  }
  Shelf(const Shelf&) = delete;
  Shelf& operator=(const Shelf&) = delete;
  ~Shelf() {
    ::unsetenv("DYNFILTER_PRESETS");
    std::error_code error;
    fs::remove_all(root_, error);
  }
  fs::path folder(const std::string& name) const {
    fs::create_directories(root_ / name);
    return root_ / name;
  }
  /// A pipeline that tells by its name which file it is.
  fs::path write(const std::string& file, const std::string& name) const {
    fs::create_directories((root_ / file).parent_path());
    std::ofstream(root_ / file) << "%YAML:1.0\n---\npipeline:\n  name: " << name << "\n";
    return root_ / file;
  }
  static void environment(const std::string& folders) { ::setenv("DYNFILTER_PRESETS", folders.c_str(), 1); }

 private:
  fs::path root_ = fs::temp_directory_path() / ("dynfilter_shelf_" + std::to_string(::getpid()));
};

std::string loaded(const std::string& source, const PresetFolders& folders = {}) {
  return load_pipeline(source, builtin_filters(), folders).name;
}
std::string refusal(const std::string& source, const PresetFolders& folders = {}) {
  try {
    load_pipeline(source, builtin_filters(), folders);
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "";
}
bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

}  // namespace

TEST_CASE("presets: a name, a name with .yaml, a path and a text are told apart") {
  const Shelf shelf;
  CHECK(loaded("rts_slam") == "rts_slam");
  CHECK(loaded("rts_slam.yaml") == "rts_slam");
  CHECK(loaded(shelf.write("mine.yaml", "my own").string()) == "my own");
  CHECK(loaded("pipeline: { name: inline, before_pose: [ epipolar ] }") == "inline");
  CHECK(loaded("%YAML:1.0\n---\npipeline:\n  name: lines\n") == "lines");
}

TEST_CASE("presets: own folders come first, then DYNFILTER_PRESETS, then installed ones, then built in") {
  const Shelf shelf;
  PresetFolders folders;
  folders.installed = {shelf.write("installed/rts_slam.yaml", "installed").parent_path()};
  CHECK(loaded("rts_slam", folders) == "installed");
  Shelf::environment(shelf.write("flat/rts_slam.yaml", "from the environment").parent_path().string());
  CHECK(loaded("rts_slam", folders) == "from the environment");
  folders.first = {shelf.write("first/rts_slam.yaml", "first").parent_path()};
  CHECK(loaded("rts_slam", folders) == "first");
  // Names of all folders are known, each once.
  shelf.write("first/only_here.yaml", "x");
  const std::vector<std::string> names = preset_names(folders);
  CHECK(std::count(names.begin(), names.end(), "rts_slam") == 1);
  CHECK(std::count(names.begin(), names.end(), "only_here") == 1);
  CHECK(std::count(names.begin(), names.end(), "dynfilter") == 1);
}

TEST_CASE("presets: those that come along are found from the place of the program, all kinds") {
  const Shelf shelf;
  const fs::path share = fs::read_symlink("/proc/self/exe").parent_path().parent_path() / "share/dynfilter";
  for (const PresetKind& kind : {kPipelinePresets, PresetKind{"detector", "detectors"}}) {
    const std::vector<fs::path> folders = preset_folders({}, kind);
    CHECK(std::count(folders.begin(), folders.end(), share / kind.folder) >= 1);
    CHECK(std::all_of(folders.begin(), folders.end(), [](const fs::path& f) { return fs::is_directory(f); }));
  }
  CHECK(preset_folders({}, {"thing", "no_such_kind"}).empty());
}

TEST_CASE("presets: DYNFILTER_PRESETS is a list; a folder in it may have one for each kind") {
  const Shelf shelf;
  shelf.write("share/pipelines/one.yaml", "one");
  shelf.write("share/detectors/eye.yaml", "eye");
  shelf.write("flat/two.yaml", "two");
  Shelf::environment(shelf.folder("share").string() + "::/no/such/folder:" + shelf.folder("flat").string());
  CHECK(loaded("one") == "one");
  CHECK(loaded("two") == "two");
  const std::vector<std::string> eyes = preset_names({}, {"detector", "detectors"});
  CHECK(std::count(eyes.begin(), eyes.end(), "eye") == 1);
  CHECK(std::count(eyes.begin(), eyes.end(), "one") == 0);
}

TEST_CASE("presets: an unknown name lists the known ones and the one that was meant") {
  const Shelf shelf;
  CHECK(contains(refusal("dynfiler"),
                 "dynfiler: neither a file nor a preset (did you mean `dynfilter`?); presets: "));
  CHECK(contains(refusal("dynfiler"), "rts_slam"));
  CHECK(refusal("dynfiltr.yaml") == "dynfiltr.yaml: no such pipeline file (did you mean `dynfilter`?)");
  CHECK(refusal("/no/such.yaml") == "/no/such.yaml: no such pipeline file");
  CHECK(contains(refusal(""), "neither a file nor a preset; presets: "));
  CHECK(contains(refusal("oracle"), "only the command `dynfilter` can run it"));
  const fs::path own = shelf.folder("own") / "oracle.yaml";  // a file of that name is the user's
  std::ofstream(own) << "pipeline: { before_pose: [ epipolar ] }\n";
  CHECK(load_pipeline(own.string(), builtin_filters()).before_pose != nullptr);
  CHECK(contains(refusal(shelf.folder("empty").string()), "no such pipeline file"));
}

TEST_CASE("presets: a relative path is looked for in the caller's folders, too") {
  const Shelf shelf;
  PresetFolders folders;
  folders.first = {shelf.folder("")};
  shelf.write("below/mine.yaml", "below");
  CHECK(loaded("below/mine.yaml", folders) == "below");
  CHECK(refusal("below/mine.yaml") != "");
}

}  // namespace preset_names_test
