"""Policies of your own in a run: classes, files of Python and networks."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

import spinebench
from spinebench.onnx import save_network

SPEC = """
name: mine
control_hz: 5
model: {constant_curvature: {}}
plant: {constant_curvature: {}}
training: {paper: {}}
targets: {pool: 30, drawn: 3, sweep: {rows: 7, columns: 7}}
modes: {closed: {feedback: closed}}
runs:
  reach:
    - {policies: [POLICY], modes: [closed]}
figures: [table1]
"""


class Integral:
    """Integrates the error in x and y."""

    def __init__(self) -> None:
        self.bend = np.zeros(2)

    def reset(self) -> None:
        self.bend[:] = 0.0

    def act(self, tip_m: Any, target_m: Any, pulls_m: Any, time_s: float) -> Any:
        self.bend += 0.08 * (target_m - tip_m)[:2]
        settled = bool(np.linalg.norm((target_m - tip_m)[:2]) < 0.001)
        return np.concatenate([self.bend, -self.bend]), settled


class ClosedOnly(Integral):
    """Decides by the measured error."""

    closed_loop_only = True


class NoPolicy:
    """Decides nothing."""


class Fails(Integral):
    """Cannot be made."""

    def __init__(self) -> None:
        raise OSError("no weights")


class Broken(Integral):
    """Raises in the third step."""

    def act(self, tip_m: Any, target_m: Any, pulls_m: Any, time_s: float) -> Any:
        if time_s > 0.3:
            raise ZeroDivisionError("no gain")
        return np.zeros(4)


class Short(Integral):
    """One tendon too few."""

    def act(self, tip_m: Any, target_m: Any, pulls_m: Any, time_s: float) -> Any:
        return np.zeros(3)


class NotANumber(Integral):
    """Decides nothing."""

    def act(self, tip_m: Any, target_m: Any, pulls_m: Any, time_s: float) -> Any:
        return [np.nan] * 4


class Words(Integral):
    """Decides no numbers."""

    def act(self, tip_m: Any, target_m: Any, pulls_m: Any, time_s: float) -> Any:
        return "left"


def run(folder: Path, spec: str) -> spinebench.ExperimentResult:
    """Runs an experiment."""
    (folder / "mine.yaml").write_text(spec)
    return spinebench.run(folder / "mine.yaml", out=folder / "out", cache=folder / "cache")["mine"]


def trials(result: spinebench.ExperimentResult, name: str) -> pd.DataFrame:
    """Rows of a policy."""
    return result.trials[result.trials.policy == name]


def own(policy: str) -> str:
    """A spec that names a policy in a file."""
    return SPEC.replace("POLICY", "mine").replace("modes: {closed", f"policies: {{mine: {policy}}}\nmodes: {{closed")


def test_a_class_in_a_file_reaches_its_targets(tmp_path: Path) -> None:
    spec = own(f"{{python: {{file: {__file__}, class: Integral}}}}")
    found = trials(run(tmp_path, spec), "mine")
    assert len(found) == 3 and (found.status == "ok").all()
    assert found.error_m.max() < 0.003
    again = spinebench.run(tmp_path / "mine.yaml", out=tmp_path / "out", cache=tmp_path / "cache")
    assert again.computed == 0
    assert "mine" in (tmp_path / "out" / "results" / "mine" / "table1.md").read_text()


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("Broken", r"ZeroDivisionError: no gain \(test_policies.py, line \d+\)"),
        ("Short", "found 3, expected 4"),
        ("NotANumber", "not finite: tendon displacement"),
        ("Words", "found a str, expected displacements"),
    ],
)
def test_faults_are_statuses_of_their_trials(tmp_path: Path, name: str, words: str) -> None:
    spec = own(f"{{python: {{file: {__file__}, class: {name}}}}}")
    found = trials(run(tmp_path, spec), "mine")
    assert len(found) == 3 and found.status.str.contains(words).all(), list(found.status)


@pytest.mark.parametrize(
    ("name", "words"), [("Nobody", "`Nobody`, which"), ("NoPolicy", "which has no method act"), ("Fails", "no weights")]
)
def test_a_class_is_looked_at_before_anything_runs(tmp_path: Path, name: str, words: str) -> None:
    with pytest.raises(spinebench.InputError, match=words) as error:
        run(tmp_path, own(f"{{python: {{file: {__file__}, class: {name}}}}}"))
    assert error.value.file == str(tmp_path / "mine.yaml") and error.value.key == "policies.outside.mine.python.class"
    assert not (tmp_path / "out").exists()


def test_a_class_for_closed_loop_only_has_no_open_loop(tmp_path: Path) -> None:
    spec = own(f"{{python: {{file: {__file__}, class: ClosedOnly}}}}")
    spec = spec.replace("modes: {closed", "modes: {open: {feedback: open}, closed")
    result = run(tmp_path, spec.replace("modes: [closed]", "modes: [open, closed]"))
    assert set(trials(result, "mine")["mode"]) == {"closed"}
    for table, cells in (("table1.md", "| N/A |"), ("table1.tex", "mine & N/A &")):
        assert cells in (tmp_path / "out" / "results" / "mine" / table).read_text()


def test_a_network_stands_in_the_table(tmp_path: Path) -> None:
    # Pulls of 0.1 times the target's x and y: the network sees the target alone.
    weights = 0.1 * np.array([[1.0, 0, 0], [0, 1.0, 0], [-1.0, 0, 0], [0, -1.0, 0]])
    save_network(tmp_path / "net.onnx", [(weights, np.zeros(4))])
    result = run(tmp_path, own("{onnx: {file: net.onnx, inputs: [target]}}"))
    found = trials(result, "mine")
    assert (found.status == "ok").all() and found.error_m.max() < 0.1


def test_a_class_joins_the_table_beside_the_policies_of_the_program(root: Path, tmp_path: Path) -> None:
    spec = root / "experiments" / "smoke.yaml"
    result = spinebench.run(spec, policies={"mine": Integral}, seeds=1, out=tmp_path / "out", cache=tmp_path / "cache")
    assert not result.failures
    rows = result["smoke"].trials
    assert {"a", "b", "c", "mine"} <= set(rows.policy)
    assert (rows[rows.policy == "mine"].status == "ok").all()
    table = (tmp_path / "out" / "results" / "smoke" / "table1.md").read_text()
    assert "mine" in table
    # The content of the file is the key: nothing is computed again.
    again = spinebench.run(spec, policies={"mine": Integral}, seeds=1, out=tmp_path / "out", cache=tmp_path / "cache")
    assert again.computed == 0
    # An object without a file of its own is computed each time, and it alone.
    third = spinebench.run(
        spec, policies={"mine": lambda: Integral()}, seeds=1, out=tmp_path / "out", cache=tmp_path / "cache"
    )
    assert 0 < third.computed < result.computed / 2


@pytest.mark.parametrize(
    ("policy", "words"),
    [
        ("{onnx: {file: none.onnx}}", "none.onnx"),
        ("{python: {file: none.py, class: A}}", "none.py"),
        ("{python: {file: none.py}}", "class"),
    ],
)
def test_wrong_entries(tmp_path: Path, policy: str, words: str) -> None:
    with pytest.raises(spinebench.InputError, match=words) as error:
        run(tmp_path, own(policy))
    assert error.value.file == str(tmp_path / "mine.yaml")
    with pytest.raises(spinebench.InputError, match="expected a class"):
        spinebench.run(tmp_path / "mine.yaml", policies={"mine": 3})  # type: ignore[dict-item]


def test_networks_are_checked_before_they_are_written(tmp_path: Path) -> None:
    for layers in ([], [(np.zeros((2, 3)), np.zeros(3))], [(np.full((1, 1), np.nan), np.zeros(1))]):
        with pytest.raises(spinebench.InputError):
            save_network(tmp_path / "net.onnx", layers)
    assert not (tmp_path / "net.onnx").exists()
