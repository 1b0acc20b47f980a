#!/bin/sh
# SPDX-License-Identifier: MIT
# The file that defines DYNFILTER_IMPLEMENTATION has every function of the libraries. Weak ones every file has for itself.
#   sh same_functions.sh NM OBJECT LIBRARY...
set -eu
nm=$1 object=$2
shift 2
functions() { "$nm" "$@" 2>/dev/null | awk '$2 == "T" { print $3 }' | sort -u; }
functions "$object" >there.txt
functions "$@" >wanted.txt
[ -s wanted.txt ] || { echo "the libraries have no functions"; exit 1; }
missing=$(comm -13 there.txt wanted.txt)
[ -z "$missing" ] || { echo "missing: $missing"; exit 1; }
