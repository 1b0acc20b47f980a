#!/usr/bin/env bash
# Follows docs/tutorials/write_a_filter.md as a new user does, with a copy of its folder and an installed dynfilter:
# runs the page's commands, and compares the figures that it prints. That the page's code is the folder's, word for
# word, is checked by test/filters/write_a_filter_test.cpp.
#   write_a_filter.sh PAGE PREFIX COMMAND WORK
# PREFIX: where dynfilter is installed; COMMAND: the program `dynfilter`.
set -euo pipefail
page=$(realpath "$1") prefix=$(realpath "$2") command=$(realpath "$3") work=$4
rm -rf "$work" && mkdir -p "$work/page" "$work/mine" && work=$(realpath "$work")

# Block N of the page is page/N.LANGUAGE, in which "sh" are commands and what they print.
awk -v "out=$work/page" '
  /^```/ { if (file) { close(file); file = ""; next }
           file = sprintf("%s/%02d.%s", out, ++n, substr($0, 4) == "" ? "sh" : substr($0, 4)); next }
  file { print > file }' "$page"

cp "$(dirname "$page")"/../../examples/06_filter_recipes/* "$work/mine"

# The commands, each with the reader's paths replaced by ours.
cd "$work"
mkdir -p bin && ln -sf "$command" bin/dynfilter
ours() {
  sed -e "s|\$HOME/opt/dynfilter/bin|$work/bin|; s|\$HOME/opt/dynfilter|$prefix|" \
      -e "s|examples/06_filter_recipes|$work/mine|; s|/tmp/walking|$work/walking|" "$1"
}
printed=""
for block in "$work"/page/*.sh; do
  if ! grep -qE '^(cmake|dynfilter|export) ' "$block"; then
    diff "$block" <(printf '%s\n' "$printed") || { echo "the page's figures differ from the program's"; exit 1; }
    compared=yes
    continue
  fi
  ours "$block" > commands.sh
  cat commands.sh
  printed=$(bash -euo pipefail commands.sh 2>&1) || { echo "$printed"; echo "failed: $block"; exit 1; }
  echo "$printed"
  printed=$(grep -E 'static kept' <<< "$printed" || true)
  export PATH=$work/bin:$PATH
done
[ "${compared-}" = yes ] || { echo "the page shows no figures"; exit 1; }
