"""Train a controller by reinforcement learning (PPO) on 32 robots side by side, and put it into Table I as an ONNX file.

The policy is linear in the tip's error, so that numpy is enough and a minute on two cores, too. With stable-baselines3, networks
are trained in the same environment: `PPO("MlpPolicy", gymnasium.make("spinebench/Reach-v0"))`.
"""

from pathlib import Path

import gymnasium
import numpy as np

import spinebench as sb
from spinebench.onnx import save_network

ROBOTS, STEPS, ROUNDS, DISCOUNT = 32, 20, 24, 0.8
rng = np.random.default_rng(0)
env = gymnasium.make_vec(
    "spinebench/Reach-v0", num_envs=ROBOTS, vectorization_mode="vector_entry_point", max_steps=STEPS + 1, within_m=None
)


def features(seen):
    return 10.0 * seen[..., 6:8]  # target minus tip in x and y


def values(seen):
    error = 10.0 * seen[..., 6:9]
    distance = np.linalg.norm(error, axis=-1, keepdims=True)
    return np.concatenate([np.ones_like(distance), distance, distance**2, np.abs(error)], axis=-1)


def episode(weights, spread):
    """Observations, actions and rewards, each (steps, robots, …), and the last distances in metres."""
    seen, _ = env.reset(seed=int(rng.integers(2**31)))
    all_seen, all_actions, all_rewards = [], [], []
    for _ in range(STEPS):
        actions = features(seen) @ weights.T + spread * rng.normal(size=(ROBOTS, 2))
        all_seen.append(seen)
        seen, rewards, _, _, info = env.step(actions.astype(np.float32))
        all_actions.append(actions)
        all_rewards.append(rewards)
    return np.array(all_seen), np.array(all_actions), np.array(all_rewards), info["distance_m"]


def log_probability(actions, inputs, weights, spread):
    return (-0.5 * ((actions - inputs @ weights.T) / spread) ** 2 - np.log(spread)).sum(axis=-1)


weights, spread = np.zeros((2, 2)), np.full(2, 0.5)
for number in range(ROUNDS):
    seen, actions, rewards, distances = episode(weights, spread)
    returns, later = np.zeros_like(rewards), np.zeros(ROBOTS)
    for step in reversed(range(STEPS)):
        later = rewards[step] + DISCOUNT * later
        returns[step] = later
    known = values(seen).reshape(STEPS * ROBOTS, -1)
    inputs, taken, returns = features(seen).reshape(-1, 2), actions.reshape(-1, 2), returns.ravel()
    advantages = returns - known @ np.linalg.lstsq(known, returns, rcond=None)[0]
    advantages /= advantages.std() + 1e-9
    before = log_probability(taken, inputs, weights, spread)
    for _ in range(10):
        ratio = np.exp(log_probability(taken, inputs, weights, spread) - before)
        clipped = ((ratio > 1.2) & (advantages > 0)) | ((ratio < 0.8) & (advantages < 0))
        push = np.where(clipped, 0.0, advantages * ratio)[:, np.newaxis]
        shift = (taken - inputs @ weights.T) / spread
        # Steps in the units of the policy's own spread keep their size while it narrows.
        weights = weights + 2.0 * spread[:, np.newaxis] * (push * shift).T @ inputs / len(inputs)
        spread = spread * np.exp(0.1 * np.clip((push * (shift**2 - 1)).mean(axis=0), -1, 0.5))
    if number % 6 == 5:
        print(f"round {number + 1}: mean distance at the end {1e3 * distances.mean():.1f} mm")

*_, distances = episode(weights, np.zeros(2))
print(f"without exploration: {1e3 * distances.mean():.2f} mm")

# As a network that sees the error in metres and decides changes of the four displacements: 6 mm for an action of 1.
gain = 0.006 * 10.0 / env.unwrapped.task.scale_m * weights
mine = np.zeros((4, 3))
mine[:, :2] = np.vstack([gain, -gain])
save_network("ppo.onnx", [(mine, np.zeros(4))])

base = Path(__file__).resolve().parents[2] / "experiments" / "smoke.yaml"
sets = {
    "policies.ppo.onnx": {"file": "ppo.onnx", "inputs": ["error"], "output": "changes"},
    "runs.reach[0].policies": ["a", "b", "c", "pi_real", "ppo"],
}
trials = sb.run(base, set=sets, seeds=1, out="out", cache="out/cache")["smoke"].trials
print((1e3 * trials[trials["mode"] == "closed"].groupby("policy").error_m.mean()).round(2).rename("closed loop (mm)"))
