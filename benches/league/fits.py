"""Maps from commands to tips that are fitted to measured trials. They know no mechanics, but for arcs and MuJoCo.

A tip depends on the commands of the rows before: those of its own row have not acted yet. Regression
and Gaussian processes see the last two (LAGS). A row of a real robot is a pose at rest (column `at_rest`): they see its own
command alone.

    ridge(degree)       ridge regression on monomials of the last command up to a degree and on the one before; its
                        regularisation has the least error on trials left out, one at a time (poses at rest: patterns, or
                        tenths of a single one)
    GaussianProcess     squared exponential kernel with a length for each command, one process for each coordinate;
                        lengths, signal and noise by maximum likelihood
    arcs                a chain of arcs (constant curvature), one for each segment, at rest under the last command: for each
                        segment a gain and a rest curvature, and for all a base tilt and a scale of length
    mujoco_sysid        MuJoCo's own system identification (`pip install "mujoco[sysid]"`): it fits eight numbers of
                        robots.py's chain to the first SYSID_TRIALS trials, in time. With the MuJoCo robots of the league it
                        shares the simulator: read it beside the others on the robots of the rod.
"""

import contextlib
import csv
import io
import itertools

import numpy as np
from mujoco import sysid
from trial import Trial

# Commands that maps see; steps of the search for the largest likelihood.
LAGS, STEPS = 2, 80
SYSID_TRIALS, SYSID_ITERATIONS = 2, 4
# Effects of catalogue.py that mujoco_sysid fits: effect, parameter, value without it, usual size.
SYSID_NUMBERS = (
    ("bending_stiffness", "scale", 1.0, 0.1), ("tendon_radius", "scale", 1.0, 0.04),
    ("distributed_mass", "scale", 1.0, 0.2), ("damping", "time_s", 0.03, 0.02),
    ("base_tilt", "tilt_x_rad", 0.0, 0.01), ("base_tilt", "tilt_y_rad", 0.0, 0.01),
    ("precurvature", "kappa_x_rad_m", 0.0, 0.2), ("precurvature", "kappa_y_rad_m", 0.0, 0.2),
)  # fmt: skip


class Recording:
    """Rows of a table. `commands_m` are those that have acted on each row, the newest first; `tips_m` is None where asked.
    Commands may also be tensions in N or angles of drives in rad. Rows of one `group` are left out together."""

    def __init__(self, file):
        with open(file, newline="") as rows:
            rows = list(csv.DictReader(rows))
        units = ("_m", "_s", "_n", "_rad")
        columns = {key: np.array([float(row[key] or "nan") for row in rows]) for key in rows[0] if key.endswith(units)}
        self.trial = np.array([int(row["trial"]) for row in rows])
        self.time_s, self.step_s = columns["time_s"], float(columns["time_s"][1] - columns["time_s"][0])
        self.pulls_m = np.column_stack([value for key, value in columns.items() if key.startswith(("tendon_", "drive_"))])
        self.at_rest, self.group = "at_rest" in rows[0], self.trial
        self.tips_m = np.column_stack([columns[f"tip_{axis}_m"] for axis in "xyz"]) if "tip_x_m" in columns else None
        self.commands_m = np.hstack([self.before(lag) for lag in range(1, LAGS + 1)])
        if self.at_rest:
            self.commands_m = self.pulls_m
            self.group = np.unique([row["pattern"] for row in rows], return_inverse=True)[1]
            if not self.group.any():
                self.group = np.arange(len(rows)) * 10 // len(rows)

    def last_m(self):
        """The last commands that have acted."""
        return self.commands_m[:, : self.pulls_m.shape[1]]

    def before(self, lag):
        """Commands so many rows before; home before the first."""
        before_m = np.zeros_like(self.pulls_m)
        before_m[lag:] = np.where((self.trial[lag:] == self.trial[:-lag])[:, None], self.pulls_m[:-lag], 0.0)
        return before_m


def monomials(x, tendons, degree):
    """Of the last commands up to the degree, and the others as they are."""
    last = x[:, :tendons]
    columns = [
        np.prod(last[:, list(chosen)], axis=1)
        for power in range(1, degree + 1)
        for chosen in itertools.combinations_with_replacement(range(tendons), power)
    ]
    return np.column_stack([*columns, x[:, tendons:]])


def ridge(given, asked, degree):
    """Tips under the asked commands."""
    scale, tendons = given.commands_m.std(), given.pulls_m.shape[1]
    x, asked = (monomials(part.commands_m / scale, tendons, degree) for part in (given, asked))
    tips_m = given.tips_m

    def solve(rows, weights):
        """Coefficients for each weight, and the means that they belong to."""
        x_mean, tip_mean = x[rows].mean(axis=0), tips_m[rows].mean(axis=0)
        left, sizes, right = np.linalg.svd(x[rows] - x_mean, full_matrices=False)
        projected = left.T @ (tips_m[rows] - tip_mean)
        return x_mean, tip_mean, [right.T @ ((sizes / (sizes**2 + weight))[:, None] * projected) for weight in weights]

    weights = len(x) * np.logspace(-8, 1, 28)
    errors = np.zeros(len(weights))
    for left_out in np.unique(given.group):
        rows = given.group != left_out
        x_mean, tip_mean, all_coefficients = solve(rows, weights)
        for i, coefficients in enumerate(all_coefficients):
            errors[i] += ((tip_mean + (x[~rows] - x_mean) @ coefficients - tips_m[~rows]) ** 2).sum()
    x_mean, tip_mean, (coefficients,) = solve(slice(None), [weights[np.argmin(errors)]])
    return tip_mean + (asked - x_mean) @ coefficients


class GaussianProcess:
    """One coordinate. `evidence` is the logarithm of the marginal likelihood, of values in standard deviations."""

    def __init__(self, x, values):
        self.x, self.mean, self.spread = x, values.mean(), values.std()
        self.y = (values - self.mean) / self.spread
        # Logarithms of lengths, of the signal's deviation and of that of the noise.
        point = np.r_[np.full(x.shape[1], np.log(2 * np.sqrt(x.shape[1]))), 0.0, np.log(0.2)]
        # Rprop: steps that grow while the gradient keeps its sign.
        step, before, self.evidence = np.full(len(point), 0.1), np.zeros(len(point)), -np.inf
        for _ in range(STEPS):
            evidence, gradient, solution = self.likelihood(point)
            if evidence > self.evidence:
                self.evidence, self.point, self.solution = evidence, point.copy(), solution
            same = np.sign(gradient) * np.sign(before)
            step = np.clip(step * np.where(same > 0, 1.2, np.where(same < 0, 0.5, 1.0)), 1e-3, 0.5)
            before = np.where(same < 0, 0.0, gradient)
            point = np.clip(point + step * np.sign(before), -7.0, 7.0)

    def kernel(self, point, other):
        a, b = self.x / np.exp(point[:-2]), other / np.exp(point[:-2])
        squares = (a**2).sum(axis=1)[:, None] + (b**2).sum(axis=1) - 2 * a @ b.T
        return np.exp(2 * point[-2] - 0.5 * np.maximum(squares, 0.0))

    def likelihood(self, point):
        count, noise = len(self.y), np.exp(2 * point[-1]) + 1e-8
        kernel = self.kernel(point, self.x)
        root = np.linalg.cholesky(kernel + noise * np.eye(count))
        inverse_root = np.linalg.solve(root, np.eye(count))
        inverse = inverse_root.T @ inverse_root
        solution = inverse @ self.y
        evidence = -0.5 * self.y @ solution - np.log(np.diag(root)).sum() - 0.5 * count * np.log(2 * np.pi)
        outer = np.outer(solution, solution) - inverse
        weighted = outer * kernel
        a = self.x / np.exp(point[:-2])
        lengths = weighted.sum(axis=1) @ a**2 - (a * (weighted @ a)).sum(axis=0)
        return evidence, np.r_[lengths, weighted.sum(), np.trace(outer) * noise], solution

    def __call__(self, other):
        return self.mean + self.spread * self.kernel(self.point, other).T @ self.solution


def processes(given, tips_m, asked):
    """What is given as tips, under the asked commands."""
    x, other = given.commands_m / given.commands_m.std(), asked.commands_m / given.commands_m.std()
    return np.column_stack([GaussianProcess(x, column)(other) for column in tips_m.T])


def stepwise(choices, values, most):
    """Names of groups of columns, [(name, columns)], that lower the BIC of a regression one after the other."""
    found, taken = [], np.zeros((len(values), 0))

    def bic(columns):
        off = values - columns @ np.linalg.lstsq(columns, values, rcond=None)[0]
        return len(off) * np.log(off @ off / len(off)) + columns.shape[1] * np.log(len(off))

    while len(found) < most:
        rest = [choice for choice in choices if choice[0] not in found]
        name, columns = min(rest, key=lambda choice: bic(np.hstack([taken, choice[1]])))
        if bic(np.hstack([taken, columns])) >= bic(taken):
            break
        found, taken = [*found, name], np.hstack([taken, columns])
    return found


def least_squares(residual, point):
    """Levenberg-Marquardt with derivatives by differences; all numbers are of the order of 1."""
    damping, value = 1e-3, residual(point)
    for _ in range(60):
        derivative = np.column_stack([(residual(point + 1e-6 * unit) - value) / 1e-6 for unit in np.eye(len(point))])
        normal = derivative.T @ derivative
        step = np.linalg.solve(normal + damping * np.diag(np.diag(normal) + 1e-12), -derivative.T @ value)
        new = residual(point + step)
        if new @ new < value @ value:
            point, value, damping = point + step, new, damping / 5
        else:
            damping *= 10
    return point


def arc_tips(robot, pulls_m, numbers):
    """Tips of a chain of arcs. `numbers`: gain and rest bend in rad about two axes of each segment, tilt in rad, length."""
    ends_m = np.array(robot.tendon_ends_m or [robot.length_m] * len(robot.tendon_angles_rad))
    segment_ends_m = np.unique(ends_m)
    count = len(segment_ends_m)
    holes_m = robot.holes_m()
    passed = np.repeat(ends_m[:, None] >= segment_ends_m - 1e-9, 2, axis=1)
    bends = (pulls_m @ np.linalg.pinv(passed * np.tile(holes_m, count)).T).reshape(-1, count, 2)
    by_segment = numbers[: 3 * count].reshape(count, 3)
    bends = by_segment[:, 0, None] * bends + by_segment[:, 1:]
    tips_m = np.zeros((len(pulls_m), 3))
    frames = np.tile(turn(numbers[None, 3 * count : 3 * count + 2]), (len(pulls_m), 1, 1))
    for segment, length_m in enumerate(np.diff(segment_ends_m, prepend=0.0) * numbers[-1]):
        bend = bends[:, segment]
        angle = np.linalg.norm(bend, axis=1) + 1e-12
        aside = (2 * np.sin(angle / 2) ** 2 / angle**2)[:, None] * bend
        local_m = length_m * np.column_stack([aside, np.sin(angle) / angle])
        tips_m += np.einsum("nij,nj->ni", frames, local_m)
        frames = frames @ turn(bend)
    return tips_m


def turn(bend):
    """Rotations that bring the axis z towards these directions of the plane, by as many rad as they are long."""
    angle = np.linalg.norm(bend, axis=1) + 1e-12
    cross = np.zeros((len(bend), 3, 3))
    cross[:, :2, 2], cross[:, 2, :2] = bend / angle[:, None], -bend / angle[:, None]
    sine, cosine = np.sin(angle)[:, None, None], np.cos(angle)[:, None, None]
    return np.eye(3) + sine * cross + (1 - cosine) * cross @ cross


def arcs(robot, given, asked, base_m=0.0, gains=1.0):
    """Tips under the asked commands. `robot`: of robots.py, for its geometry; `gains`: displacements of tendons per command."""
    given_m, asked_m = (np.dot(part.last_m(), gains) for part in (given, asked))
    tips_m = given.tips_m - base_m
    count = len(np.unique(robot.tendon_ends_m or [robot.length_m]))
    start = np.r_[np.tile([1.0, 0.0, 0.0], count), 0.0, 0.0, 1.0]

    def residual(numbers):
        # Tilt and the rest bend of the first segment differ little: a weak pull to the start keeps both finite.
        weak_m = 1e-3 * robot.length_m * (numbers - start)
        return np.r_[(arc_tips(robot, given_m, numbers) - tips_m).ravel(), weak_m]

    fitted = least_squares(residual, start)
    return base_m + arc_tips(robot, asked_m, fitted)


def mujoco_sysid(family, given, asked):
    """Tips under the asked commands. `given`, `asked`: recordings; needs mujoco[sysid]."""

    def play(sizes, recording, trials):
        effects, tips_m = {}, []
        for (effect, key, none, size), value in zip(SYSID_NUMBERS, sizes):
            effects.setdefault(effect, {})[key] = none + size * float(value)
        robot = Trial(family, None, [effects], None, recording.step_s, 0.002)
        for number in trials:
            robot.reset()
            tips_m.append(robot.observe()["tip_m"])
            for pulls in recording.pulls_m[recording.trial == number][:-1]:
                robot.command(pulls)
                tips_m.append(robot.observe()["tip_m"])
        return np.array(tips_m)

    trials = np.unique(given.trial)[:SYSID_TRIALS]
    measured_m = given.tips_m[np.isin(given.trial, trials)]

    def residual(points, _):
        """In millimetres, for a point or for several as columns."""
        off = np.stack([1e3 * (play(sizes, given, trials) - measured_m).ravel() for sizes in np.atleast_2d(points.T)], axis=1)
        return [off.reshape((-1,) + points.shape[1:])], [], []

    # Damping stays positive.
    least = [max(-4.0, -0.9 * none / size) if none else -4.0 for _, _, none, size in SYSID_NUMBERS]
    names = [f"{effect}.{key}" for effect, key, _, _ in SYSID_NUMBERS]
    numbers = {name: sysid.Parameter(name, 0.0, low, 4.0) for name, low in zip(names, least)}
    with contextlib.redirect_stdout(io.StringIO()):
        fitted, _ = sysid.optimize(sysid.ParameterDict(numbers), residual, verbose=False, max_iters=SYSID_ITERATIONS, eps=0.02)
    return play(fitted.as_vector(), asked, np.unique(asked.trial))
