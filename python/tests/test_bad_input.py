"""Bad input: one sentence, never a panic, never a hang."""

from __future__ import annotations

import multiprocessing
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import spinebench
from spinebench import InputError, Model, Rod, Rods


@pytest.mark.parametrize(
    ("pulls", "words"),
    [
        ([0.0] * 3, r"pulls_m: found shape \(3,\), expected shape \(4,\)"),
        ([[0.0] * 4], r"found shape \(1, 4\)"),
        ([0.0, 0.0, float("nan"), 0.0], "found NaN at flat index 2, expected finite numbers"),
        ([0.0, float("inf"), 0.0, 0.0], "found inf at flat index 1"),
        (["a"] * 4, "found dtype <U1, expected an array of real numbers"),
        (np.zeros(4, dtype=complex), "found dtype complex128"),
        (object(), "expected an array of real numbers"),
        ([[0.0], [0.0, 1.0]], "expected an array of numbers"),
    ],
)
def test_wrong_arrays(model: Model, pulls: object, words: str) -> None:
    for call in (Rod(model).settle, Rod(model).step):
        with pytest.raises(InputError, match=words):
            call(pulls)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    "call",
    [
        lambda model: Rod(model).step([0.0] * 4, 0.0),
        lambda model: Rod(model).step([0.0] * 4, float("nan")),
        lambda model: Rod(model).settle([0.0] * 4, tensions_n=[0.0] * 4),
        lambda model: Rod(model).jacobian("wind"),
        lambda model: Rod(model).shape(0),
        lambda model: Rod(model, parameters=["robot.nothing"]),
        lambda model: Rods([]),
        lambda model: Rods([model] * 2).settle(np.zeros((3, 4))),
        lambda model: Rods([model] * 2).play(np.zeros((3, 5, 4))),
        lambda model: model.with_value("robot.nothing", 1.0),
        lambda model: model.with_value("robot.backbone.length_m", -1.0),
        lambda model: model.with_effects([{"nothing": {}}]),
        lambda model: model.with_effects([{"tip_load": {"mass_kg": 20.0}}]),
        lambda model: Model.from_yaml("robot: {backbone: {length_m: long}}"),
        lambda model: spinebench.calibrate(model, "missing.csv"),
        lambda model: spinebench.discover(model, []),
        lambda model: spinebench.run(),
    ],
)
def test_wrong_arguments(model: Model, call: Callable[[Model], object]) -> None:
    with pytest.raises(InputError) as error:
        call(model)
    assert "panicked" not in str(error.value)


def test_numbers_in_other_units_are_refused_with_the_unit_that_was_meant(model: Model) -> None:
    with pytest.raises(InputError, match=r"found 2.3 \(if that is in GPa, write 2.3e9 Pa\)"):
        model.with_value("robot.backbone.youngs_modulus_pa", 2.3)
    millimetres = [3.0, 0.0, -3.0, 0.0]
    for call in (Rod(model).settle, Rod(model).step, lambda pulls: Rods([model] * 2).play(np.full((2, 5, 4), pulls))):
        with pytest.raises(InputError, match=r"found -?3, expected metres, a possible displacement for a robot of 0.22 m"):
            call(millimetres)


def test_a_fault_in_a_file_names_file_line_and_key(tmp_path: Path) -> None:
    file = tmp_path / "model.yaml"
    file.write_text("robot:\n  backbone:\n    lenght_m: 0.2\n")
    with pytest.raises(InputError) as error:
        Model.load(file)
    assert (error.value.file, error.value.line) == (str(file), 3)
    assert "lenght_m" in (error.value.key or "") and "length_m" in str(error.value)


def test_a_rod_in_motion_has_no_jacobian_at_rest(model: Model) -> None:
    rod = Rod(model)
    rod.step([0.005, 0.0, -0.005, 0.0])
    with pytest.raises(spinebench.SolverError) as error:
        rod.jacobian()
    assert error.value.status == "not_at_rest"


def test_ctrl_c_ends_a_long_call(model: Model) -> None:
    rods = Rods([model] * 4)
    pulls = np.random.default_rng(1).uniform(-0.01, 0.01, (4, 5000, 4))
    # Shells start background jobs, and so the tests of a build server, with the signal ignored.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    threading.Timer(0.5, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
    started = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        rods.play(pulls)
    assert time.monotonic() - started < 60.0
    # The robots answer again.
    rods.restart()
    assert np.isfinite(rods.settle(np.zeros((4, 4)))).all()


def test_a_call_after_ctrl_c_waits_for_the_one_before(model: Model) -> None:
    # The call that was left still works on all threads; the next one must not be lent to one of them.
    rods = Rods([model] * 4)
    pulls = np.random.default_rng(1).uniform(-0.01, 0.01, (4, 5000, 4))
    signal.signal(signal.SIGINT, signal.default_int_handler)
    for attempt in range(20):
        threading.Timer(0.05 + 0.007 * attempt, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
        with pytest.raises(KeyboardInterrupt):
            rods.play(pulls)
        rods.restart()
        assert np.isfinite(rods.settle(np.zeros((4, 4)))).all()


def _tip_in_child(queue: multiprocessing.Queue[list[float]]) -> None:
    model = Model()
    queue.put([float(value) for value in Rods([model] * 2).settle(np.zeros((2, 4)))[0]])


def test_a_forked_process_has_threads_of_its_own(model: Model) -> None:
    Rods([model] * 2).settle(np.zeros((2, 4)))
    context = multiprocessing.get_context("fork")
    queue: multiprocessing.Queue[list[float]] = context.Queue()
    child = context.Process(target=_tip_in_child, args=(queue,))
    child.start()
    assert len(queue.get(timeout=120)) == 3
    child.join(timeout=120)
    assert child.exitcode == 0


def test_a_call_from_another_thread_waits_for_no_lock(model: Model) -> None:
    rods, counted = Rods([model] * 8), [0]
    stop = threading.Event()

    def count() -> None:
        while not stop.is_set():
            counted[0] += 1

    thread = threading.Thread(target=count)
    thread.start()
    before = counted[0]
    rods.play(np.zeros((8, 50, 4)))
    during = counted[0] - before
    stop.set()
    thread.join()
    # Python ran meanwhile: the interpreter's lock was free.
    assert during > 100


def test_the_package_is_imported_by_a_fresh_interpreter() -> None:
    done = subprocess.run(
        [sys.executable, "-c", "import spinebench; print(spinebench.Model().tendons)"],
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stdout.strip() == "4"
