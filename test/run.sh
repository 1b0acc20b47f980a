#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Installs what is missing, builds everything and runs every test. Safe to repeat, quick the second time.
#   bash test/run.sh            everything but what only --long does; ends with a table of seconds per step
#   bash test/run.sh --quick    only the optimized build and its tests
#   bash test/run.sh --long     before a release: also all cases of the longest tests, every header alone, all unit tests by Clang
#                               and under the sanitizers, the linter over every file, LaTeX, fuzzing for 10 minutes
# FUZZ_SECONDS: for how long each of the seven fuzz targets runs, default 6 (--long: 600). They run one at a time beside the
# linter (--long: two at a time).
# The last line is "N passed, N failed, N skipped"; the exit code is 0 when nothing failed.
set -u
cd "$(dirname "${BASH_SOURCE[0]}")/.." || exit 2
. cmake/setup.sh

mode=normal
case "${1:-}" in
  "") ;;
  --quick | --long) mode=${1#--} ;;
  *) sed -n '4,10s/^# *//p' "${BASH_SOURCE[0]}"; exit 2 ;;
esac

passed=0 failed=0 skipped=0
failures=""
steps="" step_name="" step_began=0 step_cpu=0 cpu=0
# The CPU time of everything that was waited for so far. Not in a subshell, whose times are its own.
count_cpu() {
  times >build/times
  cpu=$(awk 'NR == 2 { gsub("[ms]", " "); print int(60 * $1 + $2 + 60 * $3 + $4) }' build/times)
}
end_step() {
  [ -n "$step_name" ] || return 0
  count_cpu
  printf -v steps '%s%5d s  %5d s  %s\n' "$steps" $((SECONDS - step_began)) $((cpu - step_cpu)) "$step_name"
  step_name=""
}
step() {
  end_step
  count_cpu
  step_name=$1 step_began=$SECONDS step_cpu=$cpu
  printf '\n== %s (%d s)\n' "$1" "$SECONDS"
}
finish() {
  end_step
  printf '\n   wall      CPU  step\n%s%5d s  %5d s  all\n' "$steps" "$SECONDS" "$cpu"
  [ -z "$failures" ] || printf 'Failed:%s\n' "$failures"
  echo "$passed passed, $failed failed, $skipped skipped"
  [ "$failed" = 0 ]
  exit
}
count() { passed=$((passed + $1)) failed=$((failed + $2)) skipped=$((skipped + $3)); }
# check NAME COMMAND...: one more test, that passes when the command does
check() {
  local name=$1
  shift
  if "$@"; then count 1 0 0; else count 0 1 0; failures="$failures $name"; fi
}

# build PRESET [OPTION...]
build() {
  step "build: $1"
  configure "$@" && build_targets "$1" || not_built "$1"
}
configure() { cmake --preset "$@" >"build/$1.log" 2>&1 || { cat "build/$1.log"; false; }; }
build_targets() { cmake --build --preset "$1" -j "$jobs"; }
not_built() {
  count 0 1 0
  failures="$failures build:$1"
  finish
}
# run_tests PRESET [BUILD]: BUILD is the configure preset, if it has another name.
run_tests() {
  step "test: $1"
  local log="build/${2:-$1}/Testing/Temporary/LastTest.log"
  rm -f "$log"
  ctest --preset "$1" -j "$jobs" || failures="$failures tests:$1"
  if [ -f "$log" ]; then count $(awk -f test/count.awk "$log"); else count 0 1 0; fi
}
build_and_test() { build "$@" && run_tests "$1"; }

# A C library that does not know the names of the preset clang-old-cpu ignores them: then its functions are those of this
# processor, and the preset tests less than it says.
old_c_library() {
  grep -qw fma /proc/cpuinfo || { echo "this processor is old"; return 0; }
  local bits='import math; print(sum(hash(math.exp(-k / 7919)) for k in range(100000)))' tunables
  tunables=$(sed -n 's/.*"GLIBC_TUNABLES": "\(.*\)".*/\1/p' CMakePresets.json)
  [ -n "$tunables" ] && [ "$(python3 -c "$bits")" != "$(GLIBC_TUNABLES=$tunables python3 -c "$bits")" ] ||
    { echo "GLIBC_TUNABLES of CMakePresets.json do not change the C library"; return 1; }
}

# Without git (a source package): everything but the copied doctest.
sources() { git ls-files "$@" 2>/dev/null || find include plugins examples test -name '*.[ch]pp'; }
format_check() { sources '*.hpp' '*.cpp' | xargs -r clang-format --dry-run --Werror; }

# One file that includes every header of the toolkit; all files with --long.
tidy_check() {
  local files=build/release/test/headers/first.cpp
  [ "$mode" = long ] && files="$files $(sources 'test/*_test.cpp' 'examples/*.cpp' 'plugins/*.cpp' | grep 'cpp$')"
  printf '%s\n' $files | xargs -P "$jobs" -n 1 clang-tidy -p build/release --quiet >build/lint.log 2>&1 ||
    { cat build/lint.log; false; }
}

# fuzz_result PROCESS: of what ran beside the linter.
fuzz_result() {
  wait "$1"
  local code=$?
  cat build/fuzz_beside.log
  return $code
}

mkdir -p build
step "packages"
need_packages $build_packages $test_packages $python_packages
[ "$mode" = quick ] || need_packages $clang_packages
want_packages $browser_packages
want_packages $window_packages
want_packages $reference_packages
[ "$mode" != long ] || want_packages $paper_packages
choose_tools

more=""
[ "$mode" != long ] || more=-DDYNFILTER_LONG_TESTS=ON
build_and_test release -DDYNFILTER_BUILD_PYTHON=ON $more
if [ "$mode" != quick ]; then
  # As hosts do: the sanitizers align memory, and hide loads that need it. It is one long file, compiled beside many.
  step "build: clang, asan-ubsan"
  configure clang || not_built clang
  build_targets clang >build/clang_beside.log 2>&1 &
  beside=$!
  configure asan-ubsan && build_targets asan-ubsan || not_built asan-ubsan
  wait $beside || { cat build/clang_beside.log; not_built clang; }
  run_tests clang
  check old-c-library old_c_library
  run_tests clang-old-cpu clang
  if [ "$mode" = long ]; then
    step "build: clang-more"
    build_targets clang-more || not_built clang-more
    run_tests clang-more clang
  fi
  if [ "$mode" = long ]; then
    step "build: asan-ubsan-all"
    build_targets asan-ubsan-all || not_built asan-ubsan-all
    run_tests asan-ubsan-all asan-ubsan
  else
    run_tests asan-ubsan
  fi
  if [ "$mode" = long ]; then
    build_and_test asan-ubsan-gcc
    build_and_test tsan
  fi
  step "fuzz, lint"
  if [ "$mode" = long ]; then  # looks for new inputs, in a build of its own
    check fuzz bash test/fuzz/run.sh "${FUZZ_SECONDS:-600}"
    check lint tidy_check
  else  # the same inputs for the same sources: a commit is judged by what it changed
    export DYNFILTER_FUZZ_SEED=${DYNFILTER_FUZZ_SEED:-1} DYNFILTER_FUZZ_BUILD=asan-ubsan DYNFILTER_FUZZ_AT_ONCE=1
    bash test/fuzz/run.sh "${FUZZ_SECONDS:-6}" >build/fuzz_beside.log 2>&1 &  # it and the linter take one core each
    beside=$!
    check lint tidy_check
    check fuzz fuzz_result $beside
  fi
  step "abi, format"
  check abi bash test/abi/check.sh
  [ "$mode" != long ] || check compilers bash test/compilers.sh --all
  check format format_check
fi
finish
