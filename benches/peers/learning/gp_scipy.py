"""NumPy and SciPy by hand: what can be had in Python with LAPACK, an analytic gradient and one matrix product for it."""

import numpy as np
import scipy
import scipy.optimize
from peer import BOUNDS, START, Process, serve, timed
from scipy.linalg import lapack, solve_triangular


def covariances(left, right, theta):
    """Signal part of the covariance matrix."""
    left, right = left * np.exp(-theta[1:8]), right * np.exp(-theta[1:8])
    squares = (left**2).sum(1)[:, None] + (right**2).sum(1) - 2.0 * left @ right.T
    return np.exp(theta[0] - 0.5 * np.maximum(squares, 0.0))


def factor(inputs, theta):
    """Signal part and lower Cholesky factor of the whole."""
    signal = covariances(inputs, inputs, theta)
    whole = signal.copy(order="F")
    whole.flat[:: len(inputs) + 1] += np.exp(theta[8])
    lower, failed = lapack.dpotrf(whole, lower=1, overwrite_a=1, clean=1)
    return signal, None if failed else lower


def loss(theta, inputs, output):
    """Negative log marginal likelihood and gradient: N³/3 operations for the factor, 2 N³/3 for the inverse."""
    signal, lower = factor(inputs, theta)
    if lower is None:
        return 1e25, np.zeros(9)
    alpha = lapack.dpotrs(lower, output, lower=1)[0]
    value = 0.5 * output @ alpha + np.log(np.diag(lower)).sum() + 0.5 * len(output) * np.log(2.0 * np.pi)
    inverse = lapack.dpotri(lower, lower=1, overwrite_c=1)[0]
    weights = np.outer(alpha, alpha) - (inverse + np.tril(inverse, -1).T)
    trace = np.trace(weights)
    weights *= signal
    scaled, rows = inputs * np.exp(-theta[1:8]), weights.sum(1)
    lengths = (scaled**2).T @ rows - np.einsum("nd,nd->d", scaled, weights @ scaled)
    return value, -np.concatenate([[0.5 * rows.sum()], lengths, [0.5 * np.exp(theta[8]) * trace]])


def fit(inputs, output):
    found = scipy.optimize.minimize(loss, START, (inputs, output), "L-BFGS-B", jac=True, bounds=BOUNDS)
    lower = factor(inputs, found.x)[1]
    alpha = lapack.dpotrs(lower, output, lower=1)[0]
    return (inputs, found.x, lower, alpha), -found.fun, found.nfev


def predict(models, queries):
    means, variances = [], []
    for inputs, theta, lower, alpha in models:
        k = covariances(inputs, queries, theta)
        means.append(alpha @ k)
        half = solve_triangular(lower, k, lower=True, check_finite=False, overwrite_b=True)
        variances.append(np.exp(theta[0]) - np.einsum("ij,ij->j", half, half))
    return np.stack(means, 1), np.stack(variances, 1)


PROCESS = Process(fit, predict)


def evaluation(size, _):
    inputs, outputs = PROCESS.load(size)[:2]
    theta, output = PROCESS.models[size][0][1], np.ascontiguousarray(outputs[:, 0])
    return {"cpu_s": timed(lambda: loss(theta, inputs, output))[1]}


def product(kind):
    def run(size, _):
        left = np.random.default_rng(1).standard_normal((size, size)).astype(kind)
        out = np.empty_like(left)
        return {"cpu_s": timed(lambda: np.dot(left, left, out=out))[1]}

    return run


serve(
    PROCESS.tasks() | {"evaluation": evaluation, "product_f64": product("f8"), "product_f32": product("f4")},
    {"NumPy": np.__version__, "SciPy": scipy.__version__},
)
