"""Simulate and calibrate: files and frames in, typed results out."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import pandas as pd

from . import _notebook, _plots
from . import _spinebench as _core
from ._recordings import ModelLike, Recording, frame_of_columns, frame_of_csv, source, sources
from ._spinebench import Model


def simulate(
    model: ModelLike,
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
    return frame_of_columns(_core._simulate(model, source(commands, "commands"), static, noise_m, seed))


class Result:
    """Equal by content: a copy and an unpickled object are equal to the original."""

    model: Model
    findings: dict[str, Any]

    def __eq__(self, other: object) -> bool:
        if type(other) is not type(self):
            return NotImplemented
        # Equal models and findings come of equal residuals.
        return self.model == other.model and json.dumps(self.findings) == json.dumps(other.findings)

    def __hash__(self) -> int:
        return hash((type(self), self.model, json.dumps(self.findings)))


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


@dataclass(frozen=True, eq=False, repr=False)
class Calibration(Result):
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
    """All results, as in calibration.json."""

    def __repr__(self) -> str:
        numbers = ", ".join(f"{one.name}={one.value:.4g}" for one in self.numbers)
        return f"Calibration({numbers}; rms error {1e3 * self.before_m:.3g} to {1e3 * self.after_m:.3g} mm)"

    def _repr_html_(self) -> str:
        return _notebook.calibration(self)

    def plot(self, **options: Any) -> Any:
        """Errors of the fitted model; `spinebench.plot` has the options."""
        return _plots.plot(self, **options)


def calibrate(
    model: ModelLike,
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
    """Fit numbers of a model to recordings (docs/reference/calibration.md).

    `measured` is one recording or several, each with its own known loads (`known_load_kg`, `tip_force_x_n`…).
    `fit` lists paths of the model file (`robot.tendons.angles_deg[3]`, groups with `*`) or is `["auto"]`. `hold_out` is the
    share of trials that is held out of the fit; `validate` estimates the error on unseen rows. Ctrl-C ends the call at once and
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
    fitted, findings_json, sightings = _core._calibrate(model, sources(measured), arguments)
    findings = json.loads(findings_json)
    names = CalibratedNumber.__dataclass_fields__
    numbers = [CalibratedNumber(**{name: number[name] for name in names}) for number in findings["numbers"]]
    return Calibration(fitted, numbers, findings["before_m"], findings["after_m"], frame_of_csv(sightings), findings)
