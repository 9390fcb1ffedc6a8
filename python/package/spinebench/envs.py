"""Gymnasium environments of continuum robots: `spinebench/Reach-v0` and `spinebench/Track-v0` (docs/python.md)."""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import Any, cast

import gymnasium
import numpy as np
from gymnasium.vector.vector_env import AutoresetMode
from numpy.typing import NDArray

from ._errors import InputError
from ._robots import Array, Randomisation, Robots, Seen, picture
from ._spinebench import Model

Reward = Callable[[Array, Array, Array], Array]
"""Reward of tips (n, 3), targets (n, 3), both in metres, and actions (n, actions): an array (n,)."""
Observation = NDArray[np.float32]

WARM_UP = 12
"""Steps for which a random command is held when targets are drawn."""


def lengths(vectors: Array) -> Array:
    """Lengths of vectors (n, 3)."""
    found: Array = np.sqrt((vectors * vectors).sum(axis=1))
    return found


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
        self.robots = Robots(count, model, plant, noise_m=noise_m, randomise=randomise, **settings)
        self.max_steps, self.within_m, self.hold_steps, self.reward = max_steps, within_m, hold_steps, reward
        # Targets are those of the robot as it is believed to be, without noise.
        self._nominal: Callable[[int], Robots] = lambda many: Robots(
            many, model, plant, noise_m=0.0, randomise=None, **settings
        )
        self._bend_share, self._follows_path = bend_share, follows_path
        self.home_m, self.pool_m = self._targets(path_m, steps_per_point)
        self.scale_m = float(np.linalg.norm(self.home_m)) or 1.0
        if follows_path:
            self.max_steps = len(self.pool_m)
        self.steps = np.zeros(count, dtype=int)
        self.held = np.zeros(count, dtype=int)
        self.targets_m = np.zeros((count, 3))
        self.last: Seen | None = None

    @property
    def observation_size(self) -> int:
        """Tip (3), target (3), target minus tip (3), wanted bends or displacements."""
        return 9 + self.robots.actions

    def _targets(self, path_m: Array | None, steps_per_point: int) -> tuple[Array, Array]:
        """The tip at home (3,), and the pool of targets or the path (k, 3), metres."""
        rng = np.random.default_rng(0)
        many = 1 if self._follows_path else 64
        robots = self._nominal(many)
        home = robots.reset(range(many), [rng] * many).tips_m[0].copy()
        if not self._follows_path:
            wanted = self._bend_share * rng.uniform(-1.0, 1.0, (many, robots.actions)) * robots.travel_m
            for _ in range(WARM_UP + int(np.ceil(robots.travel_m / robots.max_step_m))):
                seen = robots.step((wanted - robots.wanted() * robots.travel_m) / robots.max_step_m)
            tips = seen.tips_m[[status == "ok" for status in seen.status]]
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
            wanted = np.zeros((1, robots.actions))
            wanted[0, 0], wanted[0, min(1, robots.actions - 1)] = share * np.cos(angle), share * np.sin(angle)
            for _ in range(4):
                seen = robots.step((wanted - robots.wanted()) * robots.travel_m / robots.max_step_m)
            points_of_path.append(seen.tips_m[0].copy())
        return home, np.repeat(np.array(points_of_path), steps_per_point, axis=0)

    def reset(self, which: list[int], generators: list[np.random.Generator]) -> None:
        """New episodes of the robots `which`."""
        for index, generator in zip(which, generators, strict=True):
            if not self._follows_path:
                # Between two reachable tips lies a reachable place, nearly.
                first, second = generator.choice(len(self.pool_m), 2, replace=False)
                share = generator.uniform()
                self.targets_m[index] = share * self.pool_m[first] + (1.0 - share) * self.pool_m[second]
            else:
                self.targets_m[index] = self.pool_m[0]
        self.steps[which] = 0
        self.held[which] = 0
        self.last = self.robots.reset(which, generators)

    def step(self, actions: Array) -> tuple[Array, NDArray[np.bool_], NDArray[np.bool_], Array]:
        """Rewards, terminated, truncated and distances (m) of all robots after a step."""
        self.last = self.robots.step(actions)
        self.steps += 1
        distances = lengths(self.last.tips_m - self.targets_m)
        terminated = np.array([status != "ok" for status in self.last.status])
        within = distances <= (-1.0 if self.within_m is None else self.within_m)
        self.held = (self.held + 1) * within
        rewards = self._rewards(distances, within, actions)
        rewards[terminated] = -1.0
        if not self._follows_path:
            terminated |= self.held >= self.hold_steps
        truncated = (self.steps >= self.max_steps) & ~terminated
        if self._follows_path:
            places = np.minimum(self.steps, len(self.pool_m) - 1)
            self.targets_m = self.pool_m[places]
        return rewards, terminated, truncated, distances

    def _rewards(self, distances: Array, within: NDArray[np.bool_], actions: Array) -> Array:
        if callable(self.reward):
            assert self.last is not None
            rewards = np.asarray(self.reward(self.last.tips_m, self.targets_m, actions), dtype=float)
            if rewards.shape != distances.shape:
                raise InputError(f"reward: found shape {rewards.shape}, expected shape {distances.shape}")
            return rewards.copy()
        if self.reward == "sparse":
            return within.astype(float)
        return -distances / self.scale_m

    def observations(self) -> Observation:
        """Observations (n, observation_size) in lengths of the robot at home; the wanted commands in shares of travel."""
        assert self.last is not None
        tips, seen = self.last.tips_m, np.empty((len(self.steps), self.observation_size), dtype=np.float32)
        if np.isnan(tips).any():
            tips = np.nan_to_num(tips, nan=0.0)
        seen[:, 0:3] = tips / self.scale_m
        seen[:, 3:6] = self.targets_m / self.scale_m
        seen[:, 6:9] = (self.targets_m - tips) / self.scale_m
        seen[:, 9:] = self.robots.wanted()
        return seen

    def picture(self, index: int = 0) -> NDArray[np.uint8]:
        """Robot `index` from the side and from the front."""
        assert self.last is not None
        tip = np.nan_to_num(self.last.tips_m[index], nan=0.0)
        path = self.pool_m if self._follows_path else None
        return picture(self.robots.shape(index), tip, self.targets_m[index], path)

    def spaces(self) -> tuple[gymnasium.spaces.Box, gymnasium.spaces.Box]:
        """Spaces of one observation and of one action."""
        sizes = np.full(self.observation_size, np.inf, dtype=np.float32)
        observation = gymnasium.spaces.Box(-sizes, sizes, dtype=np.float32)
        return observation, gymnasium.spaces.Box(-1.0, 1.0, (self.robots.actions,), dtype=np.float32)


def _checked(action: object, shape: tuple[int, ...]) -> Array:
    try:
        actions = np.asarray(action, dtype=float)
    except (TypeError, ValueError):
        raise InputError(f"action: found {type(action).__name__}, expected numbers of shape {shape}") from None
    if actions.shape != shape:
        raise InputError(f"action: found shape {actions.shape}, expected shape {shape}")
    if not np.isfinite(actions).all():
        raise InputError("action: found a number that is not finite, expected finite numbers")
    return actions


class RobotEnv(gymnasium.Env[Observation, NDArray[np.float32]]):
    """One robot; see docs/python.md for every option."""

    metadata: dict[str, Any] = {"render_modes": ["rgb_array"], "render_fps": 5}

    def __init__(self, *, follows_path: bool, render_mode: str | None = None, **options: Any) -> None:
        if render_mode not in (None, "rgb_array"):
            raise InputError(f'render_mode: found {render_mode!r}, expected "rgb_array" or None')
        self.render_mode = render_mode
        self._task: _Task | None = _Task(1, follows_path=follows_path, **options)
        observation, action = self._task.spaces()
        self.observation_space = cast("gymnasium.Space[Observation]", observation)
        self.action_space = cast("gymnasium.Space[NDArray[np.float32]]", action)

    @property
    def task(self) -> _Task:
        """The robot and its targets."""
        if self._task is None:
            raise InputError("environment: found a closed one, expected one that is open")
        return self._task

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        super().reset(seed=seed)
        self.task.reset([0], [self.np_random])
        self._done = False
        assert self.task.last is not None
        return self.task.observations()[0], self._info(lengths(self.task.last.tips_m - self.task.targets_m)[0])

    def step(self, action: NDArray[np.float32]) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        if self.task.last is None or self._done:
            raise InputError("environment: found no episode under way, expected a call of reset() before step()")
        actions = _checked(action, self.action_space.shape or ())
        rewards, terminated, truncated, distances = self.task.step(actions[np.newaxis])
        self._done = bool(terminated[0] or truncated[0])
        info = self._info(distances[0])
        return self.task.observations()[0], float(rewards[0]), bool(terminated[0]), bool(truncated[0]), info

    def render(self) -> NDArray[np.uint8] | None:
        if self.render_mode is None:
            return None
        if self.task.last is None:
            raise InputError("environment: found no episode under way, expected a call of reset() before render()")
        return self.task.picture()

    def close(self) -> None:
        self._task = None

    def _info(self, distance_m: Any) -> dict[str, Any]:
        last = self.task.last
        assert last is not None
        return {
            "tip_m": last.tips_m[0].copy(),
            "target_m": self.task.targets_m[0].copy(),
            "pulls_m": last.pulls_m[0].copy(),
            "distance_m": float(distance_m),
            "status": last.status[0],
        }


class RobotVectorEnv(gymnasium.vector.VectorEnv[Observation, NDArray[np.float32], NDArray[Any]]):
    """Robots that one call steps over all cores, without the interpreter's lock. An episode that has ended begins anew with
    the next step, whose action is not used (Gymnasium's `NEXT_STEP`)."""

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
        self._ended = np.ones(num_envs, dtype=bool)

    @property
    def task(self) -> _Task:
        """The robots and their targets."""
        if self._task is None:
            raise InputError("environment: found a closed one, expected one that is open")
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
        self.task.reset(list(range(self.num_envs)), self._generators)
        self._ended[:] = False
        return self.task.observations(), self._info(self._distances())

    def step(
        self, actions: NDArray[np.float32]
    ) -> tuple[Observation, Array, NDArray[np.bool_], NDArray[np.bool_], dict[str, Any]]:
        if self.task.last is None:
            raise InputError("environment: found no episode under way, expected a call of reset() before step()")
        given = _checked(actions, (self.num_envs, self.task.robots.actions))
        fresh = np.flatnonzero(self._ended)
        rewards, terminated, truncated, _ = self.task.step(given)
        if len(fresh) > 0:
            which = [int(index) for index in fresh]
            self.task.reset(which, [self._generators[index] for index in which])
            rewards[fresh], terminated[fresh], truncated[fresh] = 0.0, False, False
        self._ended = terminated | truncated
        return self.task.observations(), rewards, terminated, truncated, self._info(self._distances())

    def render(self) -> tuple[NDArray[np.uint8], ...] | None:
        if self.render_mode is None:
            return None
        return tuple(self.task.picture(index) for index in range(self.num_envs))

    def close_extras(self, **kwargs: Any) -> None:
        self._task = None

    def _distances(self) -> Array:
        assert self.task.last is not None
        return lengths(self.task.last.tips_m - self.task.targets_m)

    def _info(self, distances: Array) -> dict[str, Any]:
        last = self.task.last
        assert last is not None
        status = np.array(last.status, dtype=object)
        return {"tip_m": last.tips_m, "pulls_m": last.pulls_m, "distance_m": distances, "status": status}


class ReachEnv(RobotEnv):
    """Bring the tip to a target that is drawn in each episode."""

    def __init__(self, **options: Any) -> None:
        super().__init__(follows_path=False, **options)


class TrackEnv(RobotEnv):
    """Follow a target that moves along a path."""

    def __init__(self, **options: Any) -> None:
        super().__init__(follows_path=True, **options)


class ReachVectorEnv(RobotVectorEnv):
    """Many robots, each with a target of its own."""

    def __init__(self, num_envs: int = 1, **options: Any) -> None:
        super().__init__(num_envs, follows_path=False, **options)


class TrackVectorEnv(RobotVectorEnv):
    """Many robots, each following the path."""

    def __init__(self, num_envs: int = 1, **options: Any) -> None:
        super().__init__(num_envs, follows_path=True, **options)


def register() -> None:
    """Registers the environments with Gymnasium; importing the package does it."""
    for name, single, vector in (("Reach", ReachEnv, ReachVectorEnv), ("Track", TrackEnv, TrackVectorEnv)):
        if f"spinebench/{name}-v0" not in gymnasium.registry:
            gymnasium.register(f"spinebench/{name}-v0", entry_point=single, vector_entry_point=vector)
