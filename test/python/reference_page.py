# SPDX-License-Identifier: MIT
"""docs/reference/python.md, made of the stubs and the docstrings."""

import ast
import inspect
import re
from pathlib import Path

import dynfilter

SECTIONS = {
    "Judge features": "Pipeline Verdict Report StageReport Camera Detection Keyframe keypoint_type UNKNOWN STATIC DYNAMIC",
    "Write a filter": "Filter param Evidence Match TwoView Votes",
    "Sequences": "Sequence Recording RenderedSequence render scene_names Frame",
    "Run and compare": "run run_scene compare judge Run Comparison Judgement to_rerun Odometry Track has_odometry",
    "Scenes with exact answers": "ExactScene ExactFrame MovingBox exact_scene_names",
    "Trajectories and counts": "ate Ate rpe Rpe Statistics Score Classification",
    "Files": "read_trajectory write_trajectory read_camera read_detections",
    "The dense map": "StaticMap MapReport",
    "What there is": "presets filter_cards FilterCard Parameter load_plugin __version__",
    "Errors": "Error ConfigError IoError PluginError",
}
SHORT = 52  # characters of a summary, if it has more and can be cut at a comma
MANY = 10  # arguments that need not be given; of more the page has none
# Values, whose docstrings are those of int and bool.
VALUES = {
    "keypoint_type": "Type of a structured array of keypoints, the fastest way to pass them",
    "UNKNOWN": "0, in `decision`",
    "STATIC": "1, in `decision`",
    "DYNAMIC": "2, in `decision`: rejected",
    "has_odometry": "Whether the package was built with the odometry",
    "__version__": "The version of dynfilter",
}
HEAD = """# Python reference

`help(dynfilter.NAME)` says more: shapes, types and units of everything. `x=` need not be given. Names
after the sentence on a class are its properties. A test writes this page from the docstrings.
[Use dynfilter from Python](../how-to/python.md) has examples, and what a verdict has.
"""


def stubs():
    """Arguments by `Class.function` and `function`, as the stub of the compiled part has them."""
    tree = ast.parse((Path(dynfilter.__file__).parent / "_core.pyi").read_text())
    found = {}
    for node in ast.walk(tree):
        for child in getattr(node, "body", []) if isinstance(node, (ast.Module, ast.ClassDef)) else []:
            if isinstance(child, ast.FunctionDef):
                owner = node.name + "." if isinstance(node, ast.ClassDef) else ""
                found.setdefault(owner + child.name, arguments(child.args))
    return found


def arguments(args):
    """Their names, with `=` after those that need not be given. `...`: many of these."""
    plain = [*args.posonlyargs, *args.args]
    defaults = [None] * (len(plain) - len(args.defaults)) + args.defaults
    parts = [named(arg, default) for arg, default in zip(plain, defaults) if arg.arg != "self"]
    if args.vararg:
        parts.append("*" + args.vararg.arg)
    elif args.kwonlyargs:
        parts.append("*")
    optional = sum(default is not None for default in [*defaults, *args.kw_defaults])
    keywords = list(zip(args.kwonlyargs, args.kw_defaults))
    parts += [named(arg, default) for arg, default in keywords if optional <= MANY or default is None]
    parts += ["..."] if optional > MANY else []
    return ", ".join(parts + (["**" + args.kwarg.arg] if args.kwarg else []))


def named(arg, default):
    return arg.arg + ("=" if default is not None else "")


def signature(name, what, known):
    if name in known:
        return known[name]
    tree = ast.parse(inspect.cleandoc("\n" + inspect.getsource(what)))
    return arguments(tree.body[0].args)


def summary(what):
    """The first sentence or line, or its beginning, without the signature that pybind11 puts first."""
    text = inspect.getdoc(what) or ""
    text = re.sub(r"\A\w+\(.*\n*", "", text).split("\n\n")[0].replace("\n", " ")
    text = re.split(r"(?<=[.])\s+(?=[A-Z`])|; ", text.strip())[0].removesuffix(".").replace("|", "\\|")
    ends = [m.start() for m in re.finditer(r", (?=where|as |after|for|or |fitted|without|and )", text) if SHORT / 2 < m.start() <= SHORT]
    whole = [end for end in ends if text[:end].count("(") == text[:end].count(")")]
    return text[: whole[-1]] if whole and len(text) > SHORT else text


def members(owner, what, known):
    """Rows of functions, and the names of properties."""
    rows, rest = [], []
    bases = [base for base in what.__mro__[1:] if base.__name__ in dynfilter.__all__]  # which have rows of their own
    for name, member in vars(what).items():
        if name.startswith("_") or isinstance(member, type) or any(name in vars(base) for base in bases):
            continue
        if inspect.isroutine(member):
            rows.append((f".{name}({signature(f'{owner}.{name}', member, known)})", summary(member)))
        else:
            rest.append(name)
    return rows, rest


def entry(name, known):
    what = getattr(dynfilter, name)
    if name in VALUES:
        return [(name, VALUES[name])]
    if not inspect.isclass(what):
        return [(f"{name}({signature(name, what, known)})", summary(what))]
    rows, rest = members(name, what, known)
    text = summary(what) + (f". `{' '.join(rest)}`" if rest else "")
    return [(f"**{name}**", text), *rows]


def page():
    known = stubs()
    text = HEAD
    for section, names in SECTIONS.items():
        text += f"\n## {section}\n\n| | |\n|---|---|\n"
        for name in names.split():
            if not hasattr(dynfilter, name):  # without the odometry
                continue
            for what, says in entry(name, known):
                code = what if what.startswith("**") else f"`{what}`"
                text += f"| {code} | {says} |\n"
    return text
