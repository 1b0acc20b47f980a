#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Known answers of tables.py: tables_test.py"""
import pathlib
import tempfile
import unittest

import tables


def run(scene, pipeline, detector, ate, tracked="500", recall="0.9", kept="0.8"):
    return {"scene": scene, "pipeline": pipeline, "detector": detector, "ate_median_m": ate, "ate_worst_m": "9",
            "tracked_of_500": tracked, "recall": recall, "static_kept": kept}


DATA = {
    "rendered_scenes": [
        run("a", "none", "yes", "0.5000"), run("a", "oracle", "yes", "0.0100"), run("a", "x_slam", "yes", "0.0300", "490"),
        run("a", "y_slam", "yes", "0.0120"), run("a", "dynfilter", "yes", "0.0110"), run("a", "dynfilter", "no", "0.0130"),
        run("b", "none", "yes", "0.0010"), run("b", "oracle", "yes", "0.0010"), run("b", "x_slam", "yes", "0.0014", "500", ""),
        run("b", "y_slam", "yes", "0.0015"), run("b", "dynfilter", "yes", "0.0010"), run("b", "dynfilter", "no", "0.0010")],
    "seeds_kept_apart": [
        {"scene": "c", "oracle_ate_median_m": "0.0020", "oracle_ate_worst_m": "0.0030", "ate_median_m": "0.0021",
         "ate_worst_m": "0.0031", "recall": "", "static_kept": "0.999"}],
}


class Tables(unittest.TestCase):
    def test_the_best_published_is_no_pipeline_of_ours(self):
        rows = tables.rendered(DATA).splitlines()
        self.assertEqual(rows[2], "| a | 0.5000 | 0.0100 | 0.0130 (9) | 0.0110 | 0.0120 y_slam | - | - | - |")
        self.assertEqual(rows[4], "| c | - | 0.0020 | - | - | - | 0.0021 (0.0031) | - | 0.999 |")

    def test_as_good_as_the_true_labels_is_1_2_times_or_0_4_mm_more(self):
        rows = tables.published(DATA).splitlines()
        # x: 3 times in a, 0.4 mm more in b. y: 1.2 times in a, 0.5 mm more in b.
        self.assertEqual(rows[2], "| `x_slam` | 1 of 2 | 0.900 | 0.800 | 10 | 0.0300 a |")
        self.assertEqual(rows[3], "| `y_slam` | 1 of 2 | 0.900 | 0.800 | 0 | 0.0120 a |")

    def test_the_mean_and_the_three_worst_of_the_tracks(self):
        data = {"labelled_tracks": [{"data": "d", "clip": name, "f1": f1} for name, f1 in
                                    (("p", "1.000"), ("q", "0.500"), ("r", "0.700"), ("s", "0.800"))]}
        self.assertEqual(tables.tracks(data).splitlines()[2], "| d | 4 | 0.750 | q 0.500, r 0.700, s 0.800 |")


class Pages(unittest.TestCase):
    def test_a_table_that_differs_is_found_and_written(self):
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder)
            (root / tables.FOLDER).mkdir(parents=True)
            page = root / "docs" / "a.md"
            page.write_text("<!-- figures masks -->\nold\n<!-- end -->\n")
            (root / tables.FOLDER / "masks.csv").write_text(
                "scene,seed,masks,iou,movers_masked_percent,static_lost_percent\ns,21,network,0.9,98.0,2.0\n")
            names, tables.TABLES = tables.TABLES, {"masks": tables.masks}
            try:
                self.assertEqual(tables.main([folder]), 1)
                self.assertEqual(tables.main([folder, "--write"]), 0)
                self.assertEqual(tables.main([folder]), 0)
            finally:
                tables.TABLES = names
            self.assertIn("| `s` | network | 0.9 | 98.0 % | 2.0 % |\n<!-- end -->", page.read_text())


if __name__ == "__main__":
    unittest.main()
