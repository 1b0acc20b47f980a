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
  "$dynfilter" compare $sequences --pipelines "none,oracle,${PIPELINE:-dynfilter}" --no-detections --no-masks \
    ${OPTIONS:-} --json | awk -v scene="$scene" -v name="$name" -v pipeline="$(basename "${PIPELINE:-dynfilter}" .yaml)" '
    function value(line) { sub(/.*: /, "", line); sub(/,$/, "", line); return line == "null" ? "-" : line }
    function add(key, line) { all[p, key] = all[p, key] " " value(line) }
    function median(p, key, form,   n, v, i, j, t) {
      n = split(all[p, key], v, " ")
      for (i = 1; i <= n; ++i)
        for (j = i + 1; j <= n; ++j) if (v[j] + 0 < v[i] + 0) { t = v[i]; v[i] = v[j]; v[j] = t }
      return n == 0 || v[1] == "-" ? "-" : sprintf(form, n % 2 ? v[(n + 1) / 2] : (v[n / 2] + v[n / 2 + 1]) / 2)
    }
    /"pipeline":/ { p = value($0); gsub(/"/, "", p); p = p == "none" || p == "oracle" ? p : "own" }
    /^      "frames":/ { total[p] += value($0) }
    /"tracked_frames":/ { tracked[p] += value($0) }
    /"ate_rmse_m":/ { add("ate", $0) }
    /"recall":/ { add("recall", $0) }
    /"static_kept":/ { add("kept", $0) }
    END {
      printf "| %s | %s | %s | %s | %s | %d | %s | %s |\n", scene, name, median("none", "ate", "%.4f"),
        median("oracle", "ate", "%.4f"), median("own", "ate", "%.4f"), total["own"] - tracked["own"],
        median("own", "recall", "%.3f"), median("own", "kept", "%.3f")
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
