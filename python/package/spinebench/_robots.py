"""Robots of environments: how they are made, what is drawn of them, pictures."""

from __future__ import annotations

import difflib
import json
import math
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._errors import InputError
from ._spinebench import Model, _effects, _Robots

Array = NDArray[np.float64]
Range = tuple[float, float]
Value = float | Range | list[float | Range]
"""A number, a range, or a list of these for the components of a vector."""
Randomisation = Mapping[str, Mapping[str, Value]] | Callable[[np.random.Generator], Sequence[dict[str, Any]]]
"""Effects drawn at random for each episode: `{"tip_load": {"mass_kg": (0.0, 0.02)}}`, or a function of a generator that returns a
list of effects. A pair is a uniform range, a number is fixed, a list is a vector of these."""

Draw = tuple[int, str, list[float]]
"""Seed, further effects (JSON; empty for none) and target (3,), metres, of an episode that begins."""


def make(
    count: int,
    model: Model | str | os.PathLike[str] | None,
    plant: str | os.PathLike[str] | None,
    *,
    step_s: float,
    noise_m: float,
    travel_m: float | None,
    max_step_m: float | None,
    action: str,
) -> _Robots:
    """`count` robots of one model or plant file, with actions in −1 to 1."""
    if model is not None and plant is not None:
        raise InputError("plant: found both a model and a plant file, expected one of the two")
    arguments = {
        "count": count,
        "step_s": step_s,
        "noise_m": noise_m,
        "travel_m": travel_m,
        "max_step_m": max_step_m,
        "action": action,
    }
    if plant is not None:
        return _Robots.of_file(Path(plant), arguments)
    return _Robots.of_model(Model() if model is None else model, arguments)


def checked_randomisation(randomise: Randomisation | None, robots: _Robots) -> Randomisation | None:
    """The same with ranges as tuples and vectors as lists. Refuses unknown effects and parameters, ranges that are reversed or
    not finite, and sizes that the robot cannot have. A function is asked only in an episode."""
    if randomise is None or callable(randomise):
        return randomise
    if not isinstance(randomise, Mapping):
        raise InputError(f"randomise: found a {type(randomise).__name__}, expected effects by name, or a function")
    effects = dict(_effects())
    checked: dict[str, dict[str, Value]] = {}
    for effect, values in randomise.items():
        if effect not in effects:
            raise InputError(f"randomise: found the effect {effect!r}, expected {_one_of(effect, effects)}")
        if not isinstance(values, Mapping):
            raise InputError(f"randomise.{effect}: found a {type(values).__name__}, expected parameters by name")
        # Components of a vector carry an index.
        parameters = {name.split("[")[0]: "[" in name for name, _, _ in effects[effect]}
        checked[effect] = {}
        for key, value in values.items():
            if key not in parameters:
                raise InputError(f"randomise.{effect}: found {key!r}, expected {_one_of(key, parameters)}")
            name = f"randomise.{effect}.{key}"
            if parameters[key] and isinstance(value, (tuple, list)):
                checked[effect][key] = [_checked_range(name, part) for part in value]
            else:
                checked[effect][key] = _checked_range(name, value)
    for end in (min, max):
        robots.check_effects(json.dumps(_effect_list(checked, end)))
    return checked


def _one_of(word: str, expected: Iterable[str]) -> str:
    names = sorted(expected)
    near = difflib.get_close_matches(word, names, 1)
    return f"`{near[0]}`" if near else f"one of {', '.join(names)}"


def _checked_range(name: str, value: Any) -> Any:
    if not isinstance(value, (tuple, list)):
        return value
    if len(value) != 2 or not all(isinstance(end, (int, float)) and math.isfinite(end) for end in value):
        raise InputError(f"{name}: found {value}, expected a number or a range of two finite numbers")
    if value[0] > value[1]:
        raise InputError(f"{name}: found {value}, expected the lower end of the range first")
    return tuple(value)


def draw_effects(randomise: Randomisation | None, generator: np.random.Generator) -> str:
    """Effects of one episode in JSON; empty for none."""
    if randomise is None:
        return ""
    if callable(randomise):
        return json.dumps(list(randomise(generator)))
    return json.dumps(_effect_list(randomise, lambda low, high: float(generator.uniform(low, high))))


def _effect_list(randomise: Mapping[str, Mapping[str, Value]], draw: Callable[[float, float], float]) -> list[dict[str, Any]]:
    """The effects with a number for each range."""

    def drawn(value: Value) -> Any:
        if isinstance(value, list):
            return [drawn(part) for part in value]
        return draw(*value) if isinstance(value, tuple) else value

    return [{name: {key: drawn(value) for key, value in values.items()}} for name, values in randomise.items()]


def picture(shape: Array | None, tip: Array, target: Array, path: Array | None, size: int = 240) -> NDArray[np.uint8]:
    """The robot from the side (z to the right, x up) and from the front (y to the right, x up), (size, 2 size, 3)."""
    image = np.full((size, 2 * size, 3), 255, dtype=np.uint8)
    reach = 1.15 * max(0.05, float(np.abs(tip).max()), float(np.abs(target).max()))
    image[:, size - 1 : size + 1] = 200
    for offset, across, start in ((0, 2, 0.08), (size, 1, 0.5)):
        half = 2.0 if across == 1 else 1.0

        def pixels(points: Array, offset: int = offset, across: int = across, start: float = start, half: float = half) -> Any:
            columns = offset + size * (start + points[:, across] / (reach * half) * 0.9)
            rows = size * (0.5 - points[:, 0] / (reach * 2.0) * 0.9)
            low = offset + 2
            return np.clip(rows, 2, size - 3).astype(int), np.clip(columns, low, offset + size - 3).astype(int)

        if path is not None:
            rows, columns = pixels(path)
            image[rows, columns] = (150, 190, 150)
        if shape is not None:
            fine = np.linspace(0, len(shape) - 1, 6 * size)
            dense = np.column_stack([np.interp(fine, np.arange(len(shape)), shape[:, axis]) for axis in range(3)])
            rows, columns = pixels(dense)
            for row_shift in (-1, 0, 1):
                image[rows + row_shift, columns] = (60, 60, 60)
        for point, colour in ((target, (30, 140, 30)), (tip, (200, 40, 40))):
            rows, columns = pixels(point[np.newaxis])
            image[rows[0] - 2 : rows[0] + 3, columns[0] - 2 : columns[0] + 3] = colour
    return image
