# SPDX-License-Identifier: MIT
# For `conan create .` of Conan 2.
from conan import ConanFile
from conan.tools.cmake import CMake, CMakeToolchain, cmake_layout


class Dynfilter(ConanFile):
    name, version, license = "dynfilter", "0.1.0", "MIT"
    settings = "os", "compiler", "build_type", "arch"
    generators = "CMakeDeps"
    exports_sources = ("CMakeLists.txt", "cmake/*", "include/*", "plugins/*",
                       "examples/*", "LICENSE", "THIRD_PARTY.md")

    def requirements(self):
        for needed in ("eigen/[>=3.3 <6]", "opencv/[>=4.5 <5]", "flann/[>=1.9]",
                       "lz4/[>=1.9 <2]", "libpng/[>=1.6 <2]", "libjpeg/[>=9e]"):
            self.requires(needed, transitive_headers=True)

    def layout(self):
        cmake_layout(self)

    def generate(self):
        toolchain = CMakeToolchain(self)
        for part in ("TESTS", "EXAMPLES", "PLUGINS", "FACADE"):
            toolchain.cache_variables[f"DYNFILTER_BUILD_{part}"] = False
        toolchain.cache_variables["DYNFILTER_WARNINGS_AS_ERRORS"] = False
        toolchain.generate()

    def build(self):
        cmake = CMake(self)
        cmake.configure()
        cmake.build()

    def package(self):
        CMake(self).install()

    def package_info(self):  # dynfilter brings its own CMake package
        self.cpp_info.set_property("cmake_find_mode", "none")
        self.cpp_info.builddirs = ["lib/cmake/dynfilter"]
