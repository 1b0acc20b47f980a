# SPDX-License-Identifier: MIT
"""Compares the YAML reader with PyYAML over generated documents.

    python3 compare.py PROGRAM PRESETS [--documents N] [--seed S] [--show]

PROGRAM is yaml_trees, PRESETS a folder of pipelines. What PROGRAM accepts, PyYAML must read as the same tree, in which
each plain text has the type that PROGRAM found. PROGRAM must accept all plain documents, so that it cannot pass by
refusing everything. Exit code 77 without PyYAML: skipped.
"""

import argparse
import collections
import itertools
import json
import os
import random
import re
import subprocess
import sys
import time

try:
    import yaml
except ImportError:
    print("skipped: python3-yaml is missing")
    sys.exit(77)

MOST_ERROR_BYTES = 1024
MOST_FINDINGS_SHOWN = 10

# ---- documents that any reader must accept

WORDS = ["a", "epipolar", "semantic_box", "role", "prior", "x1", "max_distance_px", "Camera.fx", "b-c", "two words",
         "file:///a#b", "a:b", "-x", "été", "off", "3d", "a'b", 'a"b', "x[0]", "100%", "p&q", "c*d", "w!", "e|f"]
FLOW_WORDS = [w for w in WORDS if not re.search(r"[\[\]{},?]", w)]
KEYS = [w for w in WORDS if w[0] != "-" and ":" not in w]  # PyYAML and OpenCV end `a:b: 1` at different colons
FLOW_KEYS = [w for w in KEYS if w in FLOW_WORDS]
NUMBERS = ["0", "1", "-3", "+7", "0.5", "-1.25", "1.", "1.5e+3", "2.5e-3", "1200", "1e5", "-.5", ".5", "3E-2"]
TEXTS = ["", "a b", "# no comment", "a: b", "it's", 'say "x"', "[1]", "{a}", "true", "1.5", "back\\slash", "é", "&a", "- b",
         "<<", "tab\there", "--- ", "%x"]


class Documents:
    """Trees of ("map", [(key, tree)]), ("list", [tree]), ("plain", text) and ("quoted", text), and their texts."""

    def __init__(self, rng):
        self.rng = rng

    def tree(self, depth, in_flow=False):
        kind = self.rng.random()
        if depth > 0 and kind < 0.35:
            keys = self.rng.sample(FLOW_KEYS if in_flow else KEYS, self.rng.randint(0 if in_flow else 1, 3))
            return ("map", [(k, self.tree(depth - 1, in_flow)) for k in keys])
        if depth > 0 and kind < 0.6:
            return ("list", [self.tree(depth - 1, in_flow) for _ in range(self.rng.randint(0 if in_flow else 1, 3))])
        if kind < 0.75:
            return ("plain", self.rng.choice(NUMBERS))
        if kind < 0.9:
            return ("plain", self.rng.choice(FLOW_WORDS if in_flow else WORDS))
        return ("quoted", self.rng.choice(TEXTS))

    def quoted(self, text):
        if self.rng.random() < 0.5:
            return "'" + text.replace("'", "''") + "'"
        return '"' + text.replace("\\", "\\\\").replace('"', '\\"').replace("\t", "\\t") + '"'

    def key(self, key):
        return self.quoted(key) if self.rng.random() < 0.15 else key

    def flow(self, tree):
        kind, content = tree
        blank = lambda: self.rng.choice(["", " ", " ", "\n   ", " # in brackets\n "])
        if kind == "map":
            pairs = ["%s: %s" % (self.key(k), self.flow(v)) for k, v in content]
            return "{" + blank() + ("," + blank() or ", ").join(pairs) + self.rng.choice(["", " "]) + "}"
        if kind == "list":
            return "[" + blank() + ("," + blank()).join(self.flow(v) for v in content) + self.rng.choice(["", " "]) + "]"
        return content if kind == "plain" else self.quoted(content)

    def end(self):
        return self.rng.choice(["\n"] * 6 + [" # a comment: [\n", "  \n", "\n\n", "\n# in a line of its own\n"])

    def block(self, tree, indent):
        """The lines of a map or list, each with `indent` blanks."""
        kind, content = tree
        text = ""
        for child in content:
            key, value = child if kind == "map" else (None, child)
            text += " " * indent + (self.key(key) + ":" if kind == "map" else "-")
            text += self.value(value, indent, kind == "map")
        return text

    def value(self, value, indent, of_map):
        """What follows `key:` or `-`."""
        if value[0] in ("plain", "quoted"):
            text = value[1] if value[0] == "plain" else self.quoted(value[1])
            return (" " if self.rng.random() < 0.9 else "\n" + " " * (indent + 2)) + text + self.end()
        if not value[1]:
            return " " + self.flow(value) + self.end()
        deeper = indent + self.rng.randint(1, 4)
        if of_map and value[0] == "list" and self.rng.random() < 0.3:
            deeper = indent
        if not of_map and self.rng.random() < 0.5:
            blanks = self.rng.randint(1, 3)
            return " " * blanks + self.block(value, indent + 1 + blanks).lstrip(" ")
        return self.end() + self.block(value, deeper)

    def plain_document(self):
        """A tree and its text. Both readers must find the tree."""
        keys = self.rng.sample(KEYS, self.rng.randint(1, 4))
        pairs = []
        for key in keys:
            in_flow = self.rng.random() < 0.4
            pairs.append((key, self.tree(3, in_flow), in_flow))
        text = self.rng.choice(["", "", "---\n", "# a comment\n", "\ufeff"])
        for key, value, in_flow in pairs:
            if in_flow:
                text += "%s: %s%s" % (self.key(key), self.flow(value), self.end())
            else:
                text += self.block(("map", [(key, value)]), 0)
        text += self.rng.choice(["", "", "...\n", "\n# end"])
        text = text.replace("\n", self.rng.choice(["\n", "\n", "\r\n", "\r"]))
        return ("map", [(k, v) for k, v, _ in pairs]), text.encode()


# ---- documents that need not be valid

PIECES = [":", ": ", " :", "-", "- ", "? ", "?", "\n", "\n  ", "\n- ", "\n  - ", "\r", "\r\n", "\r  ", "\t", " \t", "#", " # ", "[", "]",
          "{", "}", ", ", ",", "[]", "{}", "&x ", "*x", "*x : ", "!!str ", "!", "!t ", "!!opencv-matrix ", "!!opencv-matrix\n  ", "|\n  ",
          ">\n  ", "|-\n ", "'", '"', "''", "\\", "\\n", "\\'", "\\x41", "\\u0041", "%", "@", "`", "---\n", "\n---\n", "...\n",
          "\n...\n", "\n--- x\n", "%YAML:1.0\n", "%YAML 1.1\n---\n", "%TAG ! tag:x:\n---\n", "\x85", "\u2028", "\u2029", "\ufeff", "\x00",
          "\x0c", "\x0b", "\x7f", "\x9b", "\xa0", "\ufffe", "<<: ", "<<", "~", "null", "yes", "no", "on", "Off", "true", "True", ".inf",
          "-.INF", ".nan", "010", "0o7", "0x1F", "0b11", "1_000", "1:30", "12:30:45", "1e5", "1.5e3", "+1", "08", "1.2.3",
          "2024-01-31", "=", "a", "b", "k: v", "k:v", "k:\n", "a b", "- - x", "a: b: c", "é", "\U0001f600", "  ", "    ", "",
          "'a\n  b'", '"a\n  b"', "a\n   b", "\\\n", "x" * 1100]


def from_pieces(rng, documents):
    text = rng.choice(["", "a: ", "a:\n  ", "a: [", "a: {", "a:\n- ", '"k": ', "a: '"])
    for _ in range(rng.randint(1, 9)):
        text += rng.choice(PIECES)
    if rng.random() < 0.3:
        text = "z: 1\n" + text + "\ny: 2\n"
    return text.encode(errors="surrogatepass")


def mutated(rng, text):
    for _ in range(rng.choice([1, 1, 1, 2, 3])):
        at = rng.randint(0, len(text))
        kind = rng.random()
        if kind < 0.5:
            text = text[:at] + rng.choice(PIECES).encode() + text[at:]
        elif kind < 0.75:
            text = text[:at] + text[at + rng.choice([1, 1, 2, 5]):]
        elif kind < 0.9:
            other = rng.randint(0, len(text))
            text = text[:at] + text[other:other + rng.randint(1, 12)] + text[at:]
        else:
            text = text[:at] + bytes([rng.randrange(256)]) + text[at + 1:]
    return text


def lines_of(rng, presets):
    """Some lines of a preset, from a line that begins no deeper than the next."""
    lines = rng.choice(presets).splitlines(keepends=True)
    most = rng.choice([4, 10, 10, len(lines)])
    first = rng.randrange(len(lines))
    return b"".join(lines[first:first + most])


# ---- PyYAML

def theirs(text):
    """The tree of one document with the types of YAML 1.1, or None."""
    loader = None
    try:
        loader = yaml.SafeLoader(text)
        node = loader.get_single_node()
        return None if node is None else of_node(node, loader)
    except (yaml.YAMLError, ValueError, RecursionError):  # a date of month 13 is a ValueError
        return None


class Unknown(Exception):
    pass


def of_node(node, loader):
    if isinstance(node, yaml.MappingNode):
        if node.tag not in ("tag:yaml.org,2002:map", "tag:yaml.org,2002:opencv-matrix"):
            return ("tagged", node.tag)
        pairs = []
        for key, value in node.value:
            if not isinstance(key, yaml.ScalarNode) or key.tag == "tag:yaml.org,2002:merge":
                return ("key", str(key))
            expected = loader.resolve(yaml.ScalarNode, key.value, (key.style is None, key.style is not None))
            if key.tag != expected:
                return ("key", str(key))
            pairs.append((key.value, of_node(value, loader)))
        return ("map", pairs)
    if isinstance(node, yaml.SequenceNode):
        if node.tag != "tag:yaml.org,2002:seq":
            return ("tagged", node.tag)
        return ("list", [of_node(item, loader) for item in node.value])
    if node.style is None:
        if node.tag != loader.resolve(yaml.ScalarNode, node.value, (True, False)):
            return ("tagged", node.tag)
        return ("plain", node.value, resolved(node, loader))
    if node.style in "'\"":
        return ("quoted", node.value) if node.tag == "tag:yaml.org,2002:str" else ("tagged", node.tag)
    return ("block text", node.value)


def resolved(node, loader):
    try:
        return loader.construct_object(node)
    except (yaml.YAMLError, ValueError):
        return Unknown


# ---- the comparison

# Numbers of JSON and OpenCV that YAML 1.1 takes for words, as yaml.hpp says.
NUMBER_OF_ORDER = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?\Z")


def type_fault(ours, value):
    """What is wrong with the readings of a plain text, or ''. `value`: PyYAML's."""
    text = ours["plain"]
    is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
    if "number" in ours:
        extra = isinstance(value, str) and NUMBER_OF_ORDER.match(text) and float(text) == ours["number"]
        if not extra and not (is_number and float(value) == ours["number"]):
            return "number"
    if "integer" in ours and not (is_number and value == ours["integer"]):
        return "integer"
    if "flag" in ours and not (value is ours["flag"] or (is_number and value in (0, 1) and bool(value) is ours["flag"])):
        return "flag"
    if "word" in ours and not (isinstance(value, (str, bool)) and ours["word"] == text):
        return "word"
    return ""


def difference(ours, their):
    """Where the trees differ, or ''."""
    kind = next(iter(ours))
    if their is None or kind != their[0]:
        return "%s against %s" % (kind, their and their[0])
    if kind in ("plain", "quoted"):
        if ours[kind] != their[1]:
            return "%r against %r" % (ours[kind], their[1])
        if kind == "quoted":
            return "quoted" if set(ours) - {"quoted", "word"} or ours["word"] != their[1] else ""
        fault = type_fault(ours, their[2])
        return fault and "%r read as %s, by PyYAML as %r" % (ours["plain"], fault, their[2])
    if len(ours[kind]) != len(their[1]):
        return "%d children against %d" % (len(ours[kind]), len(their[1]))
    for our, other in zip(ours[kind], their[1]):
        if kind == "map":
            if our[0] != other[0]:
                return "key %r against %r" % (our[0], other[0])
            our, other = our[1], other[1]
        found = difference(our, other)
        if found:
            return found
    return ""


def without_tabs(tree):
    """Any tree with blanks instead of tabs."""
    if isinstance(tree, dict):
        return {k: without_tabs(v) for k, v in tree.items()}
    if isinstance(tree, (list, tuple)):
        return type(tree)(without_tabs(v) for v in tree)
    return tree.replace("\t", " ") if isinstance(tree, str) else tree


def with_blanks_after_keys(text, in_brackets):
    """`key:value` as `key: value`, but not in the first line below a key or `-`, where it is a plain text."""
    lines, below_key, brackets = text.split("\n"), False, 0
    for i, line in enumerate(lines):
        content = re.sub(r"(^|[ \t])#.*", "", line).strip()
        if not below_key and (brackets <= 0 or in_brackets):
            lines[i] = re.sub(r"^([ \t]*[A-Za-z0-9_.][A-Za-z0-9_.-]*):(?=[^ \t])", r"\1: ", line)
        if content:
            below_key = content.endswith(":") or re.search(r"(^| )-$", content) is not None
        bare = re.sub(r"'[^']*'|\"[^\"]*\"", "", content)
        brackets += sum(bare.count(c) for c in "[{") - sum(bare.count(c) for c in "]}")
    return "\n".join(lines)


def extensions_spelled_out(text, spaced=True, unescaped=True, in_brackets=False):
    """The text without what yaml_text.hpp accepts beyond PyYAML. `spaced`: `key:value`, `unescaped`: `\\'`."""
    text = text.decode(errors="replace")  # bytes of any encoding: in comments only
    text = text.removeprefix("\ufeff") if hasattr(text, "removeprefix") else text.lstrip("\ufeff")
    text = re.sub(r"[\x80-\x84\x86-\x9f\ufffe\uffff]", "?", text)
    text = re.sub(r"(?m)^%YAML[: ]1\.\d[ \t]*(#[^\r\n]*)?$(?=[\r\n]|\Z)", "#", text, count=1)
    if spaced:
        text = with_blanks_after_keys(text, in_brackets)
    if unescaped:  # in double quotes only
        unescape = lambda m: re.sub(r"(?<!\\)((?:\\\\)*)\\'", r"\1'", m.group())
        text = re.sub(r'"(?:[^"\\\n]|\\.)*"', unescape, text)
    return text.replace("\t", " ")


def fault(ours, text):
    """Of an accepted document: how it differs from PyYAML's reading, or ''."""
    found = difference(ours, theirs(text))
    if not found:
        return ""
    lf = text.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    ours = without_tabs(ours)
    for choices in itertools.product((True, False), repeat=3):
        if not difference(ours, without_tabs(theirs(extensions_spelled_out(lf, *choices)))):
            return ""
    return found


def same(ours, tree):
    """True if the tree of a plain document was found."""
    kind, content = tree
    if kind not in ours:
        return False
    if kind in ("plain", "quoted"):
        return ours[kind] == content and ("number" in ours) == (kind == "plain" and content in NUMBERS)
    if len(ours[kind]) != len(content):
        return False
    if kind == "map":
        return all(a[0] == b[0] and same(a[1], b[1]) for a, b in zip(ours[kind], content))
    return all(same(a, b) for a, b in zip(ours[kind], content))


def read_all(program, texts):
    stream = b"".join(b"%d\n%s" % (len(text), text) for text in texts)
    done = subprocess.run([program], input=stream, stdout=subprocess.PIPE, check=True)
    return [json.loads(line.decode(errors="replace")) for line in done.stdout.split(b"\n") if line]


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program")
    parser.add_argument("presets")
    parser.add_argument("--documents", type=int, default=20000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--show", action="store_true", help="print every finding")
    options = parser.parse_args()
    began = time.process_time()
    rng = random.Random(options.seed)
    documents = Documents(rng)
    presets = [open(os.path.join(options.presets, name), "rb").read() for name in sorted(os.listdir(options.presets))
               if name.endswith(".yaml")]
    cases = [("preset", None, text) for text in presets]
    while len(cases) < options.documents:
        kind = rng.random()
        if kind < 0.2:
            cases.append(("plain", *documents.plain_document()))
        elif kind < 0.5:
            cases.append(("mutated plain", None, mutated(rng, documents.plain_document()[1])))
        elif kind < 0.75:
            cases.append(("pieces", None, from_pieces(rng, documents)))
        else:
            cases.append(("mutated preset", None, mutated(rng, lines_of(rng, presets))))
    read = read_all(options.program, [text for _, _, text in cases])
    assert len(read) == len(cases)
    accepted, of_kind, findings = collections.Counter(), collections.Counter(), []
    for (kind, tree, text), ours in zip(cases, read):
        of_kind[kind] += 1
        if "error" in ours:
            if len(ours["error"].encode()) > MOST_ERROR_BYTES or not re.search(r"line \d+, column \d+: .", ours["error"]):
                findings.append((kind, "an error without place or end", text))
            if kind in ("plain", "preset"):
                findings.append((kind, ours["error"], text))
            continue
        accepted[kind] += 1
        if tree is not None and not same(ours, tree):
            findings.append((kind, "another tree than was written", text))
        if ours == {"map": []} and theirs(extensions_spelled_out(text)) in (None, ("plain", "", None)):
            continue  # nothing but comments
        found = fault(ours, text)
        if found:
            findings.append((kind, found, text))
    for kind in sorted(of_kind):
        print("%-15s %6d documents, %6d accepted" % (kind, of_kind[kind], accepted[kind]))
    print("%d documents, seed %d, %.1f s of CPU" % (len(cases), options.seed, time.process_time() - began))
    for kind, found, text in findings if options.show else findings[:MOST_FINDINGS_SHOWN]:
        print("%s: %s: %r" % (kind, found, text[:400]))
    print("%d findings" % len(findings))
    return 1 if findings else 0


if __name__ == "__main__":
    sys.exit(main())
