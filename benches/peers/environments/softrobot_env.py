"""gym-softrobot: environments of its own, whose robots are others than those of the comparison."""

import gymnasium
import gym_softrobot  # noqa: F401
import numpy as np
import worker

MADE = {}


def now_s(env):
    """The clock of the simulation, which has a name of its own in each environment."""
    return float(np.asarray(next(getattr(env, name) for name in ("time", "time_tracker", "_time") if hasattr(env, name))))


def own(name, steps):
    """Steps of an environment with drawn actions, and the simulated time of one."""
    if name not in MADE:
        MADE[name] = gymnasium.make(name, disable_env_checker=True)
        MADE[name].reset(seed=0)
        MADE[name].step(MADE[name].action_space.sample())  # what is compiled once is not timed
    env = MADE[name]
    env.reset(seed=0)
    env.action_space.seed(0)
    began = now_s(env.unwrapped)
    done = 0

    def run():
        nonlocal done
        for _ in range(steps):
            *_, terminated, truncated, _ = env.step(env.action_space.sample())
            done += 1
            if terminated or truncated:
                break

    _, times = worker.timed(run)
    return {**times, "steps": done, "simulated_s": now_s(env.unwrapped) - began}


if __name__ == "__main__":
    worker.serve({"own": own}, ["gym-softrobot", "pyelastica", "numpy"])
