"""snap.csv: snap-through of a clamped curved strip under dead tip forces in its plane.

The rest curvature about +y bends the unloaded strip towards +x; an axial force (0, 0, -P) presses it while a lateral F_x pushes
it along its arc (+) or against it (-). Method: shooting from the tip (DOP853, rtol 1e-12), so that equilibrium is one equation
theta(0) = 0 for (tip angle, F_x); the curve is followed by pseudo-arclength, folds are where the Jacobi field from the tip
vanishes at the clamp (Brent's method on the tip's angle). A part is stable in the plane when its Jacobi field has no zero, out of
it when the second variation is positive (second_variation.py): for a round rod and for a strip of twice the bending
stiffness about x, whose curve in the plane is the same.
"""

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from planar_rod import Rod, from_tip, write
from second_variation import condensed, least_out_of_plane, zeros_in_plane

# Rest curvature (rad/m) and axial force in Euler loads; the curve begins at this F_x (Euler loads).
CASES = ((1.0, 1.3), (0.5, 1.4), (0.3, 1.6), (8.0, 1.6))
BEGIN = 2.0
STRIP_RATIO = 2.0
# F_x beyond a fold on the stable branches, and from one fold to the other on the unstable one.
BEYOND_EULER = (0.02, 0.1, 0.3, 0.6, 1.0)
BETWEEN = (0.25, 0.5, 0.75)


class Strip:
    def __init__(self, curvature, axial):
        self.rod = Rod(rest_curvature_rad_m=curvature)
        self.unit, self.axial = self.rod.euler_n, axial

    def force(self, y):
        return (y[1] * self.unit, -self.axial * self.unit)

    def residual(self, y):
        return from_tip(self.rod, y[0], self.force(y))[0]

    def slopes(self, y):
        d = 1e-6
        return np.array([(self.residual(y + d * e) - self.residual(y - d * e)) / (2 * d) for e in np.eye(2)])

    def put(self, angle, near):
        """F_x / Euler load at this tip angle, by the secant of Newton's method from nearby."""
        y = np.array([angle, near])
        for _ in range(20):
            value = self.residual(y)
            if abs(value) < 1e-13:
                break
            y[1] -= value / self.slopes(y)[1]
        return y

    def curve(self, step=0.04, limit=400):
        """(tip angle, F_x / Euler load) from a strong push along the arc to a strong one against it."""
        begin = lambda angle: self.residual((angle, BEGIN))
        y, way, out = np.array([brentq(begin, 0.1, 3.1, xtol=1e-13), BEGIN]), None, []
        while len(out) < limit and y[1] > -2.5:
            out.append(y)
            slopes = self.slopes(y)
            along = np.array([-slopes[1], slopes[0]]) / np.hypot(*slopes)
            way = -along * np.sign(along[1]) if way is None else along * np.sign(along @ way)
            y = y + step * way
            for _ in range(8):
                slopes = self.slopes(y)
                change = -self.residual(y) * slopes / (slopes @ slopes)
                y = y + change
                if abs(change).max() < 1e-11:
                    break
        return np.array(out)

    def jacobi(self, y):
        """The Jacobi field from the tip, at the clamp: zero at a fold."""
        rod, force = self.rod, self.force(y)

        def slope(_, u):
            moment, stiff = condensed(rod, u[0], force)
            return [rod.rest_curvature_rad_m + u[1] / rod.bending_n_m2, moment, u[3] / rod.bending_n_m2, stiff * u[2]]

        start = [y[0], 0.0, 1.0, 0.0]
        return solve_ivp(slope, (rod.length_m, 0), start, method="DOP853", rtol=1e-12, atol=1e-14).y[2, -1]

    def at_force(self, path, share):
        """Where a monotone piece of the curve has this F_x (Euler loads)."""
        k = next(k for k in range(len(path) - 1) if (path[k, 1] - share) * (path[k + 1, 1] - share) <= 0)
        near = lambda angle: np.interp(angle, *np.sort(path[k : k + 2], axis=0).T)
        angle = brentq(lambda angle: self.put(angle, near(angle))[1] - share, *path[k : k + 2, 0], xtol=1e-13)
        return self.put(angle, share)

    def crossing(self, path, value):
        """Points of the curve where `value` of a point changes its sign."""
        values = [value(y) for y in path]
        out = []
        for k in range(len(path) - 1):
            if values[k] * values[k + 1] < 0:
                near = lambda angle: np.interp(angle, *np.sort(path[k : k + 2], axis=0).T)
                angle = brentq(lambda angle: value(self.put(angle, near(angle))), *path[k : k + 2, 0], xtol=1e-12)
                out.append(self.put(angle, near(angle)))
        return out

    def row(self, branch, y):
        _, x, z = from_tip(self.rod, y[0], self.force(y))
        fold = branch == "fold"
        plane = "" if fold else int(zeros_in_plane(self.rod, y[0], self.force(y)) == 0)
        out = [least_out_of_plane(self.rod, y[0], self.force(y), 200, ratio) > 0 for ratio in (1.0, STRIP_RATIO)]
        stable = ["", ""] if branch == "out_of_plane" else [int(bool(plane == 1 or fold) and ok) for ok in out]
        return [self.rod.rest_curvature_rad_m, self.axial, branch, y[1], *self.force(y), x, z, y[0], plane, *stable]


def main():
    rows = []
    for curvature, axial in CASES:
        strip = Strip(curvature, axial)
        path = strip.curve()
        folds = strip.crossing(path, strip.jacobi)
        print(curvature, axial, "folds", folds, "curve", path[0], path[-1], flush=True)
        if folds:
            first, second = folds
            upper = np.vstack([path[path[:, 0] > first[0]], first])
            middle = np.vstack([first, path[(path[:, 0] < first[0]) & (path[:, 0] > second[0])], second])
            lower = np.vstack([second, path[path[:, 0] < second[0]]])
            shares = [("upper", upper, first[1] + d) for d in reversed(BEYOND_EULER)]
            shares += [("unstable", middle, first[1] + d * (second[1] - first[1])) for d in BETWEEN]
            shares += [("lower", lower, second[1] - d) for d in BEYOND_EULER]
            rows += [strip.row(name, strip.at_force(part, share)) for name, part, share in shares]
            rows += [strip.row("fold", y) for y in folds]
        else:
            rows += [
                strip.row("only", strip.at_force(path, share))
                for share in (1.0, 0.5, 0.0, -0.5, -1.0, -1.5, -2.0, -2.25)
            ]
        round_ = strip.crossing(path[::3], lambda y: least_out_of_plane(strip.rod, y[0], strip.force(y), 200))
        rows += [strip.row("out_of_plane", y) for y in round_]
        print("out of plane", round_, flush=True)
    header = (
        "rest_curvature_rad_m,axial_share,branch,lateral_share,force_x_n,force_z_n,tip_x_m,tip_z_m,tip_angle_rad,"
        "stable_in_plane,stable_round,stable_strip"
    )
    write("snap.csv", header.split(","), rows)


if __name__ == "__main__":
    main()
