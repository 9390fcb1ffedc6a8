"""Other people's files: loggers' text files and bags in, bags for viewers out."""

from __future__ import annotations

import json
import os
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pandas as pd

from . import _spinebench as _core
from ._calculations import PathLike, Recording, _Columns, _recorded, _source
from ._spinebench import Model

_Clock = tuple[int | None, float, tuple[float, float], float, float]
Map = PathLike | Mapping[str, Any]
"""A map: a YAML file, or what such a file holds (docs/importing.md)."""


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


@dataclass(frozen=True)
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


def _map_file(given: Map, folder: str) -> Path:
    if not isinstance(given, Mapping):
        return Path(given)
    file = Path(folder) / "map.yaml"
    # YAML holds JSON.
    file.write_text(json.dumps(given), encoding="utf-8")
    return file


def _imported(told: tuple[_Columns, list[_Clock], list[Path], list[str]]) -> ImportedRecording:
    columns, fits, passed_over, notes = told
    by_trial = {
        trial: ClockFit(offset_s, interval_95_s, lag_s, explained)
        for trial, offset_s, interval_95_s, lag_s, explained in fits
    }
    clocks = {trial: fit for trial, fit in by_trial.items() if trial is not None}
    return ImportedRecording(_recorded(columns), by_trial.get(None), clocks, passed_over, notes)


def import_csv(files: PathLike | Sequence[PathLike], map: Map) -> ImportedRecording:
    """Read text files of any logger by a map of their columns (docs/importing.md). Raises InputError with file and line.

    `files` is one file or several. A folder stands for its files, `*` and `?` in a name for characters; then the map's
    `trial_files` says which files are trials.
    """
    logs = [Path(files)] if isinstance(files, (str, os.PathLike)) else [Path(file) for file in files]
    with tempfile.TemporaryDirectory() as folder:
        return _imported(_core._import_csv(logs, _map_file(map, folder)))


def import_mcap(bag: PathLike, map: Map) -> ImportedRecording:
    """Read a bag of ROS 2 (MCAP) by a map of its topics (docs/importing.md). Raises InputError with file and topic."""
    with tempfile.TemporaryDirectory() as folder:
        return _imported(_core._import_mcap(Path(bag), _map_file(map, folder)))


def export_mcap(
    recording: Recording,
    out: PathLike,
    *,
    model: Model | None = None,
    residuals: Recording | None = None,
    static: bool = False,
) -> None:
    """Write a recording as MCAP, which Foxglove opens: poses, commands, with a model the robot as a line, with the table
    `residuals` of a discovery what the models leave."""
    with tempfile.TemporaryDirectory() as folder:
        table = residuals
        if isinstance(table, pd.DataFrame):
            place = Path(folder) / "residuals.csv"
            # Tables of the program write `true` and `false`.
            table = table.copy()
            for name in table.select_dtypes("bool").columns:
                table[name] = table[name].astype(str).str.lower()
            table.to_csv(place, index=False)
            table = place
        _core._export_mcap(_source(recording, "recording"), Path(out), model, None if table is None else Path(table), static)
