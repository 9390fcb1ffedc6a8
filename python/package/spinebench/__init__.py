"""Tendon-driven continuum robots: simulate, calibrate, find what a model lacks, test and train controllers.

Units are SI; names end in them. Frame: right-handed, origin at the base, z along the straight robot, x up.
"""

from __future__ import annotations

from ._calculations import (
    CalibratedNumber,
    Calibration,
    Discovery,
    ExperimentResult,
    FoundEffect,
    Proposal,
    RunResult,
    calibrate,
    discover,
    discover_until_named,
    run,
    simulate,
)
from ._bags import ClockFit, ImportedRecording, export_mcap, import_csv, import_mcap
from ._errors import InputError, InternalError, RunError, SolverError, SpinebenchError
from ._learn import ElmanRegressor, GaussianProcess, NetworkRegressor
from ._policies import Policy
from ._spinebench import Model, Rod, Rods
from .envs import register as _register

__all__ = [
    "CalibratedNumber",
    "Calibration",
    "ClockFit",
    "Discovery",
    "ElmanRegressor",
    "ExperimentResult",
    "FoundEffect",
    "GaussianProcess",
    "ImportedRecording",
    "InputError",
    "InternalError",
    "Model",
    "NetworkRegressor",
    "Policy",
    "Proposal",
    "Rod",
    "Rods",
    "RunError",
    "RunResult",
    "SolverError",
    "SpinebenchError",
    "calibrate",
    "discover",
    "discover_until_named",
    "export_mcap",
    "import_csv",
    "import_mcap",
    "run",
    "simulate",
]

_register()
