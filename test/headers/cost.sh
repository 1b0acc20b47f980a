#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# What a header-only caller makes GCC instantiate: the memory that it needs to parse one. Unlike a time it is the same on
# every machine, for one version of GCC.
#   bash test/headers/cost.sh g++ 1000          fails above 1000 MB
set -eu
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
compiler=$1 most_mb=$2
libraries=$(pkg-config --cflags eigen3 "$(pkg-config --exists opencv4 && echo opencv4 || echo opencv5)")
# shellcheck disable=SC2086  # several options
mb=$(printf '%s\n' '#include <dynfilter/dynfilter.hpp>' \
  'int main() { dynfilter::pipeline_from_text("", dynfilter::builtin_filters()); }' |
  "$compiler" -x c++ -std=c++17 -O2 -DDYNFILTER_HEADER_ONLY -Iinclude $libraries -fsyntax-only -ftime-report - 2>&1 |
  sed -n 's/^ *TOTAL .* \([0-9]*\)M$/\1/p')
echo "$mb MB, at most $most_mb"
[ "$mb" -le "$most_mb" ]
