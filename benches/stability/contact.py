"""contact_plane.csv and contact_cylinder.csv: R0 pressed against rigid frictionless obstacles that its axis cannot enter.

Method: shooting from the clamp (DOP853, rtol 1e-12) for the moment, the force and where contact begins (contact radius 0).

Plane, the half-space x <= -d. Touched with the tip alone: x(L) = -d and a force there. Along a line from s on: x' = 0, so
the internal n_x follows from theta, EI theta'' = -z' n_x; x, theta, m and n_x are continuous at s (a shearable rod arrives
without a concentrated force: n_x jumping would turn x' away from the plane), and m(L) = 0. The reaction is spread over a
few sqrt(EI / GA) = 1.7 mm behind s, where an unshearable rod has a concentrated one.

Cylinder: a point contact at an unknown s with a normal force; stretch and shear give the axis a kink of R / GA there, and
the mean of both tangents touches the circle (the kink would be spread over some micrometres of arc).

Complementarity: forces push, and no other point of the axis is inside (checked on 2000 points).
Check (printed by contact_energy.py): least energy of a discrete rod under the same constraints.
"""

import numpy as np
from scipy.optimize import fsolve

from planar_rod import R0, integrate, tangent, write

PLANE_X_M = -0.03
TIP_FORCES_N = (-0.05, -0.1, -0.3, -0.6)
LINES_N_M = (-0.5, -1.0, -3.0, -6.0, -10.0, -20.0, -30.0)
CENTRE_M, CIRCLE_M = np.array([-0.035, 0.15]), 0.02
CYLINDER_FORCES_N = (-0.1, -0.2, -0.3, -0.5, -0.8, -1.2)


def solve(residual, start, scale):
    scale = np.array(scale)
    found, more, _, said = fsolve(lambda y: residual(y * scale), np.array(start) / scale, xtol=1e-13, full_output=True)
    worst = abs(np.array(more["fvec"])).max()
    if worst > 1e-9:
        raise ArithmeticError(f"{said} ({worst})")
    return found * scale


def free(rod, tip, line):
    """No contact: base moment by shooting, on from a tenth of the loads; the base force is known."""
    moment = 0.0
    for share in np.linspace(0.1, 1.0, 10):
        force = (share * (tip + line * rod.length_m), 0.0)
        end = lambda y: integrate(rod, 0, rod.length_m, [0, y[0], 0, 0], force, (share * line, 0.0)).y[:, -1]
        (moment,) = solve(lambda y: [10 * end(y)[1]], [moment * share / max(share - 0.1, 0.1)], [0.1])
    return moment, force, end([moment])


def with_tip(rod, tip, line):
    """Touching the plane with the tip: base moment and the tip's reaction."""

    def end(y):
        return integrate(rod, 0, rod.length_m, [0, y[0], 0, 0], (tip + line * rod.length_m + y[1], 0.0), (line, 0.0)).y[
            :, -1
        ]

    guess = max(-tip, 0) * 0.9 - line * rod.length_m * 0.3
    start = [(tip + guess + line * rod.length_m / 2) * rod.length_m, guess]
    moment, reaction = solve(lambda y: end(y)[1:3] * 10 - [0.0, 10 * PLANE_X_M], start, [0.1, 1.0])
    return moment, reaction, end([moment, reaction])


def held_force(rod, theta):
    """Internal n_x of a rod whose axis runs along the plane with n_z = 0: x' = 0."""
    sin, cos = np.sin(theta), np.cos(theta)
    return -sin / (sin * sin / rod.stretch_n + cos * cos / rod.shear_n)


def with_line(rod, line):
    """Along the plane from s on: (base moment, n_x at the base, s, state at s, tip_z_m, tip force).

    On the plane theta is below 2e-4 and decays like cosh((L - s) / l), l^2 = EI / GA, but for terms of theta^2 (1e-8), which
    gives m(s) = -EI theta / l tanh((L - s) / l)."""
    decay = np.sqrt(rod.bending_n_m2 / rod.shear_n)

    def at(y):
        return integrate(rod, 0, y[2], [0, y[0], 0, 0], (y[1], 0.0), (line, 0.0)).y[:, -1]

    def residual(y):
        end = at(y)
        lever = np.tanh((rod.length_m - y[2]) / decay) / decay
        across = tangent(rod, end[0], end[4], end[5])[0]
        return [10 * (end[2] - PLANE_X_M), across, 10 * (end[1] + rod.bending_n_m2 * end[0] * lever)]

    # The unshearable, linear solution: q s^4 / 72 EI = d, reaction q s / 3 at s.
    where = (72 * rod.bending_n_m2 * PLANE_X_M / line) ** 0.25
    moment, force, where = solve(residual, [line * where**2 / 6, line * where * 2 / 3, where], [0.1, 1.0, 0.1])
    end = at([moment, force, where])
    rest = rod.length_m - where
    # z' - 1 is of the order of theta^2 there.
    return moment, force, where, end, end[3] + rest, held_force(rod, tip_angle(rod, end[0], where))


def tip_angle(rod, theta, where):
    """theta at the free end of a part on the plane, linear in theta (which is below 1e-3 there)."""
    return theta / np.cosh(min((rod.length_m - where) / np.sqrt(rod.bending_n_m2 / rod.shear_n), 700.0))


def plane(rod):
    rows = []
    cases = [(tip, 0.0) for tip in TIP_FORCES_N] + [(0.0, line) for line in LINES_N_M]
    for tip, line in cases:
        load = tip + line * rod.length_m
        moment, force, end = free(rod, tip, line)
        if end[2] >= PLANE_X_M:
            rows.append([tip, line, "none", "", end[2], end[3], end[0], 0.0, 0.0, moment])
            continue
        moment, reaction, end = with_tip(rod, tip, line)
        arrives = tangent(rod, end[0], tip + reaction, 0.0)[0]
        if arrives <= 0:
            assert reaction > 0
            rows.append([tip, line, "tip", rod.length_m, end[2], end[3], end[0], reaction, reaction, moment])
            continue
        moment, force, where, at, z, last = with_line(rod, line)
        total = force - load
        print("line", line, "s", where, "n_x", at[4], "theta", at[0], "tip force", last)
        rows.append([tip, line, "line", where, PLANE_X_M, z, tip_angle(rod, at[0], where), total, last, moment])
    header = (
        "tip_force_x_n,line_force_x_n_m,contact,contact_start_m,tip_x_m,tip_z_m,tip_angle_rad,"
        "contact_force_n,contact_force_at_tip_n,base_moment_nm"
    )
    write("contact_plane.csv", header.split(","), rows)
    return rows


def over_cylinder(rod, tip, start):
    """Unknown: base moment, s, angle of the normal (from +x towards +z) and reaction."""

    def path(y):
        moment, where, angle, reaction = y
        normal = np.array([np.cos(angle), np.sin(angle)])
        base = np.array([tip, 0.0]) + reaction * normal
        first = integrate(rod, 0, where, [0, moment, 0, 0], base, dense=True)
        at = first.y[:, -1]
        second = integrate(rod, where, rod.length_m, at[:4], [tip, 0.0], dense=True)
        return normal, first, second

    def residual(y):
        normal, first, second = path(y)
        at = first.y[:, -1]
        before = np.array(tangent(rod, at[0], at[4], at[5]))
        after = np.array(tangent(rod, at[0], tip, 0.0))
        gap = at[2:4] - CENTRE_M - CIRCLE_M * normal
        return [10 * gap[0], 10 * gap[1], 0.5 * (before + after) @ normal, 10 * second.y[1, -1]]

    found = solve(residual, start, [0.1, 0.1, 1.0, 1.0])
    return found, *path(found)


def cylinder(rod):
    rows, start = [], None
    for tip in CYLINDER_FORCES_N:
        if start is None:
            moment, force, end = free(rod, tip, 0.0)
            s = np.linspace(0, rod.length_m, 2000)
            path = integrate(rod, 0, rod.length_m, [0, moment, 0, 0], force, dense=True).sol(s)
            if np.hypot(path[2] - CENTRE_M[0], path[3] - CENTRE_M[1]).min() >= CIRCLE_M:
                rows.append([tip, "none", "", end[2], end[3], end[0], 0.0, 0.0, 0.0, "", ""])
                continue
            start = [tip * 0.1, 0.15, 0.0, -tip]
        # Once on the cylinder, on from what was found last: a free rod beyond it would be a rest as well.
        found, normal, first, second = over_cylinder(rod, tip, start)
        start = found
        moment, where, angle, reaction = found
        s = np.linspace(0, rod.length_m, 2000)
        places = np.where(s < where, first.sol(np.minimum(s, where))[2:4], second.sol(np.maximum(s, where))[2:4])
        inside = CIRCLE_M - np.hypot(*(places - CENTRE_M[:, None])).min()
        print("cylinder", tip, "s", where, "normal", angle, "R", reaction, "inside", inside)
        assert reaction > 0 and inside < 1e-8
        end, at = second.y[:, -1], first.y[:, -1]
        rows.append([tip, "point", where, end[2], end[3], end[0], reaction, *(reaction * normal), at[2], at[3]])
    header = (
        "tip_force_x_n,contact,contact_s_m,tip_x_m,tip_z_m,tip_angle_rad,contact_force_n,contact_force_x_n,"
        "contact_force_z_n,contact_x_m,contact_z_m"
    )
    write("contact_cylinder.csv", header.split(","), rows)
    return rows


if __name__ == "__main__":
    for found in plane(R0) + cylinder(R0):
        print(*found)
