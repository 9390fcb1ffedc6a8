"""greenhill.csv: columns under their own weight and shafts under end moments.

Own weight. EI theta'' = N (1 + N / EA - N / GA) theta with N = -q (L - s), theta(0) = 0, theta'(L) = 0: inextensible and
unshearable from the first zero of the Bessel function J(-1/3), and with stretch and shear by shooting (A. G. Greenhill 1881).

Axial moment M on a clamped-free rod, w = x + i y. With t = (x', y', 1) the bending moments are m_x = -EI y'' + M x' and
m_y = EI x'' + M y' (the twisting moment along t is M to first order), so mu = m_y - i m_x = EI w'' - i M w'. Balance of moments
and forces with the internal axial force -P gives mu' = -(n_x + i n_y) - P w' and (n_x + i n_y)' = rho A w_tt:

    EI (1 + tau d/dt) w'''' - i M w''' + P w'' + rho A w_tt = 0,  w = w' = 0 at the clamp,
    EI (1 + tau d/dt) w'' - i M w' = c (-i M w')  and  EI (1 + tau d/dt) w''' - i M w'' + P w' = 0 at the tip,

c = 0 for a moment fixed in space (dead), 1 for one that follows the tangent, 1/2 for the semi-tangential one, which has a
potential. Weak form: int psi'' (EI w'' - i M w') - P psi' w' + c i M psi'(L) w'(L). (H. Ziegler, Principles of Structural
Stability, 1968.) For c = 0 and 1 the first-order change of omega^2 is -+ i M w'(L)^2 / (2 rho A int w^2): imaginary, so the
undamped rod flutters at any M > 0. Kelvin-Voigt damping makes the critical M finite.

Greenhill's shaft, for comparison: both ends hinged 2 pi EI / L, both clamped the first root of tan(v/2) = v/2, M = v EI / L.
"""

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from scipy.special import jv

from columns import Shapes, bisect, eigenvalues
from planar_rod import R0, write

TIMES_S = (1e-4, 1e-3, 0.03)
SHARES = (0.0, 0.25, 0.5)
MOMENTS = (0.1, 0.5, 1.0, 2.0)
KINDS = (("dead", 0.0), ("tangential", 1.0), ("semitangential", 0.5))


def own_weight():
    zero = brentq(lambda x: jv(-1 / 3, x), 1.5, 2.2, xtol=1e-15)
    return (1.5 * zero) ** 2


def own_weight_soft(rod):
    """q_cr L^3 / EI with stretch and shear."""

    def slope_at_tip(q):
        def slope(s, y):
            n = -q * rod.bending_n_m2 / rod.length_m**3 * (rod.length_m - s)
            return [y[1], n * (1 + n / rod.stretch_n - n / rod.shear_n) * y[0] / rod.bending_n_m2]

        return solve_ivp(slope, (0, rod.length_m), [0.0, 1.0], method="DOP853", rtol=1e-12, atol=1e-15).y[1, -1]

    return brentq(slope_at_tip, 7.0, 8.5, xtol=1e-12)


def stiffness(shapes, moment, axial, follow):
    tips = np.outer(shapes.tip_slope, shapes.tip_slope)
    return shapes.bending - 1j * moment * shapes.twisting - axial * shapes.slopes + follow * 1j * moment * tips


def leading(shapes, moment, axial, follow, tau):
    found = eigenvalues(stiffness(shapes, moment, axial, follow), tau * shapes.bending)
    top = found[found.real > found.real.max() - 1e-7]
    return top[np.argmin(abs(top))]


def slowest(shapes, moment, axial, follow, tau):
    """Undamped all motions grow, the faster ones not more slowly (at about M / L sqrt(rho A EI)): that of the first shape."""
    found = eigenvalues(stiffness(shapes, moment, axial, follow), tau * shapes.bending)
    found = found[found.real > 0]
    return found[np.argmin(abs(found))]


def critical(shapes, axial, follow, tau):
    """The least M (EI / L) with a growing motion."""
    unstable = lambda moment: (
        eigenvalues(stiffness(shapes, moment, axial, follow), tau * shapes.bending).real.max() > 1e-7 * (tau == 0)
    )
    first = next(moment for moment in np.geomspace(1e-4, 60.0, 400) if unstable(moment))
    return bisect(unstable, first / 1.05, first, 1e-11) if not unstable(first / 1.05) else 0.0


def main():
    rod = R0
    length, bending = rod.length_m, rod.bending_n_m2
    time_s = length**2 * np.sqrt(rod.mass_kg_m / bending)
    euler = np.pi**2 / 4
    rows = []
    for method, value in (
        ("Bessel, inextensible", own_weight()),
        ("shooting, extensible and shearable", own_weight_soft(rod)),
    ):
        gravity = value * bending / (length**3 * rod.mass_kg_m)
        rows.append(
            ["own_weight_q_l3_per_ei", "", "", "", value, gravity, "gravity_m_s2", "divergence", "", "", method]
        )
    shaft = brentq(lambda v: np.sin(v / 2) - v / 2 * np.cos(v / 2), 8.0, 9.4, xtol=1e-14)
    for name, value in (("shaft_hinged", 2 * np.pi), ("shaft_clamped", shaft)):
        rows.append(
            [
                name,
                "",
                0.0,
                0.0,
                value,
                value * bending / length,
                "moment_nm",
                "divergence",
                "",
                "",
                "exact, inextensible",
            ]
        )
    for kind, follow in KINDS:
        for share in SHARES:
            for tau_s in (0.0, *TIMES_S):
                per = [critical(Shapes(count), share * euler, follow, tau_s / time_s) for count in (12, 16)]
                at = leading(Shapes(16), per[-1], share * euler, follow, tau_s / time_s) / time_s if per[-1] else None
                # A motion that neither grows nor turns is divergence.
                how = "flutter, at any M > 0" if at is None else "flutter" if abs(at.imag) > 1e-2 else "divergence"
                print(kind, share, tau_s, per, how, at, flush=True)
                numbers = [0.0, "" if at is None else abs(at.imag) if how == "flutter" else 0.0]
                rows.append(
                    [
                        f"moment_{kind}",
                        tau_s,
                        share,
                        "",
                        per[-1],
                        per[-1] * bending / length,
                        "moment_nm",
                        how,
                        *numbers,
                        "Galerkin, inextensible",
                    ]
                )
    for share in SHARES:
        for tau_s in (0.0, *TIMES_S):
            for moment in MOMENTS:
                choose = leading if tau_s else slowest
                per = [choose(Shapes(count), moment, share * euler, 0.0, tau_s / time_s) / time_s for count in (14, 18)]
                assert abs(per[0] - per[1]) < 1e-5, per
                how = "leading eigenvalue" if tau_s else "slowest growing eigenvalue"
                rows.append(
                    [
                        "moment_dead",
                        tau_s,
                        share,
                        moment,
                        moment,
                        moment * bending / length,
                        "moment_nm",
                        how,
                        per[-1].real,
                        per[-1].imag,
                        "Galerkin, inextensible",
                    ]
                )
    header = "kind,damping_time_s,axial_share,moment_ei_per_l,value,load,load_unit,outcome,lambda_real_1_per_s,lambda_imag_1_per_s,method"
    write("greenhill.csv", header.split(","), rows)


if __name__ == "__main__":
    main()
