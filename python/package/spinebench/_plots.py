"""Pictures by matplotlib: shapes, recordings, residuals and tables."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from ._errors import InputError

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

COLOURS = ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000"]
"""Palette of Okabe and Ito, which colour-blind readers can distinguish."""
DASHES = ["-", "--", "-.", ":"]
MM = 1e3


def plot(shown: Any, *, axes: Axes | Sequence[Axes] | None = None, title: str | None = None, **options: Any) -> Figure:
    """Draw a `Rod` or `Rods` (shapes from the side and from above), a recording (tip and commands), a `Discovery` or
    `Calibration` (residuals), or a table of a run (`y` by `by`, such as `error_m` by `policy`).

    `axes` are drawn on where they are given: two of shapes and of recordings, one of anything else. Recordings take `trial`, the
    number of a trial, all by default. Returns the figure. Needs matplotlib: `pip install "./python[plot]"`.
    """
    draw, panels, size = _kind(shown)
    figure, given = _axes(axes, panels, size)
    draw(given, shown, **options)
    if title is not None:
        figure.suptitle(title)
    return figure


def _kind(shown: Any) -> tuple[Callable[..., None], int, tuple[float, float]]:
    """How it is drawn: by which function, on how many axes, in which size (inches)."""
    shown_type = type(shown).__name__
    if shown_type in ("Rod", "Rods"):
        return _shapes, 2, (9.0, 3.0)
    if shown_type == "ImportedRecording":
        return lambda axes, it, **options: _recording(axes, it.recording, **options), 2, (8.0, 5.0)
    if shown_type == "Discovery":
        return _residuals, 1, (8.0, 3.5)
    if shown_type == "Calibration":
        return _errors, 1, (8.0, 3.5)
    if isinstance(shown, pd.DataFrame):
        is_recording = {"trial", "time_s"} <= set(shown.columns) and _commands(shown)
        return (_recording, 2, (8.0, 5.0)) if is_recording else (_table, 1, (7.0, 4.0))
    raise InputError(f"plot: found a {shown_type}, expected a rod, a recording, a result or a table")


def _axes(axes: Axes | Sequence[Axes] | None, panels: int, size: tuple[float, float]) -> tuple[Figure, list[Axes]]:
    if axes is not None:
        given: list[Any] = list(axes) if isinstance(axes, (list, tuple, np.ndarray)) else [axes]
        if len(given) != panels:
            raise InputError(f"axes: found {len(given)}, expected {panels}")
        return given[0].figure, given
    try:
        pyplot = importlib.import_module("matplotlib.pyplot")
    except ImportError:
        raise InputError('plot: found no matplotlib, expected matplotlib to be installed: pip install "./python[plot]"') from None
    columns = 2 if size[0] > 8.5 else 1
    figure, made = pyplot.subplots(panels // columns, columns, figsize=size, layout="constrained", squeeze=False)
    return figure, list(made.flat)


def _shapes(axes: list[Axes], shown: Any, n: int = 80) -> None:
    """Positions along the robots from the side (z, x) and from above (z, y), millimetres, on equal scales."""
    shapes = shown.shape(n)[np.newaxis] if type(shown).__name__ == "Rod" else shown.shapes(n)
    # Many robots are a cloud, and a colour each would say nothing.
    several = 1 < len(shapes) <= len(COLOURS)
    reach = MM * float(max(1.15 * np.abs(shapes[..., :2]).max(), 0.3 * np.ptp(shapes[..., 2])))
    for ax, across, view in zip(axes, (0, 1), ("from the side", "from above"), strict=True):
        for number, shape in enumerate(shapes):
            colour = COLOURS[number % len(COLOURS) if several else 0]
            alpha = 1.0 if len(shapes) <= len(COLOURS) else 0.35
            label = f"robot {number}" if several else None
            ax.plot(MM * shape[:, 2], MM * shape[:, across], color=colour, linewidth=2.0, alpha=alpha, label=label)
            ax.plot(MM * shape[-1, 2], MM * shape[-1, across], "o", color=colour, markersize=5.0, alpha=alpha)
        ax.plot([0.0], [0.0], "s", color="black", markersize=7.0)
        ax.set(xlabel="z (mm)", ylabel=f"{'xy'[across]} (mm)", title=view, ylim=(-reach, reach))
        ax.set_aspect("equal", adjustable="box")
        ax.grid(alpha=0.3)
    if several:
        axes[0].legend(fontsize="small")


def _commands(frame: pd.DataFrame) -> list[str]:
    return [str(name) for name in frame.columns if str(name).startswith(("tendon_", "drive_"))]


def _clock(frame: pd.DataFrame) -> tuple[NDArray[np.float64], list[float]]:
    """Seconds over consecutive trials, and where each trial begins."""
    time_s, starts, end_s = np.zeros(len(frame)), [], 0.0
    trial = frame["trial"].to_numpy()
    first = np.flatnonzero(np.r_[True, trial[1:] != trial[:-1]])
    for begin, end in zip(first, [*first[1:], len(frame)], strict=True):
        trial_s = frame["time_s"].to_numpy(dtype=float)[begin:end]
        starts.append(end_s)
        time_s[begin:end] = end_s + trial_s - trial_s[0]
        step_s = float(np.median(np.diff(trial_s))) if len(trial_s) > 1 else 1.0
        end_s = float(time_s[end - 1]) + step_s
    return time_s, starts


def _over_time(ax: Axes, frame: pd.DataFrame, starts: list[float]) -> None:
    for start_s in starts[1:]:
        ax.axvline(start_s, color="0.8", linewidth=0.8, zorder=0)
    of_one = "time (s)" if len(starts) == 1 else f"time (s), {len(starts)} consecutive trials"
    ax.set_xlabel(of_one)
    ax.grid(alpha=0.3)


def _lines(ax: Axes, time_s: NDArray[np.float64], starts: list[float], columns: dict[str, NDArray[np.float64]]) -> None:
    """Lines that do not go on from one trial to the next."""
    breaks = np.searchsorted(time_s, starts[1:])
    for number, (label, values) in enumerate(columns.items()):
        colour, dash = COLOURS[number % len(COLOURS)], DASHES[number // len(COLOURS) % len(DASHES)]
        times, broken = np.insert(time_s, breaks, np.nan), np.insert(values, breaks, np.nan)
        ax.plot(times, broken, dash, color=colour, linewidth=1.3, label=label)
    ax.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), fontsize="small", frameon=False)


def _recording(axes: list[Axes], frame: pd.DataFrame, trial: int | None = None) -> None:
    """The tip and the commands over time."""
    if trial is not None:
        frame = frame[frame["trial"] == trial]
    if len(frame) == 0:
        raise InputError(f"trial: found {trial}, expected a trial of the recording")
    time_s, starts = _clock(frame)
    names = ["tip_x_m", "tip_y_m", "tip_z_m"]
    is_measured = set(names) <= set(frame.columns)
    if is_measured:
        valid = frame["valid"].to_numpy(dtype=bool) if "valid" in frame.columns else np.ones(len(frame), dtype=bool)
        tips = {name[4]: np.where(valid, MM * frame[name].to_numpy(dtype=float), np.nan) for name in names}
        _lines(axes[0], time_s, starts, tips)
    else:
        axes[0].text(0.5, 0.5, "no tip was recorded", transform=axes[0].transAxes, ha="center", va="center")
    axes[0].set_ylabel("tip (mm)")
    commands = _commands(frame)
    unit = commands[0].rsplit("_", 1)[1]
    scale, shown, what = {"m": (MM, "mm", "displacement"), "n": (1.0, "N", "tension")}.get(unit, (1.0, unit, "drive"))
    columns = {name.rsplit("_", 1)[0].replace("_", " "): scale * frame[name].to_numpy(dtype=float) for name in commands}
    _lines(axes[1], time_s, starts, columns)
    axes[1].set_ylabel(f"{what} ({shown})")
    for ax in axes:
        _over_time(ax, frame, starts)


def _size(frame: pd.DataFrame, prefix: str) -> NDArray[np.float64]:
    """Length of a vector of three columns, millimetres."""
    squares = [frame[f"{prefix}_{axis}_m"].to_numpy(dtype=float) ** 2 for axis in "xyz"]
    return np.asarray(MM * np.sqrt(sum(squares)))


def _residuals(axes: list[Axes], shown: Any) -> None:
    """Sizes of the residuals of the given and of the extended model; held-out trials are shaded."""
    (ax,), frame = axes, shown.residuals.sort_values(["trial", "time_s"], kind="stable")
    time_s, starts = _clock(frame)
    # Where no effect was named, both are the same.
    parts = {"given model": _size(frame, "before")}
    after = _size(frame, "after")
    if np.isfinite(after).any() and not np.allclose(parts["given model"], after, equal_nan=True):
        parts[f"with {', '.join(effect.name for effect in shown.effects) or 'changes'}"] = after
    _lines(ax, time_s, starts, parts)
    noise_mm = shown.findings.get("noise_floor_m")
    if noise_mm is not None:
        ax.axhline(MM * noise_mm, color="0.4", linestyle=":", linewidth=1.2, label="noise floor")
    held_out = frame["held_out"].to_numpy(dtype=bool)
    ends = [*starts[1:], float(time_s[-1])]
    shaded = [(start, end) for start, end in zip(starts, ends, strict=True) if held_out[np.searchsorted(time_s, start)]]
    for number, (start_s, end_s) in enumerate(shaded):
        ax.axvspan(start_s, end_s, color="0.92", zorder=-1, label="held out" if number == 0 else None)
    ax.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), fontsize="small", frameon=False)
    ax.set(ylabel="measured − model (mm)", ylim=(0.0, None), title=f"{shown.verdict}")
    _over_time(ax, frame, starts)


def _errors(axes: list[Axes], shown: Any) -> None:
    """Errors of the fitted model along each axis."""
    (ax,), frame = axes, shown.sightings.sort_values(["trial", "time_s"], kind="stable")
    time_s, starts = _clock(frame)
    for number, axis in enumerate("xyz"):
        errors = MM * frame[f"error_{axis}_m"].to_numpy(dtype=float)
        ax.plot(time_s, errors, "o^s"[number], color=COLOURS[number], markersize=3.5, alpha=0.8, label=axis)
    ax.axhline(0.0, color="black", linewidth=0.8)
    ax.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), fontsize="small", frameon=False)
    ax.set(ylabel="model − measured (mm)", title=f"rms {MM * shown.before_m:.3g} mm before, {MM * shown.after_m:.3g} mm after")
    _over_time(ax, frame, starts)


UNITS = {"_m": (MM, "mm"), "_s": (1.0, "s"), "_rad": (1.0, "rad"), "_n": (1.0, "N"), "_kg": (1e3, "g"), "_share": (1.0, "share")}


def _table(axes: list[Axes], frame: pd.DataFrame, y: str | None = None, by: str | Sequence[str] | None = None) -> None:
    """A number of each row by groups: every row as a point, the median as a line."""
    (ax,) = axes
    columns = [str(name) for name in frame.columns]
    y = y or next((name for name in ("error_m", "distance_m") if name in columns), None)
    if y is None or y not in columns:
        raise InputError(f"y: found {y!r}, expected one of: {', '.join(columns)}")
    groups = [by] if isinstance(by, str) else list(by or [name for name in ("policy", "mode") if name in columns])
    unknown = [name for name in groups if name not in columns]
    if unknown or not groups:
        raise InputError(f"by: found {unknown or None!r}, expected one of: {', '.join(columns)}")
    scale, unit = next((value for end, value in UNITS.items() if y.endswith(end)), (1.0, ""))
    # The first group has the colour, the others are beside each other.
    spread, labels, shades = np.random.default_rng(0), [], dict[str, int]()
    for place, (name, rows) in enumerate(frame.groupby(groups, sort=False)):
        values = scale * rows[y].to_numpy(dtype=float)
        values = values[np.isfinite(values)]
        first = str(name[0] if isinstance(name, tuple) else name)
        colour = COLOURS[shades.setdefault(first, len(shades)) % len(COLOURS)]
        ax.plot(place + spread.uniform(-0.25, 0.25, len(values)), values, ".", color=colour, markersize=4.0, alpha=0.5)
        if len(values) > 0:
            for colour, width in (("white", 5.0), ("black", 2.0)):
                ax.plot([place - 0.34, place + 0.34], [np.median(values)] * 2, color=colour, linewidth=width)
        labels.append(", ".join(str(part) for part in (name if isinstance(name, tuple) else (name,))))
    crowded = sum(len(label) for label in labels) > 60
    ax.set_xticks(range(len(labels)), labels, rotation=35.0 if crowded else 0.0, ha="right" if crowded else "center")
    what = y.removesuffix(next((end for end in UNITS if y.endswith(end)), "")).replace("_", " ")
    ax.set(xlabel=", ".join(groups), ylabel=f"{what} ({unit})" if unit else what, title="each row, and the median")
    ax.set_ylim(bottom=min(0.0, ax.get_ylim()[0]))
    ax.grid(axis="y", alpha=0.3)
