#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# What each effect of a sensor does to the default pipeline, on a static and a dynamic scene, no detector:
# ATE of no rejection, of the oracle and of dynfilter, recall, and the share of static features kept.
#   bash examples/effects.sh FOLDER [DYNFILTER]     needs the built command; about a quarter of an hour
# SEEDS, FRAMES, STATIC and DYNAMIC select others. PIPELINE and OPTIONS run another one, of a plugin.
set -eu
folder=$(realpath -m "${1:?a folder for the sequences}")
cd "$(dirname "${BASH_SOURCE[0]}")/.."
dynfilter=${2:-build/command/examples/dynfilter/dynfilter}
faults="--rolling-shutter-ms 20 --depth-offset-ms 20 --calibration-error 1 --exposure-steps"
mkdir -p "$folder"

# row NAME SCENE [SYNTH OPTION...]: a line of the table, medians over the seeds
row() {
  local name=$1 scene=$2 sequences="" seed
  shift 2
  for seed in ${SEEDS:-11 12 13}; do
    local sequence="$folder/$scene-${name// /_}-$seed"
    [ -f "$sequence/groundtruth.txt" ] ||
      "$dynfilter" synth "$scene" "$sequence" --frames "${FRAMES:-100}" --seed "$seed" "$@" >/dev/null
    sequences="$sequences $sequence"
  done
  # shellcheck disable=SC2086
  # A line per run, and with several seeds one of their medians, which comes last. Columns are found by name.
  # The notes have commas, and are the last column.
  "$dynfilter" compare $sequences --pipelines "none,oracle,${PIPELINE:-dynfilter}" --no-detections --no-masks \
    ${OPTIONS:-} --csv | awk -F, -v scene="$scene" -v name="$name" '
    NR == 1 { for (i = 1; i <= NF; ++i) column[$i] = i; next }
    {
      p = $column["pipeline"]
      if (p != "none" && p != "oracle") p = "own"
      for (head in column) value[p, head] = $column[head]
    }
    function figure(p, head, form) { return value[p, head] == "" ? "-" : sprintf(form, value[p, head]) }
    END {
      printf "| %s | %s | %s | %s | %s | %d | %s | %s |\n", scene, name, figure("none", "ate_rmse_m", "%.4f"),
        figure("oracle", "ate_rmse_m", "%.4f"), figure("own", "ate_rmse_m", "%.4f"),
        value["own", "frames"] - value["own", "tracked_frames"],
        figure("own", "recall", "%.3f"), figure("own", "static_kept", "%.3f")
    }'
}

echo "| scene | effect | none | oracle | dynfilter | lost | recall | kept |"
echo "|---|---|---|---|---|---|---|---|"
for scene in ${STATIC:-static_desk} ${DYNAMIC:-walking_rpy}; do
  row "none" "$scene"
  row "10 Hz" "$scene" --hz 10
  row "60 Hz" "$scene" --hz 60
  row "blur" "$scene" --blur
  row "rolling shutter" "$scene" --rolling-shutter-ms 20
  row "depth 10 ms late" "$scene" --depth-offset-ms 10
  row "depth 20 ms late" "$scene" --depth-offset-ms 20
  row "calibration" "$scene" --calibration-error 1
  row "exposure steps" "$scene" --exposure-steps
  # shellcheck disable=SC2086
  row "all" "$scene" --blur $faults
done
for kind in "" walking_; do
  for scene in turn_30 turn_60 turn_100 turn_150 shake; do row "none" "$kind$scene"; done
  # shellcheck disable=SC2086
  row "all" "${kind}turn_100" $faults
done
