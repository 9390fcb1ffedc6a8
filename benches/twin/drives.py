"""What the drives do with the commands of a trial: nominal, and with what may be wrong with them."""

from dataclasses import dataclass

import numpy as np

from chain import DRIVE_S


@dataclass
class Faults:
    """What is wrong with the drives; these values are nothing."""

    delay_s: float = 0.0
    play_m: float = 0.0
    dead_zone_m: float = 0.0
    gains: tuple = (1.0, 1.0, 1.0, 1.0)
    lost_tendon: int = 0
    lost_m: float = 0.0
    lost_rows: tuple = ()


def asked(commands_m, faults, trial, held_m=0.0):
    """Where the drives are to stand after each command of a trial (rows x tendons), in the order things happen to
    them; they stand at `held_m` before."""
    pulls = commands_m * np.array(faults.gains)
    pulls = np.sign(pulls) * np.maximum(abs(pulls) - faults.dead_zone_m, 0.0)
    if faults.lost_tendon:
        pulls[faults.lost_rows[trial] :, faults.lost_tendon - 1] -= faults.lost_m
    if faults.play_m:
        held = np.zeros(pulls.shape[1]) + held_m
        for row in pulls:
            held = np.clip(held, row - 0.5 * faults.play_m, row + 0.5 * faults.play_m)
            row[:] = held
    return pulls


class Drives:
    """Pulls at any time of a trial. A command is carried out at constant speed, after the delay if there is one."""

    def __init__(self, commands_m, period_s, faults, trial):
        self.delay_s = faults.delay_s
        pulls = asked(commands_m, faults, trial)
        starts = period_s * np.arange(len(pulls)) + self.delay_s
        before = np.vstack([np.zeros(4), pulls[:-1]])
        self.starts = starts
        self.times = np.stack([starts, starts + DRIVE_S], axis=1).ravel()
        self.places = np.stack([before, pulls], axis=1).reshape(-1, 4)

    def __call__(self, time_s):
        return np.array([np.interp(time_s, self.times, column) for column in self.places.T])

    def moving(self, from_s, to_s):
        """Times between these within which a drive moves."""
        spans = [(max(s, from_s), min(s + DRIVE_S, to_s)) for s in self.starts]
        return [(a, b) for a, b in spans if b - a > 1e-9]
