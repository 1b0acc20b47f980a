#!/bin/sh
# SPDX-License-Identifier: MIT
# A compiler launcher: the file is parsed, which takes half of the time, and its object is empty. Not so a precompiled header.
object="" before=""
for argument; do
  [ "$before" = -o ] && object=$argument
  before=$argument
done
case "$object" in *.gch | *.pch) exec "$@" ;; esac
"$@" -fsyntax-only && : >"$object"
