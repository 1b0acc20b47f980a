#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The API reference, as Doxygen makes it: without warnings, complete, and the same on every machine.

    check.py DOXYGEN FOLDER SOURCE    makes the pages in FOLDER, which has the Doxyfile, and prints what is wrong

Public is what Doxyfile.in does not exclude. Every public class, struct, enumeration and function has a comment. None is
needed for what C++ itself says of it (`is_plain`) and for functions that override a described one. Numbers say what they
are measured in, points and poses their frame of reference, and functions that throw say so.
"""
import pathlib
import re
import subprocess
import sys
import xml.etree.ElementTree as ElementTree

# Suffixes of names that are units, and what names a unit or a pure number in a comment.
UNIT = re.compile(r"_(px|m|s|ms|us|rad|deg|hz|kb|bytes|m_s|px_s|frames|pixels|m2|px2|features|share|px_m|per_\w+)\d?_?$")
SAID = re.compile(r"\[[^\]]+\]|\b(pixels?|px|metres?|m|seconds?|s|ms|frames?|radians?|degrees?|bytes?|Hz|shares?|matri(x|ces)|ratios?|factors?|"
                  r"probabilit(y|ies)|weights?|units?|squared?|standard deviations?|sigmas?)\b|%")
QUANTITY = re.compile(r"(^|_)(distance|depth|length|radius|age|angle|baseline|duration|timestamp|time|speed|width|height|focal|"
                      r"offset|deviation|leaf|thickness|delay|rotation|translation|sigma|noise|latency)(_|$)")
NUMBER = re.compile(r"^(const |constexpr |static |inline )*(double|float)( &| \*)?$")
POINTS = re.compile(r"Eigen::Vector3[df]|cv::Point3[fd]|WorldPoint\b")
FRAME = re.compile(r"camera|world|reference|frame of|scene|rig\b|any frame|map|own axes|rotation|axis|T_\w+_\w+", re.I)
POSE_NAME = re.compile(r"^T(_[a-z]+)*$|pose|transform|motion", re.I)
DEFINITION = re.compile(r"^(?P<indent>  )?(?=[A-Za-z\[])[^;{}()#]*?(?:\b(?P<owner>\w+)::)?(?P<name>~?\w+)\([^;{}]*\)[^;{}()]*\{", re.M)
CONTAINER = {"begin", "end", "size", "empty", "data", "front", "back"}  # as the standard library's


class Member:
    def __init__(self, element, owner):
        self.kind, self.owner = element.get("kind"), owner
        self.name = element.findtext("name")
        self.arguments = element.findtext("argsstring") or ""
        self.type = text_of(element.find("type"))
        self.comment = comment_of(element)
        self.overrides = element.find("reimplements") is not None or bool(re.search(r"\b(override|final)\b", self.arguments))
        self.parameters = [(text_of(p.find("type")), p.findtext("declname") or "") for p in element.iter("param")]
        place = element.find("location")
        self.file, self.line = place.get("file"), place.get("line")
        self.public = element.get("prot") != "private"

    def place(self):
        return f"{self.file}:{self.line}: {self.owner}::{self.name}"


def text_of(element):
    return "".join(element.itertext()) if element is not None else ""


def comment_of(element):
    return " ".join(" ".join(text_of(element.find(part + "description")).split()) for part in ("brief", "detailed")).strip()


def read(folder):
    """Comments of classes by name, with their places, and all public members."""
    classes, members = {}, {}
    for path in sorted(folder.glob("*.xml")):
        for compound in ElementTree.parse(path).getroot().iter("compounddef"):
            kind, owner = compound.get("kind"), compound.findtext("compoundname")
            if compound.get("prot") == "private":
                continue
            if kind in ("class", "struct", "union"):
                place = compound.find("location")
                classes[owner] = (f"{place.get('file')}:{place.get('line')}", comment_of(compound))
            if kind in ("class", "struct", "union", "namespace", "file", "group"):
                for element in compound.iter("memberdef"):
                    member = Member(element, element.findtext("qualifiedname", owner).rpartition("::")[0] or owner)
                    if member.public:
                        members.setdefault(element.get("id"), member)
    return classes, list(members.values())


def is_plain(member):
    """Constructors without a choice, destructors, assignments, operators, and a container's usual functions."""
    name, own = member.name, member.owner.rpartition("::")[2]
    if name.startswith("~") or re.match(r"operator(=|==|!=|<|\(\)|\*|->|bool|\||&)", name.replace(" ", "")) or name in CONTAINER:
        return True
    if name != own:
        return False
    types = [kind for kind, _ in member.parameters]
    if re.search(r"\bnoexcept\b", member.arguments) or any("detail::" in kind for kind in types):
        return True  # holds what it is given, or is not for users
    return not types or (len(types) == 1 and bool(re.search(rf"\b{own}\b|\b\w*(Params|Options|Config)\b", types[0])))


def undescribed(classes, members):
    described = {(m.owner, m.name, tuple(m.parameters)) for m in members if m.comment}
    for owner, (place, comment) in sorted(classes.items()):
        if not comment:
            yield f"{place}: {owner}: no comment"
    for m in members:
        if m.comment or m.kind not in ("function", "enum"):
            continue
        pair = (m.owner, m.name, tuple(m.parameters)) in described  # const, and not
        if not (m.kind == "function" and (m.overrides or is_plain(m) or pair)):
            yield f"{m.place()}: no comment"


def without_unit(classes, members):
    def lacks(kind, name, comment):
        return bool(NUMBER.match(kind) and QUANTITY.search(name) and not UNIT.search(name) and not SAID.search(comment))

    for m in members:
        comment = m.comment + " " + classes.get(m.owner, ("", ""))[1]
        named = [(m.type, m.name)] if m.kind in ("function", "variable") else []
        for kind, name in named + m.parameters:
            if lacks(kind, name, comment):
                yield f"{m.place()}: `{name}` has no unit"


def without_frame(classes, members):
    for m in members:
        comment = m.comment + " " + classes.get(m.owner, ("", ""))[1]
        for kind, name in [(m.type, m.name)] + m.parameters:
            if POINTS.search(kind) and not FRAME.search(comment + " " + name + " " + kind):
                yield f"{m.place()}: in which frame of reference is `{name}`?"
            if re.search(r"\bPose\b|Isometry3d", kind) and name and not POSE_NAME.search(name) and not FRAME.search(comment):
                yield f"{m.place()}: the pose `{name}` is not of the form T_a_b, and nothing says from where to where"


def throwing(source):
    """Headers, classes and names of functions that throw an exception of ours themselves."""
    found = set()
    for folder in ("include", "plugins/detectors", "plugins/dense", "plugins/recorder"):
        for path in sorted((pathlib.Path(source) / folder).rglob("*.[ch]pp")):
            text = path.read_text()
            for match in DEFINITION.finditer(text):
                body, class_name = body_at(text, match.end() - 1), match.group("owner")
                if re.search(r"\bthrow [A-Z]\w*\(", re.sub(r"\btry \{.*?catch", "", body, flags=re.S)):
                    inner = re.findall(r"^(?:class|struct) (\w+)", text[: match.start()], re.M)
                    class_name = class_name or (inner[-1] if match.group("indent") and inner else "")
                    found.add((stem_of(path), class_name, match.group("name")))
    return found


def stem_of(path):
    return re.sub(r"(-inl)?[.].*", "", pathlib.Path(path).name)


def body_at(text, begin):
    depth = 0
    for at in range(begin, len(text)):
        depth += {"{": 1, "}": -1}.get(text[at], 0)
        if depth == 0:
            return text[begin : at + 1]
    return text[begin:]


def without_errors(classes, members, thrown):
    def key(m):
        return stem_of(m.file), m.owner.rpartition("::")[2] if m.owner in classes else "", m.name

    says = {key(m) for m in members if re.search("[Tt]hrow", m.comment + classes.get(m.owner, ("", ""))[1])}
    for m in members:
        if m.kind == "function" and not m.overrides and key(m) in thrown - says and "&&" not in m.arguments:
            yield f"{m.place()}: throws, and its comment does not say what"


def wrong_pages(folder, source):
    """Rooms, cards and folders of the machine in the pages that people read."""
    html = folder / "html"
    rooms = sorted(path.name for path in (pathlib.Path(source) / "include/dynfilter").iterdir() if path.is_dir())
    for room in [*rooms, "detectors"]:
        page = html / f"group__{room}.html"
        if not page.exists() or "Classes</h2>" not in page.read_text():
            yield f"{page.name}: no group, or no class in it"
    for card in sorted((pathlib.Path(source) / "docs/reference/filters").glob("[!R]*.md")):
        if not any(f"card_{card.stem}.html" in page.read_text() for page in html.glob("classdynfilter_*Filter.html")):
            yield f"{card.name}: no class refers to this card"
    for page in sorted(html.rglob("*")):
        if page.is_file() and any(str(place).encode() in page.read_bytes() for place in (source, folder)):
            yield f"{page.name}: names a folder of this machine"


def main(arguments):
    doxygen, folder, source = arguments[0], pathlib.Path(arguments[1]), arguments[2]
    run = subprocess.run([doxygen, "Doxyfile"], cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    faults = run.stderr.splitlines()
    classes, members = read(folder / "xml")
    for find in (undescribed, without_unit, without_frame):
        faults += find(classes, members)
    faults += without_errors(classes, members, throwing(source))
    faults += wrong_pages(folder, source)
    for fault in faults:
        print(fault.replace(source + "/", ""))
    print(f"reference: {len(classes)} classes, {len(members)} members, {len(faults)} faults")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
