"""MuJoCo: the chain of `benches/peers/chain.py` as an environment, whose tendons jump to a command and stay there for a step."""

import sys
from pathlib import Path

import mujoco
import numpy as np
import worker

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
import chain  # noqa: E402

STEP_S, TRAVEL_M, MAX_STEP_M = 0.2, 0.03, 0.006


class ChainEnv:
    """Observations and actions as in spinebench's environment, without the layers of Gymnasium."""

    def __init__(self, case, segments, dt_s):
        self.chain = chain.Chain(case, segments, dt_s, spatial=False)
        self.pretension_m, self.each = case["pretension_m"], round(STEP_S / dt_s)
        self.chain.rest()
        self.home = self.chain.data.qpos.copy()
        self.target_m = np.array([0.02, -0.01, 0.21])

    def reset(self):
        mujoco.mj_resetData(self.chain.model, self.chain.data)
        self.chain.data.qpos[:] = self.home
        mujoco.mj_forward(self.chain.model, self.chain.data)
        self.wanted_m = np.zeros(4)
        return self.seen()

    def seen(self):
        tip = np.array(self.chain.tip_m())
        parts = [tip, self.target_m, self.target_m - tip, self.wanted_m / TRAVEL_M]
        return np.concatenate(parts).astype(np.float32), tip

    def step(self, action):
        moved = self.wanted_m + MAX_STEP_M * np.clip(action, -1.0, 1.0)
        self.wanted_m = np.clip(moved, -TRAVEL_M, TRAVEL_M)
        self.chain.lengths[:] = self.chain.straight - self.wanted_m - self.pretension_m
        mujoco.mj_step(self.chain.model, self.chain.data, nstep=self.each)
        mujoco.mj_kinematics(self.chain.model, self.chain.data)
        observation, tip = self.seen()
        return observation, -float(np.linalg.norm(tip - self.target_m)), tip


MADE = {}


def steps(actions, setting):
    segments, dt_s = setting
    if (segments, dt_s) not in MADE:
        MADE[(segments, dt_s)] = ChainEnv(worker.case("paper"), segments, dt_s)
    env = MADE[(segments, dt_s)]
    env.reset()
    actions = np.array(actions, dtype=np.float32)
    tips = []

    def run():
        for action in actions:
            tips.append(env.step(action)[2])

    _, times = worker.timed(run)
    if env.chain.data.warning.number[mujoco.mjtWarning.mjWARN_BADQACC] or not np.isfinite(tips).all():
        raise ArithmeticError("unstable")
    return {**times, "steps": len(actions), "tips_m": np.array(tips).tolist()}


if __name__ == "__main__":
    worker.serve({"steps": steps}, ["mujoco", "numpy"])
