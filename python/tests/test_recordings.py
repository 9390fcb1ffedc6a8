"""Frames and files as numpy and pandas make them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from test_calculations import commands

import spinebench as sb


def test_a_trial_may_be_a_float(model: sb.Model, tmp_path: Path) -> None:
    frame = commands(trials=2, rows=4)
    wanted = sb.simulate(model, frame)
    floats = frame.astype({"trial": float})
    objects = frame.astype({"trial": object})
    nullable = frame.astype({"trial": "Int64"})
    small = frame.astype({"trial": np.uint8})
    for given in (floats, objects, nullable, small, floats.astype({"trial": object})):
        pd.testing.assert_frame_equal(sb.simulate(model, given), wanted)
    # As one array, which has one type, and as the CSV that it is saved as.
    array = frame.to_numpy(dtype=float)
    pd.testing.assert_frame_equal(sb.simulate(model, pd.DataFrame(array, columns=frame.columns)), wanted)
    floats.to_csv(tmp_path / "floats.csv", index=False)
    pd.testing.assert_frame_equal(sb.simulate(model, tmp_path / "floats.csv"), wanted)
    np.savetxt(tmp_path / "numpy.csv", array, delimiter=",", header=",".join(frame.columns), comments="")
    pd.testing.assert_frame_equal(sb.simulate(model, tmp_path / "numpy.csv"), wanted)
    assert wanted.trial.tolist() == [0, 0, 0, 0, 1, 1, 1, 1]


@pytest.mark.parametrize("wrong", [0.5, -1.0, np.nan, np.inf, "first"])
def test_a_trial_that_is_no_whole_number_is_refused(model: sb.Model, tmp_path: Path, wrong: Any) -> None:
    frame = commands(trials=1, rows=4).astype({"trial": object})
    frame.loc[2, "trial"] = wrong
    if not isinstance(wrong, str):
        frame = frame.astype({"trial": float})
    with pytest.raises(sb.InputError, match=r"commands.*row 3.*trial.*expected a trial number") as error:
        sb.simulate(model, frame)
    assert error.value.key == "trial" and error.value.line == 3
    frame.to_csv(tmp_path / "wrong.csv", index=False)
    with pytest.raises(sb.InputError, match=r"wrong.csv.*line 4.*trial"):
        sb.simulate(model, tmp_path / "wrong.csv")


def test_faults_of_frames_name_row_and_column_and_no_file(model: sb.Model, tmp_path: Path) -> None:
    played = sb.simulate(model, commands(trials=2, rows=5))
    for column, value in (("tendon_2_m", np.nan), ("time_s", np.nan), ("tip_x_m", np.inf)):
        frame = played.copy()
        frame.loc[6, column] = value
        with pytest.raises(sb.InputError) as error:
            sb.calibrate(model, frame)
        message = str(error.value)
        assert "row 7" in message and column in message and message.startswith("measured"), message
        assert "/" not in message.split(":")[0] and ".csv" not in message, message
    residuals = pd.DataFrame({"trial": [0], "time_s": ["soon"], "held_out": [True], **dict.fromkeys(RESIDUALS, 0.0)})
    with pytest.raises(sb.InputError, match=r"^residuals.*row 1.*time_s") as error:
        sb.export_mcap(played, tmp_path / "out.mcap", residuals=residuals)
    assert "tmp" not in str(error.value)
    with pytest.raises(sb.InputError, match="^map") as error:
        sb.import_csv(tmp_path / "none.csv", {"colums": {}})
    assert "tmp" not in str(error.value).replace(str(tmp_path), "")
    with pytest.raises(sb.InputError, match="<text>"):
        sb.Model.from_yaml("robot: {backbone: {lenght_m: 0.2}}")


RESIDUALS = [f"{part}_{axis}_m" for part in ("tip", "before", "after") for axis in "xyz"]


def test_large_frames_go_in_and_out_as_arrays(model: sb.Model) -> None:
    frame = commands(trials=200, rows=5)
    played = sb.simulate(model, frame, static=True)
    assert played.trial.dtype == np.int64 and played.tip_x_m.dtype == np.float64
    assert len(played) == 1000 and (played.solver_status == "converged").all()


def test_an_imported_recording_is_shown(model: sb.Model) -> None:
    played = sb.simulate(model, commands(trials=15, rows=3))
    clocks = {0: sb.ClockFit(0.25, (0.2, 0.3), 0.1, 0.9)}
    imported = sb.ImportedRecording(played, None, clocks, notes=["a row <b>does</b> not count"])
    assert repr(imported) == "ImportedRecording(45 rows, 15 trials, 1 notes)"
    page = imported._repr_html_()
    assert "45 rows, 15 trials" in page and "and 3 more" in page and "trial 0: +0.25 s" in page
    assert "&lt;b&gt;" in page
