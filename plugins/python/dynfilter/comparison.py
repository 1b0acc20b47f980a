# SPDX-License-Identifier: MIT
"""Runs and their comparison: printed, and as tables for a paper."""

from __future__ import annotations

import importlib
import io
import math
import os
from dataclasses import dataclass, field
from typing import Any, List, Optional, Sequence as Many, Tuple, Union

from . import _core
from .errors import Error, IoError
from .sequences import Trajectory

Path = Union[str, "os.PathLike[str]"]


@dataclass
class Run:
    """One pipeline on one sequence or scene. NaN where there is nothing to compare with."""

    pipeline: str
    sequence: str
    scene: str = ""
    """Runs of one scene are pooled: seeds of a rendered scene, variants of a recording."""
    variant: str = ""
    """"reverse from 5"; "" for a whole sequence."""
    alignment: str = "SE(3)"
    """Of the ATE; "Sim(3)" for one camera, which has no scale of its own."""
    frames: int = 0
    tracked_frames: int = 0
    """Read it beside the ATE: lost frames flatter the ATE."""
    ate_rmse_m: float = math.nan
    rpe_trans_rmse_m: float = math.nan
    rpe_rot_rmse_deg: float = math.nan
    precision: float = math.nan
    recall: float = math.nan
    """Share of the dynamic features that were rejected."""
    static_kept: float = math.nan
    """Share of the static features that were kept."""
    judge_ms: float = math.nan
    """Median time of all calls of the pipeline, per frame."""
    cpu_ms: float = math.nan
    """Median CPU time of all threads per frame, odometry included."""
    first_s: float = math.nan
    """Stamp of the first frame."""
    last_s: float = math.nan
    failure: str = ""
    """A stage that failed in every frame. The other figures are then NaN: they would be of another pipeline."""
    notes: List[str] = field(default_factory=list, repr=False)
    """Stages that were skipped or failed, with the number of frames."""
    trajectory: Optional[Trajectory] = field(default=None, repr=False)
    _record: Any = field(default=None, repr=False, compare=False)
    """Frames and pictures for a report."""


class Comparison(List[Run]):
    """Runs, printed as a table. `to_...` have a row per scene and pipeline: median, worst, mean, std of its runs."""

    reference: str = ""
    """The pipeline that the test of the differences compares with; "": `none`, else the first one."""

    _COLUMNS: Many[Tuple[str, str, str]] = (
        ("tracked", "tracked", ""),
        ("ATE m", "ate_rmse_m", ".4f"),
        ("RPE m", "rpe_trans_rmse_m", ".4f"),
        ("precision", "precision", ".3f"),
        ("recall", "recall", ".3f"),
        ("kept", "static_kept", ".3f"),
        ("ms", "judge_ms", ".2f"),
    )

    def _table(self) -> List[List[str]]:
        columns = [c for c in self._COLUMNS if c[1] == "tracked" or any(_known(run, c[1]) for run in self)]
        states = [["", "failed"]] if any(run.failure for run in self) else []
        rows = [["sequence", "pipeline"] + [title for title, _, _ in columns] + [""] * len(states)]
        for run in self:
            cells = [run.sequence, run.pipeline]
            for _, key, shape in columns:
                if key == "tracked":
                    cells.append(f"{run.tracked_frames}/{run.frames}")
                else:
                    cells.append(format(getattr(run, key), shape) if _known(run, key) else "-")
            rows.append(cells + [state[bool(run.failure)] for state in states])
        return rows

    def _notes(self) -> List[str]:
        """Each once, with its pipelines unless it is of all."""
        of: "dict[str, List[str]]" = {}
        for run in self:
            for note in (["failed: " + run.failure] if run.failure else []) + run.notes:
                names = of.setdefault(f"{run.sequence}: {note}", [])
                if run.pipeline not in names:
                    names.append(run.pipeline)
        every = len({run.pipeline for run in self})
        return [f"note: {note}" + (f" ({', '.join(names)})" if len(names) < every else "") for note, names in of.items()]

    def __str__(self) -> str:
        rows = self._table()
        wide = [max(len(row[i]) for row in rows) for i in range(len(rows[0]))]
        lines = [
            "  ".join(cell.ljust(w) if i < 2 else cell.rjust(w) for i, (cell, w) in enumerate(zip(row, wide))).rstrip()
            for row in rows
        ]
        notes = self._notes()
        return "\n".join(lines + ([""] + notes if notes else []))

    def markdown(self) -> str:
        """The table as Markdown."""
        head, *rows = self._table()
        lines = [head, ["---", "---"] + ["---:"] * (len(head) - 2)] + rows
        return "\n".join("| " + " | ".join(row) + " |" for row in lines)

    def _repr_html_(self) -> str:
        head, *rows = ("".join(f"<td>{cell}</td>" for cell in row) for row in self._table())
        return f"<table><tr>{head}</tr>{''.join(f'<tr>{row}</tr>' for row in rows)}</table>"

    def to_latex(self, path: Optional[Path] = None) -> str:
        """The table for a paper: needs \\usepackage{booktabs}. `path`: also writes it there."""
        return self._paper("latex", path)

    def to_markdown(self, path: Optional[Path] = None) -> str:
        """The table for a paper as Markdown. `path`: also writes it there."""
        return self._paper("markdown", path)

    def to_csv(self, path: Optional[Path] = None) -> str:
        """The same with all digits. `path`: also writes it there."""
        return self._paper("csv", path)

    def to_dataframe(self) -> Any:
        """The columns of to_csv() as a pandas.DataFrame. Raises ImportError without pandas."""
        try:
            pandas = importlib.import_module("pandas")
        except ImportError as error:
            raise ImportError("to_dataframe() needs pandas (`pip install pandas`); to_csv() does not") from error
        return pandas.read_csv(io.StringIO(self.to_csv()), keep_default_na=False, na_values=[""])

    def report(self, path: Path) -> str:
        """Writes one HTML page with figures, plots and pictures of all runs on sequences, and returns its path.

        Raises Error without such runs: on exact scenes, and with `pictures=False`, nothing is recorded.
        """
        recorded = [run for run in self if run._record is not None]
        if not recorded:
            raise Error("report: no run is on a sequence and has pictures; compare() makes some, without pictures=False")
        return _write(path, _core._compare_page(recorded, self.reference))

    def _paper(self, format: str, path: Optional[Path]) -> str:
        text = _core._paper_table(format, self, self.reference)
        if path is not None:
            _write(path, text)
        return text


def _write(path: Path, text: str) -> str:
    try:
        with open(path, "w", encoding="utf-8") as file:
            file.write(text)
    except OSError as error:
        raise IoError(f"{os.fspath(path)}: cannot be written: {error.strerror}") from error
    return os.fspath(path)


def _known(run: Run, key: str) -> bool:
    return not math.isnan(getattr(run, key))
