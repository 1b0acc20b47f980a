#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Known answers of comments.py: comments_test.py"""
import unittest

import comments

A = "a" * 50
SENTENCE = " ".join(["word"] * 25)


def kinds(*rows):
    """(line, kind) of each fault, without figures."""
    return [(line, kind.split()[-1]) for line, kind, _ in comments.faults_of("\n".join(rows) + "\n")]


class Width(unittest.TestCase):
    def test_110_columns_are_allowed_and_111_are_not(self):
        self.assertEqual(kinds("// " + "a" * 107), [])
        self.assertEqual(kinds("// " + "a" * 108), [(1, "columns")])
        self.assertEqual(kinds("int x;  /// " + "a" * 99), [(1, "columns")])
        self.assertEqual(kinds("/* " + "a" * 108, " */"), [(1, "columns")])

    def test_code_and_texts_are_no_comments(self):
        self.assertEqual(kinds("int " + "x" * 120 + ";", 'auto s = "// ' + "a" * 120 + '";'), [])
        self.assertEqual(kinds('auto s = R"y(', "// " + "a" * 120, ')y";', "char c = '\"';  // b"), [])


class Sentences(unittest.TestCase):
    def test_25_words_are_allowed_and_26_are_not(self):
        self.assertEqual(kinds(*self.wrapped(SENTENCE + ".")), [])
        self.assertEqual(kinds(*self.wrapped(SENTENCE + " more.")), [(1, "words")])

    def test_a_sentence_ends_with_its_full_stop_only(self):
        self.assertEqual(kinds(*self.wrapped(SENTENCE + ". More words.")), [])
        self.assertEqual(kinds(*self.wrapped(SENTENCE + "; more words.")), [(1, "words")])
        self.assertEqual(kinds(*self.wrapped("Torr et al. " + " ".join(["word"] * 23) + ".")), [(1, "words")])

    def test_code_between_backticks_is_one_word(self):
        self.assertEqual(kinds(*self.wrapped("Read `a b c d` of " + " ".join(["word"] * 22) + ".")), [])

    def test_numbers_are_words_and_signs_are_not(self):
        self.assertEqual(kinds(*self.wrapped("1 " + SENTENCE + ".")), [(1, "words")])
        self.assertEqual(kinds(*self.wrapped("- " + SENTENCE + ".")), [])

    @staticmethod
    def wrapped(text):
        rows = ["//"]
        for word in text.split():
            if len(rows[-1]) + 1 + len(word) > comments.LIMIT:
                rows.append("//")
            rows[-1] += " " + word
        return rows


class Filled(unittest.TestCase):
    def test_a_line_is_early_if_the_next_word_fits(self):
        self.assertEqual(kinds("// " + A + " " + "b" * 50, "// ccccc"), [(1, "early")])  # 104 + 1 + 5 = 110
        self.assertEqual(kinds("// " + A + " " + "b" * 50, "// cccccc"), [])
        self.assertEqual(kinds("  /// " + A, "  /// short", "  /// again"), [(1, "early"), (2, "early")])

    def test_a_number_stays_with_its_unit(self):
        self.assertEqual(kinds("// " + A + " " + "b" * 50, "// 0.33 m"), [])  # 104 + 1 + 6 = 111
        self.assertEqual(kinds("// " + A + " " + "b" * 50, "// 9 %,"), [(1, "early")])
        self.assertEqual(kinds("// " + A + " " + "b" * 50, "// 0.3 more"), [(1, "early")])

    def test_comments_beside_code_are_filled_too(self):
        self.assertEqual(kinds("int x;  ///< the place", "        ///< of a thing"), [(1, "early")])
        self.assertEqual(kinds("int x;  ///< the place", "int y;  ///< another"), [])
        self.assertEqual(kinds("int x;  // the place", "// of the next thing"), [])

    def test_a_sentence_may_end_a_line(self):
        for end in (".", ":", "?", "!", ".)", ".`"):
            self.assertEqual(kinds("// The place" + end, "// of a thing"), [])
        for end in (",", ";", "", ")"):
            self.assertEqual(kinds("// The place" + end, "// of a thing"), [(1, "early")])

    def test_lists_tables_code_and_drawings_are_left_alone(self):
        self.assertEqual(kinds("// These", "// - one", "//   and its rest", "// - two", "// 1. three"), [])
        self.assertEqual(kinds("///  - one", "///  - two"), [])
        self.assertEqual(kinds("// | a | b |", "// | 1 | 2 |"), [])
        self.assertEqual(kinds("/// Text", "///   x = 1", "///   y = 2", "/// text"), [])
        self.assertEqual(kinds("// a    b", "// c    d"), [])
        self.assertEqual(kinds("// Text", "// a    b"), [])
        self.assertEqual(kinds("// ---- heading", "// text"), [])
        self.assertEqual(kinds("// SPDX-License-Identifier: MIT", "// Text."), [])

    def test_other_comments_begin_anew(self):
        self.assertEqual(kinds("// one", "", "// two"), [])
        self.assertEqual(kinds("// one", "//", "// two"), [])
        self.assertEqual(kinds("// one", "/// two"), [])
        self.assertEqual(kinds("/// one", "//! two"), [])
        self.assertEqual(kinds("0,  // one", "0,  // two"), [])
        self.assertEqual(kinds("// one", "  // two"), [])


class Pages(unittest.TestCase):
    def test_sentences_of_text_and_of_items_are_counted(self):
        self.assertEqual(self.lines("Text.", "", "- " + SENTENCE, "  more."), [3])
        self.assertEqual(self.lines(SENTENCE, "[more](of/what it links).", "", SENTENCE + "."), [1])

    def test_code_tables_and_headings_are_not(self):
        self.assertEqual(self.lines("```", SENTENCE + " more", "```", "| " + SENTENCE + " more |"), [])
        self.assertEqual(self.lines("# Heading", SENTENCE + ".", "", "- " + SENTENCE, "- item"), [])

    @staticmethod
    def lines(*rows):
        return [line for line, _, _ in comments.page_faults_of("\n".join(rows) + "\n")]


if __name__ == "__main__":
    unittest.main()
