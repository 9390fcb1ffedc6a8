"""The rod: numbers, shapes, derivatives, batches."""

from __future__ import annotations

import numpy as np
import pytest

import spinebench
from spinebench import Model, Rod, Rods

UP = np.array([0.01, 0.0, -0.01, 0.0])


def test_a_pull_of_tendon_1_bends_up_and_a_loaded_tip_sinks(model: Model) -> None:
    rod = Rod(model)
    home = rod.settle()
    assert home.shape == (3,) and home.dtype == np.float64
    assert rod.settle(UP)[0] > home[0] + 0.02
    loaded = Rod(model.with_effects([{"tip_load": {"mass_kg": 0.02}}]))
    assert 0.005 < home[0] - loaded.settle()[0] < 0.03


def test_shape_runs_from_the_base_to_the_tip(model: Model) -> None:
    rod = Rod(model)
    rod.settle(UP)
    shape = rod.shape(40)
    assert shape.shape == (40, 3)
    np.testing.assert_allclose(shape[0], 0.0, atol=1e-12)
    np.testing.assert_allclose(shape[-1], rod.tip, atol=1e-12)
    turns = rod.rotations(5)
    np.testing.assert_allclose(turns[-1], rod.tip_rotation, atol=1e-12)
    np.testing.assert_allclose(np.einsum("nij,nkj->nik", turns, turns), np.broadcast_to(np.eye(3), (5, 3, 3)), atol=1e-9)
    assert (rod.tensions_n >= 0).all() and rod.status == "converged"


def test_the_jacobian_is_that_of_finite_differences(model: Model) -> None:
    rod = Rod(model)
    rod.settle(UP)
    jacobian = rod.jacobian()
    for tendon in np.flatnonzero(rod.tensions_n > 0):
        step = np.zeros(4)
        step[tendon] = 1e-5
        differences = (Rod(model).settle(UP + step) - Rod(model).settle(UP - step)) / 2e-5
        np.testing.assert_allclose(jacobian[:, tendon], differences, rtol=2e-3, atol=1e-4)


def test_parameter_derivatives_are_those_of_finite_differences_in_motion(model: Model) -> None:
    path = "robot.backbone.youngs_modulus_pa"
    rod = Rod(model, parameters=[path])
    value = model.value(path)
    ends = [Rod(model.with_value(path, value * scale)) for scale in (1.001, 0.999)]
    for robot in (rod, *ends):
        robot.step(UP)
    differences = (ends[0].tip - ends[1].tip) / (0.002 * value)
    np.testing.assert_allclose(rod.parameter_jacobian()[:, 0], differences, rtol=1e-2, atol=1e-14)


def test_many_robots_do_as_one(model: Model) -> None:
    rng = np.random.default_rng(0)
    pulls = rng.uniform(-0.01, 0.01, (6, 3, 4))
    rods = Rods([model] * 6)
    tips = rods.play(pulls, dt_s=0.1)
    assert tips.shape == (6, 3, 3) and set(rods.status) == {"converged"}
    one = Rod(model)
    alone = np.array([one.step(pull, 0.1) for pull in pulls[4]])
    np.testing.assert_array_equal(tips[4], alone)
    np.testing.assert_array_equal(rods.shapes(7)[4], one.shape(7))
    at_rest = rods.settle(pulls[:, 0])
    assert at_rest.shape == (6, 3) and np.isfinite(at_rest).all()


def test_a_robot_that_cannot_be_solved_is_a_status_beside_the_others(model: Model) -> None:
    rods = Rods([model] * 2)
    tips = rods.settle([[0.0] * 4, [0.4] * 4])
    assert np.isfinite(tips[0]).all() and np.isnan(tips[1]).all()
    assert rods.status[0] == "converged" and rods.status[1] != "converged"
    with pytest.raises(spinebench.SolverError) as error:
        Rod(model).settle([0.4] * 4)
    assert error.value.status == rods.status[1]


def test_models_are_read_changed_and_written(model: Model) -> None:
    again = Model.from_yaml(model.to_yaml())
    assert again == model
    changed = model.with_value("robot.backbone.length_m", 0.25)
    assert changed.length_m == 0.25 and model.length_m == 0.22
    assert model.with_effects([{"delay": {"time_s": 0.1}}]).effect_names[-1] == "delay"
    assert any(path == "robot.backbone.radius_m" and unit == "m" for path, _, unit in model.parameters())
