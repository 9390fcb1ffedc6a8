"""A baseline of the league: segments of constant curvature, and a Gaussian process for what they leave at 100 samples.

The tip of a bend is the chain of arcs plus the mean of the process; its inverse is found by damped least squares. In closed
loop the error is integrated into the bend.
"""

import itertools

import numpy as np

# Angles of the tendons (degrees), number of segments (tendons end in equal shares), distance from the backbone and length (m),
# largest bend (rad) over all segments.
ROBOTS = {
    4: ([0, 90, 180, 270], 1, 0.02, 0.22, 1.3),
    6: ([0, 120, 240, 60, 180, 300], 2, 0.01, 0.4, 2.8),
    9: ([0, 120, 240, 40, 160, 280, 80, 200, 320], 3, 0.015, 0.3, 2.8),
}
SAMPLES = 100
LENGTH_SCALES_RAD, NOISES_M = (0.3, 0.6, 1.2, 2.4, 4.8), (0.0003, 0.0006, 0.0012)


def arcs_tip_m(bends_rad, length_m):
    """Tips of arcs of equal length, one after the other; bends (…, segments, 2): angle of each, towards x and y."""
    tip_m, turned = np.zeros((*bends_rad.shape[:-2], 3)), np.broadcast_to(np.eye(3), (*bends_rad.shape[:-2], 3, 3))
    for bend in np.moveaxis(bends_rad, -2, 0):
        angle = np.linalg.norm(bend, axis=-1)[..., None] + 1e-12
        x, y, c, s = bend[..., :1] / angle, bend[..., 1:] / angle, np.cos(angle), np.sin(angle)
        arc = length_m / bends_rad.shape[-2] / angle * np.concatenate([x * (1 - c), y * (1 - c), s], axis=-1)
        tip_m = tip_m + (turned @ arc[..., None])[..., 0]
        rows = [[1 - x * x * (1 - c), -x * y * (1 - c), x * s], [-x * y * (1 - c), 1 - y * y * (1 - c), y * s], [-x * s, -y * s, c]]
        turned = turned @ np.stack([np.concatenate(row, axis=-1) for row in rows], axis=-2)
    return tip_m


class GaussianProcess:
    def begin(self, robot):
        angles, self.segments, radius_m, self.length_m, largest_rad = ROBOTS[robot["tendons"]]
        directions = np.radians(angles).reshape(self.segments, -1)
        # A tendon feels the bends of its own segment and of those before it.
        self.pulls_m_per_rad = np.zeros((self.segments, 2, len(angles)))
        for segment, after in itertools.combinations_with_replacement(range(self.segments), 2):
            at = slice(after * directions.shape[1], (after + 1) * directions.shape[1])
            self.pulls_m_per_rad[segment, :, at] = radius_m * np.stack([np.cos(directions[after]), np.sin(directions[after])])
        draws = np.random.default_rng(0)
        self.largest_rad = largest_rad / self.segments
        size = self.largest_rad * np.sqrt(draws.uniform(size=(SAMPLES, self.segments, 1)))
        turn = draws.uniform(0, 2 * np.pi, size=(SAMPLES, self.segments, 1))
        self.bends_rad, self.tips_m = size * np.concatenate([np.cos(turn), np.sin(turn)], axis=-1), []

    def sample(self, tip_m, pulls_m):
        self.tips_m.append(tip_m)
        taken = len(self.tips_m) - 1  # The first is the tip at home.
        if taken < SAMPLES:
            return self.pulls_m(self.bends_rad[taken])
        # The tip of each sample comes with the request for the next one.
        self.known = np.concatenate([np.zeros((1, 2 * self.segments)), self.bends_rad.reshape(SAMPLES, -1)])[: len(self.tips_m)]
        left_m = np.array(self.tips_m) - self.arcs_m(self.known)
        self.mean_m = left_m.mean(axis=0)
        left_m, variance = left_m - self.mean_m, left_m.var()
        evidence = []
        for self.scale_rad, noise_m in itertools.product(LENGTH_SCALES_RAD, NOISES_M):
            root = np.linalg.cholesky(self.kernel(self.known) + noise_m**2 / variance * np.eye(len(self.known)))
            white = np.linalg.solve(root, left_m / np.sqrt(variance))
            evidence.append((-0.5 * (white**2).sum() - 3 * np.log(np.diag(root)).sum(), self.scale_rad, root))
        _, self.scale_rad, root = max(evidence, key=lambda each: each[0])
        self.weights_m = np.linalg.solve(root.T, np.linalg.solve(root, left_m))
        return None

    def kernel(self, bends_rad):
        apart = bends_rad[:, None] - self.known
        return np.exp(-0.5 * (apart**2).sum(axis=-1) / self.scale_rad**2)

    def tip_m(self, bends_rad):
        """Predicted tips of bends (rows, 2 segments)."""
        return self.arcs_m(bends_rad) + self.mean_m + self.kernel(bends_rad) @ self.weights_m

    def arcs_m(self, bends_rad):
        return arcs_tip_m(bends_rad.reshape(-1, self.segments, 2), self.length_m)

    def pulls_m(self, bends_rad):
        return np.einsum("sk,skt->t", bends_rad.reshape(self.segments, 2), self.pulls_m_per_rad)

    def reset(self):
        self.bend_rad, self.shift_rad = None, np.zeros(2 * self.segments)

    def slope_m_per_rad(self, tip_m, bend_rad):
        """Differences of predicted tips: (bends, 3)."""
        step_rad = 1e-4 * np.eye(len(bend_rad))
        return (tip_m(bend_rad + step_rad) - tip_m(bend_rad[None])) / 1e-4

    def changed(self, bend_rad, slope, wanted_m, damping_m_per_rad):
        """A bend with a change that brings the tip nearer to where it is wanted, within the range that was measured."""
        damped = slope @ slope.T + damping_m_per_rad**2 * np.eye(len(slope))
        bend_rad = bend_rad + np.clip(np.linalg.solve(damped, slope @ wanted_m), -0.2, 0.2)
        return bend_rad * min(1.0, 1.2 * self.largest_rad / (np.abs(bend_rad).max() + 1e-12))

    def act(self, tip_m, target_m, pulls_m, time_s):
        error_m = target_m - tip_m
        if self.bend_rad is None:
            self.bend_rad = self.known[np.linalg.norm(self.tips_m - target_m, axis=1).argmin()]
        for _ in range(20):
            slope = self.slope_m_per_rad(self.tip_m, self.bend_rad)
            wanted_m = target_m - self.tip_m(self.bend_rad[None])[0]
            self.bend_rad = self.changed(self.bend_rad, slope, wanted_m, 0.001)
        if time_s > 0:  # In open loop the tip stays that at home, at time 0.
            # The arcs alone tell the direction: between samples the slope of the process is uncertain.
            bend_rad = self.bend_rad + self.shift_rad
            slope = self.slope_m_per_rad(self.arcs_m, bend_rad)
            self.shift_rad = self.changed(bend_rad, slope, 0.3 * error_m, 0.01) - self.bend_rad
        return self.pulls_m(self.bend_rad + self.shift_rad), bool(np.linalg.norm(error_m) < 0.001)
