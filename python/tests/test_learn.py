"""Learners with scikit-learn's conventions, against scikit-learn."""

from __future__ import annotations

import importlib
import pickle
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from spinebench import ElmanRegressor, GaussianProcess, InputError, NetworkRegressor

pytest.importorskip("sklearn")

Array = NDArray[np.float64]


def peer(module: str) -> Any:
    """A module of scikit-learn, which has no types."""
    return importlib.import_module(f"sklearn.{module}")


def samples(rows: int = 60, outputs: int = 1) -> tuple[Array, Array]:
    """Standardised samples of a smooth function, so that standardising changes nothing."""
    rng = np.random.default_rng(7)
    inputs = rng.uniform(-2.0, 2.0, (rows, 3))
    values = np.sin(inputs @ rng.normal(size=(3, outputs))) + 0.1 * rng.normal(size=(rows, outputs))
    inputs = (inputs - inputs.mean(axis=0)) / inputs.std(axis=0)
    values = (values - values.mean(axis=0)) / values.std(axis=0)
    return inputs, values[:, 0] if outputs == 1 else values


@pytest.mark.parametrize(
    ("kernel", "theirs"),
    [
        ("se_ard", lambda k: k.ConstantKernel(1.7) * k.RBF([0.8, 1.3, 2.1])),
        ("matern52", lambda k: k.ConstantKernel(1.7) * k.Matern([0.8, 1.3, 2.1], nu=2.5)),
        ("matern32", lambda k: k.ConstantKernel(1.7) * k.Matern([0.8, 1.3, 2.1], nu=1.5)),
    ],
)
def test_a_fixed_kernel_predicts_what_scikit_learn_does(kernel: str, theirs: Any) -> None:
    process, kernels = peer("gaussian_process"), peer("gaussian_process.kernels")
    inputs, values = samples()
    queries = np.random.default_rng(8).uniform(-2.0, 2.0, (200, 3))
    theta = np.log([1.7, 0.8, 1.3, 2.1, 0.02])
    ours = GaussianProcess(kernel, theta=theta).fit(inputs, values)
    theirs_fitted = process.GaussianProcessRegressor(theirs(kernels), alpha=0.02, optimizer=None).fit(inputs, values)
    mean, std = ours.predict(queries, return_std=True)
    peer_mean, peer_std = theirs_fitted.predict(queries, return_std=True)
    np.testing.assert_allclose(mean, peer_mean, atol=1e-8)
    np.testing.assert_allclose(std, peer_std, atol=1e-8)
    assert abs(ours.log_marginal_likelihood_value_ - theirs_fitted.log_marginal_likelihood_value_) < 1e-8
    np.testing.assert_allclose(ours.theta_[0], theta)
    np.testing.assert_allclose(ours.noise_std_, np.sqrt(0.02))


def test_noise_at_its_least_is_warned_of_and_prevented_by_its_prior() -> None:
    inputs = np.linspace(-1.0, 1.0, 12)[:, None]
    values = np.sin(2.0 * inputs[:, 0])
    with pytest.warns(UserWarning, match="noise variance of output 0 low"):
        free = GaussianProcess().fit(inputs, values)
    assert (0, "noise variance", "low") in free.range_ends_
    known = GaussianProcess(noise_prior=0.05).fit(inputs, values)
    assert known.noise_std_[0] > 0.01 and not any(name == "noise variance" for _, name, _ in known.range_ends_)
    with pytest.raises(InputError, match="noise_prior"):
        GaussianProcess(noise_prior=-1.0).fit(inputs, values)


@pytest.mark.parametrize("approximation", ["sgpr", "fitc"])
def test_inducing_points_come_near_the_exact_process(approximation: str) -> None:
    inputs, values = samples(400, outputs=2)
    queries = np.random.default_rng(8).uniform(-1.5, 1.5, (100, 3))
    exact = GaussianProcess(mean="linear").fit(inputs, values)
    wanted, wanted_std = exact.predict(queries, return_std=True)
    few = GaussianProcess(mean="linear", approximation=approximation, inducing_points=60).fit(inputs, values)
    mean, std = few.predict(queries, return_std=True)
    np.testing.assert_allclose(mean, wanted, atol=0.05)
    # Fewer points know less, and say so.
    assert np.all(std > 0.9 * wanted_std)
    sparse = GaussianProcess(mean="linear", approximation=approximation, inducing_points=150).fit(inputs, values)
    again = pickle.loads(pickle.dumps(sparse))
    mean, std = sparse.predict(queries, return_std=True)
    np.testing.assert_allclose(mean, wanted, atol=1e-3)
    np.testing.assert_allclose(std, wanted_std, atol=1e-3)
    np.testing.assert_array_equal(again.predict(queries), mean)
    with pytest.raises(InputError, match="^approximation: .*`exact`, `sgpr`, `fitc`$"):
        GaussianProcess(approximation="vfe").fit(inputs, values)


def test_leave_one_out_is_a_fit_without_the_sample() -> None:
    process, kernels = peer("gaussian_process"), peer("gaussian_process.kernels")
    inputs, values = samples()
    kernel = kernels.ConstantKernel(1.7) * kernels.RBF([0.8, 1.3, 2.1])
    ours = GaussianProcess(theta=np.log([1.7, 0.8, 1.3, 2.1, 0.02])).fit(inputs, values)
    mean, std, log_probability = ours.leave_one_out()
    for i in (0, 17, 59):
        others = np.arange(len(values)) != i
        theirs = process.GaussianProcessRegressor(kernel, alpha=0.02, optimizer=None).fit(inputs[others], values[others])
        (wanted,), (latent,) = theirs.predict(inputs[i : i + 1], return_std=True)
        whole = np.sqrt(latent**2 + 0.02)
        np.testing.assert_allclose([mean[i], std[i]], [wanted, whole], atol=1e-8)
        density = -0.5 * ((values[i] - wanted) / whole) ** 2 - np.log(whole * np.sqrt(2.0 * np.pi))
        np.testing.assert_allclose(log_probability[i], density, atol=1e-7)


def test_the_search_finds_at_least_what_scikit_learn_finds() -> None:
    process, kernels = peer("gaussian_process"), peer("gaussian_process.kernels")
    inputs, values = samples()
    kernel = kernels.ConstantKernel(1.0) * kernels.RBF([1.0, 1.0, 1.0]) + kernels.WhiteKernel(0.1)
    theirs_fitted = process.GaussianProcessRegressor(kernel, n_restarts_optimizer=3, random_state=1).fit(inputs, values)
    ours = GaussianProcess().fit(inputs, values)
    assert ours.log_marginal_likelihood_value_ > theirs_fitted.log_marginal_likelihood_value_ - 1e-2
    assert ours.score(inputs, values) > 0.95
    assert len(ours.hyperparameter_names_) == ours.theta_.shape[1] == 5


def test_several_outputs_pickle_and_clone() -> None:
    clone = peer("base").clone
    inputs, values = samples(outputs=2)
    ours = GaussianProcess("se + linear", starts=2).fit(inputs, values)
    mean, std = ours.predict(inputs, return_std=True)
    assert mean.shape == std.shape == (60, 2) and (std >= 0.0).all()
    again = pickle.loads(pickle.dumps(ours))
    np.testing.assert_array_equal(again.predict(inputs), mean)
    other = clone(ours).set_params(kernel="matern52")
    assert other.get_params()["starts"] == 2 and ours.kernel == "se + linear" and not hasattr(other, "theta_")
    assert repr(other) == "GaussianProcess(kernel='matern52', starts=2)"


def test_it_works_in_a_search_over_parameters() -> None:
    make_pipeline, scaler = peer("pipeline").make_pipeline, peer("preprocessing").StandardScaler()
    inputs, values = samples()
    search = peer("model_selection").GridSearchCV(
        make_pipeline(scaler, GaussianProcess(starts=1)),
        {"gaussianprocess__kernel": ["se_ard", "constant"]},
        cv=3,
    ).fit(inputs, values)
    assert search.best_params_["gaussianprocess__kernel"] == "se_ard"


def test_a_network_learns_a_memory() -> None:
    rng = np.random.default_rng(3)
    inputs = rng.uniform(-1.0, 1.0, (600, 1))
    values = inputs[:, 0] + np.concatenate([[0.0], inputs[:-1, 0]])
    options: dict[str, Any] = {"hidden": 12, "max_epochs": 300, "learning_rate": 1e-2}
    ours = NetworkRegressor(**options).fit(inputs, values)
    assert ours.score(inputs, values) > 0.95 and ours.validation_mae_ < 0.2
    assert ours.n_epochs_ == len(ours.history_)
    blind = NetworkRegressor(window=1, stride=1, **options).fit(inputs, values)
    assert blind.score(inputs, values) < 0.7
    same = NetworkRegressor(**options).fit(inputs, values)
    np.testing.assert_array_equal(same.predict(inputs), ours.predict(inputs))
    np.testing.assert_array_equal(pickle.loads(pickle.dumps(ours)).predict(inputs), ours.predict(inputs))
    assert ElmanRegressor is NetworkRegressor
    gated = NetworkRegressor(kind="gru", members=2, **options).fit(inputs, values)
    assert gated.score(inputs, values) > 0.95
    shown = NetworkRegressor(kind="feed_forward", history=2, optimiser="lbfgs", **options).fit(inputs, values)
    assert shown.score(inputs, values) > 0.95 and shown.validation_mae_ < blind.validation_mae_
    # A row at which a sequence begins has no past.
    np.testing.assert_array_equal(ours.predict(inputs, sequences=[7])[7:], ours.predict(inputs[7:]))


@pytest.mark.parametrize(
    "call",
    [
        lambda X, y: GaussianProcess("sine").fit(X, y),
        lambda X, y: GaussianProcess(starts=0).fit(X, y),
        lambda X, y: GaussianProcess(theta=[0.0]).fit(X, y),
        lambda X, y: GaussianProcess(kernel=3).fit(X, y),  # type: ignore[arg-type]
        lambda X, y: NetworkRegressor(loss="some").fit(X, y),
        lambda X, y: NetworkRegressor(random_state=-1).fit(X, y),
        lambda X, y: NetworkRegressor(kind="transformer").fit(X, y),
        lambda X, y: NetworkRegressor(members=0).fit(X, y),
        lambda X, y: NetworkRegressor().fit(X[:5], y[:5]),
        lambda X, y: NetworkRegressor(max_epochs=1).fit(X, y, sequences=[9, 3]),
        lambda X, y: GaussianProcess().set_params(kernal="se"),
    ],
)
def test_bad_settings_are_told(call: Any) -> None:
    with pytest.raises(InputError) as error:
        call(*samples())
    assert "expected" in str(error.value), error.value


def test_scikit_learn_is_not_needed(monkeypatch: pytest.MonkeyPatch) -> None:
    from spinebench import _learn

    inputs, values = samples()
    with_it = GaussianProcess(starts=1).fit(inputs, values).predict(inputs)
    monkeypatch.setattr(_learn, "_sklearn", lambda module: None)
    ours = GaussianProcess(starts=1).fit(inputs, values)
    np.testing.assert_array_equal(ours.predict(inputs), with_it)
    wrong: list[tuple[Any, Any]] = [
        (inputs[0], values),
        (inputs, values[:-1]),
        (inputs, None),
        (np.where(inputs > 1.0, np.nan, inputs), values),
    ]
    for bad in wrong:
        with pytest.raises(InputError):
            GaussianProcess().fit(*bad)
    with pytest.raises(InputError):
        ours.predict(inputs[:, :2])
    with pytest.raises(_learn.NotFittedError):
        GaussianProcess().predict(inputs)


def test_the_checks_of_scikit_learn_pass() -> None:
    check_estimator = peer("utils.estimator_checks").check_estimator
    check_estimator(GaussianProcess(starts=1))
    memoryless = NetworkRegressor(hidden=8, window=1, stride=1, max_epochs=20)
    check_estimator(memoryless)


def test_with_memory_only_checks_of_independent_rows_fail() -> None:
    check_estimator = peer("utils.estimator_checks").check_estimator
    order = "what is predicted for a row depends on the rows before it"
    expected = {
        "check_methods_subset_invariance": order,
        "check_methods_sample_order_invariance": order,
    }
    memory = NetworkRegressor(hidden=8, window=2, stride=1, max_epochs=20)
    check_estimator(memory, expected_failed_checks=expected)
