"""Learners with scikit-learn's conventions. scikit-learn is not needed; where it is installed, inputs are validated by it."""

from __future__ import annotations

import importlib
import inspect
import json
import warnings
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _spinebench as _core
from ._errors import InputError

if TYPE_CHECKING:
    from typing_extensions import Self

Array = NDArray[np.float64]


def _sklearn(module: str) -> Any | None:
    """A module of scikit-learn, if it is installed."""
    try:
        return importlib.import_module(f"sklearn.{module}")
    except ImportError:
        return None


class NotFittedError(ValueError, AttributeError):
    """The estimator was not fitted; scikit-learn's own class where that is installed."""


def _plain(X: ArrayLike, y: ArrayLike | None, features: int | None) -> tuple[Array, Array | None]:
    """Validation without scikit-learn."""
    inputs = np.asarray(X, dtype=np.float64)
    if inputs.ndim != 2 or 0 in inputs.shape:
        raise InputError(f"X: found shape {inputs.shape}, expected (samples, features) (reshape your data)")
    if features is not None and inputs.shape[1] != features:
        raise InputError(f"X: found {inputs.shape[1]} features, expected {features} as in fit")
    outputs = None if y is None else np.asarray(y, dtype=np.float64)
    if outputs is not None and (outputs.ndim not in (1, 2) or len(outputs) != len(inputs)):
        raise InputError(f"y: found shape {outputs.shape}, expected ({len(inputs)},) or ({len(inputs)}, outputs)")
    for name, values in (("X", inputs), ("y", outputs)):
        if values is not None and not np.isfinite(values).all():
            raise InputError(f"{name}: found NaN or infinity, expected finite numbers")
    return inputs, outputs


class _Regressor:
    """Base class of the regressors."""

    _estimator_type = "regressor"
    n_features_in_: int
    """Number of features seen in `fit`."""
    _single: bool

    @classmethod
    def _parameter_names(cls) -> list[str]:
        return [name for name in inspect.signature(cls).parameters if name != "self"]

    def get_params(self, deep: bool = True) -> dict[str, Any]:
        """The parameters by name. No parameter is an estimator, so `deep` changes nothing."""
        return {name: getattr(self, name) for name in self._parameter_names()}

    def set_params(self, **params: Any) -> Self:
        """Set parameters by name; returns the estimator."""
        names = self._parameter_names()
        for name, value in params.items():
            if name not in names:
                raise InputError(f"Invalid parameter {name!r}: found {name!r}, expected one of {', '.join(names)}")
            setattr(self, name, value)
        return self

    def __repr__(self) -> str:
        defaults = {name: one.default for name, one in inspect.signature(type(self)).parameters.items()}
        changed = [f"{name}={value!r}" for name, value in self.get_params().items() if value is not defaults[name]]
        return f"{type(self).__name__}({', '.join(changed)})"

    def __sklearn_tags__(self) -> Any:
        utils = _sklearn("utils")
        assert utils is not None, "only scikit-learn asks for tags"
        return utils.Tags(
            estimator_type="regressor",
            target_tags=utils.TargetTags(required=True, multi_output=True, single_output=True),
            transformer_tags=None,
            classifier_tags=None,
            regressor_tags=utils.RegressorTags(poor_score=True),
            input_tags=utils.InputTags(),
        )

    def __sklearn_is_fitted__(self) -> bool:
        return hasattr(self, "n_features_in_")

    def _check_fitted(self) -> None:
        if self.__sklearn_is_fitted__():
            return
        module = _sklearn("exceptions")
        error = NotFittedError if module is None else module.NotFittedError
        raise error(f"This {type(self).__name__} instance is not fitted yet. Call 'fit' before 'predict'.")

    def _training(self, X: ArrayLike, y: ArrayLike | None) -> tuple[Array, Array]:
        """Inputs (samples, features) and outputs (samples, outputs), checked."""
        if y is None:
            raise InputError(f"y: found None: {type(self).__name__} requires y to be passed, but the target y is None")
        validation = _sklearn("utils.validation")
        if validation is None:
            inputs, outputs = _plain(X, y, None)
            self.n_features_in_ = inputs.shape[1]
        else:
            options = {"multi_output": True, "y_numeric": True, "dtype": np.float64, "ensure_min_samples": 2}
            inputs, outputs = validation.validate_data(self, X, y, reset=True, **options)
        assert outputs is not None
        self._single = outputs.ndim == 1
        return inputs, np.asarray(outputs, dtype=np.float64).reshape(len(inputs), -1)

    def _queries(self, X: ArrayLike) -> Array:
        self._check_fitted()
        validation = _sklearn("utils.validation")
        if validation is None:
            return _plain(X, None, self.n_features_in_)[0]
        inputs: Array = validation.validate_data(self, X, reset=False, dtype=np.float64)
        return inputs

    def _shaped(self, rows: Array) -> Array:
        """(samples,) for a single output, (samples, outputs) otherwise."""
        return rows[:, 0] if self._single else rows

    def _mean(self, X: ArrayLike) -> Array:
        raise NotImplementedError

    def score(self, X: ArrayLike, y: ArrayLike, sample_weight: ArrayLike | None = None) -> float:
        """The coefficient of determination R² of the predictions, the mean over outputs."""
        found = self._mean(X)
        found = found.reshape(len(found), -1)
        wanted = np.asarray(y, dtype=np.float64).reshape(len(found), -1)
        weights = np.ones(len(found)) if sample_weight is None else np.asarray(sample_weight, dtype=np.float64)
        left = np.average((wanted - found) ** 2, axis=0, weights=weights)
        every = np.average((wanted - np.average(wanted, axis=0, weights=weights)) ** 2, axis=0, weights=weights)
        shares = np.where(every > 0.0, 1.0 - left / np.where(every > 0.0, every, 1.0), np.where(left > 0.0, 0.0, 1.0))
        return float(np.mean(shares))


class GaussianProcess(_Regressor):
    """Gaussian-process regression, exact or with inducing points. Each output has its own hyper-parameters.

    Parameters
    ----------
    kernel: a kernel or an expression of kernels, such as `"se_ard"` or `"matern52 + linear[1-2]"` (docs/method/learning.md).
    mean: `"zero"` (the mean of the outputs), `"constant"` or `"linear"`, whose unknown weights are integrated out.
    approximation: `"exact"`, or `"sgpr"` or `"fitc"` for thousands of samples.
    inducing_points: maximum number of inducing points of an approximation.
    starts: starting points of the search for hyper-parameters.
    start_rows: maximum number of rows on which the starts are compared.
    noise_floor: smallest noise standard deviation, as a share of the output's standard deviation.
    noise_prior: known standard deviation of the measurement noise in y's unit, the same for all outputs. It keeps the fitted
        noise from falling far below this value; above it, only the likelihood counts. None: only the likelihood counts, which
        can estimate nearly no noise from few samples.
    noise_prior_width: uncertainty of `noise_prior`: standard deviation of its logarithm.
    tolerance: improvement of the log marginal likelihood (nats) below which the search ends.
    theta: natural logarithms of fixed hyper-parameters (each,) or (outputs, each), in the order of
        `hyperparameter_names_` and in standardised units; they are not optimised.

    Inputs and outputs are standardised inside (mean 0, population standard deviation 1).
    """

    theta_: Array
    """Natural logarithms of the hyper-parameters (outputs, each), in standardised units."""
    hyperparameter_names_: list[str]
    """Their names."""
    log_marginal_likelihood_value_: float
    """Log marginal likelihood of the standardised outputs (`sgpr`: its lower bound), nats, summed over outputs."""
    noise_std_: Array
    """Noise standard deviation of each output, in its unit."""
    range_ends_: list[tuple[int, str, str]]
    """Hyper-parameters at an end of their range: output, name, `low` or `high`. `fit` warns about them. Noise at its lower end
    makes intervals too narrow; a length-scale at its upper end means an input without influence."""

    def __init__(
        self,
        kernel: str = "se_ard",
        *,
        mean: str = "zero",
        approximation: str = "exact",
        inducing_points: int = 200,
        starts: int = 8,
        start_rows: int = 100,
        noise_floor: float = 1e-3,
        noise_prior: float | None = None,
        noise_prior_width: float = 0.25,
        tolerance: float = 1e-4,
        theta: ArrayLike | None = None,
    ) -> None:
        self.kernel = kernel
        self.mean = mean
        self.approximation = approximation
        self.inducing_points = inducing_points
        self.starts = starts
        self.start_rows = start_rows
        self.noise_floor = noise_floor
        self.noise_prior = noise_prior
        self.noise_prior_width = noise_prior_width
        self.tolerance = tolerance
        self.theta = theta

    def fit(self, X: ArrayLike, y: ArrayLike | None = None) -> Self:
        """Fit (samples, features) to (samples,) or (samples, outputs). Raises InputError; returns the estimator."""
        inputs, outputs = self._training(X, y)
        names = ("kernel", "mean", "approximation", "inducing_points", "starts", "start_rows", "noise_floor", "tolerance")
        settings = {name: getattr(self, name) for name in names}
        if self.noise_prior is not None:
            settings["noise_prior"] = {"std_m": self.noise_prior, "relative_std": self.noise_prior_width}
        config = json.dumps(settings, default=float)
        theta = self.theta
        if theta is not None:
            given = np.atleast_2d(np.asarray(theta, dtype=np.float64))
            theta = np.broadcast_to(given, (outputs.shape[1], given.shape[1])) if len(given) == 1 else given
        self._core = _core._Gp.fit(inputs, outputs, config, theta)
        self._describe()
        if theta is None and self.range_ends_:
            ends = ", ".join(f"{name} of output {output} {end}" for output, name, end in self.range_ends_)
            warnings.warn(f"hyper-parameters at an end of their range: {ends} (`range_ends_`)", stacklevel=2)
        return self

    def _describe(self) -> None:
        self.theta_ = self._core.theta
        self.hyperparameter_names_ = self._core.hyperparameter_names
        self.log_marginal_likelihood_value_ = float(sum(self._core.log_marginal_likelihood))
        self.noise_std_ = np.array(self._core.noise_std)
        self.range_ends_ = self._core.range_ends

    def predict(self, X: ArrayLike, return_std: bool = False) -> Any:
        """Posterior mean (samples,) or (samples, outputs); with `return_std` a pair of it and the standard deviation of the
        noise-free function, of the same shape."""
        queries = self._queries(X)
        mean, std = self._core.predict(queries, return_std)
        return self._shaped(mean) if std is None else (self._shaped(mean), self._shaped(std))

    def leave_one_out(self) -> tuple[Array, Array, Array]:
        """Mean, standard deviation (including noise) and log probability density of every training sample as predicted from the
        others, without refitting (Rasmussen & Williams 2006, section 5.4.2): (samples,) or (samples, outputs) each."""
        self._check_fitted()
        mean, std, log_probability = self._core.leave_one_out()
        return self._shaped(mean), self._shaped(std), self._shaped(log_probability)

    def _mean(self, X: ArrayLike) -> Array:
        mean: Array = self.predict(X)
        return mean

    def __getstate__(self) -> dict[str, Any]:
        state = dict(self.__dict__)
        if "_core" in state:
            state["_core"] = self._core.dump()
        return state

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        if "_core" in state:
            self._core = _core._Gp.load(state["_core"])


class NetworkRegressor(_Regressor):
    """A network of one hidden layer with a linear output and early stopping on the last share of the rows. The paper's is
    Elman's.

    Rows are samples in time order: what is predicted for a row depends on the rows before it, back to the start of its
    sequence. With `window=1` the network has no memory, and rows are independent.

    Parameters
    ----------
    hidden: hidden units.
    kind: `"elman"`, `"gru"`, `"lstm"` or `"feed_forward"`.
    history: rows of inputs that the network sees at a step; None: 4 for `feed_forward`, 1 for the other kinds.
    members: networks trained from different random weights; the answer is their mean.
    optimiser: `"adam"`, or `"lbfgs"` on all windows at once.
    window: consecutive rows through which errors are propagated back.
    stride: rows from the start of one window to the start of the next.
    loss: `"every_row"` or `"last_row"` of a window counts.
    train_share, split_blocks: share of the rows that trains, and blocks that are split so.
    batch, learning_rate, decay_patience, decay: steps of the optimiser (Adam).
    patience, max_epochs: epochs without a better validation error after which training ends, and most epochs.
    random_state: seed; the same seed gives the same bits.
    """

    n_epochs_: int
    """Epochs begun."""
    validation_mae_: float
    """Smallest mean absolute error on the validation rows, in the outputs' unit."""
    stopped_: str
    """`patience` or `epochs`."""
    history_: list[tuple[int, float, float, float]]
    """Epoch, training loss, validation error and learning rate of every epoch."""

    def __init__(
        self,
        hidden: int = 30,
        *,
        kind: str = "elman",
        history: int | None = None,
        members: int = 1,
        optimiser: str = "adam",
        window: int = 10,
        stride: int = 10,
        loss: str = "every_row",
        train_share: float = 0.7,
        split_blocks: int = 1,
        batch: int = 16,
        learning_rate: float = 4e-3,
        decay_patience: int = 20,
        decay: float = 0.5,
        patience: int = 60,
        max_epochs: int = 1000,
        random_state: int = 0,
    ) -> None:
        self.hidden = hidden
        self.kind = kind
        self.history = history
        self.members = members
        self.optimiser = optimiser
        self.window = window
        self.stride = stride
        self.loss = loss
        self.train_share = train_share
        self.split_blocks = split_blocks
        self.batch = batch
        self.learning_rate = learning_rate
        self.decay_patience = decay_patience
        self.decay = decay
        self.patience = patience
        self.max_epochs = max_epochs
        self.random_state = random_state

    def fit(self, X: ArrayLike, y: ArrayLike | None = None, sequences: Sequence[int] = ()) -> Self:
        """Train on (samples, features) and (samples,) or (samples, outputs), in time order. `sequences`: the first rows of
        recordings that follow each other. Raises InputError; returns the estimator."""
        inputs, outputs = self._training(X, y)
        options = self.get_params()
        seed = options.pop("random_state")
        if isinstance(seed, bool) or not isinstance(seed, (int, np.integer)) or seed < 0:
            raise InputError(f"random_state: found {seed!r}, expected a whole number, 0 or more")
        config = json.dumps(options, default=lambda number: number.item())
        self._core = _core._Network.train(inputs, outputs, list(sequences), config, int(seed))
        self.n_epochs_, _, self.validation_mae_, self.stopped_ = self._core.summary
        self.history_ = self._core.history
        return self

    def predict(self, X: ArrayLike, sequences: Sequence[int] = ()) -> Array:
        """Outputs (samples,) or (samples, outputs) row by row; the state is reset at the rows `sequences` and at the first."""
        queries = self._queries(X)
        return self._shaped(self._core.predict(queries, list(sequences)))

    def _mean(self, X: ArrayLike) -> Array:
        return self.predict(X)

    def __getstate__(self) -> dict[str, Any]:
        state = dict(self.__dict__)
        if "_core" in state:
            state["_core"] = self._core.dump()
        return state

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        if "_core" in state:
            self._core = _core._Network.load(state["_core"])


ElmanRegressor = NetworkRegressor
"""Alias of `NetworkRegressor`, whose default kind is `elman`."""
