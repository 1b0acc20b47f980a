#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""CITATION.cff, and the recipes for vcpkg and Conan.  packaging_test.py SOURCE CMAKE"""
import json
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import types
import unittest

CMAKE = sys.argv.pop() if len(sys.argv) > 2 else "cmake"
ROOT = pathlib.Path(sys.argv.pop() if len(sys.argv) > 1 else pathlib.Path(__file__).parents[2])
VERSION = re.search(r'DYNFILTER_VERSION "([0-9.]+)"', (ROOT / "include/dynfilter/version.hpp").read_text()).group(1)
OPTIONS = set(re.findall(r"^option\((DYNFILTER_\w+)", (ROOT / "CMakeLists.txt").read_text(), re.M))

# What the toolkit and its detectors look for, and the names of it in the registries.
NAMES = {
    "Eigen3": ("eigen3", "eigen"),
    "OpenCV": ("opencv4", "opencv"),
    "FLANN": ("flann", "flann"),
    "lz4": ("lz4", "lz4"),
    "PNG": ("libpng", "libpng"),
    "JPEG": ("libjpeg-turbo", "libjpeg"),
}
# Of the Citation File Format 1.2.0.
CFF_REQUIRED = {"cff-version", "message", "title", "authors"}
CFF_KNOWN = CFF_REQUIRED | {
    "abstract", "commit", "contact", "date-released", "doi", "identifiers", "keywords", "license", "license-url",
    "preferred-citation", "references", "repository", "repository-artifact", "repository-code", "type", "url", "version"}


def wanted_packages():
    files = "".join((ROOT / "cmake" / name).read_text() for name in ("components.cmake", "detectors.cmake"))
    packages = set(re.findall(r"^ *find_package\((\w+)", files, re.M)) - {"Threads"}
    return packages | ({"lz4"} if "lz4" in (ROOT / "cmake/FindFLANN.cmake").read_text() else set())


class Citation(unittest.TestCase):
    def test_fields(self):
        try:
            import yaml
        except ImportError:
            self.skipTest("no PyYAML")
        citation = yaml.safe_load((ROOT / "CITATION.cff").read_text())
        self.assertLessEqual(CFF_REQUIRED, set(citation))
        self.assertLessEqual(set(citation), CFF_KNOWN)
        self.assertEqual(citation["cff-version"], "1.2.0")
        self.assertEqual(citation["version"], VERSION)
        self.assertEqual(citation["type"], "software")
        self.assertEqual(citation["license"], "MIT")
        holder = re.search(r"Copyright \(c\) \d+ (.*)", (ROOT / "LICENSE").read_text()).group(1)
        self.assertEqual([author["name"] for author in citation["authors"]], [holder])
        self.assertTrue(all(isinstance(word, str) for word in citation["keywords"]))


class Vcpkg(unittest.TestCase):
    def test_manifest(self):
        manifest = json.loads((ROOT / "cmake/vcpkg/vcpkg.json").read_text())
        self.assertEqual((manifest["version"], manifest["license"]), (VERSION, "MIT"))
        names = {name if isinstance(name, str) else name["name"] for name in manifest["dependencies"]}
        tools = {name for name in names if name.startswith("vcpkg-")}
        self.assertEqual(names - tools, {NAMES[package][0] for package in wanted_packages()})

    def test_portfile(self):
        port = (ROOT / "cmake/vcpkg/portfile.cmake").read_text()
        options = re.findall(r"-D(\w+)=", port)
        self.assertIn("DYNFILTER_BUILD_TESTS", options)
        self.assertLessEqual(set(options), OPTIONS)
        self.assertIn("lib/cmake/dynfilter", port)


class Conan(unittest.TestCase):
    """The recipe with stand-ins for Conan's classes, which note what it does."""

    def setUp(self):
        self.toolchain = toolchain = types.SimpleNamespace(cache_variables={}, generate=lambda: None)
        tools = types.ModuleType("conan.tools.cmake")
        tools.CMake, tools.CMakeToolchain, tools.cmake_layout = object, lambda recipe: toolchain, lambda recipe: None
        conan = types.ModuleType("conan")
        conan.ConanFile = object
        fakes = {"conan": conan, "conan.tools": types.ModuleType("conan.tools"), "conan.tools.cmake": tools}
        sys.modules.update(fakes)
        self.addCleanup(lambda: [sys.modules.pop(name) for name in fakes])
        space = {}
        exec(compile((ROOT / "conanfile.py").read_text(), "conanfile.py", "exec"), space)
        self.recipe = space["Dynfilter"]()
        self.needed = []
        self.recipe.requires = lambda needed, **_: self.needed.append(needed)

    def test_names(self):
        self.recipe.requirements()
        self.assertEqual((self.recipe.name, self.recipe.version), ("dynfilter", VERSION))
        names = {needed.partition("/")[0] for needed in self.needed}
        self.assertEqual(names, {NAMES[package][1] for package in wanted_packages()})

    def test_exported_sources_configure_with_its_options(self):
        self.recipe.generate()
        options = self.toolchain.cache_variables
        self.assertLessEqual(set(options), OPTIONS)
        with tempfile.TemporaryDirectory() as folder:
            source = pathlib.Path(folder) / "source"
            for pattern in self.recipe.exports_sources:
                name = pattern.partition("/")[0]
                copy = shutil.copytree if pattern.endswith("/*") else shutil.copy
                source.mkdir(exist_ok=True)
                copy(ROOT / name, source / name)
            definitions = [f"-D{name}={'ON' if value else 'OFF'}" for name, value in options.items()]
            command = [CMAKE, "-S", str(source), "-B", folder + "/build", "-DCMAKE_BUILD_TYPE=Release", *definitions]
            done = subprocess.run(command, capture_output=True, text=True)
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)


if __name__ == "__main__":
    unittest.main()
