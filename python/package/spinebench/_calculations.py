"""Simulate, calibrate, discover and run: files and frames in, typed results out."""

from __future__ import annotations

import io
import json
import math
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pandas as pd

from . import _spinebench as _core
from ._errors import InputError
from ._policies import PolicyClass, spec_entry
from ._spinebench import Model

PathLike = str | os.PathLike[str]
"""Name of a file."""
Recording = str | os.PathLike[str] | pd.DataFrame
"""A recording: a CSV or Parquet file, or a frame with the same columns (docs/outputs.md)."""


def _frame(csv: bytes) -> pd.DataFrame:
    return pd.read_csv(io.BytesIO(csv)) if csv.strip() else pd.DataFrame()


_Columns = list[tuple[str, list[Any]]]
"""Columns by name."""


def _recorded(columns: _Columns) -> pd.DataFrame:
    """The frame of a recording's columns."""
    return pd.DataFrame(dict(columns))


def _source(recording: Recording, name: str) -> Path | tuple[str, _Columns]:
    """What a recording is read from: a file, or what messages call it with the columns of a frame."""
    if not isinstance(recording, pd.DataFrame):
        return Path(recording)
    return name, [(str(column), _cells(cells)) for column, cells in recording.items()]


def _sources(measured: Recording | Sequence[Recording]) -> list[Path | tuple[str, _Columns]]:
    """What one recording or several are read from."""
    if isinstance(measured, (str, os.PathLike, pd.DataFrame)):
        return [_source(measured, "measured")]
    parts = [_source(part, f"measured_{number}") for number, part in enumerate(measured)]
    if not parts:
        raise InputError("measured: found none, expected at least one recording")
    return parts


def _cells(column: pd.Series[Any]) -> list[Any]:
    """Flags, whole numbers, numbers (NaN for an empty cell) or text (empty for an empty cell)."""
    types = pd.api.types
    if types.is_bool_dtype(column) or (types.is_integer_dtype(column) and not column.hasnans):
        return column.tolist()
    if types.is_numeric_dtype(column):
        return column.to_numpy(dtype="float64", na_value=math.nan).tolist()
    return ["" if pd.isna(cell) else str(cell) for cell in column]


def simulate(
    model: Model,
    commands: Recording,
    *,
    static: bool = False,
    noise_m: float = 0.0,
    seed: int = 0,
) -> pd.DataFrame:
    """Drive the rod model with the commands of a recording.

    With `static` each row is the equilibrium under its own command. `noise_m` is the standard deviation per axis of added
    tracking noise, metres. Returns a recording: tip (m), tip quaternion (w, x, y, z), tensions (N), and `solver_status`.
    Ctrl-C ends the call at once and the simulation at its next row.
    """
    return _recorded(_core._simulate(model, _source(commands, "commands"), static, noise_m, seed))


@dataclass(frozen=True)
class CalibratedNumber:
    """A number of the model with its fitted value and 95 % interval."""

    name: str
    unit: str
    start: float
    value: float
    low: float
    high: float
    determined: bool


@dataclass(frozen=True)
class Calibration:
    """The result of a calibration."""

    model: Model
    """The model with the fitted numbers."""
    numbers: list[CalibratedNumber]
    """The fitted numbers."""
    before_m: float
    """RMS error of the given model, metres."""
    after_m: float
    """RMS error of the fitted model, metres."""
    sightings: pd.DataFrame
    """Every position of the fit with its error, metres."""
    findings: dict[str, Any] = field(repr=False)
    """Everything that was found, as in calibration.json."""


def calibrate(
    model: Model,
    measured: Recording | Sequence[Recording],
    *,
    fit: Sequence[str] = ("youngs_modulus_pa",),
    select: bool = False,
    static: bool = False,
    hold_out: float | None = None,
    hold_out_patterns: Sequence[str] = (),
    likelihood: str | None = None,
    validate: bool = False,
) -> Calibration:
    """Fit numbers of a model to recordings (docs/calibration.md).

    `measured` is one recording or several, each with its own known loads (`known_load_kg`, `tip_force_x_n`…).
    `fit` lists paths of the model file (`robot.tendons.angles_deg[3]`, groups with `*`) or is `["auto"]`. `hold_out` is the
    share of trials that is kept out of the fit; `validate` finds the error on unseen rows. Ctrl-C ends the call at once and
    the fit at its next simulated row.
    """
    if isinstance(fit, str):
        fit = fit.split(",")
    arguments = {
        "fit": list(fit),
        "select": select,
        "at_rest": static,
        "hold_out": hold_out,
        "hold_out_patterns": list(hold_out_patterns),
        "likelihood": likelihood,
        "validate": validate,
    }
    fitted, findings_json, sightings = _core._calibrate(model, _sources(measured), arguments)
    findings = json.loads(findings_json)
    names = CalibratedNumber.__dataclass_fields__
    numbers = [CalibratedNumber(**{name: number[name] for name in names}) for number in findings["numbers"]]
    return Calibration(fitted, numbers, findings["before_m"], findings["after_m"], _frame(sightings), findings)


@dataclass(frozen=True)
class FoundEffect:
    """An effect that the model lacks."""

    name: str
    parameters: dict[str, Any]
    interval_95: dict[str, Any]
    confidence: float
    confusable_with: list[str]


@dataclass(frozen=True)
class Discovery:
    """The result of a discovery."""

    verdict: str
    """`named`, `consistent`, `ambiguous` or `unexplained`."""
    effects: list[FoundEffect]
    """The missing effects."""
    model: Model
    """The given model with the missing effects."""
    summary: str
    """The answer in words."""
    before_m: float
    """RMS tip error of the given model on held-out trials, metres."""
    after_m: float
    """RMS tip error of the extended model on held-out trials, metres."""
    candidates: pd.DataFrame
    """The effects that were tried."""
    residuals: pd.DataFrame
    """Every sample with its residual before and after, metres."""
    disagreement: pd.DataFrame
    """The residual map: where the model and the robot differ."""
    findings: dict[str, Any] = field(repr=False)
    """Everything that was found, as in findings.json."""


@dataclass(frozen=True)
class Proposal:
    """An experiment that tells the rivals of an ambiguous answer apart."""

    name: str
    """Name of the protocol."""
    what: str
    """Instruction in one sentence."""
    minutes: float
    """Duration including set-up, minutes."""
    separation: float
    """Smallest distance between predictions of two rivals, in standard deviations of the noise."""
    commands: pd.DataFrame
    """The commands, as a recording without tips."""


Record = Callable[[Discovery, list[Proposal]], Recording | None]
"""Records one of the proposals of an ambiguous answer, best first; None ends the loop."""


def _answer(written: tuple[Model, str, bytes, bytes]) -> Discovery:
    extended, findings_json, residuals, places = written
    findings = json.loads(findings_json)
    names = FoundEffect.__dataclass_fields__
    effects = [FoundEffect(**{name: effect[name] for name in names}) for effect in findings["effects"]]
    return Discovery(
        findings["verdict"],
        effects,
        extended,
        findings["summary"],
        findings["gap"]["before_m"],
        findings["gap"]["after_m"],
        pd.DataFrame(findings["candidates"]),
        _frame(residuals),
        _frame(places),
        findings,
    )


def _proposals(answer: Discovery, commands: list[_Columns]) -> list[Proposal]:
    return [
        Proposal(one["name"], one["what"], one["minutes"], one["separation"], _recorded(columns))
        for one, columns in zip(answer.findings["proposals"], commands, strict=True)
    ]


def discover(
    model: Model,
    measured: Recording | Sequence[Recording],
    *,
    baseline: Recording | None = None,
    options: PathLike | None = None,
    leave_out: Sequence[str] = (),
    static: bool = False,
) -> Discovery:
    """Find, name and add the effect that a model lacks (docs/discovery.md).

    `measured` is one recording or several. `baseline` is a recording of the robot as built. `leave_out` excludes effects from
    the search. Ctrl-C ends the call at once and the search at its next step.
    """
    return _rounds(model, measured, baseline, options, leave_out, static, None, 0)[-1]


def discover_until_named(
    model: Model,
    measured: Recording | Sequence[Recording],
    record: Record,
    *,
    max_rounds: int = 3,
    baseline: Recording | None = None,
    options: PathLike | None = None,
    leave_out: Sequence[str] = (),
    static: bool = False,
) -> list[Discovery]:
    """Ask as `discover` does; while the answer is ambiguous, record a proposed experiment and ask again of all recordings.

    `record(answer, proposals)` returns a recording of one of the proposals, or None to end. It is called `max_rounds` times at
    most. Returns the answer of each round; the last one is that of all recordings together. Ctrl-C ends the call at once.
    """
    if max_rounds < 0:
        raise InputError(f"max_rounds: found {max_rounds}, expected at least 0")
    return _rounds(model, measured, baseline, options, leave_out, static, record, max_rounds)


def _rounds(
    model: Model,
    measured: Recording | Sequence[Recording],
    baseline: Recording | None,
    options: PathLike | None,
    leave_out: Sequence[str],
    static: bool,
    record: Record | None,
    max_rounds: int,
) -> list[Discovery]:
    def recorded(written: tuple[Model, str, bytes, bytes], commands: list[_Columns]) -> Any:
        answer = _answer(written)
        new = None if record is None else record(answer, _proposals(answer, commands))
        return None if new is None else _source(new, "recorded")

    arguments = {
        "measured": _sources(measured),
        "baseline": None if baseline is None else _source(baseline, "baseline"),
        "options": None if options is None else Path(options),
        "leave_out": list(leave_out),
        "at_rest": static,
        "max_rounds": max_rounds,
    }
    answers = _core._discover(model, arguments, recorded)
    return [_answer(written) for written in answers]


@dataclass(frozen=True)
class ExperimentResult:
    """The published results of one experiment."""

    name: str
    """Name of the experiment."""
    folder: Path
    """Folder of its tables."""
    files: list[Path]
    """Every file that was written."""
    failed_trials: int
    """Number of trials that failed; their rows say why."""
    notices: list[str]
    """Figures that could not be made, and why."""

    def table(self, name: str) -> pd.DataFrame:
        """The table `NAME.csv`, such as `trials`, `table1` or `claims` (docs/outputs.md)."""
        file = self.folder / f"{name}.csv"
        if not file.is_file():
            there = ", ".join(sorted(path.stem for path in self.folder.glob("*.csv")))
            raise InputError(f"name: found {name!r}, expected one of: {there}")
        return pd.read_csv(file)

    @property
    def trials(self) -> pd.DataFrame:
        """Every goal-reaching trial."""
        return self.table("trials")


@dataclass(frozen=True)
class RunResult:
    """The result of a run."""

    experiments: dict[str, ExperimentResult]
    """Each experiment by its name."""
    computed: int
    """Number of stages that were computed."""
    cached: int
    """Number of stages that were read from the store."""
    failures: list[str]
    """Stages that failed, with their status."""

    def __getitem__(self, name: str) -> ExperimentResult:
        return self.experiments[name]


def run(
    *specs: PathLike,
    policies: Mapping[str, PolicyClass] | None = None,
    out: PathLike = "out",
    seeds: int | None = None,
    set: Mapping[str, Any] | None = None,
    sweep: Sequence[str] = (),
    jobs: int = 0,
    cache: PathLike | None = None,
) -> RunResult:
    """Run experiments as `spinebench run` does, and write tables and figures below `out`.

    `policies` adds controllers of your own by name: they join every set of goal-reaching trials (docs/python.md). `set`
    overrides keys of the specs (`{"gp.starts": 3}`). Ctrl-C ends the call; what is computed is stored.
    """
    if not specs:
        raise InputError("specs: found none, expected at least one file")
    sets = [f"{key}={json.dumps(value)}" for key, value in (set or {}).items()]
    if seeds is not None:
        sets.append(f"seeds={int(seeds)}")
    own = {name: spec_entry(name, policy) for name, policy in (policies or {}).items()}
    store = cache or os.environ.get("SPINEBENCH_CACHE") or ".spinebench/cache"
    arguments = {
        "out": Path(out),
        "cache": Path(store),
        "sets": sets,
        "sweeps": list(sweep),
        "jobs": jobs,
        "own": json.dumps(own),
    }
    told = json.loads(_core._run([Path(spec) for spec in specs], arguments))
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
