// SPDX-License-Identifier: MIT
#include <cstdlib>
#include <dynfilter/config/registry.hpp>
#include <dynfilter/config/yaml.hpp>
#include <dynfilter/core/error.hpp>
#include <dynfilter/plugin/abi.hpp>
#include <dynfilter/plugin/loader.hpp>
#include <dynfilter/semantic/detector_yaml.hpp>
#include <dynfilter/semantic/provider.hpp>
#include <dynfilter/semantic/provider_registry.hpp>
#include <fstream>

#include "doctest/doctest.h"

namespace loader_test {

using namespace dynfilter;
namespace fs = std::filesystem;

namespace {

fs::path module_file(const std::string& name) {
  return fs::path(DYNFILTER_BAD_PLUGINS_DIR) / (name + ".so");
}

using Names = std::vector<std::string>;

/// Error message of loading; "" without an error. After any failure the registry must not change.
std::string complaint_about(const fs::path& file, Registry registry = {}) {
  const Names before = registry.names();
  try {
    load_plugin(file, registry);
  } catch (const PluginError& error) {
    CHECK(registry.names() == before);
    const std::string text = error.what();
    CHECK(text.find(file.string() + ": ") == 0);
    CHECK(text.find('\n') == std::string::npos);
    return text.substr(file.string().size() + 2);
  }
  return "";
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

struct EmptyFolder {
  fs::path path = fs::temp_directory_path() / ("dynfilter_plugin_test_" + std::to_string(std::rand()));
  EmptyFolder() {
    fs::remove_all(path);
    fs::create_directories(path);
  }
  ~EmptyFolder() { fs::remove_all(path); }
};

}  // namespace

TEST_CASE("a plugin's filters join the registry and can be made") {
  Registry registry;
  CHECK(load_plugin(module_file("good"), registry) == Names{"harmless", "named_b"});
  CHECK(registry.names() == Names{"harmless", "named_b"});
  const auto document = YamlDocument::from_text("p: { limit_px: 2 }");
  const auto filter = registry.find("named_b")->make(*document.root().find("p"));
  CHECK(filter->name() == "named_b");
  CHECK(registry.find("harmless")->card.parameters.at(0).name == "limit_px");
}

TEST_CASE("wrong parameters for a plugin's filter throw a ConfigError that the host can catch") {
  Registry registry;
  load_plugin(module_file("good"), registry);
  const auto document = YamlDocument::from_text("p: { limit_px: 20 }");
  CHECK_THROWS_AS(registry.find("harmless")->make(*document.root().find("p")), ConfigError);
  load_plugin(module_file("throws_when_made"), registry);
  const auto picky = YamlDocument::from_text("p: { limit_px: 6 }");
  CHECK_THROWS_WITH_AS(registry.find("named_p")->make(*picky.root().find("p")),
                       "limit_px: too much for this machine", ConfigError);
}

TEST_CASE("a plugin's providers join their own registry; a detector's YAML may name them") {
  Registry filters;
  ProviderRegistry providers;
  CHECK(load_plugin(module_file("provider"), filters, providers) == Names{"corner"});
  CHECK(filters.names().empty());
  CHECK(providers.names() == Names{"corner"});
  const auto detector = [&](const std::string& keys) {
    const auto document = YamlDocument::from_text("detector: { type: corner" + keys + " }");
    return read_detector(document, providers, {}).make();
  };
  SemanticImage image;
  image.frame_id = 4;
  const auto result = detector(", size_px: 20")->infer(image);
  CHECK(result->frame_id == 4);
  CHECK(result->detections->at(0).box == cv::Rect2f(0, 0, 20, 20));
  CHECK_THROWS_WITH_AS(detector(", size_px: 0"), "detector.size_px: expected 1 to 100, got `0`", ConfigError);
  CHECK_THROWS_AS(load_plugin(module_file("provider"), filters, providers),
                  PluginError);  // the name is taken
  CHECK(providers.names() == Names{"corner"});
  // A caller that wants filters only gets none. One that wants both accepts a plugin of filters.
  CHECK(complaint_about(module_file("provider")) ==
        "not a dynfilter plugin: it has no function `dynfilter_plugin_register`");
  CHECK(load_plugin(module_file("good"), filters, providers) == Names{"harmless", "named_b"});
  CHECK_THROWS_AS(load_plugin(module_file("no_register"), filters, providers), PluginError);
}

TEST_CASE("each field of the ABI tag is compared, named and shown with both values") {
  const AbiTag ours = abi_tag();
  int number = 0;
  for (const AbiField& field : kAbiFields) {
    setenv("DYNFILTER_TEST_WRONG_FIELD", std::to_string(number++).c_str(), 1);
    const std::string text = complaint_about(module_file("wrong_tag"));
    CAPTURE(text);
    CHECK(contains(text, std::string("another ") + field.name + ": it has "));
    CHECK(contains(text, "it has " + std::to_string(ours.*field.value + 1) + ", this program has " +
                             std::to_string(ours.*field.value) + ";"));
  }
  unsetenv("DYNFILTER_TEST_WRONG_FIELD");
  CHECK(number == sizeof(AbiTag) / sizeof(std::uint32_t));
}

TEST_CASE("the field names of the ABI tag are all different, and so are the fields") {
  std::vector<std::string> names;
  AbiTag tag{};
  for (const AbiField& field : kAbiFields) {
    names.emplace_back(field.name);
    CHECK(tag.*field.value == 0);  // no field twice
    tag.*field.value = 1;
  }
  std::sort(names.begin(), names.end());
  CHECK(std::adjacent_find(names.begin(), names.end()) == names.end());
}

TEST_CASE("a plugin built with other vector instructions is refused") {
  if (!fs::exists(module_file("wider_vectors"))) {
    MESSAGE("skipped: this processor has no -mavx");
    return;
  }
  if (EIGEN_MAX_ALIGN_BYTES >= 32) {
    MESSAGE("skipped: the tests themselves are built with -mavx");
    return;
  }
  CHECK(contains(complaint_about(module_file("wider_vectors")), "EIGEN_MAX_ALIGN_BYTES: it has 32"));
}

TEST_CASE("files that are no plugins are refused with the reason") {
  const EmptyFolder folder;
  const fs::path text_file = folder.path / "text.so";
  std::ofstream(text_file) << "not a library\n";
  CHECK(complaint_about(folder.path / "missing.so") == "no such plugin file");
  CHECK(complaint_about(folder.path) == "no such plugin file");
  CHECK(contains(complaint_about(text_file), "cannot be loaded: "));
  CHECK(contains(complaint_about(module_file("no_tag")), "no function `dynfilter_plugin_tag`"));
  CHECK(contains(complaint_about(module_file("no_register")), "no function `dynfilter_plugin_register`"));
  CHECK(contains(complaint_about(module_file("undefined_symbol")), "dynfilter_test_nobody_has_this"));
}

TEST_CASE("a truncated plugin is refused before it is loaded, wherever it was cut") {
  const EmptyFolder folder;
  const fs::path whole = module_file("good"), cut = folder.path / "cut.so";
  const auto size = fs::file_size(whole);
  for (const std::uintmax_t left :
       {std::uintmax_t{0}, std::uintmax_t{3}, std::uintmax_t{63}, std::uintmax_t{64}, std::uintmax_t{4096},
        size / 4, size / 2, size - 4096, size - 1}) {
    CAPTURE(left);
    fs::copy_file(whole, cut, fs::copy_options::overwrite_existing);
    fs::resize_file(cut, left);
    const std::string text = complaint_about(cut);
    CHECK(contains(text, left < 64 ? "cannot be loaded: not an ELF file" : "cannot be loaded: truncated: "));
  }
  fs::copy_file(whole, cut, fs::copy_options::overwrite_existing);
  Registry registry;
  CHECK(load_plugin(cut, registry).size() == 2);
}

TEST_CASE("a plugin for another word size is refused") {
  const EmptyFolder folder;
  const fs::path other = folder.path / "other.so";
  fs::copy_file(module_file("good"), other);
  std::fstream file(other, std::ios::in | std::ios::out | std::ios::binary);
  file.seekp(4);  // EI_CLASS: 1 is 32 bits, 2 is 64
  file.put(sizeof(void*) == 8 ? 1 : 2);
  file.close();
  CHECK(complaint_about(other) == "cannot be loaded: built for another word size");
}

TEST_CASE("a registration that fails half-way leaves nothing behind") {
  CHECK(complaint_about(module_file("throws_in_constructor")) == "registration failed: no licence for today");
  CHECK(complaint_about(module_file("throws_an_int")) ==
        "registration failed: something that is no std::exception was thrown");
  CHECK(complaint_about(module_file("duplicate_name")) ==
        "registration failed: a filter named `named_d` is registered already");
}

TEST_CASE("a name that is taken is refused, also when the same file comes twice") {
  Registry registry;
  load_plugin(module_file("good"), registry);
  CHECK(complaint_about(module_file("good"), registry) == "a filter named `harmless` is registered already");
}

TEST_CASE("two plugins with classes of one name keep their own parameters") {
  Registry registry;
  load_plugin(module_file("twin_a"), registry);
  load_plugin(module_file("twin_b"), registry);
  CHECK(registry.find("twin_a")->card.parameters.at(0).name == "alpha_m");
  CHECK(registry.find("twin_b")->card.parameters.at(0).name == "beta_px");
}

TEST_CASE("a folder is loaded in the order of names, all or nothing") {
  const EmptyFolder folder;
  Registry registry;
  CHECK(load_plugin_directory(folder.path, registry).empty());
  fs::create_symlink(module_file("twin_a"), folder.path / "1.so");
  fs::create_symlink(module_file("good"), folder.path / "0.so");
  std::ofstream(folder.path / "readme.txt") << "not loaded\n";
  CHECK(load_plugin_directory(folder.path, registry) == Names{"harmless", "named_b", "twin_a"});

  Registry other;
  fs::create_symlink(module_file("no_tag"), folder.path / "2.so");
  CHECK_THROWS_AS(load_plugin_directory(folder.path, other), PluginError);
  CHECK(other.names().empty());
  CHECK_THROWS_AS(load_plugin_directory(folder.path / "none", other), PluginError);
}

}  // namespace loader_test
