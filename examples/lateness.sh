#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# The table of docs/semantics.md: what pipelines lose when boxes and masks come late.
#   bash examples/lateness.sh "SEQUENCE..." [DYNFILTER]     needs the built command; about a minute per row
# PIPELINES and MODES choose others, OPTIONS goes to `dynfilter compare` as it is.
set -eu
sequences=${1:?sequences, e.g. those that synth wrote}
dynfilter=${2:-$(dirname "${BASH_SOURCE[0]}")/../build/command/examples/dynfilter/dynfilter}
echo "| pipeline | boxes and masks | tracked | ATE, median | worst | recall | kept |"
echo "|---|---|---|---|---|---|---|"
for mode in ${MODES:-sync late:1 late:3 late:10 rate:2}; do
  "$dynfilter" compare $sequences --pipelines "${PIPELINES:-rts_slam,ngd_slam}" --detector-mode "$mode" ${OPTIONS:-} --json |
    python3 -c '
import json, statistics, sys
rows = json.load(sys.stdin)["rows"]
for pipeline in dict.fromkeys(r["pipeline"] for r in rows):
    own = [r for r in rows if r["pipeline"] == pipeline]
    def known(key): return [r[key] for r in own if r[key] is not None]
    def figure(values, f, digits): return "%.*f" % (digits, f(values)) if values else "-"
    print("| %s | %s | %d of %d | %s m | %s | %s | %s |" % (
        pipeline, sys.argv[1], sum(r["tracked_frames"] for r in own), sum(r["frames"] for r in own),
        figure(known("ate_rmse_m"), statistics.median, 4), figure(known("ate_rmse_m"), max, 4),
        figure(known("recall"), statistics.median, 3), figure(known("static_kept"), statistics.median, 3)))' "$mode"
done
