#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# The tables of docs/reference/results.md, on every rendered scene:
# the default pipeline with and without a detector, and every published preset.
#   bash examples/results.sh FOLDER [DYNFILTER]     needs the built command; about half an hour
# SCENES, SEEDS and PIPELINES select others.
set -eu
folder=$(realpath -m "${1:?a folder for the sequences}")
cd "$(dirname "${BASH_SOURCE[0]}")/.."
dynfilter=${2:-build/command/examples/dynfilter/dynfilter}
scenes="static_desk walking_xyz walking_static walking_rpy walking_halfsphere sitting_static moving_box along_epipolar
  person_tracking crowd synchronous synchronous_cold low_texture majority majority_cold"
pipelines=none,oracle,rts_slam,des_slam,motion_consistency,sg_slam,ds_slam,ovd_slam,dynaslam,rds_slam,ngd_slam,yolo_slam,coeb_slam,dynfilter
mkdir -p "$folder"
for scene in ${SCENES:-$scenes}; do
  sequences=""
  for seed in ${SEEDS:-1 2 3 4 5}; do
    [ -f "$folder/$scene-$seed/groundtruth.txt" ] || "$dynfilter" synth "$scene" "$folder/$scene-$seed" --frames 100 --seed "$seed"
    sequences="$sequences $folder/$scene-$seed"
  done
  echo "== $scene"
  "$dynfilter" compare --wide $sequences --pipelines "${PIPELINES:-$pipelines}"
  echo "== $scene, no detector"
  "$dynfilter" compare --wide $sequences --no-detections --no-masks --pipelines dynfilter
done
