#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Tables of measured figures on the pages, made from docs/reference/figures/*.csv.

    tables.py ROOT           prints each table that differs from its file, and fails if there is any
    tables.py ROOT --write   writes the tables into the pages

A page has a table between `<!-- figures NAME -->` and `<!-- end -->`. The files hold every figure, the tables what
readers compare.
"""
import csv
import pathlib
import re
import statistics
import sys

FOLDER = "docs/reference/figures"
MARK = re.compile(r"(<!-- figures (\w+) -->\n)(.*?)(<!-- end -->)", re.S)
OURS = ("none", "oracle", "dynfilter")
NEAR = 1.2  # times the oracle's error: as good as the true labels
NEAR_M = 0.0004  # or this much above it, which is the noise of the figures


def table(head, rows):
    lines = ["| " + " | ".join(row) + " |" for row in [head] + rows]
    return "\n".join([lines[0], "|" + "---|" * len(head)] + lines[1:]) + "\n"


def unique(values):
    return list(dict.fromkeys(values))


def select(rows, **wanted):
    return [row for row in rows if all(row[key] == value for key, value in wanted.items())]


def pair(row, name="ate"):
    return f"{row[name + '_median_m']} ({row[name + '_worst_m']})"


def or_dash(text):
    return text or "-"


def is_near(row, oracle):
    ate, best = float(row["ate_median_m"]), float(oracle["ate_median_m"])
    return ate <= max(NEAR * best, best + NEAR_M) + 1e-9


def rendered(data):
    """Per scene: the default pipeline beside none, the true labels, and the best published system. Then other seeds."""
    rows = []
    kept_apart = {row["scene"]: row for row in data["seeds_kept_apart"]}
    scenes = unique(row["scene"] for row in data["rendered_scenes"])
    for scene in scenes + [scene for scene in kept_apart if scene not in scenes]:
        apart = kept_apart.get(scene)
        last = [pair(apart), or_dash(apart["recall"]), apart["static_kept"]] if apart else ["-", "-", "-"]
        of = select(data["rendered_scenes"], scene=scene)
        if not of:
            rows.append([scene, "-", apart["oracle_ate_median_m"], "-", "-", "-"] + last)
            continue
        none, oracle = select(of, pipeline="none")[0], select(of, pipeline="oracle")[0]
        alone = select(of, pipeline="dynfilter", detector="no")[0]
        boxes = select(of, pipeline="dynfilter", detector="yes")[0]
        best = min((row for row in of if row["pipeline"] not in OURS), key=lambda row: float(row["ate_median_m"]))
        rows.append([scene, none["ate_median_m"], oracle["ate_median_m"], pair(alone), boxes["ate_median_m"],
                     f"{best['ate_median_m']} {best['pipeline']}"] + last)
    return table(["scene", "none", "true labels", "`dynfilter`", "with boxes", "best published",
                  "other seeds", "recall", "kept"], rows)


def published(data):
    """Per published system: on how many scenes it is as good as the true labels, and where it is worst."""
    rows = []
    scenes = unique(row["scene"] for row in data["rendered_scenes"])
    for pipeline, detector in unique((row["pipeline"], row["detector"]) for row in data["rendered_scenes"]):
        if pipeline in ("none", "oracle"):
            continue
        of = select(data["rendered_scenes"], pipeline=pipeline, detector=detector)
        near = sum(is_near(row, select(data["rendered_scenes"], scene=row["scene"], pipeline="oracle")[0]) for row in of)
        lost = sum(500 - int(row["tracked_of_500"]) for row in of)
        recall = statistics.median(float(row["recall"]) for row in of if row["recall"])
        kept = statistics.median(float(row["static_kept"]) for row in of)
        worst = max(of, key=lambda row: float(row["ate_median_m"]))
        name = f"`{pipeline}`" + (", no detector" if detector == "no" else "")
        rows.append([name, f"{near} of {len(scenes)}", f"{recall:.3f}", f"{kept:.3f}", str(lost),
                     f"{worst['ate_median_m']} {worst['scene']}"])
    return table(["pipeline", "as the true labels", "recall", "kept", "frames lost", "worst scene"], rows)


def sensors(data):
    """Stereo and one camera, side by side. In brackets: frames tracked."""
    def cells(row):
        def cell(ate, tracked):
            return or_dash(ate) + (f" ({tracked})" if tracked else "")
        return [cell(row["none_ate_m"], row["none_tracked"]), cell(row["oracle_ate_m"], row["oracle_tracked"]),
                cell(row["ate_m"], row["tracked"]), or_dash(row["recall"])]
    columns = ["none", "true labels", "`dynfilter`", "recall"]
    return table(["scene"] + ["stereo: none"] + columns[1:] + ["mono: none"] + columns[1:],
                 [[scene] + cells(select(data["stereo_mono"], scene=scene, sensor="stereo")[0]) +
                  cells(select(data["stereo_mono"], scene=scene, sensor="mono")[0])
                  for scene in unique(row["scene"] for row in data["stereo_mono"])])


def maps(data):
    rows = []
    for row in select(data["maps"], scene="walking_xyz", poses="odometry"):
        name = f"`{row['pipeline']}`" + (", no detector" if row["detector"] == "no" else "")
        rows.append([name, row["ate_m"], row["points"], row["ghosts_percent"] + " %",
                     row["astray_percent"] + " %", row["covered_of_oracle_percent"] + " %", row["error_median_m"]])
    return table(["`walking_xyz`", "ATE m", "points", "ghosts", "astray", "covered", "error m"], rows)


def tracks(data):
    rows = []
    for name in unique(row["data"] for row in data["labelled_tracks"]):
        of = select(data["labelled_tracks"], data=name)
        worst = sorted(of, key=lambda row: float(row["f1"]))[:3]
        mean = statistics.mean(float(row["f1"]) for row in of)
        rows.append([name, str(len(of)), f"{mean:.3f}", ", ".join(f"{row['clip']} {row['f1']}" for row in worst)])
    return table(["data", "clips", "mean F1", "worst"], rows)


def masks(data):
    """A seed that was kept apart."""
    return table(["scene", "masks", "IoU", "movers masked", "static lost"],
                 [[f"`{row['scene']}`", row["masks"], row["iou"], row["movers_masked_percent"] + " %",
                   row["static_lost_percent"] + " %"]
                  for row in data["masks"] if row["seed"] == "21" and row["masks"] != "perfect"])


TABLES = {function.__name__: function for function in
          (rendered, published, sensors, maps, tracks, masks)}


def read(root):
    data = {}
    for path in sorted((root / FOLDER).glob("*.csv")):
        with path.open(encoding="utf-8", newline="") as file:
            data[path.stem] = list(csv.DictReader(file))
    return data


def updated(text, data):
    return MARK.sub(lambda m: m[1] + TABLES[m[2]](data) + m[4], text)


def main(arguments):
    root = pathlib.Path(arguments[0])
    data = read(root)
    used, wrong = set(), 0
    for page in sorted((root / "docs").rglob("*.md")):
        text = page.read_text(encoding="utf-8")
        used |= {m[2] for m in MARK.finditer(text)}
        wanted = updated(text, data)
        if wanted == text:
            continue
        if "--write" in arguments:
            page.write_text(wanted, encoding="utf-8")
        else:
            print(f"{page.relative_to(root)}: a table differs from {FOLDER}: test/words/tables.py . --write")
            wrong += 1
    for name in sorted(set(TABLES) - used):
        print(f"no page has the table {name}")
        wrong += 1
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
