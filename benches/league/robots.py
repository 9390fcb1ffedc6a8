"""The robots of the league, in numbers for the MuJoCo chain of benches/twin.

`paper` is the nominal robot of benches/twin (models/nominal.yaml), `two_segment` and `nine_tendon` are those of the model
files of the same names in this folder.
"""

import sys
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "twin"))

from robot import Robot


@dataclass
class Segmented(Robot):
    """A robot without compressible sections, some of whose tendons end part-way. Disks are part of the density."""

    sections: int = 0
    disk_mass_kg: float = 0.0
    pretension_m: float = 0.0002
    tendon_compliance_m_per_n: float = 1e-4
    # Bending stiffness of each segment over the nominal one; empty: all nominal.
    segment_scales: dict = field(default_factory=dict)

    def softness(self, start_m, end_m):
        """Bending angle per moment of a piece, over that of a nominal piece of its length."""
        soft, bounds = 0.0, segment_ends_m(self)
        for number, (a, b) in enumerate(zip([0.0, *bounds], bounds), start=1):
            soft += max(0.0, min(end_m, b) - max(start_m, a)) / self.segment_scales.get(number, 1.0)
        return soft / (end_m - start_m) / self.bending_scale


def segment_ends_m(robot):
    """Arc lengths at which tendons end, base to tip: a segment ends there."""
    return sorted(set(robot.tendon_ends_m or [robot.length_m]))


def paper(pieces=11):
    return Robot(pieces=pieces)


def two_segment(pieces=20):
    return Segmented(
        length_m=0.4,
        radius_m=0.0007,
        youngs_modulus_pa=54e9,
        poisson_ratio=0.3,
        density_kg_m3=12992.0,
        tendon_radius_m=0.01,
        tendon_angles_rad=tuple(np.radians([0, 120, 240, 60, 180, 300])),
        tendon_ends_m=(0.2,) * 3 + (0.4,) * 3,
        offsets_m=np.zeros(6),
        pieces=pieces,
    )


def nine_tendon(pieces=18):
    return Segmented(
        length_m=0.3,
        density_kg_m3=5305.0,
        tendon_radius_m=0.015,
        tendon_angles_rad=tuple(np.radians([0, 120, 240, 40, 160, 280, 80, 200, 320])),
        tendon_ends_m=(0.1,) * 3 + (0.2,) * 3 + (0.3,) * 3,
        offsets_m=np.zeros(9),
        pieces=pieces,
    )


ROBOTS = {robot.__name__: robot for robot in (paper, two_segment, nine_tendon)}
# Longest time step; figures in measure.py. With 2 ms the chain of two segments becomes unstable where a controller pulls
# tendons against each other (40 N each); with 1 ms it moves as with 0.2 ms.
TIME_STEP_S = 0.001
