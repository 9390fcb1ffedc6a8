"""Stability of planar rests of a clamped rod under dead tip loads, in the plane and out of it.

In the plane stretch and shear are condensed (at given theta they follow from the force), so a rest is stable when the
Jacobi field from the free tip has no zero (Gelfand & Fomin, Calculus of Variations, chapter 5). Out of the plane, with turns
alpha about d1 and beta about d3 and M = EI (kappa - kappa0), the second variation of the energy is

    int 1/2 EI_x (alpha' + kappa beta)^2 + 1/2 GJ (beta' - kappa alpha)^2
        + M (1/2 (alpha beta' - beta alpha') - 1/2 kappa (alpha^2 + beta^2)) - 1/2 (n.d1 alpha beta - n.d3 alpha^2) ds,

without out-of-plane shear and with EI_x = bending_ratio EI; its least eigenvalue (times L / EI, unit mass) is found with linear elements.
"""

import numpy as np
from scipy.integrate import solve_ivp
from scipy.linalg import eig_banded

from planar_rod import integrate


def condensed(rod, theta, force):
    """m' and its derivative by theta at a constant force."""
    sin, cos = np.sin(theta), np.cos(theta)
    along, across = force[0] * sin + force[1] * cos, force[0] * cos - force[1] * sin
    # m' = -(n.d1)(1 + n.d3 (1/EA - 1/GA)), with (n.d3)' = n.d1 and (n.d1)' = -n.d3 by theta.
    soft = 1 / rod.stretch_n - 1 / rod.shear_n
    return -across * (1 + along * soft), along * (1 + along * soft) - across * across * soft


def zeros_in_plane(rod, tip_angle_rad, force):
    """Zeros of the Jacobi field on (0, L), the number of ways down in the plane; one within 1e-9 of 0 means a fold."""

    def slope(_, y):
        moment, stiff = condensed(rod, y[0], force)
        return [rod.rest_curvature_rad_m + y[1] / rod.bending_n_m2, moment, y[3] / rod.bending_n_m2, stiff * y[2]]

    hit = lambda _, y: y[2]
    path = solve_ivp(
        slope, (rod.length_m, 0.0), [tip_angle_rad, 0.0, 1.0, 0.0], method="DOP853", rtol=1e-10, atol=1e-13, events=hit
    )
    return len(path.t_events[0])


def least_out_of_plane(rod, tip_angle_rad, force, elements=400, bending_ratio=1.0):
    path = integrate(rod, rod.length_m, 0.0, [tip_angle_rad, 0.0, 0.0, 0.0], force, dense=True)
    h = rod.length_m / elements
    middle = h * (np.arange(elements) + 0.5)
    theta, moment = path.sol(middle)[:2]
    kappa = rod.rest_curvature_rad_m + moment / rod.bending_n_m2
    n1 = force[0] * np.cos(theta) - force[1] * np.sin(theta)
    n3 = force[0] * np.sin(theta) + force[1] * np.cos(theta)
    size = 2 * (elements + 1)
    whole = np.zeros((size, size))
    for k in range(elements):
        # Middle-point values of alpha, beta, alpha', beta' from the nodes' (alpha, beta, alpha, beta).
        a, b = np.array([0.5, 0, 0.5, 0]), np.array([0, 0.5, 0, 0.5])
        da, db = np.array([-1, 0, 1, 0]) / h, np.array([0, -1, 0, 1]) / h
        both = lambda u, v: 0.5 * (np.outer(u, v) + np.outer(v, u))
        bend, twist = da + kappa[k] * b, db - kappa[k] * a
        part = bending_ratio * rod.bending_n_m2 * np.outer(bend, bend) + rod.torsion_n_m2 * np.outer(twist, twist)
        part += moment[k] * (both(a, db) - both(b, da) - kappa[k] * (np.outer(a, a) + np.outer(b, b)))
        part += n3[k] * np.outer(a, a) - n1[k] * both(a, b)
        whole[2 * k : 2 * k + 4, 2 * k : 2 * k + 4] += h * part
    free = whole[2:, 2:] / h
    free[-2:] *= np.sqrt(2)
    free[:, -2:] *= np.sqrt(2)
    bands = np.zeros((4, size - 2))
    for d in range(4):
        bands[d, : size - 2 - d] = np.diagonal(free, -d)
    return float(
        eig_banded(bands, lower=True, eigvals_only=True, select="i", select_range=(0, 0))[0]
        * rod.length_m**2
        / rod.bending_n_m2
    )
