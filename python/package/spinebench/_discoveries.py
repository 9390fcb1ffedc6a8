"""Discover what a model lacks: files and frames in, typed results out."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pandas as pd

from . import _notebook, _plots
from . import _spinebench as _core
from ._errors import InputError
from ._fits import Result
from ._progress import shown
from ._recordings import Columns, ModelLike, PathLike, Recording, frame_of_columns, frame_of_csv, source, sources
from ._spinebench import Model

_Written = tuple[Model, str, bytes, bytes, list[tuple[str, bytes]]]


@dataclass(frozen=True)
class FoundEffect:
    """An effect that the model lacks."""

    name: str
    parameters: dict[str, Any]
    interval_95: dict[str, Any]
    confidence: float
    confusable_with: list[str]


@dataclass(frozen=True, eq=False, repr=False)
class Discovery(Result):
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
    """The fitted or screened effects."""
    residuals: pd.DataFrame
    """Every sample with its residual before and after, metres."""
    disagreement: pd.DataFrame
    """The residual map: where the model and the robot differ."""
    findings: dict[str, Any]
    """All results, as in findings.json."""
    files: dict[str, bytes]
    """The files of `spinebench discover --out`, by name."""

    def save(self, folder: PathLike) -> None:
        """Write the files of `spinebench discover --out`: `findings.json`, `model.yaml`, `report.html`, figures and tables."""
        _core._save_discovery(Path(folder), list(self.files.items()))

    def __repr__(self) -> str:
        effects = ", ".join(effect.name for effect in self.effects) or "no effect"
        return f"Discovery({self.verdict}: {effects}; rms error {1e3 * self.before_m:.3g} to {1e3 * self.after_m:.3g} mm)"

    def _repr_html_(self) -> str:
        return _notebook.discovery(self)

    def plot(self, **options: Any) -> Any:
        """Residuals of the given and of the extended model; `spinebench.plot` has the options."""
        return _plots.plot(self, **options)


@dataclass(frozen=True)
class Proposal:
    """An experiment that distinguishes the candidates of an ambiguous answer."""

    name: str
    """Name of the protocol."""
    what: str
    """Instruction in one sentence."""
    minutes: float
    """Duration including set-up, minutes."""
    separation: float
    """Smallest distance between predictions of two rivals, in standard deviations of the noise."""
    commands: pd.DataFrame = field(repr=False)
    """The commands, as a recording without tips."""


Record = Callable[[Discovery, list[Proposal]], Recording | None]
"""Records one of the proposals of an ambiguous answer, which are sorted best first; None ends the loop."""


def _answer(written: _Written) -> Discovery:
    extended, findings_json, residuals, places, files = written
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
        frame_of_csv(residuals),
        frame_of_csv(places),
        findings,
        dict(files),
    )


def _proposals(answer: Discovery, commands: list[Columns]) -> list[Proposal]:
    return [
        Proposal(one["name"], one["what"], one["minutes"], one["separation"], frame_of_columns(columns))
        for one, columns in zip(answer.findings["proposals"], commands, strict=True)
    ]


def discover(
    model: ModelLike,
    measured: Recording | Sequence[Recording],
    *,
    baseline: Recording | None = None,
    options: PathLike | None = None,
    leave_out: Sequence[str] = (),
    static: bool = False,
    progress: bool | None = None,
) -> Discovery:
    """Find, name and add the effect that a model lacks (docs/reference/discovery.md).

    `measured` is one recording or several. `baseline` is a recording of the robot as built. `leave_out` excludes effects from
    the search. `progress` shows the steps by tqdm: None where it is installed, in notebooks and terminals. Ctrl-C ends the call
    at once and the search at its next step.
    """
    return _rounds(model, measured, baseline, options, leave_out, static, progress, None, 0)[-1]


def discover_until_named(
    model: ModelLike,
    measured: Recording | Sequence[Recording],
    record: Record,
    *,
    max_rounds: int = 3,
    baseline: Recording | None = None,
    options: PathLike | None = None,
    leave_out: Sequence[str] = (),
    static: bool = False,
    progress: bool | None = None,
) -> list[Discovery]:
    """Run `discover`; while the answer is ambiguous, record a proposed experiment and repeat with all recordings.

    `record(answer, proposals)` returns a recording of one of the proposals, or None to end. It is called `max_rounds` times at
    most. Returns the answer of each round; the last one is based on all recordings. Ctrl-C ends the call at once.
    """
    if max_rounds < 0:
        raise InputError(f"max_rounds: found {max_rounds}, expected at least 0")
    return _rounds(model, measured, baseline, options, leave_out, static, progress, record, max_rounds)


def _rounds(
    model: ModelLike,
    measured: Recording | Sequence[Recording],
    baseline: Recording | None,
    options: PathLike | None,
    leave_out: Sequence[str],
    static: bool,
    progress: bool | None,
    record: Record | None,
    max_rounds: int,
) -> list[Discovery]:
    def recorded(written: _Written, commands: list[Columns]) -> Any:
        answer = _answer(written)
        new = None if record is None else record(answer, _proposals(answer, commands))
        return None if new is None else source(new, "recorded")

    arguments = {
        "measured": sources(measured),
        "baseline": None if baseline is None else source(baseline, "baseline"),
        "options": None if options is None else Path(options),
        "leave_out": list(leave_out),
        "at_rest": static,
        "max_rounds": max_rounds,
    }
    with shown(progress, "discover") as bar:
        answers = _core._discover(model, arguments, recorded, None if bar is None else bar.step)
    return [_answer(written) for written in answers]
