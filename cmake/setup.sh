# SPDX-License-Identifier: MIT
# Sourced by test/run.sh and examples/demo.sh: Debian's packages, Ninja and ccache.

build_packages="cmake g++ ninja-build ccache pkg-config libopencv-dev libeigen3-dev libpng-dev libjpeg-dev
  libflann-dev liblz4-dev libceres-dev libcli11-dev nlohmann-json3-dev libfmt-dev"
test_packages="doctest-dev libbenchmark-dev clang-format clang-tidy python3-yaml"
clang_packages="clang lld libclang-rt-14-dev abigail-tools"  # fuzz targets, other compilers, the facade's ABI
browser_packages="chromium python3"
reference_packages="doxygen"  # pages of the API
window_packages="xvfb xauth imagemagick"  # a window without a display, and its picture
paper_packages="texlive-latex-base texlive-latex-recommended"  # prints a table for a paper
python_packages="python3-dev python3-numpy python3-opencv python3-pip python3-pytest python3-venv pybind11-dev mypy"

# need_packages NAME...: installs what is missing, as root or through sudo; otherwise says what to type.
need_packages() {
  local missing="" name
  if ! command -v dpkg-query >/dev/null; then
    echo "Not a Debian system: these packages are expected under other names: $*"
    return 0
  fi
  for name in "$@"; do
    [ "$(dpkg-query -W -f '${db:Status-Status}' "$name" 2>/dev/null)" = installed ] || missing="$missing $name"
  done
  [ -n "$missing" ] || return 0
  local install="apt-get install -y --no-install-recommends$missing"
  local as_root=""
  if [ "$(id -u)" != 0 ]; then
    if ! command -v sudo >/dev/null || ! { sudo -n true 2>/dev/null || [ -t 0 ]; }; then
      echo "Some packages are missing. Please run as root:"
      echo "  apt-get update && $install"
      exit 2
    fi
    as_root="sudo"
  fi
  echo "Installing:$missing"
  $as_root env DEBIAN_FRONTEND=noninteractive $install -qq >/dev/null 2>&1 ||
    { $as_root apt-get update -qq && $as_root env DEBIAN_FRONTEND=noninteractive $install -qq >/dev/null; } ||
    { echo "That failed. Please run as root:"; echo "  apt-get update && $install"; exit 2; }
}

# want_packages NAME...: the same for tests that are skipped without them.
want_packages() { (need_packages "$@") || echo "Tests that need one of these are skipped: $*"; }

# Both are taken from the environment by CMake.
choose_tools() {
  if command -v ninja >/dev/null; then export CMAKE_GENERATOR=Ninja; fi
  if command -v ccache >/dev/null; then export CMAKE_C_COMPILER_LAUNCHER=ccache CMAKE_CXX_COMPILER_LAUNCHER=ccache; fi
}

jobs=$(nproc 2>/dev/null || echo 2)
