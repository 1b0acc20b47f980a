#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Installs what is missing, builds everything and runs every test. Safe to repeat, quick the second time.
#   bash test/run.sh            everything but what only --long does
#   bash test/run.sh --quick    only the optimized build and its tests
#   bash test/run.sh --long     also clang-tidy over every file, more sanitizers, every compiler, fuzzing for 10 minutes
# FUZZ_SECONDS: for how long each fuzz target runs, default 60 (--long: 600). Two of the six run at a time, so that all of
# them take three times as long.
# The last line is "N passed, N failed, N skipped"; the exit code is 0 when nothing failed.
set -u
cd "$(dirname "${BASH_SOURCE[0]}")/.." || exit 2
. cmake/setup.sh

mode=normal
case "${1:-}" in
  "") ;;
  --quick | --long) mode=${1#--} ;;
  *) sed -n '4,8s/^# *//p' "${BASH_SOURCE[0]}"; exit 2 ;;
esac

passed=0 failed=0 skipped=0
failures=""
finish() {
  [ -z "$failures" ] || printf 'Failed:%s\n' "$failures"
  echo "$passed passed, $failed failed, $skipped skipped"
  [ "$failed" = 0 ]
  exit
}
count() { passed=$((passed + $1)) failed=$((failed + $2)) skipped=$((skipped + $3)); }
step() { printf '\n== %s (%d s)\n' "$1" "$SECONDS"; }
# check NAME COMMAND...: one more test, that passes when the command does
check() {
  local name=$1
  shift
  if "$@"; then count 1 0 0; else count 0 1 0; failures="$failures $name"; fi
}

# build_and_test PRESET [OPTION...]
build_and_test() {
  step "build: $1"
  if ! { cmake --preset "$@" >"build/$1.log" 2>&1 || { cat "build/$1.log"; false; }; } ||
     ! cmake --build --preset "$1" -j "$jobs"; then
    count 0 1 0
    failures="$failures build:$1"
    finish
  fi
  step "test: $1"
  local log="build/$1/Testing/Temporary/LastTest.log"
  rm -f "$log"
  ctest --preset "$1" -j "$jobs" || failures="$failures tests:$1"
  if [ -f "$log" ]; then count $(awk -f test/count.awk "$log"); else count 0 1 0; fi
}

# Without git (a source package): everything but the copied doctest.
sources() { git ls-files "$@" 2>/dev/null || find include plugins examples test -name '*.[ch]pp'; }
format_check() { sources '*.hpp' '*.cpp' | xargs -r clang-format --dry-run --Werror; }

# One file that includes every header of the toolkit; all files with --long.
tidy_check() {
  local files=build/release/test/headers/first.cpp
  [ "$mode" = long ] && files="$files $(sources 'test/*_test.cpp' 'examples/*.cpp' 'plugins/*.cpp' | grep 'cpp$')"
  printf '%s\n' $files | xargs -P "$jobs" -n 1 clang-tidy -p build/release --quiet
}

# lint_result PROCESS: what it says is shown only if it found something.
lint_result() { wait "$1" || { cat build/lint.log; false; }; }

step "packages"
need_packages $build_packages $test_packages $python_packages
[ "$mode" = quick ] || need_packages $clang_packages
want_packages $browser_packages
choose_tools
mkdir -p build

build_and_test release -DDYNFILTER_BUILD_PYTHON=ON
if [ "$mode" != quick ]; then
  build_and_test asan-ubsan
  if [ "$mode" = long ]; then
    build_and_test tsan
    build_and_test ubsan-clang
  fi
  step "fuzz"
  # The same inputs for the same sources: a commit is judged by what it changed. --long looks for new ones.
  if [ "$mode" = long ]; then seconds=600; else seconds=60 DYNFILTER_FUZZ_SEED=${DYNFILTER_FUZZ_SEED:-1}; fi
  export DYNFILTER_FUZZ_SEED
  check fuzz bash test/fuzz/run.sh "${FUZZ_SECONDS:-$seconds}"
  step "lint, abi, compilers, format"
  tidy_check >build/lint.log 2>&1 &  # one file takes one core: the others meanwhile
  lint=$!
  check abi bash test/abi/check.sh
  if [ "$mode" = long ]; then check compilers bash test/compilers.sh --all; else check compilers bash test/compilers.sh; fi
  check format format_check
  check lint lint_result $lint
fi
step "done"
finish
