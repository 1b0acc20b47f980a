#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# The figures of docs/reference/results.md on every rendered scene: the default pipeline with and without a detector,
# and every published preset. Writes FOLDER/rendered_scenes.csv, from which test/words/tables.py makes the tables.
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

# rows DETECTOR: the medians of `compare --csv`
rows() {
  awk -F, -v detector="$1" '
    function short(x) { return x == "" ? "" : sprintf("%.3f", x) }
    NR == 1 { for (i = 1; i <= NF; i++) column[$i] = i; next }
    $column["run"] ~ /^median of/ {
      printf "%s,%s,%s,%.4f,%.4f,%s,%s,%s\n", $column["sequence"], $column["pipeline"], detector, $column["ate_rmse_m"],
        $column["ate_rmse_max_m"], $column["tracked_frames"], short($column["recall"]), short($column["static_kept"])
    }'
}

echo "scene,pipeline,detector,ate_median_m,ate_worst_m,tracked_of_500,recall,static_kept" | tee "$folder/rendered_scenes.csv"
for scene in ${SCENES:-$scenes}; do
  sequences=""
  for seed in ${SEEDS:-1 2 3 4 5}; do
    [ -f "$folder/$scene-$seed/groundtruth.txt" ] || "$dynfilter" synth "$scene" "$folder/$scene-$seed" --frames 100 --seed "$seed" >&2
    sequences="$sequences $folder/$scene-$seed"
  done
  # shellcheck disable=SC2086
  {
    "$dynfilter" compare --csv $sequences --pipelines "${PIPELINES:-$pipelines}" | rows yes
    "$dynfilter" compare --csv $sequences --no-detections --no-masks --pipelines dynfilter | rows no
  } | tee -a "$folder/rendered_scenes.csv"
done
