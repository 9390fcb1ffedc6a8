"""Tendon-driven continuum robots: simulate, calibrate, find what a model lacks, test and train controllers.

Units are SI; names end in them. Frame: right-handed, origin at the base, z along the straight robot, x up.
"""

from __future__ import annotations

from ._bags import ClockFit, ImportedRecording, export_mcap, import_csv, import_mcap
from ._compare import Comparison, compare
from ._discoveries import Discovery, FoundEffect, Proposal, discover, discover_until_named
from ._errors import InputError, InternalError, RunError, SolverError, SpinebenchError
from ._fits import CalibratedNumber, Calibration, calibrate, simulate
from ._learn import ElmanRegressor, GaussianProcess, NetworkRegressor
from ._plots import plot
from ._policies import Policy
from ._runs import ExperimentResult, Plan, RunResult, plan, run
from ._spinebench import _VERSION, Model, Rod, Rods
from .envs import register as _register

__version__ = _VERSION
"""Version with the revision of the sources, as `spinebench --version` prints it."""

__all__ = [
    "CalibratedNumber",
    "Calibration",
    "ClockFit",
    "Comparison",
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
    "Plan",
    "Policy",
    "Proposal",
    "Rod",
    "Rods",
    "RunError",
    "RunResult",
    "SolverError",
    "SpinebenchError",
    "__version__",
    "calibrate",
    "compare",
    "discover",
    "discover_until_named",
    "export_mcap",
    "import_csv",
    "import_mcap",
    "plan",
    "plot",
    "run",
    "simulate",
]

_register()
