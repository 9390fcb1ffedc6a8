"""Recordings: files, or frames with the same columns."""

from __future__ import annotations

import io
import math
import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from ._errors import InputError
from ._spinebench import Model

PathLike = str | os.PathLike[str]
"""Name of a file."""
ModelLike = Model | PathLike
"""A model, or the name of its file."""
Recording = str | os.PathLike[str] | pd.DataFrame
"""A recording: a CSV or Parquet file, or a frame with the same columns (docs/reference/outputs.md)."""
Cells = NDArray[Any] | list[str]
"""Flags, whole numbers, numbers (NaN for an empty cell) or text (empty for an empty cell)."""
Columns = list[tuple[str, Cells]]
"""Columns by name."""
Source = Path | tuple[str, Columns]
"""Source of a recording: a file, or a name for messages with the columns of a frame."""


def frame_of_csv(csv: bytes) -> pd.DataFrame:
    """The frame of a table."""
    return pd.read_csv(io.BytesIO(csv)) if csv.strip() else pd.DataFrame()


def frame_of_columns(columns: Columns) -> pd.DataFrame:
    """The frame of a recording's columns."""
    return pd.DataFrame(dict(columns))


def source(recording: Recording, name: str) -> Source:
    """What one recording is read from."""
    if not isinstance(recording, pd.DataFrame):
        return Path(recording)
    return name, [(str(column), _cells(cells)) for column, cells in recording.items()]


def sources(measured: Recording | Sequence[Recording]) -> list[Source]:
    """What one recording or several are read from."""
    if isinstance(measured, (str, os.PathLike, pd.DataFrame)):
        return [source(measured, "measured")]
    parts = [source(part, f"measured_{number}") for number, part in enumerate(measured)]
    if not parts:
        raise InputError("measured: found none, expected at least one recording")
    return parts


def _cells(column: pd.Series[Any]) -> Cells:
    types = pd.api.types
    if types.is_bool_dtype(column) and not column.hasnans:
        return column.to_numpy(dtype=np.bool_)
    if types.is_integer_dtype(column) and not column.hasnans:
        return column.to_numpy(dtype=np.int64)
    if types.is_numeric_dtype(column):
        return column.to_numpy(dtype=np.float64, na_value=math.nan)
    return ["" if pd.isna(cell) else str(cell) for cell in column]
