"""Import text files of loggers and bags; export bags for viewers."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pandas as pd

from . import _notebook, _plots
from . import _spinebench as _core
from ._recordings import Columns, ModelLike, PathLike, Recording, frame_of_columns, source

_Clock = tuple[int | None, float, tuple[float, float], float, float]
Map = PathLike | Mapping[str, Any]
"""A map: a YAML file, or its content as a mapping (docs/reference/importing.md)."""


@dataclass(frozen=True)
class ClockFit:
    """A clock offset estimated from the motion."""

    offset_s: float
    """Seconds added to the tracker's times."""
    interval_95_s: tuple[float, float]
    """Its 95 % interval, seconds."""
    lag_s: float
    """Fitted time constant of the lag from command to tip, seconds."""
    explained: float
    """Share of the tip's motion that the commands explain."""


@dataclass(frozen=True, repr=False)
class ImportedRecording:
    """The result of an import."""

    recording: pd.DataFrame
    """The recording."""
    clock: ClockFit | None
    """The clock offset, if the map requests an estimate and one log contains all trials."""
    clocks: dict[int, ClockFit] = field(default_factory=dict)
    """The clock offset of each trial, if the map requests estimates and each trial has its own files."""
    passed_over: list[Path] = field(default_factory=list)
    """Files whose names match no pattern of the map's `trial_files`."""
    notes: list[str] = field(default_factory=list)
    """Possible mistakes and ignored rows, one sentence each."""

    def __repr__(self) -> str:
        rows, trials = len(self.recording), self.recording["trial"].nunique()
        return f"ImportedRecording({rows} rows, {trials} trials, {len(self.notes)} notes)"

    def _repr_html_(self) -> str:
        return _notebook.recording(self)

    def plot(self, **options: Any) -> Any:
        """Tip and commands over time; `spinebench.plot` has the options."""
        return _plots.plot(self, **options)


def _map(given: Map) -> Path | tuple[str, str]:
    """What a map is read from: a file, or what messages call it with its text."""
    # YAML holds JSON.
    return ("map", json.dumps(given)) if isinstance(given, Mapping) else Path(given)


def _imported(told: tuple[Columns, list[_Clock], list[Path], list[str]]) -> ImportedRecording:
    columns, fits, passed_over, notes = told
    by_trial = {
        trial: ClockFit(offset_s, interval_95_s, lag_s, explained)
        for trial, offset_s, interval_95_s, lag_s, explained in fits
    }
    clocks = {trial: fit for trial, fit in by_trial.items() if trial is not None}
    return ImportedRecording(frame_of_columns(columns), by_trial.get(None), clocks, passed_over, notes)


def import_csv(files: PathLike | Sequence[PathLike], map: Map) -> ImportedRecording:
    """Read text files of any logger by a map of their columns (docs/reference/importing.md). Raises InputError with file and line.

    `files` is one file or several. A folder is replaced by its files; `*` and `?` in a name match characters. In both
    cases the map's `trial_files` selects the files of trials.
    """
    logs = [Path(files)] if isinstance(files, (str, os.PathLike)) else [Path(file) for file in files]
    return _imported(_core._import_csv(logs, _map(map)))


def import_mcap(bag: PathLike, map: Map) -> ImportedRecording:
    """Read a bag of ROS 2 (MCAP) by a map of its topics (docs/reference/importing.md). Raises InputError with file and topic."""
    return _imported(_core._import_mcap(Path(bag), _map(map)))


def export_mcap(
    recording: Recording,
    out: PathLike,
    *,
    model: ModelLike | None = None,
    residuals: Recording | None = None,
    static: bool = False,
) -> None:
    """Write a recording as MCAP, which Foxglove opens: poses and commands; with `model` also the simulated robot as a
    line; with `residuals`, a table of a discovery, also the residuals of its models."""
    table = None if residuals is None else source(residuals, "residuals")
    _core._export_mcap(source(recording, "recording"), Path(out), model, table, static)
