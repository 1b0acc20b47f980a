#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Compiles every header with its bodies, and the consumer project, with other compilers, standards and C++ libraries than
# those of the build. Nothing is linked: Debian's OpenCV is linked to libstdc++, so no program can use it with libc++.
#   bash test/compilers.sh          Clang with C++20 and libc++: what no build of test/run.sh has
#   bash test/compilers.sh --all    every combination of GCC and Clang, C++17 and C++20, and with Clang both libraries
set -u
cd "$(dirname "${BASH_SOURCE[0]}")/.." || exit 2
build=build/compilers
mkdir -p $build || exit 2

# libc++-14-dev and libgoogle-glog-dev, which Ceres needs, conflict in Debian 12: its headers are unpacked, not installed.
libcxx() {
  local headers=$build/root/usr/lib/llvm-14/include/c++/v1
  [ -f "$headers/vector" ] || {
    (cd $build && apt-get download libc++-14-dev >/dev/null 2>&1 && dpkg -x libc++-14-dev_*.deb root) || return 1
  }
  [ -f "$headers/vector" ] && echo "-nostdinc++ -isystem $headers"
}

sources="$build/all.cpp test/consumer/project/main.cpp test/consumer/project/matches.cpp
  test/consumer/project/keyframes.cpp"
git ls-files 'include/dynfilter/*.hpp' 2>/dev/null | grep -v -e '-inl.hpp$' -e facade/detail/ |
  sed 's|^include/\(.*\)|#include <\1>|' >$build/all.cpp
includes="-Iinclude $(pkg-config --cflags-only-I opencv4 eigen3 | sed 's/-I/-isystem /g')"

failed=0
# compile COMPILER STANDARD LIBRARY
compile() {
  local name="$1 C++$2 $3" flags=""
  if [ "$3" = libc++ ]; then
    flags=$(libcxx) || { echo "$name: skipped: libc++-14-dev cannot be downloaded"; return; }
  fi
  printf '%s\n' $sources | xargs -P "${jobs:-2}" -n 1 "$1" -std=c++"$2" -fsyntax-only -DDYNFILTER_HEADER_ONLY \
    -Wall -Wextra -Werror $flags $includes || { echo "$name: does not compile"; failed=1; return; }
  echo "$name: compiled"
}

case "${1:-}" in
  "") compile clang++ 20 libc++ ;;
  --all)
    for standard in 17 20; do
      compile g++ $standard libstdc++
      compile clang++ $standard libstdc++
      compile clang++ $standard libc++
    done ;;
  *) sed -n '5,6s/^# *//p' "${BASH_SOURCE[0]}"; exit 2 ;;
esac
exit $failed
