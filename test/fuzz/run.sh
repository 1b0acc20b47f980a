#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Builds the fuzz targets and runs each for SECONDS, two at a time. Stops at the first target that finds something, and
# names the input that shows it.
#   bash test/fuzz/run.sh [SECONDS] [TARGET...]     SECONDS: default 60, of each target; TARGET: default all
# What is found is collected in build/fuzz/found/TARGET, and new inputs in build/fuzz/corpus/TARGET, so that the next run
# continues from there. DYNFILTER_FUZZ_AT_ONCE: targets at a time, default 2. DYNFILTER_FUZZ_SEED: for the same inputs in
# every run that starts without build/fuzz/corpus; default: other inputs each time. DYNFILTER_FUZZ_BUILD: the preset, default
# fuzz, where libFuzzer sees all branches; with asan-ubsan those of the targets, for which nothing more has to be built.
set -u
cd "$(dirname "${BASH_SOURCE[0]}")/../.." || exit 2
seconds=${1:-60}
[[ "$seconds" =~ ^[1-9][0-9]*$ ]] || { sed -n '5,9s/^# *//p' "${BASH_SOURCE[0]}"; exit 2; }
shift || true
targets=${*:-yaml frames files sequences protocol facade facade_cxx11}

command -v clang++ >/dev/null || { echo "clang++ is missing: apt-get install clang libclang-rt-14-dev"; exit 2; }
if command -v ninja >/dev/null; then export CMAKE_GENERATOR=Ninja; fi
if command -v ccache >/dev/null; then export CMAKE_C_COMPILER_LAUNCHER=ccache CMAKE_CXX_COMPILER_LAUNCHER=ccache; fi
mkdir -p build/fuzz
export preset=${DYNFILTER_FUZZ_BUILD:-fuzz}
{ cmake --preset "$preset" && cmake --build --preset "$preset" --target $(printf " fuzz_%s" $targets) -j "${DYNFILTER_FUZZ_AT_ONCE:-2}"; } >build/fuzz.log 2>&1 ||
  { tail -n 40 build/fuzz.log; exit 1; }

# fuzz TARGET: the last lines of its log when it found something, else one line with what it did.
fuzz() {
  local target=$1 extra=() log=build/fuzz/$1.log
  mkdir -p "build/fuzz/found/$target" "build/fuzz/corpus/$target"
  if [ "$target" = yaml ]; then extra=(-dict=test/fuzz/yaml.dict examples/pipelines test/fuzz/pipelines); fi
  # An input may take 20 s here: the sanitizers are slow, and so may be the machine.
  DYNFILTER_FUZZ_RATE=1 build/"$preset"/test/fuzz/fuzz_"$target" -seed="${DYNFILTER_FUZZ_SEED:-0}" -max_total_time="$seconds" -timeout=20 -rss_limit_mb=3000 -malloc_limit_mb=1000 \
    -max_len=4096 -artifact_prefix="build/fuzz/found/$target/" -print_final_stats=1 "build/fuzz/corpus/$target" \
    "test/fuzz/corpus/$target" "${extra[@]}" >"$log" 2>&1
  local code=$?
  if [ "$code" != 0 ]; then
    echo "$target: found something"
    grep -E "property does not hold|ERROR:|runtime error|SUMMARY|Test unit written" "$log" | head -n 12
    return 1
  fi
  local runs frames
  runs=$(sed -n 's/^stat::number_of_executed_units: *//p' "$log")
  frames=$(sed -n 's/^frames: //p' "$log")
  echo "$target: $runs inputs in $seconds s${frames:+, frames: $frames}"
}
export -f fuzz
export seconds
printf '%s\n' $targets | xargs -P "${DYNFILTER_FUZZ_AT_ONCE:-2}" -I{} bash -c 'fuzz {}' || { echo "fuzzing failed"; exit 1; }
echo "fuzzing found nothing"
