"""Bags that third-party tools write, and files that they read."""

from __future__ import annotations

import importlib
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from numpy.typing import NDArray

import spinebench
from spinebench import InputError, Model

rosbag2: Any = pytest.importorskip("rosbags.rosbag2")
typesys: Any = pytest.importorskip("rosbags.typesys")
STORE = typesys.get_typestore(typesys.Stores.ROS2_HUMBLE)

Message = tuple[str, str, int, Any]
"""Topic, type, log time (ns) and message."""
START_NS = 1_732_633_000_123_456_789
"""Since 1970: more digits than a double holds."""


def kind(name: str) -> Any:
    return STORE.types[name]


def header(stamp_ns: int) -> Any:
    stamp = kind("builtin_interfaces/msg/Time")(sec=stamp_ns // 10**9, nanosec=stamp_ns % 10**9)
    return kind("std_msgs/msg/Header")(stamp=stamp, frame_id="world")


def point(position: NDArray[np.float64]) -> Any:
    return kind("geometry_msgs/msg/Point")(*map(float, position))


def pose(position: NDArray[np.float64]) -> Any:
    # A quarter turn about z.
    turn = kind("geometry_msgs/msg/Quaternion")(x=0.0, y=0.0, z=np.sqrt(0.5), w=np.sqrt(0.5))
    return kind("geometry_msgs/msg/Pose")(position=point(position), orientation=turn)


def pose_stamped(stamp_ns: int, position: NDArray[np.float64]) -> Message:
    message = kind("geometry_msgs/msg/PoseStamped")(header=header(stamp_ns), pose=pose(position))
    return "/tip", message.__msgtype__, stamp_ns + 999, message


def transform_stamped(stamp_ns: int, position: NDArray[np.float64]) -> Message:
    part = kind("geometry_msgs/msg/Transform")(
        translation=kind("geometry_msgs/msg/Vector3")(*map(float, position)), rotation=pose(position).orientation
    )
    message = kind("geometry_msgs/msg/TransformStamped")(header=header(stamp_ns), child_frame_id="tip", transform=part)
    return "/tip", message.__msgtype__, stamp_ns + 999, message


def odometry(stamp_ns: int, position: NDArray[np.float64]) -> Message:
    zero = kind("geometry_msgs/msg/Vector3")(x=0.0, y=0.0, z=0.0)
    twist = kind("geometry_msgs/msg/Twist")(linear=zero, angular=zero)
    covariance = np.zeros(36)
    message = kind("nav_msgs/msg/Odometry")(
        header=header(stamp_ns),
        child_frame_id="tip",
        pose=kind("geometry_msgs/msg/PoseWithCovariance")(pose=pose(position), covariance=covariance),
        twist=kind("geometry_msgs/msg/TwistWithCovariance")(twist=twist, covariance=covariance),
    )
    return "/tip", message.__msgtype__, stamp_ns + 999, message


def joint_state(stamp_ns: int, numbers: NDArray[np.float64]) -> Message:
    message = kind("sensor_msgs/msg/JointState")(
        header=header(stamp_ns),
        name=["left", "right_motor"],
        position=np.asarray(numbers),
        velocity=np.array([]),
        effort=np.array([]),
    )
    return "/motors", message.__msgtype__, stamp_ns + 5, message


def multi_array(stamp_ns: int, numbers: NDArray[np.float64]) -> Message:
    dimension = kind("std_msgs/msg/MultiArrayDimension")(label="motor", size=2, stride=2)
    layout = kind("std_msgs/msg/MultiArrayLayout")(dim=[dimension], data_offset=0)
    message = kind("std_msgs/msg/Float64MultiArray")(layout=layout, data=np.asarray(numbers))
    return "/motors", message.__msgtype__, stamp_ns, message


def float_array(stamp_ns: int, numbers: NDArray[np.float64]) -> Message:
    layout = kind("std_msgs/msg/MultiArrayLayout")(dim=[], data_offset=0)
    message = kind("std_msgs/msg/Float32MultiArray")(layout=layout, data=np.asarray(numbers, dtype=np.float32))
    return "/motors", message.__msgtype__, stamp_ns, message


STORE.register(typesys.get_types_from_msg("string name\nfloat32 error\ngeometry_msgs/Pose pose", "lab_msgs/msg/Body"))
STORE.register(typesys.get_types_from_msg("std_msgs/Header header\nBody[] bodies", "lab_msgs/msg/Bodies"))


def named_bodies(stamp_ns: int, position: NDArray[np.float64]) -> Message:
    bodies = [kind("lab_msgs/msg/Body")(name, 0.1, pose(place)) for name, place in [("base", 0 * position), ("tip", position)]]
    message = kind("lab_msgs/msg/Bodies")(header=header(stamp_ns), bodies=bodies)
    return "/tip", message.__msgtype__, stamp_ns + 999, message


def pose_array(stamp_ns: int, position: NDArray[np.float64]) -> Message:
    message = kind("geometry_msgs/msg/PoseArray")(header=header(stamp_ns), poses=[pose(0 * position), pose(position)])
    return "/tip", message.__msgtype__, stamp_ns + 999, message


def transforms(stamp_ns: int, position: NDArray[np.float64]) -> Message:
    both = [transform_stamped(stamp_ns, place)[3] for place in (0 * position, position)]
    both[0].child_frame_id = "base"
    return "/tip", "tf2_msgs/msg/TFMessage", stamp_ns + 999, kind("tf2_msgs/msg/TFMessage")(transforms=both)


def by_rosbags(file: Path, messages: list[Message], compression: str) -> Path:
    """A bag of rosbags; returns its MCAP file."""
    folder = file.with_suffix("")
    with rosbag2.Writer(folder, version=9, storage_plugin=rosbag2.StoragePlugin.MCAP) as writer:
        if compression:
            raise AssertionError("rosbags compresses messages, not chunks")
        topics: dict[str, Any] = {}
        for topic, name, log_ns, message in messages:
            if topic not in topics:
                topics[topic] = writer.add_connection(topic, name, typestore=STORE)
            writer.write(topics[topic], log_ns, STORE.serialize_cdr(message, name))
    return next(folder.glob("*.mcap"))


def by_mcap(file: Path, messages: list[Message], compression: str) -> Path:
    """A bag of mcap, in compressed chunks."""
    module: Any = importlib.import_module("mcap.writer")
    with file.open("wb") as stream:
        kinds = {"": module.CompressionType.NONE, "zstd": module.CompressionType.ZSTD, "lz4": module.CompressionType.LZ4}
        writer = module.Writer(stream, chunk_size=2000, compression=kinds[compression])
        writer.start(profile="ros2", library="test")
        channels: dict[str, int] = {}
        for topic, name, log_ns, message in messages:
            if topic not in channels:
                text = STORE.generate_msgdef(name, ros_version=2)[0]
                schema = writer.register_schema(name, "ros2msg", text.encode())
                channels[topic] = writer.register_channel(topic, "cdr", schema)
            data = bytes(STORE.serialize_cdr(message, name))
            writer.add_message(channels[topic], log_ns, data, log_ns)
        writer.finish()
    return file


def plain(part: Any) -> Any:
    """A message as dictionaries and lists."""
    if isinstance(part, np.ndarray):
        return part.tolist()
    if isinstance(part, list):
        return [plain(one) for one in part]
    if hasattr(part, "__msgtype__"):
        return {name: plain(getattr(part, name)) for name in vars(part) if name != "__msgtype__"}
    return part


def by_mcap_ros2(file: Path, messages: list[Message], compression: str) -> Path:
    """A bag whose messages another implementation of CDR writes."""
    module: Any = importlib.import_module("mcap_ros2.writer")
    with file.open("wb") as stream:
        writer = module.Writer(stream)
        schemas: dict[str, Any] = {}
        for topic, name, log_ns, message in messages:
            if name not in schemas:
                schemas[name] = writer.register_msgdef(name, STORE.generate_msgdef(name, ros_version=2)[0])
            writer.write_message(topic, schemas[name], plain(message), log_ns, log_ns)
        writer.finish()
    return file


def tip(time_s: float) -> NDArray[np.float64]:
    """Linear in time, so that interpolation is exact."""
    return np.array([10.0 + 4.0 * time_s, 20.0 - time_s, 210.0 + 2.0 * time_s])


Of = Callable[[int, NDArray[np.float64]], Message]


def motion(command: Of, tracked: Of, offset_ns: int = 0) -> list[Message]:
    """Commands at 5 Hz and a tip at 50 Hz."""
    commands = [command(START_NS + 200_000_000 * k, np.array([0.1 * k, -0.1 * k])) for k in range(10)]
    frames = [tracked(START_NS + 20_000_000 * k + offset_ns, tip(0.02 * k)) for k in range(-2, 100)]
    return sorted(commands + frames, key=lambda message: message[2])


def map_of(columns: list[str]) -> dict[str, Any]:
    return {
        "commands": {"topic": "/motors", "tendons": {"columns": columns, "unit": "rad", "scale": [0.01]}},
        "tracking": {"topic": "/tip", "unit": "mm", "axes": "x=+y,y=-x,z=+z", "tip": {}},
    }


JOINTS = ["position[left]", "position[right_motor]"]


@pytest.mark.parametrize(
    ("write", "compression"),
    [(by_rosbags, ""), (by_mcap, ""), (by_mcap, "zstd"), (by_mcap, "lz4"), (by_mcap_ros2, "")],
)
@pytest.mark.parametrize("tracked", [pose_stamped, transform_stamped, odometry])
@pytest.mark.parametrize(("command", "columns"), [(joint_state, JOINTS), (multi_array, ["data[0]", "data[1]"])])
def test_bags_of_others_are_read(
    tmp_path: Path,
    write: Callable[[Path, list[Message], str], Path],
    compression: str,
    tracked: Of,
    command: Of,
    columns: list[str],
) -> None:
    bag = write(tmp_path / "bag.mcap", motion(command, tracked), compression)
    found = spinebench.import_mcap(bag, map_of(columns))
    frame = found.recording
    assert found.clock is None and len(frame) == 10 and (frame["valid"] == 1).all()
    times = 0.2 * np.arange(10)
    np.testing.assert_allclose(frame["time_s"], times, atol=1e-12)
    np.testing.assert_allclose(frame["tendon_2_m"], -0.001 * np.arange(10), atol=1e-12)
    tips = np.array([tip(time) for time in times]) * 1e-3
    np.testing.assert_allclose(frame["tip_x_m"], tips[:, 1], atol=1e-9)
    np.testing.assert_allclose(frame["tip_y_m"], -tips[:, 0], atol=1e-9)
    np.testing.assert_allclose(frame["tip_z_m"], tips[:, 2], atol=1e-9)
    turn = frame[["tip_qw", "tip_qx", "tip_qy", "tip_qz"]].to_numpy()
    np.testing.assert_allclose(np.abs(turn), [[np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5)]] * 10, atol=1e-9)


@pytest.mark.parametrize("write", [by_rosbags, by_mcap, by_mcap_ros2])
@pytest.mark.parametrize(
    ("tracked", "body"),
    [
        (named_bodies, {"child": "tip"}),
        (named_bodies, {"position": [f"bodies[tip].pose.position.{axis}" for axis in "xyz"]}),
        (pose_array, {"position": [f"poses[1].position.{axis}" for axis in "xyz"]}),
        (transforms, {"child": "tip"}),
    ],
)
def test_any_message_is_read_by_its_definition(
    tmp_path: Path, write: Callable[[Path, list[Message], str], Path], tracked: Of, body: dict[str, Any]
) -> None:
    bag = write(tmp_path / "bag.mcap", motion(float_array, tracked), "")
    by = map_of(["data[0]", "data[1]"])
    by["tracking"]["tip"] = body
    found = spinebench.import_mcap(bag, by)
    frame = found.recording
    assert len(frame) == 10 and (frame["valid"] == 1).all()
    tips = np.array([tip(0.2 * k) for k in range(10)]) * 1e-3
    np.testing.assert_allclose(frame[["tip_x_m", "tip_y_m"]], np.c_[tips[:, 1], -tips[:, 0]], atol=1e-9)
    np.testing.assert_allclose(frame["tendon_2_m"], -0.001 * np.arange(10), atol=1e-9)
    # Several positions, and a name that nothing has.
    for wrong, words in [({}, "the positions"), ({"child": "hand"}, "no child `hand`")]:
        by["tracking"]["tip"] = wrong
        with pytest.raises(InputError, match=words):
            spinebench.import_mcap(bag, by)


def test_an_unknown_offset_is_estimated(tmp_path: Path) -> None:
    rng = np.random.default_rng(5)
    pulls = rng.normal(0.0, 0.3, 150)
    lag, frames = 0.0, []
    for tick in range(3000):
        position = np.array([40.0 * lag, 0.0, 200.0]) + rng.normal(0.0, 0.1, 3)
        frames.append(pose_stamped(START_NS + 10_000_000 * tick + 7_654_000_000, position))
        lag += (pulls[tick // 20] - lag) * (1.0 - np.exp(-0.01 / 0.06))
    commands = [joint_state(START_NS + 200_000_000 * k, np.array([pull, -pull])) for k, pull in enumerate(pulls)]
    bag = by_mcap(tmp_path / "bag.mcap", sorted(commands + frames, key=lambda message: message[2]), "zstd")
    by = map_of(JOINTS)
    by["tracking"]["clock"] = {"estimate": {}}
    clock = spinebench.import_mcap(bag, by).clock
    assert clock is not None and abs(clock.offset_s + 7.654) < 0.003, clock
    low, high = clock.interval_95_s
    # Beside half of the lag on either side, which is left for a first motion that differs.
    assert low < clock.offset_s < high and high - low - clock.lag_s < 0.006 and clock.explained > 0.9, clock


def test_what_is_no_bag_of_ours_is_told(tmp_path: Path) -> None:
    bag = by_mcap(tmp_path / "bag.mcap", motion(joint_state, pose_stamped), "zstd")
    by = map_of(JOINTS)
    by["tracking"]["topic"] = "/hand"
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(bag.read_bytes()[:-3000])
    text = tmp_path / "text.mcap"
    text.write_text("no bag")
    database = by_rosbags_sqlite(tmp_path / "old")
    for file, given, words in [
        (bag, by, "one of `/motors`, `/tip`"),
        (bag, map_of(["position[up]", "position[left]"]), "`position[left]`"),
        (cut, map_of(JOINTS), "the end of the file within a record"),
        (text, map_of(JOINTS), "expected an MCAP file"),
        (database, map_of(JOINTS), "a database of SQLite"),
    ]:
        with pytest.raises(InputError) as error:
            spinebench.import_mcap(file, given)
        assert words in str(error.value), error.value
        assert error.value.file == str(file)


def by_rosbags_sqlite(folder: Path) -> Path:
    with rosbag2.Writer(folder, version=9) as writer:
        writer.add_connection("/tip", "geometry_msgs/msg/PoseStamped", typestore=STORE)
    return next(folder.glob("*.db3"))


def test_exports_are_read_by_others(tmp_path: Path, model: Model) -> None:
    reader: Any = importlib.import_module("mcap.reader")
    frame = pd.DataFrame({"trial": [0, 0, 1], "time_s": [0.0, 0.2, 0.0]})
    for tendon, pulls in enumerate([[0.0, 0.01, 0.0], [0.0] * 3, [0.0, -0.01, 0.0], [0.0] * 3], start=1):
        frame[f"tendon_{tendon}_m"] = pulls
    played = spinebench.simulate(model, frame)
    residuals = pd.DataFrame({"trial": [0], "time_s": [0.2], "held_out": [True]})
    for part in ("tip", "before", "after"):
        for axis, size in zip("xyz", (0.001, 0.002, 0.003), strict=True):
            residuals[f"{part}_{axis}_m"] = [size]
    out = tmp_path / "rec.mcap"
    spinebench.export_mcap(played, out, model=model, residuals=residuals)
    with out.open("rb") as stream:
        opened = reader.make_reader(stream)
        summary = opened.get_summary()
        assert summary.statistics.message_count == 3 * 5 + 2
        topics = {channel.topic: summary.schemas[channel.schema_id].name for channel in summary.channels.values()}
        assert topics == {
            "/commands": "spinebench.Commands",
            "/row": "spinebench.Row",
            "/tip": "foxglove.PoseInFrame",
            "/robot": "foxglove.SceneUpdate",
            "/tf": "foxglove.FrameTransforms",
            "/residuals": "spinebench.Residual",
            "/residual_lines": "foxglove.SceneUpdate",
        }
        messages = [(channel.topic, message) for _, channel, message in opened.iter_messages()]
    read = {topic: [json.loads(message.data) for name, message in messages if name == topic] for topic in topics}
    assert [tip["timestamp"] for tip in read["/tip"]] == [
        {"sec": 0, "nsec": 0},
        {"sec": 0, "nsec": 200_000_000},
        {"sec": 1, "nsec": 200_000_000},
    ]
    assert read["/tip"][1]["pose"]["position"]["x"] == pytest.approx(played["tip_x_m"][1], abs=1e-12)
    assert read["/commands"][1]["tendon_1_m"] == 0.01 and read["/row"][2]["trial"] == 1
    line = read["/robot"][1]["entities"][0]["lines"][0]
    end = [line["points"][-1][axis] for axis in "xyz"]
    np.testing.assert_allclose(end, played.loc[1, ["tip_x_m", "tip_y_m", "tip_z_m"]].astype(float), rtol=0.0, atol=1e-9)
    assert len(line["points"]) > 20 and line["points"][0] == {"x": 0.0, "y": 0.0, "z": 0.0}
    assert read["/residuals"][0]["before_size_m"] == pytest.approx(np.sqrt(14.0) * 1e-3)
    assert len(read["/residual_lines"][0]["entities"][0]["lines"]) == 2


def test_a_loggers_text_is_read(tmp_path: Path) -> None:
    log = tmp_path / "log.csv"
    log.write_text("\ufefft;a;b;x;y;z\n0;1,5;-1,5;0;0;200\n100;2,5;-2,5;1;2;200\n", encoding="utf-8")
    by = {
        "text": {"delimiter": ";", "decimal": ","},
        "commands": {"time": {"column": "t", "unit": "ms"}, "tendons": {"columns": ["a", "b"], "unit": "mm"}},
        "tracking": {"unit": "mm", "tip": {"position": ["x", "y", "z"]}},
    }
    frame = spinebench.import_csv(log, by).recording
    assert frame["time_s"].tolist() == [0.0, 0.1]
    np.testing.assert_allclose(frame["tendon_2_m"], [-0.0015, -0.0025])
    np.testing.assert_allclose(frame["tip_y_m"], [0.0, 0.002])
    with pytest.raises(InputError) as error:
        spinebench.import_csv([log, log], {**by, "commands": {"file": 3}})
    assert error.value.line is not None
