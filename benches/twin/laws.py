"""Laws with a memory that act in the bending hinges, besides the joint springs.

Each is told the hinges' nominal stiffness (N m / rad), whatever their springs have, and the length that a hinge stands for, and returns moments
for angles, once a time step: `begin` (straight, no history), `moments`, `at_home` (keep the history as it is now),
`go_home` (take it back).
"""

import numpy as np


class Law:
    def begin(self, stiffness, piece_m):
        self.stiffness, self.piece_m = stiffness, piece_m
        self.state = None

    def at_home(self):
        self.kept = None if self.state is None else self.state.copy()

    def go_home(self):
        self.state = None if self.kept is None else self.kept.copy()


class Jenkins(Law):
    """Elasto-plastic elements side by side on each axis: equal stiffnesses, which add up to `share` of the
    hinge's; element k of n yields at a curvature of range * k / n."""

    def __init__(self, share, range_rad_m, elements=4):
        self.share, self.range_rad_m, self.elements = share, range_rad_m, elements

    def begin(self, stiffness, piece_m):
        super().begin(stiffness, piece_m)
        self.state = np.zeros((self.elements, len(stiffness)))
        steps = np.arange(1, self.elements + 1) / self.elements
        self.yields_rad = (self.range_rad_m * piece_m * steps)[:, None]

    def moments(self, angles_rad, dt_s):
        self.state = np.clip(self.state, angles_rad - self.yields_rad, angles_rad + self.yields_rad)
        return self.share / self.elements * self.stiffness * (self.state - angles_rad).sum(axis=0)


class Creep(Law):
    """A Maxwell branch: `share` of the hinge's stiffness relaxes with `time_s`. Home is fully relaxed."""

    def __init__(self, share, time_s):
        self.share, self.time_s = share, time_s

    def begin(self, stiffness, piece_m):
        super().begin(stiffness, piece_m)
        self.state = np.zeros(len(stiffness))
        self.resting = True

    def at_home(self):
        self.resting = False
        super().at_home()

    def moments(self, angles_rad, dt_s):
        time_s = 0.2 if self.resting else self.time_s
        self.state = self.state + dt_s / time_s * (angles_rad - self.state)
        return self.share * self.stiffness * self.state


class Mullins(Law):
    """The hinge loses up to `loss` of its stiffness with the largest curvature that it has seen."""

    def __init__(self, loss, scale_rad_m):
        self.loss, self.scale_rad_m = loss, scale_rad_m

    def begin(self, stiffness, piece_m):
        super().begin(stiffness, piece_m)
        self.state = np.zeros(len(stiffness) // 2)

    def moments(self, angles_rad, dt_s):
        bent = np.hypot(angles_rad[0::2], angles_rad[1::2]) / self.piece_m
        self.state = np.maximum(self.state, bent)
        lost = self.loss * (1 - np.exp(-self.state / self.scale_rad_m))
        return np.repeat(lost, 2) * self.stiffness * angles_rad
