"""Gymnasium environments of continuum robots: `spinebench/Reach-v0` and `spinebench/Track-v0` (docs/reference/python.md)."""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import Any, cast

import gymnasium
import numpy as np
from gymnasium.vector.vector_env import AutoresetMode
from numpy.typing import NDArray

from ._errors import InputError
from ._robots import Array, Draw, Randomisation, checked_randomisation, draw_effects, make, picture
from ._spinebench import Model, _Robots

Reward = Callable[[Array, Array, Array], Array]
"""Reward of tips (n, 3), targets (n, 3), both in metres, and actions (n, actions): an array (n,)."""
Observation = NDArray[np.float32]

WARM_UP = 12
"""Steps for which a random command is held when targets are drawn."""


POSITION_LIMIT = 2.0
"""Coordinates in observations are clipped to this many robot lengths, or more if targets are farther away."""


class _Task:
    """Robots with targets: what one environment and a vector of them share."""

    def __init__(
        self,
        count: int,
        *,
        follows_path: bool,
        model: Model | str | os.PathLike[str] | None = None,
        plant: str | os.PathLike[str] | None = None,
        step_s: float = 0.2,
        noise_m: float = 0.0,
        travel_m: float | None = None,
        max_step_m: float | None = None,
        action: str = "bend",
        randomise: Randomisation | None = None,
        max_steps: int = 50,
        within_m: float | None = 0.003,
        hold_steps: int = 3,
        bend_share: float = 0.6,
        path_m: Array | None = None,
        steps_per_point: int = 1,
        reward: str | Reward = "distance",
    ) -> None:
        if isinstance(reward, str) and reward not in ("distance", "sparse"):
            raise InputError(f'reward: found {reward!r}, expected "distance", "sparse" or a function')
        if max_steps < 1 or hold_steps < 1 or steps_per_point < 1:
            raise InputError("max_steps, hold_steps, steps_per_point: found less than 1, expected at least 1 each")
        settings: dict[str, Any] = {
            "step_s": step_s,
            "travel_m": travel_m,
            "max_step_m": max_step_m,
            "action": action,
        }
        self.robots = make(count, model, plant, noise_m=noise_m, **settings)
        self.randomise = checked_randomisation(randomise, self.robots)
        self.reward, self.travel_m = reward, self.robots.travel_m
        self.max_step_m, self._follows_path, self._bend_share = self.robots.max_step_m, follows_path, bend_share
        # Targets are those of the robot as it is believed to be, without noise.
        nominal = make(1 if follows_path else 64, model, plant, noise_m=0.0, **settings)
        self.home_m, self.pool_m = self._targets(nominal, path_m, steps_per_point)
        self.scale_m = float(np.linalg.norm(self.home_m)) or 1.0
        farthest = float(np.abs(self.pool_m).max()) / self.scale_m
        self.limit = max(POSITION_LIMIT, float(np.ceil(1.25 * farthest)))
        self.robots.set_task(
            {
                "scale_m": self.scale_m,
                "limit": self.limit,
                "path_m": self.pool_m.tolist() if follows_path else None,
                "max_steps": len(self.pool_m) if follows_path else max_steps,
                "within_m": within_m,
                "hold_steps": hold_steps,
                "is_sparse": reward == "sparse",
            }
        )

    def _targets(self, robots: _Robots, path_m: Array | None, steps_per_point: int) -> tuple[Array, Array]:
        """The tip at home (3,), and the pool of targets or the path (k, 3), metres."""
        rng = np.random.default_rng(0)
        many, actions = (1 if self._follows_path else 64), robots.actions
        robots.begin((list(range(many)), [int(rng.integers(2**63)) for _ in range(many)], [""] * many, [[0.0] * 3] * many))
        home = robots.tips_m[0].copy()
        if not self._follows_path:
            wanted_m = self._bend_share * rng.uniform(-1.0, 1.0, (many, actions)) * self.travel_m
            for _ in range(WARM_UP + int(np.ceil(self.travel_m / self.max_step_m))):
                robots.drive((wanted_m - robots.wanted_m) / self.max_step_m)
            tips = robots.tips_m[[status == "ok" for status in robots.status]]
            if len(tips) < 2:
                raise InputError("bend_share: found commands that this robot cannot follow, expected a smaller share")
            return home, tips
        if path_m is not None:
            points = np.asarray(path_m, dtype=float)
            if points.ndim != 2 or points.shape[1] != 3 or len(points) < 2 or not np.isfinite(points).all():
                raise InputError(f"path_m: found shape {points.shape}, expected finite numbers of shape (k, 3), k >= 2")
            return home, np.repeat(points, steps_per_point, axis=0)
        # A circle in the plane of the first two components, after a spiral out to it.
        points_of_path = []
        for index in range(20 + 40):
            angle = 2.0 * np.pi * max(index - 20, 0) / 40
            share = self._bend_share * min(1.0, index / 20)
            wanted_m = np.zeros((1, actions))
            wanted_m[0, 0], wanted_m[0, min(1, actions - 1)] = share * np.cos(angle), share * np.sin(angle)
            wanted_m *= self.travel_m
            for _ in range(4):
                robots.drive((wanted_m - robots.wanted_m) / self.max_step_m)
            points_of_path.append(robots.tips_m[0].copy())
        return home, np.repeat(np.array(points_of_path), steps_per_point, axis=0)

    def draw(self, generator: np.random.Generator) -> Draw:
        """What a new episode begins with."""
        target_m = self.pool_m[0]
        if not self._follows_path:
            # Between two reachable tips lies a reachable place, nearly.
            first, second = generator.choice(len(self.pool_m), 2, replace=False)
            share = generator.uniform()
            target_m = share * self.pool_m[first] + (1.0 - share) * self.pool_m[second]
        seed = int(generator.integers(2**63))
        return seed, draw_effects(self.randomise, generator), target_m.tolist()

    def draws(
        self, which: list[int], generators: list[np.random.Generator]
    ) -> tuple[list[int], list[int], list[str], list[list[float]]]:
        """What new episodes of the robots `which` begin with."""
        seeds, effects, targets_m = zip(*[self.draw(generators[index]) for index in which], strict=True)
        return which, list(seeds), list(effects), list(targets_m)

    def rewards(self, told: Array, info: dict[str, Any], actions: Array) -> Array:
        """Rewards of a step (n,): those that were told, or those of a function."""
        if not callable(self.reward):
            return told
        rewards = np.asarray(self.reward(info["tip_m"], self.robots.last_targets_m, actions), dtype=float)
        if rewards.shape != told.shape:
            raise InputError(f"reward: found shape {rewards.shape}, expected shape {told.shape}")
        return np.where([status == "ok" for status in info["status"]], rewards, -1.0)

    def picture(self, index: int = 0) -> NDArray[np.uint8]:
        """Robot `index` from the side and from the front."""
        tip = np.nan_to_num(self.robots.tips_m[index], nan=0.0)
        path = self.pool_m if self._follows_path else None
        return picture(self.robots.shape(index, 60), tip, self.robots.tell()[4]["target_m"][index], path)

    def spaces(self) -> tuple[gymnasium.spaces.Box, gymnasium.spaces.Box]:
        """Spaces of one observation and of one action."""
        actions = self.robots.actions
        limits = np.array([self.limit] * 6 + [2.0 * self.limit] * 3 + [1.0] * actions, dtype=np.float32)
        observation = gymnasium.spaces.Box(-limits, limits, dtype=np.float32)
        return observation, gymnasium.spaces.Box(-1.0, 1.0, (actions,), dtype=np.float32)


class RobotEnv(gymnasium.Env[Observation, NDArray[np.float32]]):
    """One robot; see docs/reference/python.md for every option."""

    metadata: dict[str, Any] = {"render_modes": ["rgb_array"], "render_fps": 5}

    def __init__(self, *, follows_path: bool, render_mode: str | None = None, **options: Any) -> None:
        if render_mode not in (None, "rgb_array"):
            raise InputError(f'render_mode: found {render_mode!r}, expected "rgb_array" or None')
        self.render_mode = render_mode
        self._task: _Task | None = _Task(1, follows_path=follows_path, **options)
        observation, action = self._task.spaces()
        self.observation_space = cast("gymnasium.Space[Observation]", observation)
        self.action_space = cast("gymnasium.Space[NDArray[np.float32]]", action)
        self._begun = False

    @property
    def task(self) -> _Task:
        """The robot and its targets."""
        if self._task is None:
            raise InputError("environment: found a closed environment, expected an open one")
        return self._task

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        super().reset(seed=seed)
        robots = self.task.robots
        robots.begin(self.task.draws([0], [self.np_random]))
        self._begun = True
        told = robots.tell_alone()
        return told[0], told[4]

    def step(self, action: NDArray[np.float32]) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        task = self.task
        told = task.robots.step_alone(action)
        if not callable(task.reward):
            return told
        seen, reward, terminated, truncated, info = told
        every = {"tip_m": info["tip_m"][np.newaxis], "status": [info["status"]]}
        actions = np.asarray(action, dtype=float)[np.newaxis]
        return seen, float(task.rewards(np.array([reward]), every, actions)[0]), terminated, truncated, info

    def render(self) -> NDArray[np.uint8] | None:
        if self.render_mode is None:
            return None
        task = self.task
        if not self._begun:
            raise InputError("environment: found no active episode, expected a call of reset() before render()")
        return task.picture()

    def close(self) -> None:
        self._task = None


class RobotVectorEnv(gymnasium.vector.VectorEnv[Observation, NDArray[np.float32], NDArray[Any]]):
    """Robots stepped by one call on all cores, without the interpreter's lock. The step after the end of an episode begins
    a new one and ignores its action (Gymnasium's `NEXT_STEP`)."""

    metadata: dict[str, Any] = {
        "render_modes": ["rgb_array"],
        "render_fps": 5,
        "autoreset_mode": AutoresetMode.NEXT_STEP,
    }

    def __init__(self, num_envs: int = 1, *, follows_path: bool, render_mode: str | None = None, **options: Any) -> None:
        if num_envs < 1:
            raise InputError(f"num_envs: found {num_envs}, expected at least 1")
        self.num_envs, self.render_mode = num_envs, render_mode
        self._task: _Task | None = _Task(num_envs, follows_path=follows_path, **options)
        single_observation, single_action = self._task.spaces()
        self.single_observation_space, self.single_action_space = single_observation, single_action
        batch: Callable[..., Any] = gymnasium.vector.utils.batch_space
        self.observation_space = batch(single_observation, num_envs)
        self.action_space = batch(single_action, num_envs)
        self._generators = [np.random.default_rng() for _ in range(num_envs)]
        self._ended: NDArray[np.bool_] | None = None

    @property
    def task(self) -> _Task:
        """The robots and their targets."""
        if self._task is None:
            raise InputError("environment: found a closed environment, expected an open one")
        return self._task

    def reset(
        self, *, seed: int | list[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        if seed is not None:
            seeds = [seed + index for index in range(self.num_envs)] if isinstance(seed, int) else list(seed)
            if len(seeds) != self.num_envs:
                raise InputError(f"seed: found {len(seeds)} seeds, expected {self.num_envs}")
            # As an environment alone seeds itself.
            pairs = zip(seeds, self._generators, strict=True)
            self._generators = [kept if one is None else gymnasium.utils.seeding.np_random(one)[0] for one, kept in pairs]
        robots = self.task.robots
        robots.begin(self.task.draws(list(range(self.num_envs)), self._generators))
        self._ended = np.zeros(self.num_envs, dtype=bool)
        told = robots.tell()
        return told[0], self._info(told[4])

    def step(
        self, actions: NDArray[np.float32]
    ) -> tuple[Observation, Array, NDArray[np.bool_], NDArray[np.bool_], dict[str, Any]]:
        task = self.task
        if self._ended is None:
            raise InputError("environment: found no active episode, expected a call of reset() before step()")
        fresh = np.flatnonzero(self._ended)
        beginnings = task.draws([int(index) for index in fresh], self._generators) if len(fresh) > 0 else None
        seen, rewards, terminated, truncated, info = task.robots.step(actions, beginnings)
        if callable(task.reward):
            rewards = task.rewards(rewards, info, np.asarray(actions, dtype=float))
            rewards[fresh] = 0.0
        self._ended = terminated | truncated
        return seen, rewards, terminated, truncated, self._info(info)

    def render(self) -> tuple[NDArray[np.uint8], ...] | None:
        if self.render_mode is None:
            return None
        return tuple(self.task.picture(index) for index in range(self.num_envs))

    def close_extras(self, **kwargs: Any) -> None:
        self._task = None

    def _info(self, info: dict[str, Any]) -> dict[str, Any]:
        return info | {"status": np.array(info["status"], dtype=object)}


class ReachEnv(RobotEnv):
    """Bring the tip to a target that is drawn in each episode."""

    def __init__(self, **options: Any) -> None:
        super().__init__(follows_path=False, **options)


class TrackEnv(RobotEnv):
    """Follow a target that moves along a path."""

    def __init__(self, **options: Any) -> None:
        super().__init__(follows_path=True, **options)


class ReachVectorEnv(RobotVectorEnv):
    """Many robots, each with its own target."""

    def __init__(self, num_envs: int = 1, **options: Any) -> None:
        super().__init__(num_envs, follows_path=False, **options)


class TrackVectorEnv(RobotVectorEnv):
    """Many robots, each following the path."""

    def __init__(self, num_envs: int = 1, **options: Any) -> None:
        super().__init__(num_envs, follows_path=True, **options)


def register() -> None:
    """Registers the environments with Gymnasium; importing the package calls it."""
    for name, single, vector in (("Reach", ReachEnv, ReachVectorEnv), ("Track", TrackEnv, TrackVectorEnv)):
        if f"spinebench/{name}-v0" not in gymnasium.registry:
            gymnasium.register(f"spinebench/{name}-v0", entry_point=single, vector_entry_point=vector)
