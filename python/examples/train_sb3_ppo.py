"""Train a network with stable-baselines3 (PPO) on robots that differ, and put it into Table I beside A, B, C and π_real.

`pip install "./python[rl]"` installs stable-baselines3. As it stands this trains for two and a half minutes and runs
the small experiment; `train_sb3_ppo.py experiments/table1.yaml 3` runs Table I three times.
"""

import sys
import time
from pathlib import Path

import gymnasium
import numpy as np
import torch
from stable_baselines3 import PPO
from stable_baselines3.common.env_util import make_vec_env

import spinebench as sb

SPEC = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).resolve().parents[2] / "experiments" / "smoke.yaml"
SEEDS = int(sys.argv[2]) if len(sys.argv) > 2 else 1
ROBOTS, STEPS, EPISODE = 16, 160_000, 20
TRAVEL_M, STEP_M = 0.03, 0.006
# The policy is trained on the model, never on the robot of the table: unknown loads and stiffness stand for what differs.
OPTIONS = {
    "max_steps": EPISODE,
    "within_m": None,
    "bend_share": 0.9,
    "noise_m": 0.0005,
    "randomise": {"tip_load": {"mass_kg": (0.0, 0.02)}, "bending_stiffness": {"scale": (0.8, 1.25)}},
}
# Of an observation: the tip's error counts ten times, so that millimetres are seen.
WEIGHTS = np.array([1.0] * 6 + [10.0] * 3 + [1.0] * 2, dtype=np.float32)


class Weighted(gymnasium.ObservationWrapper):
    """Weights the observation."""

    def observation(self, observation):
        return WEIGHTS * observation


def evaluated(model, episodes=64):
    """Distances at the end of episodes on fresh robots, metres."""
    env = gymnasium.make_vec(
        "spinebench/Reach-v0", num_envs=episodes, vectorization_mode="vector_entry_point", **{**OPTIONS, "max_steps": EPISODE + 1}
    )
    seen, _ = env.reset(seed=1_000_000)
    for _ in range(EPISODE):
        actions, _ = model.predict(WEIGHTS * seen, deterministic=True)
        seen, _, _, _, info = env.step(actions)
    return info["distance_m"]


torch.set_num_threads(1)
robots = make_vec_env("spinebench/Reach-v0", ROBOTS, seed=0, env_kwargs=OPTIONS, wrapper_class=Weighted)
began = time.monotonic()
model = PPO(
    "MlpPolicy", robots, seed=0, device="cpu", n_steps=64, batch_size=256, n_epochs=10, gamma=0.8, gae_lambda=0.9,
    learning_rate=lambda left: 1e-3 * left, policy_kwargs={"net_arch": [64, 64], "log_std_init": -0.7},
)  # fmt: skip
model.learn(STEPS)
distances = evaluated(model)
print(f"{STEPS} steps in {time.monotonic() - began:.0f} s; distance after {EPISODE} steps on {len(distances)} fresh robots:")
print(f"mean {1e3 * distances.mean():.2f} mm, largest {1e3 * distances.max():.2f} mm")
model.save("ppo_sb3.zip")
scale_m = float(np.linalg.norm(sb.Rod(sb.Model()).settle([0.0] * 4)))


class Trained:
    """The trained network as a policy: changes of the two wanted bends from what the environment shows."""

    closed_loop_only = True

    def reset(self):
        pass

    def act(self, tip_m, target_m, pulls_m, time_s):
        wanted = 0.5 * (pulls_m[:2] - pulls_m[2:])
        parts = [tip_m / scale_m, target_m / scale_m, (target_m - tip_m) / scale_m, wanted / TRAVEL_M]
        action, _ = model.predict(WEIGHTS * np.concatenate(parts).astype(np.float32), deterministic=True)
        wanted = np.clip(wanted + STEP_M * np.clip(action, -1, 1), -TRAVEL_M, TRAVEL_M)
        return np.concatenate([wanted, -wanted])


result = sb.run(SPEC, policies={"ppo": Trained}, seeds=SEEDS, out="out", cache="out/cache")
trials = next(iter(result.experiments.values())).trials
groups = [name for name in ("training", "policy", "mode") if name in trials]
table = trials.groupby(groups).error_m.agg(["mean", "std", "count"])
table[["mean", "std"]] *= 1e3
print(table.round(2).rename(columns={"mean": "mean (mm)", "std": "SD (mm)"}))
