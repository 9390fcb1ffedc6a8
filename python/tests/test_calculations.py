"""Simulate, calibrate, discover and run."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import spinebench
from spinebench import Model


def commands(trials: int = 6, rows: int = 14, seed: int = 3) -> pd.DataFrame:
    """Random walks of four antagonistic tendons."""
    rng = np.random.default_rng(seed)
    parts = []
    for trial in range(trials):
        bend = np.clip(np.cumsum(rng.uniform(-0.006, 0.006, (rows, 2)), axis=0), -0.015, 0.015)
        bend[0] = 0.0
        pulls = np.column_stack([bend, -bend])
        frame = pd.DataFrame(pulls, columns=[f"tendon_{i}_m" for i in range(1, 5)])
        frame.insert(0, "time_s", 0.2 * np.arange(rows))
        frame.insert(0, "trial", trial)
        parts.append(frame)
    return pd.concat(parts, ignore_index=True)


def test_simulate_is_the_rod(model: Model) -> None:
    frame = commands(trials=1)
    played = spinebench.simulate(model, frame)
    assert len(played) == len(frame) and (played.solver_status == "converged").all()
    rod = spinebench.Rod(model)
    pulls = frame[[f"tendon_{i}_m" for i in range(1, 5)]].to_numpy()
    tips = np.array([rod.settle(pulls[0])] + [rod.step(pull) for pull in pulls[:-1]])
    np.testing.assert_allclose(played[["tip_x_m", "tip_y_m", "tip_z_m"]].to_numpy(), tips, atol=1e-9)


def test_calibrate_finds_the_modulus(model: Model) -> None:
    path = "robot.backbone.youngs_modulus_pa"
    real = model.with_value(path, 1.1 * model.value(path))
    measured = spinebench.simulate(real, commands(trials=2), static=True, noise_m=1e-4)
    found = spinebench.calibrate(model, measured, fit=[path], static=True)
    assert found.after_m < found.before_m
    (number,) = found.numbers
    assert number.low < real.value(path) < number.high or abs(number.value / real.value(path) - 1) < 0.01
    assert len(found.sightings) == len(measured)


def test_calibrate_takes_several_recordings(model: Model) -> None:
    path = "robot.backbone.youngs_modulus_pa"
    real = model.with_value(path, 1.1 * model.value(path))
    free, hung = commands(trials=2), commands(trials=2, seed=4)
    hung["known_load_kg"] = 0.05
    measured = [spinebench.simulate(real, each, static=True) for each in (free, hung)]
    found = spinebench.calibrate(model, measured, fit=[path], static=True)
    assert len(found.sightings) == len(free) + len(hung)
    assert abs(found.numbers[0].value / real.value(path) - 1) < 1e-5
    assert {group["name"] for group in found.findings["residual_groups"] if group["kind"] == "recording"} == {
        "measured_0",
        "measured_1",
    }


def test_discover_names_a_tip_load(model: Model) -> None:
    real = model.with_effects([{"tip_load": {"mass_kg": 0.02}}])
    columns = ["trial", "time_s", *[f"tendon_{i}_m" for i in range(1, 5)], "tip_x_m", "tip_y_m", "tip_z_m"]
    measured = spinebench.simulate(real, commands(), noise_m=3e-4)[columns]
    found = spinebench.discover(model, measured, leave_out=[])
    assert found.verdict in {"named", "ambiguous"}
    assert found.after_m < 0.5 * found.before_m
    assert "tip_load" in {effect.name for effect in found.effects}
    assert len(found.residuals) > 0 and len(found.candidates) > 0


def test_an_ambiguous_answer_is_asked_again(model: Model) -> None:
    real = model.with_effects([{"tip_load": {"mass_kg": 0.0012}}])
    columns = ["trial", "time_s", *[f"tendon_{i}_m" for i in range(1, 5)], "tip_x_m", "tip_y_m", "tip_z_m"]
    measured = spinebench.simulate(real, commands(), noise_m=5e-4)[columns]
    calls = []

    def record(answer: spinebench.Discovery, proposals: list[spinebench.Proposal]) -> pd.DataFrame | None:
        assert answer.verdict == "ambiguous"
        calls.append(proposals[0].name)
        kept = next(one for one in proposals if one.name not in {"base_remounted", "known_weight"})
        return spinebench.simulate(real, kept.commands, noise_m=5e-4, seed=1)[columns]

    answers = spinebench.discover_until_named(model, measured, record, max_rounds=1)
    assert len(answers) == 1 + len(calls) and len(calls) <= 1
    assert all(answer.verdict == "ambiguous" for answer in answers[:-1])
    if calls:
        assert len(answers[1].residuals) > len(answers[0].residuals)


def test_a_failing_recorder_ends_the_loop(model: Model) -> None:
    with pytest.raises(spinebench.InputError, match="max_rounds"):
        spinebench.discover_until_named(model, commands(), lambda answer, proposals: None, max_rounds=-1)


def test_run_publishes_frames(tmp_path: Path) -> None:
    spec = tmp_path / "tiny.yaml"
    spec.write_text(
        "name: tiny\ncontrol_hz: 5\n"
        "plant: {constant_curvature: {}}\n"
        "model: {constant_curvature: {}}\n"
        "training: {paper: {}}\n"
        "runs: {gap: {rows: 20}}\n"
    )
    out = spinebench.run(spec, out=tmp_path / "out", cache=tmp_path / "cache", set={"explore.points": 100})
    assert not out.failures and out.computed > 0
    assert len(out["tiny"].table("gap")) == 20
    again = spinebench.run(spec, out=tmp_path / "out", cache=tmp_path / "cache", set={"explore.points": 100})
    assert again.computed == 0
    with pytest.raises(spinebench.InputError, match="expected one of"):
        out["tiny"].table("nothing")
