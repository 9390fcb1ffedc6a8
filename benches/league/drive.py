"""The drives of a trial whose commands arrive one by one.

As in benches/twin, a command is carried out at constant speed, after the delay if there is one. NaN stands for a tendon
that follows without tension.
"""

import numpy as np
from chain import DRIVE_S
from drives import asked


class Drive:
    def __init__(self, faults, dt_s, step_ticks):
        self.faults = faults
        self.ramp_ticks = min(max(1, round(DRIVE_S / dt_s)), step_ticks)
        self.delay_ticks = round(faults.delay_s / dt_s)
        self.waiting = []
        self.commanded_m = self.places_m = self.target_m = np.zeros(len(faults.gains))
        self.since = self.ramp_ticks

    def command(self, tick, pulls_m):
        self.waiting.append((tick + self.delay_ticks, pulls_m))

    def go_on(self, other):
        """Stands where `other` stands, with the command that it carries out and those that wait."""
        self.waiting, self.places_m = list(other.waiting), other.places_m
        self.begin(other.commanded_m, other.places_m)

    def begin(self, pulls_m, places_m):
        self.commanded_m, self.start_m = pulls_m, places_m
        self.target_m = asked(pulls_m[None], self.faults, 0, places_m)[0]
        self.since = 0

    def start_due(self, tick, slack_m):
        """Starts the commands that are due; `slack_m()`: places of following tendons."""
        while self.waiting and self.waiting[0][0] <= tick:
            following, places_m = np.isnan(self.places_m), self.places_m
            if following.any():
                places_m = np.where(following, slack_m(), places_m)
            self.begin(self.waiting.pop(0)[1], places_m)

    def moving(self):
        return self.since < self.ramp_ticks

    def next_start(self):
        return self.waiting[0][0] if self.waiting else None

    def move(self):
        """Places one tick later."""
        self.since += 1
        self.places_m = self.start_m + (self.target_m - self.start_m) * (self.since / self.ramp_ticks)
        return self.places_m
