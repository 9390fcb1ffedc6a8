"""The nominal robot in numbers, and what its cross-sections add up to over a piece of it.

All lengths run from the base along the straight robot; SI units.
"""

from dataclasses import dataclass, field

import numpy as np


@dataclass
class Robot:
    """The nominal robot; effects change its numbers before the chain is built."""

    length_m: float = 0.22
    radius_m: float = 0.002
    youngs_modulus_pa: float = 2.33e9
    poisson_ratio: float = 0.3897
    density_kg_m3: float = 1200.0
    sections: int = 11
    section_length_m: float = 0.01
    section_compliance_m_per_n: float = 2e-4
    saturation_n: float = 20.0
    disk_mass_kg: float = 0.004
    disk_radius_m: float = 0.020
    tendon_radius_m: float = 0.020
    tendon_angles_rad: tuple = (0.0, np.pi / 2, np.pi, 3 * np.pi / 2)
    # Where each tendon is anchored; None: all at the tip.
    tendon_ends_m: tuple | None = None
    pretension_m: float = 0.0005
    # Not the nominal model's: see docs/evidence/twin.md.
    tendon_compliance_m_per_n: float = 7e-5
    gravity_m_s2: tuple = (-9.81, 0.0, 0.0)
    damping_time_s: float = 0.03

    # How the chain stands for the robot: rigid pieces, and tendons as springs or as limits of length.
    pieces: int = 22
    tendons: str = "spring"

    # What effects change; these values change nothing.
    mass_scale: float = 1.0
    tip_mass_kg: float = 0.0
    tip_force_n: tuple = (0.0, 0.0, 0.0)
    base_tilt_rad: tuple = (0.0, 0.0)
    base_spring_nm_per_rad: float = 0.0
    bending_scale: float = 1.0
    bending_ratio: float = 0.0
    principal_angle_rad: float = 0.0
    rest_curvature_rad_m: tuple = (0.0, 0.0)
    soft_position_m: float = 0.0
    soft_scale: float = 1.0
    hinge_friction_nm: float = 0.0
    offsets_m: np.ndarray = field(default_factory=lambda: np.zeros(4))
    wall_y_m: float | None = None
    # Centre and radius of a sphere that the body, this thick, cannot enter.
    sphere: tuple | None = None
    touching_radius_m: float = 0.002

    def bending_n_m2(self):
        """E I of the nominal cross-section."""
        return self.youngs_modulus_pa * np.pi / 4 * self.radius_m**4

    def torsion_n_m2(self):
        """G J, G = E / (2 (1 + nu))."""
        return self.youngs_modulus_pa / (2 * (1 + self.poisson_ratio)) * np.pi / 2 * self.radius_m**4

    def disk_thickness_m(self):
        """Disks and sections fill the robot: disk, section, disk, ..., disk."""
        return (self.length_m - self.sections * self.section_length_m) / (self.sections + 1)

    def section_middles_m(self):
        """Middle of each compressible section, base to tip."""
        pitch = self.disk_thickness_m() + self.section_length_m
        return self.disk_thickness_m() + 0.5 * self.section_length_m + pitch * np.arange(self.sections)

    def holes_m(self):
        """Guide holes of the tendons in a cross-section, tendons x 2."""
        angles = np.array(self.tendon_angles_rad)
        return self.tendon_radius_m * np.stack([np.cos(angles), np.sin(angles)], axis=1).round(15)

    def masses(self):
        """[start, end, kg/m, radius] of all that has mass: the backbone and the disks, each a disk's thickness long."""
        area = np.pi * self.radius_m**2
        pieces = [(0.0, self.length_m, self.density_kg_m3 * area, self.radius_m)]
        thick = self.disk_thickness_m()
        for k in range(self.sections + 1):
            start = k * (thick + self.section_length_m)
            pieces.append((start, start + thick, self.disk_mass_kg / thick, self.disk_radius_m))
        return [(a, b, m * self.mass_scale, r) for a, b, m, r in pieces]

    def inertia(self, start_m, end_m):
        """(mass, centre, about a transverse axis through it, about the axis) of the part from start to end."""
        mass = first = second = side = axial = 0.0
        for a, b, density, radius in self.masses():
            a, b = max(a, start_m), min(b, end_m)
            if b > a:
                part = density * (b - a)
                mass += part
                first += part * (a + b) / 2
                second += density * (b**3 - a**3) / 3
                side += part * radius**2 / 4
                axial += part * radius**2 / 2
        centre = first / mass
        return mass, centre, second - mass * centre**2 + side, axial

    def softness(self, start_m, end_m):
        """Bending angle per moment of a piece, over that of a nominal piece of its length: one soft section counts."""
        middles = self.section_middles_m()
        middle = middles[np.argmin(abs(middles - self.soft_position_m))]
        half = 0.5 * self.section_length_m
        inside = max(0.0, min(end_m, middle + half) - max(start_m, middle - half))
        return (1 + (1 / self.soft_scale - 1) * inside / (end_m - start_m)) / self.bending_scale
