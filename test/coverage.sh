#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Line and branch coverage of include/ by the unit tests. Needs gcovr. By hand, not in continuous integration: it is one
# more build of every test.
#   bash test/coverage.sh           prints each file and the sums. Fails below 92 % of the lines or 80 % of the branches.
# Branches that only an exception takes are not counted (--exclude-throw-branches): each call that may throw has one, and
# no test takes most of them. Nor are those that the compiler knows to be unreachable (--exclude-unreachable-branches).
set -u
cd "$(dirname "${BASH_SOURCE[0]}")/.." || exit 2
. cmake/setup.sh
choose_tools
command -v gcovr >/dev/null || { echo "gcovr is missing: apt-get install gcovr"; exit 2; }
mkdir -p build
{ cmake --preset coverage && cmake --build --preset coverage -j "${DYNFILTER_JOBS:-$jobs}"; } >build/coverage.log 2>&1 ||
  { tail -n 40 build/coverage.log; exit 1; }
find build/coverage -name '*.gcda' -delete
ctest --preset coverage -j "${DYNFILTER_JOBS:-$jobs}" | tail -n 5 || exit 1
gcovr --root . --object-directory build/coverage --filter 'include/dynfilter/' \
  --exclude-throw-branches --exclude-unreachable-branches --sort-percentage --print-summary \
  --fail-under-line 92 --fail-under-branch 80 build/coverage
