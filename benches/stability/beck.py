"""beck.csv: Beck's column, a clamped rod under a follower force at its tip, without and with Kelvin-Voigt damping.

EI (1 + tau d/dt) w'''' + P w'' + rho A w_tt = 0, w(0) = w'(0) = w''(L) = w'''(L) = 0. Method: Galerkin (columns.py) and the
roots of the characteristic determinant for the undamped column (M. Beck 1952, Z. angew. Math. Phys. 3; damped: V. V. Bolotin,
Nonconservative Problems of the Theory of Elastic Stability, 1963).
"""

import numpy as np
from scipy.optimize import fsolve

from columns import Shapes, bisect, eigenvalues
from planar_rod import R0, write

TIMES_S = (1e-4, 1e-3, 0.03)
SHARES = (0.9, 1.1, 1.3)


def stiffness(shapes, force):
    """int psi'' w'' - P int psi' w' + P psi(L) w'(L): P w'' by parts."""
    return shapes.bending - force * shapes.slopes + force * np.outer(shapes.tip, shapes.tip_slope)


def determinant(force, omega):
    """Zero where omega is a frequency of the undamped column (force and omega without units)."""
    root = np.sqrt(force**2 / 4 + omega**2)
    a, b = np.sqrt(force / 2 + root), np.sqrt(root - force / 2)
    # w = A cos as + B sin as + C cosh bs + D sinh bs with C = -A, D = -B a / b.
    ca, sa, cb, sb = np.cos(a), np.sin(a), np.cosh(b), np.sinh(b)
    bend = (-a * a * ca - b * b * cb, -a * a * sa - a * b * sb)
    shear = (a**3 * sa - b**3 * sb, -(a**3) * ca - a * b * b * cb)
    return bend[0] * shear[1] - bend[1] * shear[0]


def undamped_critical():
    """Where two frequencies meet: the determinant and its slope by omega vanish (slope by central differences)."""
    slope = lambda p, w: (determinant(p, w + 1e-4) - determinant(p, w - 1e-4)) / 2e-4
    return fsolve(lambda y: [determinant(*y), slope(*y)], [20.05, 11.0], xtol=1e-13)


def critical(count, tau):
    shapes = Shapes(count)
    if tau == 0:
        # Undamped the frequencies are real until two meet.
        fast = lambda force: abs(eigenvalues(stiffness(shapes, force), 0 * shapes.bending).real).max() > 1e-3
        return bisect(fast, 15.0, 25.0)
    unstable = lambda force: eigenvalues(stiffness(shapes, force), tau * shapes.bending).real.max() > 0
    first = next(force for force in np.arange(1.0, 1000.0, 0.5) if unstable(force))
    return bisect(unstable, first - 0.5, first)


def main():
    rod = R0
    time_s = rod.length_m**2 * np.sqrt(rod.mass_kg_m / rod.bending_n_m2)
    unit_n = rod.bending_n_m2 / rod.length_m**2
    exact, omega = undamped_critical()
    print("undamped", exact, omega, "Galerkin", critical(16, 0), critical(20, 0))
    rows = [["critical", 0.0, "", exact, exact * unit_n, 0.0, omega / time_s]]
    for tau_s in TIMES_S:
        found = [critical(count, tau_s / time_s) for count in (10, 14, 18)]
        shapes = Shapes(16)
        lambdas = eigenvalues(stiffness(shapes, found[-1]), tau_s / time_s * shapes.bending)
        at = lambdas[np.argmax(lambdas.real + 1e-9 * lambdas.imag)]
        print(tau_s, found, at / time_s)
        rows.append(["critical", tau_s, "", found[-1], found[-1] * unit_n, 0.0, abs(at.imag) / time_s])
    for tau_s in (0.0, *TIMES_S):
        for share in SHARES:
            per = []
            for count in (14, 18):
                shapes = Shapes(count)
                lambdas = eigenvalues(stiffness(shapes, share * exact), tau_s / time_s * shapes.bending)
                if share < 1 and tau_s == 0:
                    slow = lambdas[lambdas.imag > 0]
                    per.append(1j * np.sort(slow.imag)[0])
                else:
                    per.append(lambdas[np.argmax(lambdas.real + 1e-9 * lambdas.imag)])
            print(tau_s, share, np.array(per) / time_s)
            rows.append(
                [
                    "eigenvalue",
                    tau_s,
                    share,
                    share * exact,
                    share * exact * unit_n,
                    per[-1].real / time_s,
                    per[-1].imag / time_s,
                ]
            )
    header = (
        "kind,damping_time_s,share_of_undamped,load_ei_per_l2,load_n,lambda_real_1_per_s,lambda_imag_1_per_s".split(",")
    )
    write("beck.csv", header, rows)


if __name__ == "__main__":
    main()
