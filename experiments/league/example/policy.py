"""A submission to the league: measures where the tip goes under 24 bends, fits the bend to the tip, and integrates the error."""

import numpy as np

# Angles of the tendons (degrees), where they end (share of the length), and their distance from the backbone (m).
ROBOTS = {
    4: ([0, 90, 180, 270], [1] * 4, 0.02),
    6: ([0, 120, 240, 60, 180, 300], [1 / 2] * 3 + [1] * 3, 0.01),
    9: ([0, 120, 240, 40, 160, 280, 80, 200, 320], [1 / 3] * 3 + [2 / 3] * 3 + [1] * 3, 0.015),
}
BENDS_RAD = [r * np.array([np.cos(a), np.sin(a)]) for r in (0.4, 0.8, 1.2) for a in np.arange(8) * np.pi / 4]


def features(x, y):
    return np.stack([x**0, x, y, x * x, x * y, y * y, x**3, x * x * y, x * y * y, y**3], axis=-1)


class MeasuredMap:
    def begin(self, robot):
        angles, ends, radius_m = ROBOTS[robot["tendons"]]
        a = np.radians(angles)
        self.pulls_per_rad = radius_m * np.array(ends) * np.stack([np.cos(a), np.sin(a)])
        self.tips_m, self.shift_m = [], np.zeros(2)

    def sample(self, tip_m, pulls_m):
        self.tips_m.append(tip_m)
        taken = len(self.tips_m)
        if taken <= len(BENDS_RAD):
            return BENDS_RAD[taken - 1] @ self.pulls_per_rad
        tips_m, bends_rad = np.array(self.tips_m), np.array([np.zeros(2), *BENDS_RAD])
        self.scale_m = np.abs(tips_m).max()
        known = features(*(tips_m[:, :2] / self.scale_m).T)
        self.inverse = np.linalg.lstsq(known, bends_rad, rcond=None)[0]
        return None

    def reset(self):
        self.shift_m = np.zeros(2)

    def act(self, tip_m, target_m, pulls_m, time_s):
        error_m = (target_m - tip_m)[:2]
        if time_s > 0:  # In open loop the tip stays that at home, at time 0.
            self.shift_m = np.clip(self.shift_m + 0.2 * error_m, -0.05, 0.05)
        aim = (target_m[:2] + self.shift_m) / self.scale_m
        return features(*aim) @ self.inverse @ self.pulls_per_rad, bool(np.hypot(*error_m) < 0.001)
