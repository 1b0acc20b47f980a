#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# The figures of docs/reference/results.md (figures/late_results.csv): accuracy of pipelines with late boxes and masks.
#   bash examples/lateness.sh "SEQUENCE..." [DYNFILTER]     needs the built command; about a minute per row
# PIPELINES and MODES select others. OPTIONS is passed to `dynfilter compare`.
set -eu
sequences=${1:?sequences, e.g. those that synth wrote}
dynfilter=${2:-$(dirname "${BASH_SOURCE[0]}")/../build/command/examples/dynfilter/dynfilter}
echo "| pipeline | boxes and masks | tracked | ATE, median | worst | recall | kept |"
echo "|---|---|---|---|---|---|---|"
for mode in ${MODES:-sync late:1 late:3 late:10 rate:2}; do
  "$dynfilter" compare --wide $sequences --pipelines "${PIPELINES:-rts_slam,ngd_slam}" --detector-mode "$mode" ${OPTIONS:-} |
    awk -v mode="$mode" '
      function known(key) { return values[key] > 0 }
      function sorted(key,   i, j, v) {  # in place
        for (i = 2; i <= values[key]; i++) {
          v = value[key, i]
          for (j = i - 1; j > 0 && value[key, j] > v; j--) value[key, j + 1] = value[key, j]
          value[key, j + 1] = v
        }
      }
      function median(key, digits,   n) {
        n = values[key]
        if (n == 0) return "-"
        sorted(key)
        return sprintf("%.*f", digits, (value[key, int((n + 1) / 2)] + value[key, int(n / 2) + 1]) / 2)
      }
      function add(key, v) { if (v ~ /^[0-9]/) value[key, ++values[key]] = v + 0 }
      $1 == "sequence" {  # columns without any figure are not there
        gsub(/(ATE|RPE|filters) /, "&_"); gsub(/ _/, "_")
        delete column
        for (i = 1; i <= NF; i++) column[$i] = i
      }
      function at(name) { return name in column ? $(column[name]) : "" }
      $2 !~ /^[0-9]+$/ && $3 ~ /^[0-9]+\/[0-9]+$/ {  # not the summary of all runs
        if (!($2 in tracked)) order[++pipelines] = $2
        split($3, part, "/"); tracked[$2] += part[1]; frames[$2] += part[2]
        add($2 " ate", at("ATE_m")); add($2 " recall", at("recall")); add($2 " kept", at("kept"))
      }
      END {
        for (p = 1; p <= pipelines; p++) {
          name = order[p]; ate = median(name " ate", 4)
          worst = known(name " ate") ? sprintf("%.4f", value[name " ate", values[name " ate"]]) : "-"
          printf "| %s | %s | %d of %d | %s m | %s | %s | %s |\n", name, mode, tracked[name], frames[name], ate, worst,
            median(name " recall", 3), median(name " kept", 3)
        }
      }'
done
