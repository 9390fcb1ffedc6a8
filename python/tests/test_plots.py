"""Pictures: what is drawn, in which units, and in colours that all readers tell apart."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from test_calculations import commands

import spinebench as sb

matplotlib = pytest.importorskip("matplotlib")
matplotlib.use("Agg")
from matplotlib import pyplot  # noqa: E402


@pytest.fixture(autouse=True)
def closed() -> Any:
    yield
    pyplot.close("all")


@pytest.fixture(scope="module")
def played(model: sb.Model) -> pd.DataFrame:
    return sb.simulate(model, commands(trials=3), noise_m=3e-4)


def labels(figure: Any) -> list[str]:
    return [text for ax in figure.axes for text in (ax.get_xlabel(), ax.get_ylabel())]


def test_a_rod_shows_its_shape_in_millimetres(model: sb.Model, tmp_path: Path) -> None:
    rod = sb.Rod(model)
    rod.settle([0.02, 0.0, -0.02, 0.0])
    figure = rod.plot()
    assert labels(figure) == ["z (mm)", "x (mm)", "z (mm)", "y (mm)"]
    line = figure.axes[0].lines[0]
    assert line.get_xdata()[-1] == pytest.approx(1e3 * rod.tip[2]) and line.get_ydata()[-1] == pytest.approx(1e3 * rod.tip[0])
    assert figure.axes[0].get_aspect() == 1.0
    figure.savefig(tmp_path / "rod.png")
    rods = sb.Rods([model] * 3)
    rods.settle(np.array([[0.01, 0, -0.01, 0], [0.0] * 4, [-0.01, 0, 0.01, 0]]))
    legend = sb.plot(rods, title="three").axes[0].get_legend()
    assert legend is not None and len(legend.get_texts()) == 3


def test_a_recording_shows_tip_and_commands(played: pd.DataFrame) -> None:
    figure = sb.plot(played)
    assert labels(figure) == [
        "time (s), 3 consecutive trials",
        "tip (mm)",
        "time (s), 3 consecutive trials",
        "displacement (mm)",
    ]
    tip = figure.axes[0].lines[0].get_ydata()
    assert np.nanmax(tip) == pytest.approx(1e3 * played.tip_x_m.max())
    assert np.isnan(tip).sum() == 2, "a line ends with its trial"
    assert labels(sb.plot(played, trial=1))[0] == "time (s)"
    assert labels(sb.plot(commands(trials=1)))[3] == "displacement (mm)"
    imported = sb.ImportedRecording(played, None)
    assert labels(imported.plot()) == labels(figure)
    with pytest.raises(sb.InputError, match="trial: found 9"):
        sb.plot(played, trial=9)


def test_residuals_show_what_the_models_leave(model: sb.Model, played: pd.DataFrame) -> None:
    path = "robot.backbone.youngs_modulus_pa"
    fitted = sb.calibrate(model.with_value(path, 0.9 * model.value(path)), played, fit=[path])
    figure = fitted.plot()
    assert "model − measured (mm)" in labels(figure) and "rms" in figure.axes[0].get_title()
    real = sb.simulate(model.with_effects([{"tip_load": {"mass_kg": 0.02}}]), commands(), noise_m=3e-4)
    columns = ["trial", "time_s", *[f"tendon_{i}_m" for i in range(1, 5)], "tip_x_m", "tip_y_m", "tip_z_m"]
    answer = sb.discover(model, real[columns])
    figure = answer.plot()
    legend = [text.get_text() for text in figure.axes[0].get_legend().get_texts()]
    assert legend[0] == "given model" and "noise floor" in legend and "held out" in legend
    assert any("tip_load" in text for text in legend)


def test_a_table_shows_each_row_by_groups(root: Path) -> None:
    trials = pd.read_csv(root / "results" / "table1" / "trials.csv")
    figure = sb.plot(trials)
    assert labels(figure) == ["policy, mode", "error (mm)"]
    groups = trials.groupby(["policy", "mode"]).ngroups
    assert len(figure.axes[0].get_xticklabels()) == groups
    assert labels(sb.plot(trials, y="steps", by="policy")) == ["policy", "steps"]
    _, axes = pyplot.subplots(1, 2)
    assert sb.plot(trials, axes=axes[0], y="error_m", by=["policy"]) is axes[0].figure


def test_wrong_options_are_refused(model: sb.Model, played: pd.DataFrame) -> None:
    for shown, options, words in (
        (3, {}, "found a int"),
        (pd.DataFrame({"a": [1]}), {}, "expected one of: a"),
        (pd.DataFrame({"a": [1]}), {"y": "a", "by": "b"}, "by: found"),
        (played, {"axes": pyplot.subplots()[1]}, "axes: found 1, expected 2"),
    ):
        with pytest.raises(sb.InputError, match=words):
            sb.plot(shown, **options)


def test_colours_are_told_apart_without_red_and_green() -> None:
    """Neighbours of the palette differ in lightness or blue for readers who see no difference of red and green."""
    from matplotlib.colors import to_rgb

    from spinebench._plots import COLOURS

    rgb = np.array([to_rgb(colour) for colour in COLOURS])
    lightness = rgb @ [0.2126, 0.7152, 0.0722]
    for one in range(len(rgb)):
        for other in range(one):
            assert abs(lightness[one] - lightness[other]) > 0.04 or abs(rgb[one, 2] - rgb[other, 2]) > 0.2, (one, other)
