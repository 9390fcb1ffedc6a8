"""Run experiments: specs in, tables as frames out."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd

from . import _notebook, _plots
from . import _spinebench as _core
from ._errors import InputError
from ._policies import PolicyClass, spec_entry
from ._progress import shown
from ._recordings import PathLike


@dataclass(frozen=True, repr=False)
class ExperimentResult:
    """The published results of one experiment."""

    name: str
    """Name of the experiment."""
    folder: Path
    """Folder of its tables."""
    files: list[Path]
    """Every written file."""
    failed_trials: int
    """Number of failed trials; their rows contain the reason."""
    notices: list[str]
    """Figures that could not be drawn, with the reasons."""

    def table(self, name: str) -> pd.DataFrame:
        """The table `NAME.csv`, such as `trials`, `table1` or `claims` (docs/reference/outputs.md)."""
        file = self.folder / f"{name}.csv"
        if not file.is_file():
            there = ", ".join(sorted(path.stem for path in self.folder.glob("*.csv")))
            raise InputError(f"name: found {name!r}, expected one of: {there}")
        return pd.read_csv(file)

    @property
    def trials(self) -> pd.DataFrame:
        """Every goal-reaching trial."""
        return self.table("trials")

    def __repr__(self) -> str:
        return f"ExperimentResult({self.name}: {len(self.files)} files in {self.folder}, {self.failed_trials} failed trials)"

    def plot(self, table: str = "trials", **options: Any) -> Any:
        """A table of trials; `spinebench.plot` has the options."""
        return _plots.plot(self.table(table), **options)


@dataclass(frozen=True, repr=False)
class RunResult:
    """The result of a run."""

    experiments: dict[str, ExperimentResult]
    """Each experiment by its name."""
    computed: int
    """Number of computed stages."""
    cached: int
    """Number of stages read from the store."""
    failures: list[str]
    """Stages that failed, with their status."""

    def __getitem__(self, name: str) -> ExperimentResult:
        return self.experiments[name]

    def __repr__(self) -> str:
        names, failed = ", ".join(self.experiments), f", {len(self.failures)} failed" if self.failures else ""
        return f"RunResult({names}: {self.computed} stages computed, {self.cached} read{failed})"

    def _repr_html_(self) -> str:
        return _notebook.run(self)


def run(
    *specs: PathLike,
    policies: Mapping[str, PolicyClass] | None = None,
    out: PathLike = "out",
    seeds: int | None = None,
    set: Mapping[str, Any] | None = None,
    sweep: Sequence[str] = (),
    jobs: int = 0,
    cache: PathLike | None = None,
    progress: bool | None = None,
) -> RunResult:
    """Run experiments as `spinebench run` does, and write tables and figures below `out`.

    `policies` adds your own controllers by name to every set of goal-reaching trials (docs/reference/python.md). `set`
    overrides keys of the specs (`{"gp.starts": 3}`). `progress` counts the stages by tqdm: None where it is installed, in
    notebooks and terminals. Ctrl-C ends the call; the computed stages are stored.
    """
    files, arguments = _arguments(specs, policies, out, seeds, set, sweep, jobs, cache)
    with shown(progress, "run") as bar:
        told = json.loads(_core._run(files, arguments, None if bar is None else bar.count))
    experiments = {
        one["name"]: ExperimentResult(
            one["name"],
            Path(out) / "results" / one["name"],
            [Path(file) for file in one["files"]],
            one["failed_trials"],
            one["notices"],
        )
        for one in told["experiments"]
    }
    return RunResult(experiments, told["computed"], told["cached"], told["failures"])


@dataclass(frozen=True, repr=False)
class Plan:
    """The plan of a run."""

    runs: pd.DataFrame
    """Every run: `experiment`, `run` and whether its result is `stored`."""
    stages: pd.DataFrame
    """Number of results that are `stored` and `left` to compute, by `kind` of stage; stages shared by runs count once."""
    notes: list[str]
    """Notes about the specs."""

    def __repr__(self) -> str:
        runs, stages = self.runs, self.stages
        stored = int(runs["stored"].sum())
        return f"Plan({len(runs)} runs, {stored} stored; {stages['left'].sum()} stages left to compute)"

    def _repr_html_(self) -> str:
        return _notebook.plan(self)


def plan(
    *specs: PathLike,
    policies: Mapping[str, PolicyClass] | None = None,
    seeds: int | None = None,
    set: Mapping[str, Any] | None = None,
    sweep: Sequence[str] = (),
    cache: PathLike | None = None,
) -> Plan:
    """The plan of `run` with these arguments, as by `spinebench plan`; runs nothing."""
    files, arguments = _arguments(specs, policies, "out", seeds, set, sweep, 0, cache)
    told = json.loads(_core._plan(files, arguments))
    stages = [(kind, stored, left) for kind, (stored, left) in told["stages"].items()]
    return Plan(
        pd.DataFrame(told["runs"], columns=["experiment", "run", "stored"]),
        pd.DataFrame(stages, columns=["kind", "stored", "left"]),
        told["notes"],
    )


def _arguments(
    specs: Sequence[PathLike],
    policies: Mapping[str, PolicyClass] | None,
    out: PathLike,
    seeds: int | None,
    overrides: Mapping[str, Any] | None,
    sweep: Sequence[str],
    jobs: int,
    cache: PathLike | None,
) -> tuple[list[Path], dict[str, Any]]:
    """The specs, and how they are run."""
    if not specs:
        raise InputError("specs: found none, expected at least one file")
    sets = [f"{key}={json.dumps(value)}" for key, value in (overrides or {}).items()]
    if seeds is not None:
        sets.append(f"seeds={int(seeds)}")
    own = {name: spec_entry(name, policy) for name, policy in (policies or {}).items()}
    arguments = {
        "out": Path(out),
        "cache": None if cache is None else Path(cache),
        "sets": sets,
        "sweeps": list(sweep),
        "jobs": jobs,
        "own": json.dumps(own),
    }
    return [Path(spec) for spec in specs], arguments
