# SPDX-License-Identifier: MIT
"""Calls with a wrong argument answer with its name and the nearest known one, not with a signature."""

from __future__ import annotations

import functools
import inspect
import re
from types import ModuleType
from typing import Any, Callable, Dict, Iterable, List, NamedTuple, Tuple, TypeVar

from . import _core

F = TypeVar("F", bound=Callable[..., Any])

_MISMATCH = "(): incompatible "
"""What pybind11's TypeError says behind the function's name when no argument list fits."""
_SIMPLE = {"float": "a number", "int": "an integer", "bool": "True or False", "str": "a text"}


class _Parameter(NamedTuple):
    name: str
    type: str
    required: bool
    keyword_only: bool


def named_arguments(function: F) -> F:
    """A function of Python whose unknown keyword arguments are answered with the nearest known one."""
    known = _keywords(function)
    name = function.__qualname__.replace(".__init__", "")

    @functools.wraps(function)
    def checked(*args: Any, **kwargs: Any) -> Any:
        check(name, kwargs, known)
        return function(*args, **kwargs)

    return checked  # type: ignore[return-value]


def check(function: str, given: Iterable[str], known: List[str]) -> None:
    """Raises TypeError for the first name that is not known."""
    for name in given:
        if name not in known:
            raise TypeError(f"{function}: " + _core._unknown_name("argument", name, known))


def check_fields(kind: type, given: Iterable[str]) -> None:
    """The same for the arguments of a class."""
    made: Any = getattr(kind, "__init__")
    if made is not object.__init__:
        any_name = any(p.kind is p.VAR_KEYWORD for p in inspect.signature(made).parameters.values())
        if not any_name:
            check(kind.__name__, given, _keywords(made)[1:])


def explain_calls_of(module: ModuleType) -> None:
    """Wraps every compiled function and method of the module. A call that succeeds costs 0.4 us more."""
    for name, member in list(vars(module).items()):
        if isinstance(member, type) and member.__module__ == module.__name__:
            for of_class, method in list(vars(member).items()):
                if of_class == "__init__" or not of_class.startswith("__"):
                    _wrap(member, of_class, method, name if of_class == "__init__" else of_class)
        else:
            _wrap(module, name, member, name)


def _keywords(function: Callable[..., Any]) -> List[str]:
    kinds = (inspect.Parameter.POSITIONAL_OR_KEYWORD, inspect.Parameter.KEYWORD_ONLY)
    return [p.name for p in inspect.signature(function).parameters.values() if p.kind in kinds]


def _wrap(owner: Any, attribute: str, function: Any, shown: str) -> None:
    signature = (getattr(function, "__doc__", None) or "").split("\n", 1)[0]
    if signature.startswith(attribute + "(*args, **kwargs)"):  # overloads, which have no single list
        return
    if not callable(function) or isinstance(function, type) or not signature.startswith(attribute + "("):
        return

    @functools.wraps(function)
    def explained(*args: Any, **kwargs: Any) -> Any:
        try:
            return function(*args, **kwargs)
        except TypeError as error:
            if not re.match(r"(\w|\.)*" + re.escape(attribute + _MISMATCH), str(error)):
                raise
            reason = _reason(_parameters(signature), args, kwargs)
        raise TypeError(f"{shown}: {reason}")

    setattr(owner, attribute, explained)


def _reason(parameters: List[_Parameter], args: Tuple[Any, ...], kwargs: Dict[str, Any]) -> str:
    """Why a call does not fit."""
    if parameters and parameters[0].name == "self":
        parameters, args = parameters[1:], args[1:]
    known = [p.name for p in parameters]
    for name in kwargs:
        if name not in known:
            return str(_core._unknown_name("argument", name, known))
    by_place = [p.name for p in parameters if not p.keyword_only]
    if len(args) > len(by_place):
        return f"at most {len(by_place)} arguments without a name, got {len(args)}; arguments: {', '.join(known)}"
    given = {**dict(zip(by_place, args)), **kwargs}
    for p in parameters:
        if p.required and p.name not in given:
            return f"argument `{p.name}` is missing"
    for p in parameters:
        if p.name in given and not _fits(given[p.name], p.type):
            return f"{p.name}: expected {_SIMPLE.get(p.type, p.type)}, got {_described(given[p.name])}"
    return "expected " + ", ".join(f"{p.name}: {p.type}" for p in parameters)


def _fits(value: Any, kind: str) -> bool:
    """False only where that is certain."""
    if kind == "str":
        return isinstance(value, (str, bytes))
    if kind == "bool":
        return type(value).__name__ in ("bool", "bool_")
    if kind == "int":
        return hasattr(value, "__index__") and -(2**63) <= int(value) < 2**63
    if kind == "float":
        return hasattr(value, "__float__") or hasattr(value, "__index__")
    return not kind.startswith(_core.__name__ + ".") or type(value).__name__ == kind.rsplit(".", 1)[1]


def _described(value: Any) -> str:
    return "None" if value is None else f"a {type(value).__name__}"


def _parameters(signature: str) -> List[_Parameter]:
    """Of "name(self: T, a: float, *, b: int = 0) -> R", as pybind11 writes it."""
    parameters: List[_Parameter] = []
    keyword_only = False
    for part in _split(signature[signature.index("(") + 1 :]):
        keyword_only = keyword_only or part == "*"
        found = re.match(r"(\w+): (.*?)( = .*)?$", part)
        if found:
            parameters.append(_Parameter(found[1], found[2], found[3] is None, keyword_only))
    return parameters


def _split(text: str) -> List[str]:
    """The parts between commas, up to the bracket that closes the list."""
    parts, start, depth = [], 0, 0
    for i, letter in enumerate(text):
        depth += (letter in "([{") - (letter in ")]}")
        if depth < 0 or (letter == "," and depth == 0):
            parts.append(text[start:i].strip())
            start = i + 1
        if depth < 0:
            break
    return [part for part in parts if part]
