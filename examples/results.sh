#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# The tables of docs/results.md: every preset on the walking scenes and the static control, five seeds each.
#   bash examples/results.sh FOLDER [DYNFILTER]     needs the built command; about ten minutes
set -eu
folder=$(realpath -m "${1:?a folder for the sequences}")
cd "$(dirname "${BASH_SOURCE[0]}")/.."
dynfilter=${2:-build/command/examples/dynfilter/dynfilter}
pipelines=none,oracle,rts_slam_s,rts_slam_g,rts_slam_sg,rts_slam,rts_slam_published
mkdir -p "$folder"
for scene in ${SCENES:-walking_xyz walking_static walking_rpy walking_halfsphere static_desk}; do
  sequences=""
  for seed in ${SEEDS:-1 2 3 4 5}; do
    [ -f "$folder/$scene-$seed/groundtruth.txt" ] || "$dynfilter" synth "$scene" "$folder/$scene-$seed" --frames 100 --seed "$seed"
    sequences="$sequences $folder/$scene-$seed"
  done
  echo "== $scene"
  "$dynfilter" compare $sequences --pipelines "$pipelines"
done
