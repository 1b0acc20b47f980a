# SPDX-License-Identifier: MIT
"""The stubs are those of the module, and mypy agrees with package and examples."""

import ast
import inspect
import re
from pathlib import Path

import dynfilter
from dynfilter import _core

PACKAGE = Path(dynfilter.__file__).parent


def public(names):
    return {name for name in names if not name.startswith("__") or name in ("__init__", "__len__")}


def arguments_in_stub(function):
    a = function.args
    return [arg.arg for arg in a.posonlyargs + a.args] + (["*"] if a.kwonlyargs else []) + [k.arg for k in a.kwonlyargs]


def arguments_at_runtime(doc):
    """From pybind11's first line: `f(self: T, a: int = 0, *, b: handle = (1, 2)) -> None`."""
    inside = re.match(r"\w+\((.*)\)( ->.*)?$", doc.strip().splitlines()[0]).group(1)
    depth, parts = 0, [""]
    for c in inside:
        depth += (c in "([{<") - (c in ")]}>")
        if c == "," and depth == 0:
            parts.append("")
        else:
            parts[-1] += c
    return [part.split(":")[0].split("=")[0].strip() for part in parts if part.strip()]


def members(node):
    return {item.name: item for item in node.body if isinstance(item, ast.FunctionDef)}


def test_stub_is_the_module():
    tree = ast.parse((PACKAGE / "_core.pyi").read_text())
    classes = {node.name: node for node in tree.body if isinstance(node, ast.ClassDef)}
    functions = {node.name: node for node in tree.body if isinstance(node, ast.FunctionDef)}
    at_runtime = {name: value for name, value in vars(_core).items() if not name.startswith("__")}
    assert set(classes) == {name for name, value in at_runtime.items() if inspect.isclass(value)}
    assert set(functions) == {name for name, value in at_runtime.items() if inspect.isbuiltin(inspect.unwrap(value))}
    for name, node in functions.items():
        assert arguments_in_stub(node) == arguments_at_runtime(at_runtime[name].__doc__), name
    for name, node in classes.items():
        own = vars(at_runtime[name])
        stub = members(node)
        fields = {item.target.id for item in node.body if isinstance(item, ast.AnnAssign)}
        made = {"__init__"} if "(self: " not in str(own.get("__init__").__doc__) else set()
        assert public(own) - made - {"_pybind11_conduit_v1_"} == public(stub) | fields, name
        for method, function in stub.items():
            is_property = any(isinstance(d, ast.Name) and d.id == "property" for d in function.decorator_list)
            assert isinstance(own[method], property) == is_property, f"{name}.{method}"
            if not is_property and method not in ("__eq__", "__len__") and function.args.kwarg is None:
                assert arguments_in_stub(function) == arguments_at_runtime(own[method].__doc__), f"{name}.{method}"


def test_everything_is_documented():
    undocumented = [
        name for name in dynfilter.__all__ if inspect.isclass(getattr(dynfilter, name)) and not getattr(dynfilter, name).__doc__
    ]
    assert undocumented == []
    for name in ("before_pose", "reset", "update_pose"):
        assert getattr(dynfilter.Pipeline, name).__doc__
    for line in dynfilter.Pipeline.before_pose.__doc__.splitlines()[2:]:
        assert len(line) <= 120


def test_mypy(root, tmp_path):
    from mypy import api

    files = [str(path) for path in sorted((root / "examples/python").glob("*.py"))]
    package = [str(path) for path in sorted(PACKAGE.glob("*.py*")) if path.suffix in (".py", ".pyi")]
    import os

    os.environ["MYPYPATH"] = str(PACKAGE.parent)
    options = ["--config-file", str(root / "pyproject.toml"), "--cache-dir", str(tmp_path)]
    for wanted in (["-p", "dynfilter"], files):
        text, errors, code = api.run(options + wanted)
        assert code == 0, text + errors
    assert package and files
