"""Linearised columns by Galerkin: shapes s^2 times polynomials on a clamped-free rod, natural conditions in the weak form.

Lengths are in L, forces in EI / L^2, moments in EI / L and times in L^2 sqrt(rho A / EI); Euler-Bernoulli without rotary
inertia, shear or stretch. The shapes are integrated Legendre polynomials made orthonormal in mass, so that double precision
holds to some 30 of them.
"""

import numpy as np
from numpy.polynomial import legendre
from scipy.linalg import cholesky, eigvals, solve_triangular


class Shapes:
    """Matrices of shapes u_j with u(0) = u'(0) = 0."""

    def __init__(self, count=16):
        nodes, weights = legendre.leggauss(2 * count + 8)
        nodes = np.append(nodes, 1.0)

        def values(order):
            out = []
            for j in range(count):
                series = legendre.Legendre(np.eye(j + 1)[j], domain=[0, 1])
                shape = series.integ(2 - order, lbnd=0) if order < 2 else series
                out.append(shape((nodes + 1) / 2))
            return np.array(out)

        whole = [values(order) for order in (0, 1, 2)]
        weights = weights / 2
        mass = (whole[0][:, :-1] * weights) @ whole[0][:, :-1].T
        # Twice, since one pass loses digits to the condition of the mass matrix.
        for _ in range(2):
            factor = cholesky(mass, lower=True)
            whole = [solve_triangular(factor, values_, lower=True) for values_ in whole]
            mass = (whole[0][:, :-1] * weights) @ whole[0][:, :-1].T
        du, ddu = (part[:, :-1] for part in whole[1:])
        self.count = count
        self.bending = (ddu * weights) @ ddu.T
        self.slopes = (du * weights) @ du.T
        # int u_i'' u_j', row i a test shape.
        self.twisting = (ddu * weights) @ du.T
        self.tip, self.tip_slope = whole[0][:, -1], whole[1][:, -1]


def eigenvalues(stiffness, damping):
    """All lambda of lambda^2 + lambda D + K."""
    n = len(stiffness)
    whole = np.zeros((2 * n, 2 * n), dtype=complex)
    whole[:n, n:] = np.eye(n)
    whole[n:, :n], whole[n:, n:] = -stiffness, -damping
    return eigvals(whole)


def bisect(unstable, low, high, tolerance=1e-12):
    assert not unstable(low) and unstable(high)
    while high - low > tolerance * high:
        middle = 0.5 * (low + high)
        if unstable(middle):
            high = middle
        else:
            low = middle
    return 0.5 * (low + high)
