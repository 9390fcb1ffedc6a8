"""Text files as pandas and the csv module write them: one a trial, dates, Euler angles."""

from __future__ import annotations

import csv
import datetime
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from numpy.typing import NDArray

import spinebench
from spinebench import InputError, Model

Array = NDArray[np.float64]
TENDONS = [f"tendon_{i}_m" for i in range(1, 5)]
TIP = ["tip_x_m", "tip_y_m", "tip_z_m"]
TURN = ["tip_qw", "tip_qx", "tip_qy", "tip_qz"]
START = pd.Timestamp("2024-03-31T01:59:58.75+01:00")
"""Europe's clocks went forward a second later."""


def commands(rows: int, seed: int) -> pd.DataFrame:
    """A random walk of four antagonistic tendons at 10 Hz, which starts at home."""
    rng = np.random.default_rng(seed)
    bend = np.clip(np.cumsum(rng.uniform(-0.005, 0.005, (rows, 2)), axis=0), -0.015, 0.015)
    bend[0] = 0.0
    frame = pd.DataFrame(np.column_stack([bend, -bend]), columns=TENDONS)
    frame.insert(0, "time_s", 0.1 * np.arange(rows))
    frame.insert(0, "trial", 0)
    return frame


def turned(quaternions: Array) -> Array:
    """Rotation matrices (n, 3, 3) of quaternions w, x, y, z (n, 4)."""
    w, x, y, z = quaternions.T
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.array(rows).transpose(2, 0, 1)


def roll_pitch_yaw(matrices: Array) -> Array:
    """Angles (n, 3), radians, of rotations about the fixed x, y and z axes, one after the other."""
    roll = np.arctan2(matrices[:, 2, 1], matrices[:, 2, 2])
    pitch = np.arcsin(-matrices[:, 2, 0])
    yaw = np.arctan2(matrices[:, 1, 0], matrices[:, 0, 0])
    return np.column_stack([roll, pitch, yaw])


def lab_map(**changes: Any) -> dict[str, Any]:
    """The map of the files that `lab` writes."""
    made: dict[str, Any] = {
        "trial_files": {"commands": "motors_{trial}.csv", "tracking": "mocap_{trial}.csv"},
        "commands": {"time": {"column": "stamp", "unit": "iso8601"}, "tendons": {"columns": [2, 3, 4, 5], "unit": "mm"}},
        "tracking": {
            "time": {"column": "time", "unit": "iso8601"},
            "unit": "mm",
            "euler": {"order": "xyz", "rotation": "extrinsic", "unit": "deg"},
            "tip": {"position": ["x", "y", "z"], "angles": ["roll", "pitch", "yaw"]},
        },
    }
    for key, value in changes.items():
        part = made
        *path, last = key.split("__")
        for name in path:
            part = part[name]
        part[last] = value
    return made


def lab(folder: Path, model: Model, names: list[str]) -> list[pd.DataFrame]:
    """Two files a trial: commands by pandas in a zone of their own, tracking by the csv module in UTC. Returns what was played."""
    played = []
    for number, name in enumerate(names):
        motion = spinebench.simulate(model, commands(12 + number, 5 + number))
        played.append(motion)
        # The wall clock goes on between trials.
        start = START + pd.Timedelta(minutes=3 * number)
        stamps = start + pd.to_timedelta(motion.time_s, unit="s")
        motors = pd.DataFrame({"stamp": stamps, **{f"motor {i}": 1e3 * motion[f"tendon_{i}_m"] for i in range(1, 5)}})
        motors.to_csv(folder / f"motors_{name}.csv", index=False)
        angles = np.rad2deg(roll_pitch_yaw(turned(motion[TURN].to_numpy())))
        with (folder / f"mocap_{name}.csv").open("w", newline="") as stream:
            writer = csv.writer(stream)
            writer.writerow(["time", "x", "y", "z", "roll", "pitch", "yaw"])
            for stamp, tip, angle in zip(stamps, motion[TIP].to_numpy(), angles, strict=True):
                utc = stamp.to_pydatetime().astimezone(datetime.timezone.utc)
                # `isoformat` leaves the fraction out where it is zero.
                writer.writerow([utc.isoformat(), *(1e3 * tip), *angle])
    (folder / "README.txt").write_text("notes\n")
    return played


def agree(found: pd.DataFrame, played: pd.DataFrame) -> None:
    np.testing.assert_allclose(found.time_s, played.time_s, atol=1e-9)
    np.testing.assert_allclose(found[TENDONS], played[TENDONS], atol=1e-12)
    np.testing.assert_allclose(found[TIP], played[TIP], atol=1e-9)
    dots = np.abs((found[TURN].to_numpy() * played[TURN].to_numpy()).sum(axis=1))
    assert dots.min() > 1 - 1e-12
    assert (found.valid == 1).all()


def test_a_folder_with_two_files_a_trial(tmp_path: Path, model: Model) -> None:
    names = ["2", "10", "9"]
    played = lab(tmp_path, model, names)
    found = spinebench.import_csv(tmp_path, lab_map())
    assert [int(number) for number in found.recording.trial.unique()] == [2, 9, 10]
    for name, motion in zip(names, played, strict=True):
        agree(found.recording[found.recording.trial == int(name)], motion)
    assert [path.name for path in found.passed_over] == ["README.txt"]
    assert "trial_name" not in found.recording and "export_time_s" not in found.recording
    # The same by a name with signs for characters.
    again = spinebench.import_csv([tmp_path / "motors_*.csv", tmp_path / "mocap_?*.csv"], lab_map())
    pd.testing.assert_frame_equal(again.recording, found.recording)
    assert not again.passed_over


def test_names_of_trials_stand_in_a_column(tmp_path: Path, model: Model) -> None:
    played = lab(tmp_path, model, ["slow", "circle_10", "circle_9"])
    found = spinebench.import_csv(tmp_path, lab_map()).recording
    names = found.groupby("trial").trial_name.unique().map(list).tolist()
    assert names == [["circle_9"], ["circle_10"], ["slow"]]
    agree(found[found.trial_name == "slow"], played[0])


@pytest.mark.parametrize("zone", [None, "+01:00"])
def test_dates_without_a_zone(tmp_path: Path, model: Model, zone: str | None) -> None:
    played = lab(tmp_path, model, ["1"])
    file = tmp_path / "motors_1.csv"
    motors = pd.read_csv(file, parse_dates=["stamp"])
    motors["stamp"] = motors["stamp"].dt.tz_localize(None)
    motors.to_csv(file, index=False)
    if zone is None:
        with pytest.raises(InputError, match=r"motors_1.csv, all rows: found dates without a time zone.*expected `zone` in addition"):
            spinebench.import_csv(tmp_path, lab_map())
        offset = lab_map(tracking__clock={"offset_s": 3600.0})
        agree(spinebench.import_csv(tmp_path, offset).recording, played[0])
        return
    by = lab_map()
    by["commands"]["time"]["zone"] = zone
    agree(spinebench.import_csv(tmp_path, by).recording, played[0])


def test_one_file_a_trial_with_both(tmp_path: Path, model: Model) -> None:
    by = lab_map(trial_files={"commands": "{trial}.csv"})
    by["tracking"] |= {"time": {"column": "stamp", "unit": "iso8601"}, "unit": "m"}
    by["tracking"]["euler"] = {"order": "zyx", "rotation": "intrinsic", "unit": "rad"}
    by["tracking"]["tip"]["angles"] = ["yaw", "pitch", "roll"]
    played = spinebench.simulate(model, commands(10, 1))
    angles = roll_pitch_yaw(turned(played[TURN].to_numpy()))
    frame = pd.DataFrame({"stamp": pd.Timestamp("2024-05-01") + pd.to_timedelta(played.time_s, unit="s")})
    for i in range(1, 5):
        frame[f"l{i}"] = 1e3 * played[f"tendon_{i}_m"]
    frame[["x", "y", "z"]] = played[TIP]
    frame[["roll", "pitch", "yaw"]] = angles
    for name in ("0", "1"):
        frame.to_csv(tmp_path / f"{name}.csv", index=False)
    found = spinebench.import_csv(tmp_path, by).recording
    for trial in (0, 1):
        agree(found[found.trial == trial], played)


BAD_MAPS: list[tuple[dict[str, Any], str]] = [
    ({"trial_files": {"commands": "motors.csv"}}, r"trial_files\.commands: found `motors.csv`, expected the name of a file"),
    ({"trial_files": {"commands": "motors_{trial}.csv", "tracking": "motors_{trial}.csv"}}, r"trial_files\.tracking"),
    ({"commands__trial": 1}, r"commands\.trial: found `trial` and `trial_files`, expected one of the two"),
    ({"commands__file": 2}, r"commands\.file: found `file` and `trial_files`"),
    ({"commands__time": {"column": "stamp", "zone": "Z"}}, r"commands\.time\.zone: found `Z`, expected `unit: iso8601`"),
    ({"commands__time": {"column": "stamp", "unit": "iso8601", "zone": "CET"}}, r"commands\.time\.zone: found `CET`"),
    ({"tracking__euler": {"order": "xyz", "unit": "deg"}}, r"rotation"),
    ({"tracking__euler": {"order": "xxy", "rotation": "intrinsic", "unit": "deg"}}, r"tracking\.euler\.order"),
    ({"tracking__euler": None}, r"tracking\.euler: found no such key, expected what `angles` mean"),
    ({"tracking__tip__orientation": ["a", "b", "c", "d"]}, r"tracking\.tip\.angles: found `orientation` and `angles`"),
]


@pytest.mark.parametrize(("changes", "words"), BAD_MAPS, ids=[words for _, words in BAD_MAPS])
def test_bad_maps_are_refused_with_their_key(
    tmp_path: Path, model: Model, changes: dict[str, Any], words: str
) -> None:
    lab(tmp_path, model, ["1"])
    with pytest.raises(InputError, match=words):
        spinebench.import_csv(tmp_path, lab_map(**changes))


def test_bad_files_are_refused_with_file_and_line(tmp_path: Path, model: Model) -> None:
    lab(tmp_path, model, ["1", "2"])
    mocap, motors = tmp_path / "mocap_2.csv", tmp_path / "motors_2.csv"
    good = mocap.read_text()

    def refused(text: str) -> InputError:
        mocap.write_text(text)
        with pytest.raises(InputError) as error:
            spinebench.import_csv(tmp_path, lab_map())
        return error.value

    lines = good.splitlines()
    error = refused("\n".join([*lines[:3], lines[3].replace("T", "X", 1), *lines[4:]]))
    assert (error.file, error.line, error.key) == (str(mocap), 4, "time") and "date and time" in str(error)
    error = refused("\n".join([*lines[:3], lines[3].replace("+00:00", ""), *lines[4:]]))
    assert (error.line, error.key) == (4, "time") and "with a zone, as in the previous rows" in str(error)
    error = refused("\n".join([*lines[:5], ",".join([*lines[5].split(",")[:4], "left", "0", "0"]), *lines[6:]]))
    assert (error.line, error.key, error.found) == (6, "roll", "`left`")
    mocap.unlink()
    with pytest.raises(InputError, match=r"motors_2.csv, its name: found only the commands of trial `2`, expected .* `mocap_2.csv`"):
        spinebench.import_csv(tmp_path, lab_map())
    motors.unlink()
    with pytest.raises(InputError, match="names like `run_{trial}.csv`"):
        spinebench.import_csv(tmp_path, lab_map(trial_files={"commands": "run_{trial}.csv"}))
    with pytest.raises(InputError, match=r"trial_files: found no such key for a folder"):
        by = lab_map()
        del by["trial_files"]
        spinebench.import_csv(tmp_path, by)
    with pytest.raises(InputError, match=r"none_\*.csv: .*found no such files"):
        spinebench.import_csv(tmp_path / "none_*.csv", lab_map())


def test_an_empty_angle_is_a_lost_pose(tmp_path: Path, model: Model) -> None:
    lab(tmp_path, model, ["1"])
    file = tmp_path / "mocap_1.csv"
    frame = pd.read_csv(file)
    frame.loc[4, "pitch"] = np.nan
    frame.to_csv(file, index=False)
    found = spinebench.import_csv(tmp_path, lab_map(tracking__max_gap_s=0.05)).recording
    assert found.index[found.valid == 0].tolist() == [4]
    assert np.isfinite(found.loc[4, TENDONS].to_numpy(dtype=float)).all()


def test_clocks_of_trials_are_estimated_one_by_one(tmp_path: Path, model: Model) -> None:
    rng = np.random.default_rng(4)
    offsets = {1: -3.25, 2: 12.5}
    for trial, offset_s in offsets.items():
        # Steps at 5 Hz, seen at 100 Hz.
        bend = rng.uniform(-0.01, 0.01, (100, 2))
        bend[0] = 0.0
        moved = pd.DataFrame(np.column_stack([bend, -bend]), columns=TENDONS)
        fast = moved.loc[np.repeat(np.arange(100), 20)].assign(trial=0, time_s=0.01 * np.arange(2000))
        motion = spinebench.simulate(model, fast[["trial", "time_s", *TENDONS]])
        motors = pd.DataFrame({"stamp": 0.2 * np.arange(100), **{f"m{i}": 1e3 * moved[f"tendon_{i}_m"] for i in range(1, 5)}})
        motors.to_csv(tmp_path / f"motors_{trial}.csv", index=False)
        noisy = motion[TIP].to_numpy() + rng.normal(scale=2e-4, size=(2000, 3))
        seen = pd.DataFrame(1e3 * noisy, columns=["x", "y", "z"])
        seen.insert(0, "time", motion.time_s - offset_s)
        seen.to_csv(tmp_path / f"mocap_{trial}.csv", index=False)
    by = lab_map(
        commands__time={"column": "stamp"}, tracking__time={"column": "time"}, tracking__clock={"estimate": {}}
    )
    by["tracking"]["tip"] = {"position": ["x", "y", "z"]}
    del by["tracking"]["euler"]
    found = spinebench.import_csv(tmp_path, by)
    assert found.clock is None and sorted(found.clocks) == [1, 2]
    for trial, offset_s in offsets.items():
        low, high = found.clocks[trial].interval_95_s
        assert low <= offset_s <= high and high - low < 0.06, found.clocks[trial]
        assert abs(found.clocks[trial].offset_s - offset_s) < 0.02, found.clocks[trial]
