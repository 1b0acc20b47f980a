#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Known answers of pages.py: pages_test.py"""
import pathlib
import tempfile
import unittest

import pages


class Anchors(unittest.TestCase):
    def test_signs_go_blanks_become_dashes_and_equal_ones_are_numbered(self):
        self.assertEqual(pages.anchor("`map`, and `run --map`"), "map-and-run---map")
        self.assertEqual(pages.anchor("C++17, OpenCV 4 and [newer](x.md)"), "c17-opencv-4-and-newer")
        self.assertEqual(pages.anchors("# A b\n## C\n## C\n"), {"a-b", "c", "c-1"})

    def test_headings_in_code_are_none(self):
        self.assertEqual(pages.anchors("# A\n\n```\n# B\n```\n"), {"a"})


class Readme(unittest.TestCase):
    def test_130_lines_are_allowed_and_131_are_not(self):
        self.assertEqual(pages.readme_faults("x\n" * 130), [])
        self.assertEqual(len(pages.readme_faults("x\n" * 131)), 1)

    def test_72_columns_of_code_are_allowed_and_73_are_not(self):
        self.assertEqual(pages.readme_faults("```cpp\n" + "x" * 72 + "\n```\n" + "y" * 200 + "\n"), [])
        self.assertEqual(len(pages.readme_faults("```\n" + "x" * 73 + "\n```\n")), 1)


class Repository(unittest.TestCase):
    def faults(self, **files):
        """Of a repository with these pages, named as docs/NAME.md."""
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder).resolve()
            (root / "docs").mkdir()
            (root / "README.md").write_text("# x\n")
            for name, text in files.items():
                (root / "docs" / (name + ".md")).write_text(text)
            return pages.faults_of(root)

    def test_links_to_files_headings_and_addresses(self):
        self.assertEqual(self.faults(README="[a](a.md#b-c) [x](https://x.y/z.md) [top](../README.md)\n", a="## B c\n"), [])

    def test_a_link_that_leads_nowhere(self):
        index = "[a](a.md)\n"
        self.assertEqual(self.faults(README=index, a="[b](b.md)\n"), ["docs/a.md: no such file: b.md"])
        self.assertEqual(self.faults(README=index, a="# A\n[b](#b)\n"), ["docs/a.md: no such heading: #b"])
        self.assertEqual(self.faults(README=index, a="`[b](b.md)`\n\n```\n[b](b.md)\n```\n"), [])

    def test_a_page_in_no_index(self):
        self.assertEqual(self.faults(README="x\n", a="x\n"), ["docs/a.md: is in no index"])

    def test_220_kB_are_allowed_and_a_byte_more_is_not(self):
        index = "[a](a.md)\n"
        self.assertEqual(self.faults(README=index, a="x" * (220000 - len(index))), [])
        self.assertEqual(len(self.faults(README=index, a="x" * (220001 - len(index)))), 1)


if __name__ == "__main__":
    unittest.main()
