"""A planar Cosserat rod with bending, stretch and shear, integrated with DOP853 for references by shooting.

The rod lies in the plane y = 0, is clamped at the origin and runs along +z when straight; theta is its turn about +y, so
d3 = (sin theta, cos theta) and d1 = (cos theta, -sin theta) in (x, z), and positive curvature bends it towards +x.
With n the internal force and m the internal moment about y:

    r' = (1 + n.d3 / EA) d3 + (n.d1 / GA) d1        theta' = kappa0 + m / EI
    n' = -f (dead line load)                         m' = -(z' n_x - x' n_z)

Stiffnesses are those of the simulator: GA = E / (2 (1 + nu)) A without a shear correction. Source: S. S. Antman, Nonlinear
Problems of Elasticity, chapter 4; nothing of the simulator's code is used.
"""

import csv
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.integrate import solve_ivp

OUT = Path(__file__).resolve().parents[2] / "tests" / "reference" / "stability"
RTOL, ATOL = 1e-12, 1e-14


@dataclass(frozen=True)
class Rod:
    length_m: float = 0.30
    radius_m: float = 0.002
    youngs_modulus_pa: float = 2.5e9
    poisson_ratio: float = 0.39
    density_kg_m3: float = 1200.0
    rest_curvature_rad_m: float = 0.0

    @property
    def area_m2(self):
        return np.pi * self.radius_m**2

    @property
    def bending_n_m2(self):
        return self.youngs_modulus_pa * np.pi / 4 * self.radius_m**4

    @property
    def shear_modulus_pa(self):
        return self.youngs_modulus_pa / (2 * (1 + self.poisson_ratio))

    @property
    def torsion_n_m2(self):
        return self.shear_modulus_pa * np.pi / 2 * self.radius_m**4

    @property
    def stretch_n(self):
        return self.youngs_modulus_pa * self.area_m2

    @property
    def shear_n(self):
        return self.shear_modulus_pa * self.area_m2

    @property
    def mass_kg_m(self):
        return self.density_kg_m3 * self.area_m2

    @property
    def euler_n(self):
        return np.pi**2 * self.bending_n_m2 / (4 * self.length_m**2)


R0 = Rod()
# A wire like nitinol; its Poisson's ratio and density are chosen here.
WIRE = Rod(length_m=0.18, radius_m=0.0005, youngs_modulus_pa=70e9, poisson_ratio=0.33, density_kg_m3=6450.0)


def tangent(rod, theta, force_x_n, force_z_n):
    """(x', z') of the line of centroids."""
    sin, cos = np.sin(theta), np.cos(theta)
    along = 1 + (force_x_n * sin + force_z_n * cos) / rod.stretch_n
    across = (force_x_n * cos - force_z_n * sin) / rod.shear_n
    return along * sin + across * cos, along * cos - across * sin


def integrate(rod, from_m, to_m, state, force, line=(0.0, 0.0), dense=False):
    """State (theta, m, x, z, n_x, n_z) at to_m from (theta, m, x, z) at from_m with the internal force there."""

    def slope(_, y):
        dx, dz = tangent(rod, y[0], y[4], y[5])
        return [
            rod.rest_curvature_rad_m + y[1] / rod.bending_n_m2,
            -(dz * y[4] - dx * y[5]),
            dx,
            dz,
            -line[0],
            -line[1],
        ]

    start = np.concatenate([state, force])
    return solve_ivp(slope, (from_m, to_m), start, method="DOP853", rtol=RTOL, atol=ATOL, dense_output=dense)


def from_tip(rod, tip_angle_rad, force, line=(0.0, 0.0)):
    """Shooting from a free tip with dead loads: (theta(0), tip_x_m, tip_z_m); equilibrium is theta(0) = 0."""
    end = integrate(rod, rod.length_m, 0.0, [tip_angle_rad, 0.0, 0.0, 0.0], force, line).y[:, -1]
    return end[0], -end[2], -end[3]


def write(name, header, rows):
    OUT.mkdir(parents=True, exist_ok=True)
    with open(OUT / name, "w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(header)
        for row in rows:
            writer.writerow([repr(float(x)) if isinstance(x, (float, np.floating)) else x for x in row])
