#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# The table of docs/how-to/masks.md (docs/reference/figures/masks.csv): masks of rendered sequences against their labels.
#   bash examples/masks.sh FOLDER [DYNFILTER]     needs the built command; about a quarter of an hour
# SCENES, SEEDS and KINDS (discs features network perfect) select others. OPTIONS is passed to `dynfilter masks`.
set -eu
folder=$(realpath -m "${1:?a folder for the sequences}")
cd "$(dirname "${BASH_SOURCE[0]}")/.."
dynfilter=$(realpath "${2:-build/command/examples/dynfilter/dynfilter}")
frames=60
mkdir -p "$folder"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

rendered() {  # SCENE SEED: its folder
  local sequence="$folder/$1-$2"
  [ -f "$sequence/instances.txt" ] ||
    "$dynfilter" synth "$1" "$sequence" --frames $frames --seed "$2" --instances > /dev/null
  echo "$sequence"
}

# Where objects come from. Those of the network have its faults, and masks of a quarter of the size.
source_of() {  # KIND SEQUENCE
  case $1 in
    discs | features) echo "--shape $1 --no-detections --no-masks" ;;
    network) echo "--shape objects --masks $2/instances_small" ;;
    perfect) echo "--shape objects --masks $2/instances --detections $2/instances.txt" ;;
  esac
}

truth() {  # KEY
  sed -n "s/^ *\"$1\": \([0-9.e-]*\),*$/\1/p" "$work/out.json"
}

echo "| scene | seed | masks | IoU | movers masked | static lost |"
echo "|---|---|---|---|---|---|"
for scene in ${SCENES:-walking_xyz street_traffic hall_people crowd}; do
  for seed in ${SEEDS:-1 21 22}; do
    sequence=$(rendered "$scene" "$seed")
    for kind in ${KINDS:-discs features network perfect}; do
      # shellcheck disable=SC2046,SC2086
      "$dynfilter" masks "$sequence" "$work/out" --force --truth --json $(source_of "$kind" "$sequence") \
        ${OPTIONS:-} > "$work/out.json"
      printf '| %s | %s | %s | %.3f | %.1f %% | %.2f %% |\n' "$scene" "$seed" "$kind" "$(truth iou)" \
        "$(awk -v x="$(truth movers_masked)" 'BEGIN { print 100 * x }')" \
        "$(awk -v x="$(truth static_lost)" 'BEGIN { print 100 * x }')"
    done
  done
done
