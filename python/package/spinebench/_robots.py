"""Robots of environments: commands from actions, observations, work space, pictures."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._errors import InputError
from ._spinebench import Model, _Plants

Array = NDArray[np.float64]
Range = tuple[float, float]
Randomisation = Mapping[str, Mapping[str, float | Range]] | Callable[[np.random.Generator], Sequence[dict[str, Any]]]
"""Effects drawn anew in each episode: `{"tip_load": {"mass_kg": (0.0, 0.02)}}`, or a function of a generator that returns a
list of effects. A pair is a uniform range, a number is fixed."""


@dataclass(frozen=True)
class Seen:
    """What is seen of the robots: tips (n, 3), displacements (n, tendons), both in metres, flags and statuses."""

    tips_m: Array
    pulls_m: Array
    valid: NDArray[np.bool_]
    status: list[str]


class Robots:
    """`count` robots of one model or plant file, with actions in −1 to 1."""

    def __init__(
        self,
        count: int,
        model: Model | str | os.PathLike[str] | None,
        plant: str | os.PathLike[str] | None,
        *,
        step_s: float,
        noise_m: float,
        travel_m: float | None,
        max_step_m: float | None,
        action: str,
        randomise: Randomisation | None,
    ) -> None:
        if model is not None and plant is not None:
            raise InputError("plant: found a model, too, expected either a model or a plant file")
        if plant is not None:
            self._plants = _Plants.of_file(Path(plant), count, step_s)
        else:
            given = Model() if model is None else model if isinstance(model, Model) else Model.load(model)
            self._plants = _Plants.of_model(given, count, step_s, noise_m, travel_m)
        travel_m = self._plants.suited_travel_m if travel_m is None else travel_m
        max_step_m = 0.2 * travel_m if max_step_m is None else max_step_m
        if not 0.0 < max_step_m <= travel_m:
            raise InputError(f"max_step_m: found {max_step_m}, expected a number above 0 and up to travel_m")
        limit = self._plants.travel_m
        self.count, self.tendons, self.step_s = count, self._plants.tendons, step_s
        self.travel_m = travel_m if limit is None else min(travel_m, limit)
        self.max_step_m = max_step_m
        self.randomise = randomise
        self._ways = self._ways_of(action)
        self._wanted_m = np.zeros((count, len(self._ways)))

    def _ways_of(self, action: str) -> Array:
        """What each component of an action does to each tendon, (actions, tendons)."""
        if action == "tendons":
            return np.eye(self.tendons)
        if action != "bend":
            raise InputError(f'action: found {action!r}, expected "bend" or "tendons"')
        rows = []
        for segment in self._plants.layout:
            for turn in (np.cos, np.sin):
                row = np.zeros(self.tendons)
                for tendon, angle_deg in segment:
                    row[tendon] = turn(np.deg2rad(angle_deg))
                rows.append(row)
        return np.array(rows)

    @property
    def actions(self) -> int:
        """Number of components of an action."""
        return len(self._ways)

    def reset(self, which: Sequence[int], generators: Sequence[np.random.Generator]) -> Seen:
        """Brings the robots `which` home, each with its own generator."""
        seeds = [int(generator.integers(2**63)) for generator in generators]
        effects = [self._drawn(generator) for generator in generators]
        self._wanted_m[list(which)] = 0.0
        return self._seen(self._plants.reset(list(which), seeds, effects))

    def step(self, actions: Array) -> Seen:
        """Moves the wanted bends (or displacements) by the actions (n, actions) in units of `max_step_m`."""
        moved = self._wanted_m + self.max_step_m * _held(actions, 1.0)
        self._wanted_m = _held(moved, self.travel_m)
        pulls_m = _held(self._wanted_m @ self._ways, self.travel_m)
        return self._seen(self._plants.step(pulls_m))

    def shape(self, index: int, n: int = 60) -> Array | None:
        """Positions (n, 3) along a simulated robot, metres."""
        return self._plants.shape(index, n)

    def wanted(self) -> Array:
        """Wanted bends or displacements (n, actions) as shares of the travel."""
        return self._wanted_m / self.travel_m

    def _seen(self, told: tuple[Array, Array, list[bool], list[str]]) -> Seen:
        tips_m, pulls_m, valid, status = told
        return Seen(tips_m, pulls_m, np.array(valid, dtype=bool), status)

    def _drawn(self, generator: np.random.Generator) -> str:
        if self.randomise is None:
            return ""
        if callable(self.randomise):
            return json.dumps(list(self.randomise(generator)))
        return json.dumps([{name: _draw(values, generator)} for name, values in self.randomise.items()])


def _held(values: Array, limit: float) -> Array:
    """Values held within ±limit; on few numbers `np.clip` takes several times as long."""
    held: Array = np.minimum(np.maximum(values, -limit), limit)
    return held


def _draw(values: Mapping[str, float | Range], generator: np.random.Generator) -> dict[str, float]:
    drawn = {}
    for key, value in values.items():
        if isinstance(value, (int, float)):
            drawn[key] = float(value)
            continue
        low, high = value
        drawn[key] = float(generator.uniform(low, high))
    return drawn


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
