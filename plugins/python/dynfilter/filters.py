# SPDX-License-Identifier: MIT
"""Filters written in Python."""

from __future__ import annotations

import dataclasses
import inspect
import math
import re
import typing
from dataclasses import dataclass
from typing import Any, Dict, Iterable, List, Optional, Tuple, Type, TypeVar, Union

from . import _core
from .errors import ConfigError
from .keywords import check_fields, named_arguments

T = TypeVar("T")
Names = Union[str, Iterable[str]]

registered: Dict[str, Type["Filter"]] = {}
"""The filters that pipelines may name, beside those of the toolkit and of plugins."""


@named_arguments
def param(default: T, *, unit: str = "", min: float = -math.inf, max: float = math.inf, doc: str = "") -> T:
    """A parameter of a filter, with its unit, range (both ends included) and meaning."""
    about = {"unit": unit, "min": min, "max": max, "doc": doc}
    value: Any = default
    made: Any = (
        dataclasses.field(default_factory=value.copy, metadata=about)
        if isinstance(value, list)
        else dataclasses.field(default=value, metadata=about)
    )
    return typing.cast(T, made)


@dataclass(frozen=True)
class Field:
    """A parameter as the reader of YAML and the cards need it."""

    name: str
    kind: str
    unit: str
    default: str
    range: str
    doc: str
    min: float
    max: float
    choices: List[str]


class Filter:
    """Base of filters. A subclass is registered under its name and can then be named in YAML.

    ::

        @dataclass
        class TooNear(dynfilter.Filter, name="too_near", needs="depth"):
            \"\"\"Rejects features nearer than a limit.\"\"\"
            min_depth_m: float = dynfilter.param(0.5, unit="m", min=0, max=10, doc="nearer features are dynamic")

            def apply(self, evidence, votes):
                votes.dynamic(evidence.depths_m < self.min_depth_m)

    Arguments of the class:

    `name`: in YAML; without it the class's name in snake_case.
    `needs`: inputs without which a frame skips the filter, as text or list: grey, depth, camera, pose, boxes,
    mask, descriptors, map_points, keyframes, matches.
    `optional`: inputs that are used where a frame has them.
    `history_frames`: how many earlier frames it looks at; 1 if it needs matches.

    A filter judges one camera stream. It may keep state between frames.
    """

    name: typing.ClassVar[str] = ""
    summary: typing.ClassVar[str] = ""
    needs: typing.ClassVar[Tuple[str, ...]] = ()
    optional: typing.ClassVar[Tuple[str, ...]] = ()
    history_frames: typing.ClassVar[int] = 0

    def __init_subclass__(
        cls,
        *,
        name: Optional[str] = None,
        needs: Names = (),
        optional: Names = (),
        history_frames: Optional[int] = None,
        **kwargs: Any,
    ) -> None:
        super().__init_subclass__(**kwargs)
        cls.name = name or _snake_case(cls.__name__)
        cls.needs, cls.optional = _words(needs), _words(optional)
        uses_matches = "matches" in cls.needs + cls.optional
        cls.history_frames = history_frames if history_frames is not None else int(uses_matches)
        cls.summary = _first_line(cls)
        _core._check_inputs(cls.needs + cls.optional)
        if _core.is_compiled_filter(cls.name):
            raise ConfigError(f"a filter named `{cls.name}` comes with dynfilter: choose another name")
        registered[cls.name] = cls

    def __new__(cls, *args: Any, **kwargs: Any) -> "Filter":
        check_fields(cls, kwargs)
        return super().__new__(cls)

    def apply(self, evidence: _core.Evidence, votes: _core.Votes) -> None:
        """Casts votes for the features of one frame. What gets no vote is unknown, and kept."""
        raise NotImplementedError(f"{type(self).__name__}.apply(evidence, votes)")

    def reset(self) -> None:
        """Clears the state of earlier frames: on loss of tracking, or when time jumps."""

    @classmethod
    def _fields(cls) -> List[Field]:
        if not dataclasses.is_dataclass(cls):
            return []
        types = typing.get_type_hints(cls)
        return [_field(f, types[f.name]) for f in dataclasses.fields(cls) if f.init]


_KINDS = {
    float: "number",
    int: "integer",
    bool: "flag",
    str: "text",
    List[str]: "list of words",
    List[float]: "list of numbers",
    List[int]: "list of integers",
    list[str]: "list of words",
    list[float]: "list of numbers",
    list[int]: "list of integers",
}


def _field(field: "dataclasses.Field[Any]", kind: Any) -> Field:
    choices = [str(c) for c in typing.get_args(kind)] if typing.get_origin(kind) is typing.Literal else []
    if not choices and kind not in _KINDS:
        raise ConfigError(f"{field.name}: parameters are {', '.join(sorted(set(_KINDS.values())))} or a Literal")
    low, high = field.metadata.get("min", -math.inf), field.metadata.get("max", math.inf)
    return Field(
        name=field.name,
        kind="choice" if choices else _KINDS[kind],
        unit=field.metadata.get("unit", ""),
        default=_shown(field),
        range=", ".join(choices) if choices else _range(low, high),
        doc=field.metadata.get("doc", ""),
        min=low,
        max=high,
        choices=choices,
    )


def _shown(field: "dataclasses.Field[Any]") -> str:
    if field.default is not dataclasses.MISSING:
        value = field.default
    elif field.default_factory is not dataclasses.MISSING:
        value = field.default_factory()
    else:
        return "required"
    if isinstance(value, bool):
        return "true" if value else "false"
    return f"[{', '.join(map(str, value))}]" if isinstance(value, list) else f"{value}"


def _range(low: float, high: float) -> str:
    if math.isinf(low) and math.isinf(high):
        return ""
    if math.isinf(high):
        return f"at least {low:g}"
    return f"at most {high:g}" if math.isinf(low) else f"{low:g} to {high:g}"


def _words(names: Names) -> Tuple[str, ...]:
    return tuple(names.replace(",", " ").split()) if isinstance(names, str) else tuple(names)


def _snake_case(name: str) -> str:
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", name).lower()


def _first_line(cls: type) -> str:
    text = inspect.cleandoc(cls.__dict__.get("__doc__") or "")
    return text.split("\n", 1)[0].rstrip(".")
