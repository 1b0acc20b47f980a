#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Compares the ABI of the facade's C interface with test/abi/facade.abi: that of the last release, and before the first
# release that of the version in the repository. Needs abigail-tools. Takes about a second.
#   bash test/abi/check.sh            fails where a program that was compiled earlier would break
#   bash test/abi/check.sh --renew    writes test/abi/facade.abi: with every release, and with a new DYNFILTER_ABI_VERSION
# The C++11 interface is not compared: it takes types of OpenCV and of the C++ library, whose ABI it shares.
set -u
cd "$(dirname "${BASH_SOURCE[0]}")/../.." || exit 2
case "${1:-}" in
  "" | --renew) ;;
  *) sed -n '5,6s/^# *//p' "${BASH_SOURCE[0]}"; exit 2 ;;
esac
command -v abidw >/dev/null || { echo "abidw is missing: apt-get install abigail-tools"; exit 2; }

# A library of the declared functions without their bodies, and one per enumeration since they take these as int. In C: the
# real library's debug information is full of C++, at which abigail 2.2 fails. That it has these functions, the linker
# says when the facade's tests are built.
build=build/abi
mkdir -p $build || exit 2
{
  echo '#include <dynfilter/facade/dynfilter.h>'
  sed -n 's/^enum \([a-z_]*\).*/void use_\1(enum \1 value) { (void)value; }/p' include/dynfilter/facade/dynfilter.h
  sed -n '/^DYNFILTER_C_API/,/;/p' include/dynfilter/facade/dynfilter.h | sed 's/;/ { __builtin_trap(); }/'
} >$build/facade.c
"${CC:-cc}" -std=c11 -g -O0 -fPIC -shared -Iinclude $build/facade.c -o $build/facade.so || exit 1

if [ "${1:-}" = --renew ]; then
  abidw --no-corpus-path --no-comp-dir-path --no-show-locs $build/facade.so >test/abi/facade.abi &&
    echo "test/abi/facade.abi is written"
  exit
fi
# The bits of the exit code: 1 error, 2 usage, 4 a change, 8 an incompatible one. A new function is no change.
abidiff --no-added-syms test/abi/facade.abi $build/facade.so
code=$?
[ $code = 0 ] && { echo "abi: as before"; exit 0; }
echo "abi: changed. Undo the change, or raise DYNFILTER_ABI_VERSION and renew the dump"
exit 1
