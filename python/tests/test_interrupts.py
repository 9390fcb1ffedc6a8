"""Ctrl-C in long calls: KeyboardInterrupt at once, the computation behind it ends, and nothing half-written stays."""

from __future__ import annotations

import contextlib
import os
import signal
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import spinebench
from spinebench import GaussianProcess, Model, NetworkRegressor

TASKS = Path("/proc/self/task")
pytestmark = pytest.mark.skipif(not TASKS.is_dir(), reason="threads are listed by Linux alone")
TENDONS = [f"tendon_{i}_m" for i in range(1, 5)]


def calls_under_way() -> int:
    """Number of computations that run in this process."""
    names = []
    for task in TASKS.iterdir():
        with contextlib.suppress(OSError):
            names.append((task / "comm").read_text().strip())
    return names.count("spinebench call")


def wait(until: Callable[[], bool], what: str) -> None:
    """Waits; a minute is a hang. Undisturbed the computations here take minutes."""
    for _ in range(6000):
        if until():
            return
        time.sleep(0.01)
    pytest.fail(what)


@contextlib.contextmanager
def interrupted() -> Iterator[None]:
    """Sends SIGINT as soon as a computation is under way, and expects KeyboardInterrupt and its end."""
    wait(lambda: calls_under_way() == 0, "an earlier computation goes on")
    signal.signal(signal.SIGINT, signal.default_int_handler)
    seen = threading.Event()

    def press() -> None:
        wait(lambda: calls_under_way() > 0, "no computation began")
        time.sleep(0.2)
        seen.set()
        os.kill(os.getpid(), signal.SIGINT)

    thread = threading.Thread(target=press)
    thread.start()
    with pytest.raises(KeyboardInterrupt):
        yield
    thread.join()
    assert seen.is_set()
    wait(lambda: calls_under_way() == 0, "the computation goes on")


@pytest.fixture
def scratch(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty folder in which temporary files are made."""
    folder = tmp_path / "scratch"
    folder.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(folder))
    return folder


def walk(trials: int, rows: int) -> pd.DataFrame:
    """Random walks of four antagonistic tendons."""
    rng = np.random.default_rng(2)
    parts = []
    for trial in range(trials):
        bend = np.clip(np.cumsum(rng.uniform(-0.004, 0.004, (rows, 2)), axis=0), -0.015, 0.015)
        bend[0] = 0.0
        frame = pd.DataFrame(np.column_stack([bend, -bend]), columns=TENDONS)
        frame.insert(0, "time_s", 0.2 * np.arange(rows))
        frame.insert(0, "trial", trial)
        parts.append(frame)
    return pd.concat(parts, ignore_index=True)


@pytest.mark.parametrize("static", [False, True])
def test_simulate(model: Model, scratch: Path, static: bool) -> None:
    frame = walk(1, 300_000)
    with interrupted():
        spinebench.simulate(model, frame, static=static)
    assert list(scratch.iterdir()) == []
    assert len(spinebench.simulate(model, frame.head(5), static=static)) == 5


@pytest.mark.parametrize("static", [False, True])
def test_calibrate(model: Model, scratch: Path, static: bool) -> None:
    part = spinebench.simulate(model, walk(1, 100), static=static)[["trial", "time_s", *TENDONS, "tip_x_m", "tip_y_m", "tip_z_m"]]
    measured = pd.concat([part.assign(trial=trial) for trial in range(600)], ignore_index=True)
    path = "robot.backbone.youngs_modulus_pa"
    other = model.with_value(path, 1.3 * model.value(path))
    with interrupted():
        spinebench.calibrate(other, measured, fit=[path, "robot.damping_time_s"] if not static else [path], static=static)
    assert list(scratch.iterdir()) == []
    found = spinebench.calibrate(other, part, fit=[path], static=static)
    assert abs(found.model.value(path) / model.value(path) - 1) < 0.01


def test_export_with_a_model(model: Model, scratch: Path, tmp_path: Path) -> None:
    measured = walk(1, 200_000)
    measured[["tip_x_m", "tip_y_m", "tip_z_m"]] = 0.1
    out = tmp_path / "out.mcap"
    with interrupted():
        spinebench.export_mcap(measured, out, model=model)
    assert not out.exists() and list(scratch.iterdir()) == []


def test_fit_of_a_process() -> None:
    rng = np.random.default_rng(0)
    inputs = rng.uniform(size=(3000, 6))
    with interrupted():
        GaussianProcess("se_ard").fit(inputs, rng.normal(size=3000))


def test_training_of_a_network() -> None:
    rng = np.random.default_rng(0)
    inputs, outputs = rng.normal(size=(20_000, 6)), rng.normal(size=(20_000, 3))
    with interrupted():
        NetworkRegressor(max_epochs=100_000, patience=100_000).fit(inputs, outputs)


def test_discover(model: Model, scratch: Path) -> None:
    measured = spinebench.simulate(model, walk(4, 60), noise_m=3e-4)
    with interrupted():
        spinebench.discover(model.with_effects([{"tip_load": {"mass_kg": 0.02}}]), measured)
    assert list(scratch.iterdir()) == []
