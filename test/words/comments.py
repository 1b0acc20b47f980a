#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Comments of C++ and C that are hard to read, and long sentences in pages of Markdown.

    comments.py ROOT    prints each place and fails if there is any

Lines have at most 110 columns, sentences at most 25 words, and each line of a paragraph is filled with words. A paragraph
is neighbouring lines of // or /// with the same indentation. It also ends after a line that ends with a sentence or a
colon, and before an item of a list. Rows of tables, indented lines and lines with three spaces between words are left
alone. A comment beside code continues in the lines below that begin in its column.
"""
import pathlib
import re
import sys

LIMIT = 110  # columns
WORDS = 25  # of a sentence
FOLDERS = ("include", "plugins", "examples", "test")
SUFFIXES = (".hpp", ".cpp", ".h", ".c")

# A text, a character or a raw text, which may hold "//"; a comment; or anything else.
TOKEN = re.compile(
    r'R"([^()\s\\]{0,16})\(.*?\)\1"|"(?:\\.|[^"\\\n])*"|(?<![0-9a-fA-F])\'(?:\\.|[^\'\\\n])+\'|//[^\n]*|/\*.*?\*/|\n', re.S)
MARK = re.compile(r"///<?|//!?")
STARTS = re.compile(r" ?([-*+|#@\\]|\d+[.)] )|  |NOLINT|clang-format|SPDX")
ALONE = re.compile(r"[|#@\\]|  |[-=]{2}|NOLINT|clang-format|SPDX|.*\S   *\S")
ENDS = re.compile(r"[.:!?][)\"'`*]*$")
SENTENCE = re.compile(r"(?<=[.!?])[)\"'`*]*\s+(?=[\"'`(*\[-]*[A-Za-z0-9])")
ABBREVIATION = re.compile(r"\b(e\.g|i\.e|cf|vs|al|[Ff]ig|[Ee]q|[Ss]ec|Alg|pp?)\.\s")


class Line:
    """One line of a comment: `number` from 1, `head` is all before the text, `beside`: with code before it."""

    def __init__(self, number, head, text, beside):
        self.number, self.head, self.text, self.beside = number, head, text, beside


def comment_lines(text):
    lines, rows = [], text.split("\n")
    number, begin = 1, 0
    for token in TOKEN.finditer(text):
        found = token.group()
        if found == "\n":
            number, begin = number + 1, token.end()
        elif found.startswith("//"):
            row = rows[number - 1]
            at = token.start() - begin
            mark = MARK.match(found).group()
            rest = found[len(mark):]
            space = 1 if rest.startswith(" ") else 0
            lines.append(Line(number, row[:at] + mark + " " * space, rest[space:].rstrip(), row[:at].strip() != ""))
        else:
            if found.startswith("/*"):  # only its width is looked at
                lines += [Line(number + k, "", "", False) for k in range(found.count("\n") + 1)]
            number += found.count("\n")
            begin = token.start() + found.rindex("\n") + 1 if "\n" in found else begin
    return lines


def follows(above, line):
    """Whether `line` continues the comment of `above`."""
    return (line.number == above.number + 1 and not line.beside and len(line.head) == len(above.head) and
            above.head.endswith(line.head.lstrip()))


def paragraphs(lines):
    """Lists of lines. What may not be filled is a paragraph of its own."""
    found = []
    for line in lines:
        above = found[-1][-1] if found else None
        if (above and follows(above, line) and above.text and line.text and not STARTS.match(line.text) and
                not ALONE.match(above.text) and not ALONE.match(line.text) and not ENDS.search(above.text)):
            found[-1].append(line)
        else:
            found.append([line])
    return found


def words_of(text):
    """A number stays with its unit."""
    return re.findall(r"[\d.]+ (?:%|px|m|mm|s|ms|us|Hz|kB|MB|GB)(?!\w)\S*|\S+", text)


def count_words(text):
    """What is between backticks is one word."""
    return sum(1 for word in re.sub("`[^`]*`", "x", text).split() if re.search(r"[A-Za-z0-9]", word))


def sentences(text):
    return SENTENCE.split(ABBREVIATION.sub(lambda m: m.group().replace(".", ""), text))


def long_sentences(text):
    return [s for s in sentences(text) if count_words(s) > WORDS]


def faults_of(text):
    """Triples of line, kind and excerpt."""
    lines = comment_lines(text)
    rows = text.split("\n")
    faults = []
    for number in sorted({line.number for line in lines}):
        if len(rows[number - 1]) > LIMIT:
            faults.append((number, "%d columns" % len(rows[number - 1]), rows[number - 1].strip()))
    for paragraph in paragraphs(lines):
        text = " ".join(line.text.strip() for line in paragraph)
        faults += [(paragraph[0].number, "%d words" % count_words(s), s) for s in long_sentences(text)]
        for line, below in zip(paragraph, paragraph[1:]):
            if len(line.head) + len(line.text) + 1 + len(words_of(below.text)[0]) <= LIMIT:
                faults.append((line.number, "wrapped early", line.text))
    return sorted(faults)


def page_faults_of(text):
    """Long sentences of a page of Markdown, without its code, tables and headings."""
    text = re.sub(r"(?ms)^( *)```.*?^\1```", "", text)
    text = re.sub(r"\]\([^)]*\)", "]", text)
    faults, number = [], 1
    for part in re.split(r"(\n(?=\s*\n|\s*[-*|#>]|\s*\d+\. ))", text):
        if not re.match(r"\s*([|#>]|    )", part):
            faults += [(number, "%d words" % count_words(s), s) for s in long_sentences(" ".join(part.split()))]
        number += part.count("\n")
    return faults


def files(root):
    return [path for folder in FOLDERS for path in sorted((root / folder).rglob("*"))
            if path.suffix in SUFFIXES and path.name != "doctest.h"]


def pages(root):
    return sorted(root.glob("*.md")) + sorted((root / "docs").rglob("*.md"))


def main(arguments):
    root = pathlib.Path(arguments[0])
    count = 0
    for path in files(root) + pages(root):
        faults = page_faults_of if path.suffix == ".md" else faults_of
        for number, kind, excerpt in faults(path.read_text(encoding="utf-8")):
            print(f"{path.relative_to(root)}:{number}: {kind}: {excerpt}")
            count += 1
    print(f"words: {count} places")
    return 1 if count else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
