"""The compiled part of the package."""

from collections.abc import Callable, Sequence
from os import PathLike
from pathlib import Path
from typing import Any, final

import numpy as np
from numpy.typing import ArrayLike, NDArray

_Array = NDArray[np.float64]
_Flags = NDArray[np.bool_]
_Observation = NDArray[np.float32]
_Info = dict[str, Any]
_ModelLike = Model | str | PathLike[str]

_VERSION: str

@final
class Model:
    """The model of a robot: its parameters and the effects on it. Immutable: methods return a new model."""

    def __init__(self, file: _ModelLike | None = None) -> None:
        """Read a model file as `load` does; without a file, use the paper's robot: 0.22 m long, four tendons."""
    @classmethod
    def load(cls, file: str | PathLike[str]) -> Model:
        """Read a model file. Raises InputError with file, line and key."""
    @classmethod
    def from_yaml(cls, text: str) -> Model:
        """Read the text of a model file."""
    def to_yaml(self) -> str:
        """The text of a model file with every key filled in."""
    def save(self, file: str | PathLike[str]) -> None:
        """Write a model file."""
    @property
    def tendons(self) -> int:
        """Number of tendons."""
    @property
    def length_m(self) -> float:
        """Length of the backbone, metres."""
    @property
    def effect_names(self) -> list[str]:
        """Names of the effects."""
    def parameters(self) -> list[tuple[str, float, str]]:
        """Path, value and unit of every number of the model."""
    def value(self, path: str) -> float:
        """The number at a path such as `robot.backbone.youngs_modulus_pa`."""
    def with_value(self, path: str, value: float) -> Model:
        """The model with this number changed."""
    def with_effects(self, effects: Sequence[dict[str, Any]]) -> Model:
        """The model with further effects: `[{"tip_load": {"mass_kg": 0.02}}]` (`spinebench effects`)."""
    def __eq__(self, other: object) -> bool:
        """Whether robot and effects are the same."""
    def __hash__(self) -> int: ...
    def __copy__(self) -> Model: ...
    def __deepcopy__(self, memo: dict[int, Any]) -> Model: ...
    def _repr_html_(self) -> str: ...

@final
class Rod:
    """One simulated robot: the Cosserat rod of a model with its effects. Frame: z along the straight robot, x up."""

    def __init__(self, model: _ModelLike, parameters: Sequence[str] | None = None) -> None:
        """`parameters`: paths of numbers of the model with respect to which the tip is differentiated."""
    def restart(self) -> None:
        """Reset to the straight robot without history, at time 0."""
    def settle(self, pulls_m: ArrayLike | None = None, *, tensions_n: ArrayLike | None = None) -> _Array:
        """Bring the robot to rest under displacements (tendons,) in metres, positive pulls, or under tensions in newtons;
        at home without arguments. Returns the tip (3,), metres. Raises SolverError."""
    def step(self, pulls_m: ArrayLike, dt_s: float = 0.2) -> _Array:
        """Move the drives to displacements (tendons,), metres, and hold them, `dt_s` seconds in all. The first step starts at
        rest at home. Returns the tip (3,), metres. Raises SolverError."""
    @property
    def tip(self) -> _Array:
        """Measured tip (3,), metres."""
    @property
    def tip_rotation(self) -> _Array:
        """Orientation of the tip (3, 3); columns are the body axes."""
    def shape(self, n: int = 50) -> _Array:
        """Positions (n, 3) of cross-sections from base to tip, metres."""
    def rotations(self, n: int = 50) -> _Array:
        """Orientations (n, 3, 3) of the same cross-sections."""
    @property
    def tensions_n(self) -> _Array:
        """Tendon tensions (tendons,), newtons; 0 when slack."""
    @property
    def status(self) -> str:
        """Status of the last solve: `converged`, the solver's named failure, or `not_solved`."""
    @property
    def time_s(self) -> float:
        """Time since the restart, seconds."""
    @property
    def residual_m(self) -> float:
        """Estimated tip error of the last solve, metres."""
    @property
    def model(self) -> Model:
        """The model."""
    @property
    def parameters(self) -> list[str]:
        """Paths of the parameters of `parameter_jacobian`."""
    def jacobian(self, with_respect_to: str = "pulls") -> _Array:
        """Derivative of the tip at rest: (3, tendons) with respect to `pulls` (drive positions, m/m) or `tensions` (m/N); (3, 3)
        with respect to `force` (m/N) or `moment` (m/(N m)) at the tip. Raises SolverError unless the rod is at rest."""
    def parameter_jacobian(self) -> _Array:
        """Derivative (3, parameters) of the tip with respect to each parameter, metres per unit of it, also in motion."""
    def plot(self, **options: Any) -> Any:
        """The shape from the side and from above; `spinebench.plot` has the options. Returns a figure of matplotlib."""

@final
class Rods:
    """Many simulated robots, solved over all cores. A robot whose solver fails has a tip of NaN; its status gives the reason."""

    def __init__(self, models: Sequence[_ModelLike]) -> None:
        """One robot per model or model file; `[model] * 256` for equal ones."""
    def __len__(self) -> int: ...
    @property
    def tendons(self) -> int:
        """Number of tendons of each robot."""
    def restart(self) -> None:
        """Reset all to straight robots without history, at time 0."""
    def settle(self, pulls_m: ArrayLike) -> _Array:
        """Equilibrium under displacements (robots, tendons), metres. Returns tips (robots, 3), metres."""
    def step(self, pulls_m: ArrayLike, dt_s: float = 0.2) -> _Array:
        """One step of `dt_s` seconds under displacements (robots, tendons), metres. Returns tips (robots, 3), metres."""
    def play(self, pulls_m: ArrayLike, dt_s: float = 0.2) -> _Array:
        """Steps under displacements (robots, steps, tendons), metres. Returns tips (robots, steps, 3), metres; NaN after a
        failure."""
    @property
    def tips(self) -> _Array:
        """Tips (robots, 3), metres."""
    @property
    def tensions_n(self) -> _Array:
        """Tensions (robots, tendons), newtons."""
    @property
    def status(self) -> list[str]:
        """Status of each robot."""
    def shapes(self, n: int = 50) -> _Array:
        """Positions (robots, n, 3) of cross-sections from base to tip, metres."""
    def plot(self, **options: Any) -> Any:
        """The shapes from the side and from above; `spinebench.plot` has the options. Returns a figure of matplotlib."""

_Beginnings = tuple[list[int], list[int], list[str], list[list[float]]]

@final
class _Robots:
    """Robots of an environment, each in an episode of its own."""

    @classmethod
    def of_model(cls, model: _ModelLike, arguments: dict[str, Any]) -> _Robots: ...
    @classmethod
    def of_file(cls, file: Path, arguments: dict[str, Any]) -> _Robots: ...
    @property
    def actions(self) -> int: ...
    @property
    def travel_m(self) -> float: ...
    @property
    def max_step_m(self) -> float: ...
    @property
    def tips_m(self) -> _Array: ...
    @property
    def last_targets_m(self) -> _Array: ...
    @property
    def wanted_m(self) -> _Array: ...
    @property
    def status(self) -> list[str]: ...
    def set_task(self, task: dict[str, Any]) -> None: ...
    def check_effects(self, effects: str) -> None: ...
    def begin(self, beginnings: _Beginnings) -> None: ...
    def drive(self, actions: ArrayLike) -> None: ...
    def step_alone(self, action: ArrayLike) -> tuple[_Observation, float, bool, bool, _Info]: ...
    def tell_alone(self) -> tuple[_Observation, float, bool, bool, _Info]: ...
    def step(
        self, actions: ArrayLike, beginnings: _Beginnings | None = None
    ) -> tuple[_Observation, _Array, _Flags, _Flags, _Info]: ...
    def tell(self) -> tuple[_Observation, _Array, _Flags, _Flags, _Info]: ...
    def shape(self, index: int, n: int) -> _Array | None: ...

@final
class _Gp:
    """A fitted Gaussian process."""

    @staticmethod
    def fit(inputs: ArrayLike, outputs: ArrayLike, config: str, theta: ArrayLike | None = None) -> _Gp: ...
    def predict(self, inputs: ArrayLike, std: bool) -> tuple[_Array, _Array | None]: ...
    def leave_one_out(self) -> tuple[_Array, _Array, _Array]: ...
    @property
    def theta(self) -> _Array: ...
    @property
    def hyperparameter_names(self) -> list[str]: ...
    @property
    def log_marginal_likelihood(self) -> list[float]: ...
    @property
    def noise_std(self) -> list[float]: ...
    @property
    def range_ends(self) -> list[tuple[int, str, str]]: ...
    def dump(self) -> str: ...
    @staticmethod
    def load(text: str) -> _Gp: ...

@final
class _Network:
    """A trained network."""

    @staticmethod
    def train(inputs: ArrayLike, outputs: ArrayLike, sequences: list[int], config: str, seed: int) -> _Network: ...
    def predict(self, inputs: ArrayLike, sequences: list[int]) -> _Array: ...
    @property
    def summary(self) -> tuple[int, int, float, str]: ...
    @property
    def history(self) -> list[tuple[int, float, float, float]]: ...
    def dump(self) -> str: ...
    @staticmethod
    def load(text: str) -> _Network: ...

_Clock = tuple[int | None, float, tuple[float, float], float, float]
_Columns = list[tuple[str, NDArray[Any] | list[str]]]
_Source = Path | tuple[str, _Columns]
_Map = Path | tuple[str, str]
_ToldImport = tuple[_Columns, list[_Clock], list[Path], list[str]]

def _effects() -> list[tuple[str, list[tuple[str, str, float]]]]: ...
def _import_csv(files: list[Path], map: _Map) -> _ToldImport: ...
def _import_mcap(bag: Path, map: _Map) -> _ToldImport: ...
def _export_mcap(
    recording: _Source, out: Path, model: _ModelLike | None, residuals: _Source | None, at_rest: bool
) -> None: ...
def _simulate(model: _ModelLike, commands: _Source, at_rest: bool, noise_m: float, seed: int) -> _Columns: ...
def _calibrate(model: _ModelLike, measured: list[_Source], arguments: dict[str, Any]) -> tuple[Model, str, bytes]: ...
_WrittenDiscovery = tuple[Model, str, bytes, bytes, list[tuple[str, bytes]]]

def _discover(
    model: _ModelLike,
    arguments: dict[str, Any],
    record: Callable[[_WrittenDiscovery, list[_Columns]], Any] | None,
    tell: Callable[[int, str], None] | None,
) -> list[_WrittenDiscovery]: ...
def _save_discovery(out: Path, files: list[tuple[str, bytes]]) -> None: ...
def _plan(specs: list[Path], arguments: dict[str, Any]) -> str: ...
def _run(specs: list[Path], arguments: dict[str, Any], tell: Callable[[int, int], None] | None) -> str: ...
