#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Pages that nobody would read, and links that lead nowhere.

    pages.py ROOT    prints each fault and fails if there is any

The pages of docs/ have at most 220 kB in all. README.md has at most 130 lines, and no line of its code is wider than 72
columns, so that it can be read at 400 px. Every relative link of a page leads to a file, its anchor to a heading, and
every page of docs/ is in docs/README.md or in an index that is linked there.
"""
import pathlib
import re
import sys

PAGES_BYTES = 220_000  # what a reader may have to search
README_LINES = 130
README_CODE_COLUMNS = 72

FENCE = re.compile(r"(?ms)^( *)```[^\n]*\n(.*?)^\1```")
LINK = re.compile(r"\]\(([^)\s]+)\)")
HEADING = re.compile(r"(?m)^#+ +(.*?) *$")
INDICES = ("docs/README.md", "docs/reference/filters/README.md")


def without_code(text):
    return re.sub(r"`[^`\n]*`", "", FENCE.sub("", text))


def anchor(heading):
    """As GitHub makes it: links and code lose their marks, signs go, blanks become dashes."""
    text = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading).replace("`", "").lower()
    return re.sub(r" ", "-", re.sub(r"[^\w\- ]", "", text))


def anchors(text):
    found = set()
    for heading in HEADING.findall(FENCE.sub("", text)):
        name, number = anchor(heading), 0
        while name + (f"-{number}" if number else "") in found:
            number += 1
        found.add(name + (f"-{number}" if number else ""))
    return found


def links(text):
    return [target for target in LINK.findall(without_code(text)) if not re.match(r"[a-z]+:", target)]


def link_faults(root, page):
    faults = []
    for target in links(page.read_text(encoding="utf-8")):
        name, _, mark = target.partition("#")
        file = (page.parent / name).resolve() if name else page
        if not file.exists():
            faults.append(f"no such file: {target}")
        elif mark and file.suffix == ".md" and mark not in anchors(file.read_text(encoding="utf-8")):
            faults.append(f"no such heading: {target}")
    return [f"{page.relative_to(root)}: {fault}" for fault in faults]


def index_faults(root):
    """Pages of docs/ that no index links."""
    linked = {(root / index).resolve() for index in INDICES}
    for index in INDICES:
        path = root / index
        if path.exists():
            linked |= {(path.parent / target.partition("#")[0]).resolve() for target in links(path.read_text(encoding="utf-8"))}
    return [f"{page.relative_to(root)}: is in no index" for page in pages(root) if page.resolve() not in linked]


def size_faults(root):
    size = sum(page.stat().st_size for page in pages(root))
    return [f"docs/: {size} bytes of pages, at most {PAGES_BYTES}"] if size > PAGES_BYTES else []


def readme_faults(text):
    faults = []
    if text.count("\n") > README_LINES:
        faults.append(f"README.md: {text.count(chr(10))} lines, at most {README_LINES}")
    for block in FENCE.finditer(text):
        faults += [f"README.md: {len(line)} columns, at most {README_CODE_COLUMNS}: {line}"
                   for line in block[2].split("\n") if len(line) > README_CODE_COLUMNS]
    return faults


def pages(root):
    return sorted((root / "docs").rglob("*.md"))


def faults_of(root):
    faults = size_faults(root) + readme_faults((root / "README.md").read_text(encoding="utf-8")) + index_faults(root)
    for page in sorted(root.glob("*.md")) + pages(root):
        faults += link_faults(root, page)
    return faults


def main(arguments):
    faults = faults_of(pathlib.Path(arguments[0]).resolve())
    print("\n".join(faults + [f"pages: {len(faults)} places"]))
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
