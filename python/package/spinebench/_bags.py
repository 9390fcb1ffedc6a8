"""Other people's files: loggers' text files and bags in, bags for viewers out."""

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
"""A map: a YAML file, or what such a file holds (docs/reference/importing.md)."""


@dataclass(frozen=True)
class ClockFit:
    """An offset between two clocks that was estimated from the motion."""

    offset_s: float
    """Seconds that are added to the tracker's times."""
    interval_95_s: tuple[float, float]
    """Its 95 % interval, seconds."""
    lag_s: float
    """Time constant of the lag from command to tip that was fitted with it, seconds."""
    explained: float
    """Share of the tip's motion that the commands explain."""


@dataclass(frozen=True, repr=False)
class ImportedRecording:
    """What an import gives."""

    recording: pd.DataFrame
    """The recording."""
    clock: ClockFit | None
    """The offset of the clocks, where the map asks for an estimate and one log holds all trials."""
    clocks: dict[int, ClockFit] = field(default_factory=dict)
    """The offset of each trial's clocks, where the map asks for estimates and each trial has files of its own."""
    passed_over: list[Path] = field(default_factory=list)
    """Files whose names fit no pattern of the map's `trial_files`."""
    notes: list[str] = field(default_factory=list)
    """What looks like a mistake, and which rows do not count, one sentence each."""

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

    `files` is one file or several. A folder stands for its files, `*` and `?` in a name for characters; then the map's
    `trial_files` says which files are trials.
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
    """Write a recording as MCAP, which Foxglove opens: poses, commands, with a model the robot as a line, with the table
    `residuals` of a discovery what the models leave."""
    table = None if residuals is None else source(residuals, "residuals")
    _core._export_mcap(source(recording, "recording"), Path(out), model, table, static)
