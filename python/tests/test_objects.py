"""Models and results as Python people use objects: pickled, copied, hashed, sent to processes, shown."""

from __future__ import annotations

import copy
import multiprocessing
import pickle
import re
import subprocess
from importlib.metadata import version as installed
from pathlib import Path

import gymnasium
import numpy as np
import pandas as pd
import pytest
from packaging.version import Version
from test_calculations import commands

import spinebench as sb

MODULUS = "robot.backbone.youngs_modulus_pa"


def all_models(root: Path) -> list[sb.Model]:
    files = sorted((root / "models").rglob("*.yaml"))
    models = [sb.Model()]
    for file in files:
        try:
            models.append(sb.Model(file))
        except sb.InputError:  # a plant file
            continue
    assert len(models) > 5
    return models


def test_every_model_comes_back_the_same(root: Path) -> None:
    for model in all_models(root):
        for again in (pickle.loads(pickle.dumps(model)), copy.copy(model), copy.deepcopy(model)):
            assert again == model and hash(again) == hash(model) and again.to_yaml() == model.to_yaml()
    models = all_models(root)
    assert len(set(models)) >= len(models) - 1, "the paper's robot has a file, too"


def test_models_are_keys_and_differ_by_content(model: sb.Model) -> None:
    stiffer = model.with_value(MODULUS, 1.1 * model.value(MODULUS))
    table = {model: "as built", stiffer: "stiffer"}
    assert table[stiffer.with_value(MODULUS, model.value(MODULUS))] == "as built"
    assert model != stiffer and model != "a model"
    loaded = model.with_effects([{"tip_load": {"mass_kg": 0.02}}])
    assert pickle.loads(pickle.dumps(loaded)).effect_names == ["tip_load"] and loaded != model


def test_a_fitted_number_may_lie_where_no_written_one_may(model: sb.Model) -> None:
    # A modulus in GPa by mistake is refused in a file; a result holds what a fit says.
    text = model.to_yaml().replace("youngs_modulus_pa: 2330000000.0", "youngs_modulus_pa: 2.33")
    with pytest.raises(sb.InputError):
        sb.Model.from_yaml(text)
    stored = pickle.dumps(model)
    assert b"2330000000.0" in stored
    odd = pickle.loads(stored.replace(b"2330000000.0", b"000000002.33"))
    assert odd.value(MODULUS) == 2.33 and pickle.loads(pickle.dumps(odd)) == odd


def tip_of(model: sb.Model) -> list[float]:
    """What a process does with a model that it is sent."""
    return [float(value) for value in sb.Rod(model).settle([0.01, 0.0, -0.01, 0.0])]


def test_processes_take_models(model: sb.Model) -> None:
    models = [model, model.with_effects([{"tip_load": {"mass_kg": 0.02}}])]
    with multiprocessing.get_context("spawn").Pool(2) as pool:
        tips = pool.map(tip_of, models)
    np.testing.assert_array_equal(tips, [tip_of(each) for each in models])


def test_a_path_stands_for_a_model(root: Path, tmp_path: Path) -> None:
    file = root / "models" / "nominal.yaml"
    model = sb.Model.load(file)
    pulls = [0.01, 0.0, -0.01, 0.0]
    tip = sb.Rod(model).settle(pulls)
    assert sb.Model(file) == sb.Model(str(file)) == sb.Model(model) == model
    np.testing.assert_array_equal(sb.Rod(file).settle(pulls), tip)
    np.testing.assert_array_equal(sb.Rods([file, str(file), model]).settle([pulls] * 3), [tip] * 3)
    played = sb.simulate(file, commands(trials=1), static=True)
    pd.testing.assert_frame_equal(played, sb.simulate(model, commands(trials=1), static=True))
    assert sb.calibrate(str(file), played, fit=[MODULUS], static=True).after_m < 1e-6
    sb.export_mcap(played, tmp_path / "played.mcap", model=file, static=True)
    assert (tmp_path / "played.mcap").stat().st_size > 0
    env = gymnasium.make("spinebench/Reach-v0", model=file)
    assert np.isfinite(env.reset(seed=0)[0]).all()


@pytest.mark.parametrize("wrong", [3, None, b"\x00", ["models/nominal.yaml"]])
def test_what_is_no_model_is_refused(wrong: object) -> None:
    with pytest.raises(sb.InputError, match="expected a Model, or the name of a model file|none.yaml|\0"):
        sb.Rod(wrong)  # type: ignore[arg-type]
    with pytest.raises(sb.InputError, match="none.yaml"):
        sb.Rods(["none.yaml"])


def test_the_version_names_the_revision(root: Path) -> None:
    found = Version(sb.__version__)
    assert found.base_version == installed_version()
    if found.local is not None:
        assert re.fullmatch(r"[0-9a-f]{8}(\.modified)?", found.local), sb.__version__
    program = root / "target" / "release" / "spinebench"
    if program.is_file():
        said = subprocess.run([program, "--version"], capture_output=True, text=True, check=True).stdout
        assert said.split("+")[0] == f"spinebench {found.base_version}" or said.strip() == f"spinebench {found}"


def installed_version() -> str:
    try:
        return installed("spinebench")
    except ModuleNotFoundError:  # imported from its folder
        return "0.1.0"


@pytest.fixture(scope="module")
def calibration(model: sb.Model) -> sb.Calibration:
    real = model.with_value(MODULUS, 1.1 * model.value(MODULUS))
    measured = sb.simulate(real, commands(trials=2), static=True, noise_m=1e-4)
    return sb.calibrate(model, measured, fit=[MODULUS], static=True)


def test_a_calibration_is_pickled_and_shown(calibration: sb.Calibration) -> None:
    for again in (pickle.loads(pickle.dumps(calibration)), copy.deepcopy(calibration), copy.copy(calibration)):
        assert again == calibration and hash(again) == hash(calibration)
        pd.testing.assert_frame_equal(again.sightings, calibration.sightings)
    assert re.fullmatch(r"Calibration\(.*youngs_modulus_pa=2\.\d+e\+09; rms error .* to .* mm\)", repr(calibration))
    page = calibration._repr_html_()
    assert "<table>" in page and "youngs_modulus_pa" in page and "95 % interval" in page


def test_models_and_rods_are_shown_in_a_line(model: sb.Model) -> None:
    shown = [model, sb.Rod(model), sb.Rods([model] * 3)]
    assert all("\n" not in repr(each) and len(repr(each)) < 120 for each in shown)
    loaded = model.with_effects([{"tip_load": {"mass_kg": 0.02}}])
    page = loaded._repr_html_()
    assert "effects[0].mass_kg" in page and "0.02" in page and "4 tendons" in page
