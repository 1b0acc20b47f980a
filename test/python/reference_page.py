# SPDX-License-Identifier: MIT
"""docs/reference/python.md, made of the stubs and the docstrings."""

import ast
import inspect
import re
from pathlib import Path

import dynfilter

SECTIONS = {
    "Judge features": "Pipeline Verdict Report StageReport Camera Detection Keyframe MotionPrior Gyroscope keypoint_type UNKNOWN STATIC DYNAMIC",
    "Write a filter": "Filter param Evidence Match TwoView Votes",
    "Sequences and scenes": "Sequence Recording RenderedSequence render scene_names Frame "
    "ExactScene ExactFrame MovingBox exact_scene_names",
    "Run and compare": "run run_scene compare judge Run Comparison Judgement to_rerun Odometry Track has_odometry",
    "Trajectories and counts": "ate Ate rpe Rpe Statistics Score Classification read_trajectory write_trajectory",
    "The dense map": "StaticMap MapReport",
    "Files, filters and errors": "read_camera read_detections read_gyroscope presets filter_cards FilterCard Parameter load_plugin "
    "__version__ Error ConfigError IoError PluginError",
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

Every name of the package. `help(dynfilter.NAME)` says more: arguments, shapes, types and units.
`x=` need not be given. After a class are its properties and functions. A test writes this page.
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


def members(what):
    """Names of properties and, with brackets, of functions."""
    bases = [base for base in what.__mro__[1:] if base.__name__ in dynfilter.__all__]  # which have rows of their own
    return [
        name + ("()" if inspect.isroutine(member) else "")
        for name, member in vars(what).items()
        if not name.startswith("_") and not isinstance(member, type) and not any(name in vars(base) for base in bases)
    ]


def entry(name, known):
    what = getattr(dynfilter, name)
    if name in VALUES:
        return f"`{name}`", VALUES[name]
    if not inspect.isclass(what):
        return f"`{name}({signature(name, what, known)})`", summary(what)
    names = members(what)
    return f"**{name}**", summary(what) + (f". `{' '.join(names)}`" if names else "")


def page():
    known = stubs()
    text = HEAD
    for section, names in SECTIONS.items():
        text += f"\n## {section}\n\n| | |\n|---|---|\n"
        for name in names.split():
            if not hasattr(dynfilter, name):  # without the odometry
                continue
            text += "| {} | {} |\n".format(*entry(name, known))
    return text
