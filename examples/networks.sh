#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# The table of docs/reference/results.md: detectors and segmenters on a real sequence,
# and pipelines that use them.
#   bash examples/networks.sh SEQUENCE NETWORKS [DYNFILTER]
# SEQUENCE: tum_fr3_walking_halfsphere; NETWORKS: the folder with the files that examples/detectors/*.yaml name.
set -eu
sequence=$(realpath "${1:?a TUM sequence}")
networks=$(realpath "${2:?the folder of the networks}")
cd "$(dirname "${BASH_SOURCE[0]}")/.."
dynfilter=${3:-build/command/examples/dynfilter/dynfilter}
for detector in yolo_fastest yolo_fastest_xl deeplabv3plus_person; do
  "$dynfilter" detect "$sequence" --detector $detector --network-dir "$networks"
done
echo "== the sequence's own files"
"$dynfilter" compare --wide "$sequence" --pipelines none,rts_slam
for detector in yolo_fastest yolo_fastest_xl; do
  echo "== $detector"
  "$dynfilter" compare --wide "$sequence" --pipelines rts_slam --detector $detector --network-dir "$networks"
done
for detector in yolo_fastest_masks deeplabv3plus_person; do
  echo "== $detector"
  "$dynfilter" compare --wide "$sequence" --pipelines des_slam --detector $detector --network-dir "$networks"
done
