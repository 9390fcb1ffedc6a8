"""What notebooks show of results: small tables in HTML."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ._bags import ImportedRecording
    from ._discoveries import Discovery
    from ._fits import Calibration
    from ._runs import Plan, RunResult
    from ._spinebench import Model

MAX_ROWS = 12
"""Rows of a long table that are shown."""


def _table(head: Sequence[str], rows: Iterable[Sequence[Any]], more: int = 0) -> str:
    cells = "".join(f"<th>{escape(name)}</th>" for name in head)
    body = "".join(f"<tr>{''.join(f'<td>{escape(str(cell))}</td>' for cell in row)}</tr>" for row in rows)
    further = f"<tr><td colspan='{len(head)}'>and {more} more</td></tr>" if more > 0 else ""
    return f"<table><thead><tr>{cells}</tr></thead><tbody>{body}{further}</tbody></table>"


def _titled(title: str, *parts: str) -> str:
    return f"<div><strong>{escape(title)}</strong>{''.join(parts)}</div>"


def _paragraph(text: str) -> str:
    return f"<p>{escape(text)}</p>"


def _list(items: Sequence[str]) -> str:
    return f"<ul>{''.join(f'<li>{escape(item)}</li>' for item in items)}</ul>" if items else ""


def _mm(length_m: float | None) -> str:
    return "–" if length_m is None else f"{1e3 * length_m:.3g} mm"


def _number(value: Any) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def model(shown: Model) -> str:
    """Its numbers: the effects' and the main ones of the robot."""
    numbers = shown.parameters()
    effects = [number for number in numbers if number[0].startswith("effects")]
    others = [number for number in numbers if not number[0].startswith("effects")]
    rows = [(path, _number(value), unit) for path, value, unit in [*effects, *others]]
    title = f"Model: {shown.tendons} tendons, {shown.length_m:g} m, effects: {', '.join(shown.effect_names) or 'none'}"
    limit = max(MAX_ROWS, len(effects))
    return _titled(title, _table(["number", "value", "unit"], rows[:limit], len(rows) - limit))


def recording(shown: ImportedRecording) -> str:
    """Its trials, and what looks like a mistake."""
    frame = shown.recording
    trials = list(frame.groupby("trial", sort=False))
    rows = [(number, len(part), f"{part['time_s'].iloc[-1] - part['time_s'].iloc[0]:.3g}") for number, part in trials]
    clocks = [] if shown.clock is None else [f"clock of the tracker: {shown.clock.offset_s:+.4g} s"]
    clocks += [f"clock of the tracker in trial {number}: {fit.offset_s:+.4g} s" for number, fit in shown.clocks.items()]
    title = f"Recording: {len(frame)} rows, {len(trials)} trials, {len(frame.columns)} columns"
    table = _table(["trial", "rows", "duration (s)"], rows[:MAX_ROWS], len(rows) - MAX_ROWS)
    return _titled(title, table, _list([*clocks, *shown.notes]))


def calibration(shown: Calibration) -> str:
    """The fitted numbers with their intervals."""
    rows = [
        (one.name, _number(one.start), _number(one.value), f"{one.low:.4g} to {one.high:.4g}", one.unit, _yes(one.determined))
        for one in shown.numbers
    ]
    title = f"Calibration: rms error {_mm(shown.before_m)} before, {_mm(shown.after_m)} after"
    limitations = [str(one) for one in shown.findings.get("limitations", [])]
    table = _table(["number", "start", "value", "95 % interval", "unit", "determined"], rows)
    return _titled(title, table, _list(limitations))


def _yes(value: bool) -> str:
    return "yes" if value else "no"


def discovery(shown: Discovery) -> str:
    """The verdict, the named effects and the best candidates."""
    effects = [
        (effect.name, key, _number(value), _interval(effect.interval_95.get(key)), f"{effect.confidence:.3g}")
        for effect in shown.effects
        for key, value in effect.parameters.items()
    ]
    parts = [_paragraph(shown.summary)]
    if effects:
        parts.append(_table(["effect", "parameter", "value", "95 % interval", "confidence"], effects))
    if len(shown.candidates) > 0:
        best = shown.candidates.head(5)
        rows = [(one["name"], _mm(one["after_m"]), one["why_not"]) for _, one in best.iterrows()]
        parts.append(_table(["candidate", "rms error with it", "reason for rejection"], rows, len(shown.candidates) - len(best)))
    title = f"Discovery: {shown.verdict}, rms error {_mm(shown.before_m)} before, {_mm(shown.after_m)} after"
    return _titled(title, *parts, _list([str(one) for one in shown.findings.get("limitations", [])]))


def _interval(interval: Any) -> str:
    if isinstance(interval, (list, tuple)) and len(interval) == 2 and all(isinstance(end, (int, float)) for end in interval):
        return f"{interval[0]:.4g} to {interval[1]:.4g}"
    return "–" if interval is None else str(interval)


def run(shown: RunResult) -> str:
    """Its experiments, and what failed."""
    rows = [(one.name, str(one.folder), len(one.files), one.failed_trials) for one in shown.experiments.values()]
    title = f"Run: {shown.computed} stages computed, {shown.cached} read from the store"
    notices = [notice for one in shown.experiments.values() for notice in one.notices]
    table = _table(["experiment", "tables in", "files", "failed trials"], rows)
    return _titled(title, table, _list([*shown.failures, *notices]))


def plan(shown: Plan) -> str:
    """What is stored and what is left, by kind of stage."""
    stored = int(shown.runs["stored"].sum())
    rows = [(one["kind"], one["stored"], one["left"]) for _, one in shown.stages.iterrows()]
    title = f"Plan: {len(shown.runs)} runs, {stored} stored"
    return _titled(title, _table(["stage", "stored", "left"], rows))
