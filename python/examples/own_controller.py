"""A controller of your own in Table I, beside policies A, B and C. The small experiment stands for experiments/table1.yaml."""

from pathlib import Path

import numpy as np

import spinebench as sb

SPEC = Path(__file__).resolve().parents[2] / "experiments" / "smoke.yaml"


class Integral:
    """Integrates the tip's error in x and y into pulls on opposite tendons."""

    closed_loop_only = True

    def reset(self):
        self.bend = np.zeros(2)

    def act(self, tip_m, target_m, pulls_m, time_s):
        error = (target_m - tip_m)[:2]
        self.bend = np.clip(self.bend + 0.06 * error, -0.03, 0.03)
        settled = np.linalg.norm(error) < 0.001
        return np.concatenate([self.bend, -self.bend]), settled


result = sb.run(SPEC, policies={"mine": Integral}, seeds=1, out="out", cache="out/cache")
trials = result["smoke"].trials
table = trials.groupby(["training", "policy", "mode"]).error_m.agg(["mean", "std", "count"])
table[["mean", "std"]] *= 1e3
print(table.round(2).rename(columns={"mean": "mean (mm)", "std": "SD (mm)"}))
