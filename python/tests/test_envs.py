"""Gymnasium environments."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

import spinebench
from spinebench import InputError, Model

IDS = ["spinebench/Reach-v0", "spinebench/Track-v0"]
RANDOM: dict[str, Any] = {"tip_load": {"mass_kg": (0.0, 0.02)}, "base_tilt": {"tilt_x_rad": (-0.05, 0.05), "tilt_y_rad": 0.0}}


@pytest.mark.parametrize("name", IDS)
def test_gymnasiums_checker_has_no_complaint(name: str) -> None:
    env = gymnasium.make(name, render_mode="rgb_array", randomise=RANDOM)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(env.unwrapped, skip_render_check=False)


@pytest.mark.parametrize("name", IDS)
def test_stable_baselines_checker_has_no_complaint(name: str) -> None:
    checker = pytest.importorskip("stable_baselines3.common.env_checker")
    checker.check_env(gymnasium.make(name, render_mode="rgb_array").unwrapped, warn=True)


@pytest.mark.parametrize("name", IDS)
def test_observations_stay_within_their_bounds(name: str) -> None:
    options: dict[str, Any] = {"randomise": RANDOM, "noise_m": 0.02, "action": "tendons"}
    many = gymnasium.make_vec(name, num_envs=8, vectorization_mode="vector_entry_point", **options)
    space = many.single_observation_space
    assert isinstance(space, gymnasium.spaces.Box) and np.isfinite(space.low).all() and np.isfinite(space.high).all()
    seen, _ = many.reset(seed=3)
    rng = np.random.default_rng(1)
    for _ in range(60):
        assert all(space.contains(one) for one in seen)
        seen = many.step(rng.choice([-1.0, 1.0], (8, 4)).astype(np.float32))[0]


def test_what_lies_beyond_the_bounds_is_held_there(model: Model) -> None:
    # The tracking frame is half a metre off, more than two lengths of the robot.
    far = [{"frame_shift": {"shift_m": [0.0, 0.0, 0.45]}}]
    env = gymnasium.make(IDS[0], model=model, randomise=lambda generator: far)
    seen, info = env.reset(seed=0)
    assert info["tip_m"][2] > 0.6 and env.observation_space.contains(seen)
    assert seen[2] == env.observation_space.high[2]  # type: ignore[attr-defined]
    # A path that lies farther out has bounds farther out.
    track = gymnasium.make(IDS[1], model=model, path_m=np.array([[0.0, 0.0, 0.2], [0.0, 0.0, 0.9]]))
    assert track.observation_space.high[5] * 0.22 > 0.9  # type: ignore[attr-defined]


@pytest.mark.parametrize(
    ("randomise", "words"),
    [
        ({"tip_lod": {"mass_kg": 0.1}}, "randomise: found the effect 'tip_lod', expected `tip_load`"),
        ({"tip_load": {"mass": 0.1}}, "randomise.tip_load: found 'mass', expected `mass_kg`"),
        ({"tip_load": {"mass_kg": (0.02, 0.0)}}, "randomise.tip_load.mass_kg: .* lower end of the range first"),
        ({"tip_load": {"mass_kg": (0.0, 0.1, 0.2)}}, "randomise.tip_load.mass_kg: .* range of two finite numbers"),
        ({"tip_load": {"mass_kg": (0.0, float("inf"))}}, "two finite numbers"),
        ({"tip_load": {"mass_kg": (-1.0, 0.0)}}, "randomise.*mass_kg"),
        ({"tip_load": 0.02}, "randomise.tip_load: found a float, expected parameters by name"),
        ({"tip_force": {"force_n": [(0.0, 1.0), 0.0]}}, "randomise"),
        ([{"tip_load": {"mass_kg": 0.1}}], "randomise: found a list"),
    ],
)
def test_wrong_randomisations_are_refused_before_anything_runs(randomise: Any, words: str) -> None:
    with pytest.raises(InputError, match=words):
        gymnasium.make(IDS[0], randomise=randomise)


def test_robots_without_effects_take_no_randomisation(tmp_path: Path) -> None:
    plant = tmp_path / "plant.yaml"
    plant.write_text("constant_curvature: {}\n")
    with pytest.raises(InputError, match="effects cannot be added to this plant"):
        gymnasium.make(IDS[0], plant=plant, randomise=RANDOM)


def test_vectors_and_whole_numbers_are_drawn(model: Model) -> None:
    ranges = {
        "tip_force": {"force_n": [(0.0, 0.1), 0.0, (-0.1, 0.1)]},
        "actuator_gain": {"tendon": 2, "scale": [0.9, 1.1]},
    }
    env = gymnasium.make(IDS[0], model=model, randomise=ranges)
    tips = [env.reset(seed=seed)[1]["tip_m"] for seed in range(3)]
    assert not np.array_equal(tips[0], tips[1])


@pytest.mark.parametrize("name", IDS)
def test_rewards_of_a_function_see_the_target_of_the_step(model: Model, name: str) -> None:
    def reward(tips_m: Any, targets_m: Any, actions: Any) -> Any:
        return -np.linalg.norm(tips_m - targets_m, axis=1) - 0.01 * np.abs(actions).sum(axis=1)

    env = gymnasium.make(name, model=model, reward=reward)
    many = gymnasium.make_vec(name, num_envs=2, vectorization_mode="vector_entry_point", model=model, reward=reward)
    env.reset(seed=4)
    many.reset(seed=4)
    action = np.array([1.0, -0.5], dtype=np.float32)
    for _ in range(3):
        _, value, _, _, info = env.step(action)
        assert float(value) == pytest.approx(-info["distance_m"] - 0.015, abs=1e-12)
        _, values, _, _, infos = many.step(np.array([action] * 2))
        assert values[0] == value and infos["distance_m"][0] == info["distance_m"]


def test_the_same_seed_is_the_same_episode(model: Model) -> None:
    def episode(seed: int) -> list[np.ndarray[Any, Any]]:
        env = gymnasium.make(IDS[0], model=model, noise_m=1e-3, randomise=RANDOM)
        rng = np.random.default_rng(5)
        seen = [env.reset(seed=seed)[0]]
        seen += [env.step(rng.uniform(-1, 1, 2).astype(np.float32))[0] for _ in range(5)]
        seen.append(env.reset()[0])
        return seen

    first, again, other = episode(7), episode(7), episode(8)
    np.testing.assert_array_equal(first, again)
    assert not np.array_equal(first, other)


def test_robots_side_by_side_do_as_each_alone(model: Model) -> None:
    options: dict[str, Any] = {"model": model, "noise_m": 1e-3, "randomise": RANDOM, "max_steps": 4}
    many = gymnasium.make_vec(IDS[0], num_envs=3, vectorization_mode="vector_entry_point", **options)
    alone = [gymnasium.make(IDS[0], **options) for _ in range(3)]
    together, _ = many.reset(seed=11)
    np.testing.assert_array_equal(together, [env.reset(seed=11 + index)[0] for index, env in enumerate(alone)])
    rng = np.random.default_rng(0)
    ended = [False] * 3
    for _ in range(11):
        actions = rng.uniform(-1, 1, (3, 2)).astype(np.float32)
        together, rewards, terminated, truncated, _ = many.step(actions)
        for index, env in enumerate(alone):
            if ended[index]:
                seen, reward, ended[index] = env.reset()[0], 0.0, False
            else:
                seen, value, over, cut, _ = env.step(actions[index])
                reward, ended[index] = float(value), over or cut
                assert (over, cut) == (terminated[index], truncated[index])
            np.testing.assert_array_equal(together[index], seen)
            assert rewards[index] == reward


def test_ends_are_told_apart(model: Model) -> None:
    env = gymnasium.make(IDS[0], model=model, max_steps=3, within_m=None, disable_env_checker=True).unwrapped
    env.reset(seed=0)
    ends = [env.step(np.zeros(2, dtype=np.float32))[2:4] for _ in range(3)]
    assert ends == [(False, False), (False, False), (False, True)]
    with pytest.raises(InputError, match="reset"):
        env.step(np.zeros(2, dtype=np.float32))
    near = gymnasium.make(IDS[0], model=model, within_m=1.0, hold_steps=2).unwrapped
    near.reset(seed=0)
    ends = [near.step(np.zeros(2, dtype=np.float32))[2:4] for _ in range(2)]
    assert ends == [(False, False), (True, False)]


def test_targets_can_be_reached(model: Model) -> None:
    env = gymnasium.make(IDS[0], model=model, max_steps=80).unwrapped
    nearest = []
    for seed in range(4):
        _, info = env.reset(seed=seed)
        rod = spinebench.Rod(model)
        rod.settle()
        for _ in range(60):
            error = info["target_m"] - info["tip_m"]
            action = np.clip(error[:2] * 20.0, -1, 1).astype(np.float32)
            _, _, terminated, truncated, info = env.step(action)
            if terminated or truncated:
                break
        nearest.append(info["distance_m"])
    assert max(nearest) < 0.006, nearest


def test_any_plant_file_and_model_makes_an_environment(root: Path, tmp_path: Path) -> None:
    plant = tmp_path / "plant.yaml"
    plant.write_text("constant_curvature: {}\n")
    each: list[dict[str, Any]] = [{"plant": plant}, {"model": root / "models" / "tdcr_two_segments.yaml"}]
    for options in each:
        env = gymnasium.make(IDS[0], **options)
        env.reset(seed=1)
        action = np.zeros(env.action_space.shape or (), dtype=np.float32)
        assert env.step(action)[4]["status"] == "ok"


def test_pictures_show_the_robot(model: Model) -> None:
    env = gymnasium.make(IDS[1], model=model, render_mode="rgb_array")
    env.reset(seed=0)
    before = env.render()
    for _ in range(30):
        env.step(np.array([1.0, 0.0], dtype=np.float32))
    after = env.render()
    assert isinstance(before, np.ndarray) and isinstance(after, np.ndarray)
    assert before.shape == (240, 480, 3) and before.dtype == np.uint8
    assert (before != after).any()


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"reward": "praise"}, "reward: found 'praise'"),
        ({"action": "dance"}, "action: found 'dance'"),
        ({"max_steps": 0}, "at least 1"),
        ({"max_step_m": -1.0}, "max_step_m"),
        ({"model": "missing.yaml"}, "missing.yaml"),
        ({"path_m": np.zeros((4, 2))}, "path_m"),
        ({"step_s": 0.0}, "step_s"),
        ({"noise_m": float("nan")}, "noise_m"),
    ],
)
def test_wrong_options(options: dict[str, Any], words: str) -> None:
    with pytest.raises(InputError, match=words):
        gymnasium.make(IDS[1], **options)


def test_closed_environments_and_wrong_actions(model: Model) -> None:
    env = gymnasium.make(IDS[0], model=model, disable_env_checker=True).unwrapped
    env.reset(seed=0)
    for action, words in (
        (np.zeros(3), r"found shape \(3,\), expected shape \(2,\)"),
        (np.array([np.nan, 0.0]), "finite"),
        ("up", "expected"),
    ):
        with pytest.raises(InputError, match=words):
            env.step(action)
    env.close()
    for call in (lambda: env.step(np.zeros(2)), lambda: env.reset()):
        with pytest.raises(InputError, match="closed"):
            call()
