#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# The figures of docs/reference/results.md (figures/map*.csv) on rendered scenes:
# downsampling, ghosts by pipeline, keyframes by selector.
#   bash examples/mapping.sh FOLDER [DYNFILTER]     needs the built command; about a quarter of an hour
# TABLES (thin ghosts keyframes), SCENES, PIPELINES and POSES (TRUE ESTIMATED) select others.
# MAPS=FOLDER keeps the maps and their pictures.
set -eu
folder=$(realpath -m "${1:?a folder for the sequences}")
cd "$(dirname "${BASH_SOURCE[0]}")/.."
dynfilter=$(realpath "${2:-build/command/examples/dynfilter/dynfilter}")
tables=${TABLES:-thin ghosts keyframes}
scenes=${SCENES:-walking_xyz walking_halfsphere}
pipelines=${PIPELINES:-none oracle dynfilter rts_slam des_slam motion_consistency dynaslam}
mkdir -p "$folder"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
maps=${MAPS:-$work}
mkdir -p "$maps"

rendered() {  # SCENE: its folder
  [ -f "$folder/$1-1/scene.txt" ] || "$dynfilter" synth "$1" "$folder/$1-1" --frames 100 --seed 1 > /dev/null
  echo "$folder/$1-1"
}

# A field of the command's JSON by its path, with a factor and a format of printf.
field() {  # FILE PATH [FACTOR FORMAT]
  awk -v want="$2" -v factor="${3:-}" -v format="${4:-%s}" '
    { match($0, /^ */); depth = RLENGTH / 2 }
    match($0, /"[^"]+": /) {
      path[depth] = substr($0, RSTART + 1, RLENGTH - 4)
      value = substr($0, RSTART + RLENGTH); sub(/,$/, "", value); gsub(/"/, "", value)
      name = path[1]; for (i = 2; i <= depth; i++) name = name "." path[i]
      if (name == want) { if (value == "null") print "-"; else printf(format "\n", factor == "" ? value : value * factor); exit }
    }' "$1"
}

# With true poses (TRUE) or those of the odometry (ESTIMATED).
build() {  # TRUE|ESTIMATED SCENE NAME ARGUMENTS...
  local poses=$1 sequence name=$3
  sequence=$(rendered "$2")
  shift 3
  if [ "$poses" = TRUE ]; then
    "$dynfilter" map "$sequence" "$sequence/groundtruth.txt" --map "$maps/$name.ply" --json "$@" > "$work/out.json"
  else
    "$dynfilter" run "$sequence" --map "$maps/$name.ply" --json "$@" > "$work/out.json"
  fi
}

thin_row() {  # LABEL LEAF N_W PREFIX
  echo "| $1 | $2 | $3 | $(field "$work/out.json" "$4points") | $(reduction "$4") | $(field "$work/out.json" "$5" 1e-6 %.1f) \
| $(field "$work/out.json" "$4ms_per_keyframe" 1 %.1f) |"
}
reduction() {  # PREFIX
  awk -v n="$(field "$work/out.json" "$1points")" -v all="$(field "$work/out.json" map.full.points)" \
    'BEGIN { printf "%.1f %%", 100 * (1 - n / all) }'
}

thin() {
  local grid="$work/grid.yaml" equal="$work/equal.yaml" ours="$work/ours.yaml"
  echo "== thinning: walking_xyz, true poses, every 5th frame, what moves cut out by the labels (oracle)"
  echo "| map | r_v | N_w | points | fewer | MB | ms a keyframe |"
  echo "|---|---|---|---|---|---|---|"
  printf 'mapping: { carve: false, key_window: 0, key_classes: [ none ] }\n' > "$grid"
  printf 'mapping: { key_window: 5, key_divisor: 1 }\n' > "$equal"
  printf 'mapping: { key_window: 5 }\n' > "$ours"
  for leaf in 0.01 0.02 0.04; do
    build TRUE walking_xyz "grid-$leaf" --pipeline oracle --keyframes every:5 --map-leaf-m $leaf --map-config "$grid" \
      --map-full "$maps/full.ply"
    [ $leaf != 0.01 ] || thin_row "full cloud" - - map.full. map.full.bytes
    thin_row "voxel grid" "$leaf m" - map. map.cloud_bytes
  done
  thin_ours "key objects at r_v" "$equal"
  thin_ours "key objects at r_v / 4" "$ours"
}
thin_ours() {  # LABEL CONFIG
  for leaf in 0.01 0.02 0.04; do
    build TRUE walking_xyz "ours-$leaf" --pipeline oracle --keyframes every:5 --map-leaf-m $leaf --map-config "$2" \
      --map-full "$maps/full.ply"
    thin_row "map, $1" "$leaf m" 5 map. map.cloud_bytes
  done
}

percent() { field "$work/out.json" "$1" 100 "%.$2f %%"; }
metres() { field "$work/out.json" "$1" 1 %.4f; }
truth_cells() {
  echo "$(field "$work/out.json" map.points) | $(percent map.truth.ghosts 2) | $(percent map.truth.astray 1) \
| $(percent map.truth.coverage 1) | $(percent map.truth.coverage_of_oracle 1) | $(metres map.truth.error_median_m) \
| $(metres map.truth.error_p95_m)"
}

ghosts() {
  for scene in $scenes; do
    for poses in ${POSES:-TRUE ESTIMATED}; do
      echo "== ghosts: $scene, $(tr '[:upper:]' '[:lower:]' <<< "$poses") poses, every 5th frame, r_v 0.02 m"
      echo "| pipeline | ATE m | points | ghosts | astray | covered | of the oracle's | error median m | 95 % m |"
      echo "|---|---|---|---|---|---|---|---|---|"
      for pipeline in $pipelines; do
        build "$poses" "$scene" "$scene-$poses-$pipeline" --pipeline "$pipeline" --keyframes every:5 --truth
        echo "| $pipeline | $(metres ate_rmse_m) | $(truth_cells) |"
      done
      build "$poses" "$scene" "$scene-$poses-dynfilter-alone" --pipeline dynfilter --keyframes every:5 --truth \
        --no-detections --no-masks
      echo "| dynfilter, no detector | $(metres ate_rmse_m) | $(truth_cells) |"
    done
  done
}

keyframes() {
  echo "== keyframes: dynfilter, the odometry's poses, r_v 0.02 m"
  echo "| scene | chosen by | keyframes | ATE m | points | ghosts | astray | covered | of the oracle's | error median m | 95 % m |"
  echo "|---|---|---|---|---|---|---|---|---|---|---|"
  for scene in ${SCENES:-static_desk walking_xyz walking_halfsphere person_tracking}; do
    for rule in own pose_change vertex_cover; do
      build ESTIMATED "$scene" "$scene-$rule" --pipeline dynfilter --keyframes $rule --truth
      echo "| $scene | $rule | $(field "$work/out.json" map.keyframes) | $(metres ate_rmse_m) | $(truth_cells) |"
    done
  done
}

for table in $tables; do $table; done
