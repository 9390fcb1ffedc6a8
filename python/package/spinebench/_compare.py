"""Comparison of the results of two runs."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from ._errors import InputError
from ._recordings import PathLike
from ._runs import ExperimentResult, RunResult

Compared = RunResult | ExperimentResult | PathLike
"""A run, an experiment of it, or the folder that a run wrote to."""
CLOCKS = {"wall_s", "cpu_s"}
"""Columns that differ from run to run."""


@dataclass(frozen=True, repr=False)
class Comparison:
    """The differences between two runs."""

    differences: pd.DataFrame
    """One row per differing value: `experiment`, `table`, `row` (from 0), `column`, `first`, `second`, and `difference` of
    numbers. A table or column of only one run, and a different number of rows, have one row each."""
    first_stage: str | None
    """The first stage whose result differs, by `stages.csv`; None if all results are equal or a run has no `stages.csv`."""
    tables: int
    """Number of compared tables."""

    @property
    def equal(self) -> bool:
        """Whether the runs are equal."""
        return len(self.differences) == 0

    def __repr__(self) -> str:
        if self.equal:
            return f"Comparison({self.tables} tables, no difference)"
        places = Counter(zip(self.differences["experiment"], self.differences["table"], strict=True))
        named = ", ".join(f"{experiment}/{table}: {count}" for (experiment, table), count in list(places.items())[:4])
        more = "" if len(places) <= 4 else f" and {len(places) - 4} more tables"
        return f"Comparison({self.tables} tables, {len(self.differences)} differences: {named}{more})"

    def _repr_html_(self) -> str:
        shown = self.differences.head(12).to_html(index=False)
        stage = "" if self.first_stage is None else f"<p>first stage that differs: {self.first_stage}</p>"
        return f"<div><strong>{repr(self)}</strong>{'' if self.equal else shown}{stage}</div>"


def compare(first: Compared, second: Compared, *, tolerance: float = 0.0) -> Comparison:
    """Compare the tables of two runs, value by value and row by row; run times are not compared.

    `first` and `second` are results of `run`, experiments of them, or folders that runs wrote to (`out`). Numbers are equal if
    they differ by at most `tolerance` times the larger one, or by at most 1e-9; with `tolerance` 0 they must be identical.
    """
    if not 0.0 <= tolerance < 1.0:
        raise InputError(f"tolerance: found {tolerance}, expected a number of at least 0 and below 1")
    one, other = _folders(first, "first"), _folders(second, "second")
    shared = [name for name in one if name in other]
    if not shared:
        raise InputError(f"second: found {_words(other)}, expected an experiment of the first: {_words(one)}")
    rows: list[tuple[object, ...]] = []
    only = [(name, "first", "second") for name in one if name not in other]
    only += [(name, "second", "first") for name in other if name not in one]
    rows += [(name, None, None, None, *_sides(side)) for name, side, _ in only]
    tables, first_stage = 0, None
    for name in shared:
        ours, theirs = _tables(one[name]), _tables(other[name])
        for table in sorted(set(ours) | set(theirs)):
            if table not in ours or table not in theirs:
                rows.append((name, table, None, None, *_sides("first" if table in ours else "second")))
                continue
            tables += 1
            here, there = _read(ours[table]), _read(theirs[table])
            if table == "stages":
                first_stage = first_stage or _parting(here, there)
                continue
            rows += [(name, table, *difference) for difference in _differences(here, there, tolerance)]
    columns = ["experiment", "table", "row", "column", "first", "second", "difference"]
    return Comparison(pd.DataFrame(rows, columns=columns), first_stage, tables)


def _sides(side: str) -> tuple[str | None, str | None, None]:
    return ("there", None, None) if side == "first" else (None, "there", None)


def _words(names: dict[str, Path]) -> str:
    return ", ".join(f"`{name}`" for name in names) or "no experiment"


def _folders(given: Compared, name: str) -> dict[str, Path]:
    """Folders of tables by experiment."""
    if isinstance(given, ExperimentResult):
        return {given.name: given.folder}
    if isinstance(given, RunResult):
        return {key: one.folder for key, one in given.experiments.items()}
    folder = Path(given)
    results = folder / "results"
    places = sorted(results.iterdir()) if results.is_dir() else [folder]
    experiments = {place.name: place for place in places if (place / "spec.yaml").is_file()}
    if not experiments:
        raise InputError(f"{name}: found no results in {folder}, expected a folder that a run wrote to")
    return experiments


def _tables(folder: Path) -> dict[str, Path]:
    return {file.stem: file for file in sorted(folder.iterdir()) if file.suffix in (".csv", ".parquet")}


def _read(file: Path) -> pd.DataFrame:
    if file.suffix == ".csv":
        return pd.read_csv(file)
    try:
        return pd.read_parquet(file)
    except ImportError:
        raise InputError(f"{file}: found a Parquet file but no pyarrow, expected pyarrow to be installed") from None


def _parting(here: pd.DataFrame, there: pd.DataFrame) -> str | None:
    """The first stage whose result differs."""
    for (_, ours), (_, theirs) in zip(here.iterrows(), there.iterrows(), strict=False):
        if [ours["stage"], ours["label"]] != [theirs["stage"], theirs["label"]] or ours["result"] != theirs["result"]:
            return f"{ours['stage']} ({ours['label']})"
    return None


def _differences(here: pd.DataFrame, there: pd.DataFrame, tolerance: float) -> list[tuple[object, ...]]:
    """Row, column, both values and their difference."""
    rows: list[tuple[object, ...]] = []
    for column in [*here.columns, *there.columns.difference(here.columns)]:
        if column not in here.columns or column not in there.columns:
            rows.append((None, column, *_sides("first" if column in here.columns else "second")))
    if len(here) != len(there):
        rows.append((None, None, f"{len(here)} rows", f"{len(there)} rows", None))
    count = min(len(here), len(there))
    for column in [name for name in here.columns if name in there.columns and name not in CLOCKS]:
        ours, theirs = here[column].iloc[:count], there[column].iloc[:count]
        numeric = all(pd.api.types.is_numeric_dtype(part) and not pd.api.types.is_bool_dtype(part) for part in (ours, theirs))
        if numeric:
            one, other = ours.to_numpy(dtype=float), theirs.to_numpy(dtype=float)
            apart = np.abs(one - other)
            limit = np.maximum(1e-9, tolerance * np.maximum(np.abs(one), np.abs(other))) if tolerance > 0.0 else 0.0
            same = (apart <= limit) | (np.isnan(one) & np.isnan(other)) | (one == other)
        else:
            same = ((ours.to_numpy() == theirs.to_numpy()) | (ours.isna().to_numpy() & theirs.isna().to_numpy())).astype(bool)
        for row in np.flatnonzero(~same):
            values = ours.iloc[row], theirs.iloc[row]
            rows.append((int(row), column, *values, float(values[1] - values[0]) if numeric else None))
    return rows
