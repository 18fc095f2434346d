"""PyPI rosbags reads a bag that `sinew log export` has written: every field, every value, every octet."""

from __future__ import annotations

import csv
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from program import PROGRAM, built

pytestmark = built

rosbag2: Any = pytest.importorskip("rosbags.rosbag2", reason="rosbags is not installed")
typesys: Any = pytest.importorskip("rosbags.typesys", reason="rosbags is not installed")

RUN = ["planar_leg", "--path", "to-joints:hip=0.4,knee=1.0", "--duration", "3", "--hold", "0", "--virtual-time"]


def sinew(folder: Path, *arguments: str) -> str:
    ran = subprocess.run([str(PROGRAM), *arguments], cwd=folder, capture_output=True, text=True, check=True)
    return ran.stdout


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a recording, its table and its bag."""
    made = tmp_path_factory.mktemp("ros2")
    sinew(made, "run", *RUN, "--fault", "load-cell:hamstrings:lost@4", "--record", "run.mcap")
    sinew(made, "log", "export", "run.mcap", "--every", "20", "--out", "run.csv")
    sinew(made, "log", "export", "run.mcap", "--every", "1", "--out", "all.csv")
    assert "SIMULATED" in sinew(made, "log", "export", "run.mcap", "--to", "ros2", "--out", "bag")
    return made


def columns(file: Path) -> dict[str, Any]:
    with file.open(newline="") as lines:
        head, *rows = csv.reader(lines)
    return dict(zip(head, np.array([[float(cell or "nan") for cell in row] for row in rows]).T))


def messages(folder: Path) -> dict[str, list[tuple[int, Any]]]:
    """All messages by topic. Those in standard types have the definitions of rosbags, ours those of the file."""
    store = typesys.get_typestore(typesys.Stores.ROS2_HUMBLE)
    found: dict[str, list[tuple[int, Any]]] = {}
    with rosbag2.Reader(folder / "bag") as reader:
        for connection in reader.connections:
            given = typesys.get_types_from_msg(connection.msgdef.data, connection.msgtype)
            store.register({name: fields for name, fields in given.items() if name.startswith("sinew_msgs/")})
            known, _ = store.generate_msgdef(connection.msgtype, ros_version=2)
            other = typesys.get_typestore(typesys.Stores.EMPTY)
            other.register(given)
            assert other.generate_msgdef(connection.msgtype, ros_version=2)[0] == known
        counts = {connection.topic: connection.msgcount for connection in reader.connections}
        for connection, time, octets in reader.messages():
            message = store.deserialize_cdr(octets, connection.msgtype)
            assert bytes(store.serialize_cdr(message, connection.msgtype)) == bytes(octets), connection.topic
            if connection.msgtype != "tf2_msgs/msg/TFMessage":
                assert 10**9 * message.header.stamp.sec + message.header.stamp.nanosec == time
            found.setdefault(connection.topic, []).append((time, message))
        assert reader.message_count == sum(map(len, found.values()))
        assert reader.start_time == min(items[0][0] for items in found.values())
    assert {topic: len(items) for topic, items in found.items()} == counts
    return found


def test_every_signal_is_that_of_the_recording(folder: Path) -> None:
    found, table = messages(folder), columns(folder / "run.csv")
    seen = {"time_s"}
    for topic in ("/sinew/cycle", "/sinew/joints", "/sinew/muscles"):
        times = [time for time, _ in found[topic]]
        assert np.array_equal(times, np.round(table["deadline_us"] * 1e3))
        fields = [name for name in vars(found[topic][0][1]) if not name.startswith("_")]
        for field in set(fields) - {"header", "name"}:
            values = np.array([getattr(message, field) for _, message in found[topic]])
            if topic == "/sinew/cycle":
                expected = {field: values}
            else:
                names, unit = found[topic][0][1].name, "_rad" if topic == "/sinew/joints" else ""
                expected = {f"{field}{unit}:{name}": values[:, k] for k, name in enumerate(names)}
            for column, got in expected.items():
                # A decimal fraction and a multiple of a resolution differ by rounding.
                assert np.allclose(got, table[column], rtol=1e-15, atol=1e-13, equal_nan=True), column
                seen.add(column)
    assert seen == set(table)


def test_joints_and_frames_are_those_of_the_pose(folder: Path) -> None:
    found, table = messages(folder), columns(folder / "run.csv")
    states = [message for _, message in found["/joint_states"]]
    names = states[0].name
    assert names == ["hip", "knee"]
    for k, name in enumerate(names):
        assert np.array_equal([state.position[k] for state in states], table[f"joint_rad:{name}"])
    poses = "\n".join([",".join(names), *(",".join(map(repr, map(float, state.position))) for state in states)])
    (folder / "poses.csv").write_text(poses + "\n")
    sinew(folder, "machine", "evaluate", "planar_leg", "--poses", "poses.csv", "--out", "geometry.csv")
    geometry, muscles = columns(folder / "geometry.csv"), found["/sinew/muscles"][0][1].name
    for k, name in enumerate(names):
        arms = [geometry[f"moment_arm_m:{muscle}:{name}"] for muscle in muscles]
        tensions = [table[f"tension_out_estimated_n:{muscle}"] for muscle in muscles]
        expected = sum(arm * tension for arm, tension in zip(arms, tensions))
        assert np.abs([state.effort[k] for state in states] - expected).max() < 1e-9
    assert all(len(state.velocity) == 0 for state in states)
    frames = [message.transforms for _, message in found["/tf"]]
    assert len(frames) == len(states)
    assert [frame.child_frame_id for frame in frames[0]][-2:] == ["thigh", "shank"]
    angle = 2 * np.arctan2(*[[getattr(f[-1].transform.rotation, axis) for f in frames] for axis in ("y", "w")])
    moved = np.abs(np.abs(angle - angle[0]) - np.abs(table["joint_rad:knee"] - table["joint_rad:knee"][0]))
    assert moved.max() < 1e-5, moved.max()
    for transform in (transform for frame in frames for transform in frame):
        turn = transform.transform.rotation
        assert abs(np.linalg.norm([turn.x, turn.y, turn.z, turn.w]) - 1) < 1e-5


def test_diagnostics_tell_every_change_of_the_supervisor(folder: Path) -> None:
    found, table = messages(folder), columns(folder / "all.csv")
    told = [(time, message.status[0]) for time, message in found["/diagnostics"]]
    state = np.array([table[name] for name in ("status", "fault", "mode", "mode_fault")])
    changed = np.flatnonzero(np.any(np.diff(state, axis=1), axis=0)) + 1
    due = np.unique(np.concatenate([[0], changed, np.arange(0, state.shape[1], 1000)]))
    assert np.array_equal([time for time, _ in told], np.round(table["deadline_us"][due] * 1e3))
    for row, (_, status) in zip(due, told):
        assert status.hardware_id == "SIMULATED planar_leg"
        for pair in status.values:
            assert float(pair.value) == table[pair.key][row] or np.isnan(table[pair.key][row])
        assert status.level == {0: 0, 1: 0, 2: 1, 3: 2}[int(table["status"][row])]
    assert any("load cell" in status.message and "hamstrings" in status.message for _, status in told)
