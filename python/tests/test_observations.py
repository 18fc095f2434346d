"""Bags that rosbags and mcap-ros2-support have written calibrate a machine as the table with the same numbers does."""

from __future__ import annotations

import csv
import json
import os
import subprocess
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

PROGRAM = Path(os.environ.get("SINEW_PROGRAM", Path(__file__).parents[2] / "target/debug/sinew"))

pytestmark = pytest.mark.skipif(not PROGRAM.is_file(), reason=f"{PROGRAM} is not built")

MACHINE = ["planar_leg", "--tolerances", "rough"]
# A clock that began in 1970.
NOW = 1_760_000_000
POSE = """std_msgs/Header header
geometry_msgs/Pose pose
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
================================================================================
MSG: geometry_msgs/Pose
geometry_msgs/Point position
geometry_msgs/Quaternion orientation
================================================================================
MSG: geometry_msgs/Point
float64 x
float64 y
float64 z
================================================================================
MSG: geometry_msgs/Quaternion
float64 x
float64 y
float64 z
float64 w
"""
TRANSFORMS = POSE.replace(
    "std_msgs/Header header\ngeometry_msgs/Pose pose\n",
    "geometry_msgs/TransformStamped[] transforms\n" + 80 * "=" + "\nMSG: geometry_msgs/TransformStamped\n"
    "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/Transform transform\n" + 80 * "="
    + "\nMSG: geometry_msgs/Transform\ngeometry_msgs/Vector3 translation\ngeometry_msgs/Quaternion rotation\n"
    + 80 * "=" + "\nMSG: geometry_msgs/Vector3\nfloat64 x\nfloat64 y\nfloat64 z\n",
)

Sighting = tuple[int, str, list[float]]


def sinew(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([str(PROGRAM), *arguments], cwd=folder, capture_output=True, text=True)


def fit(folder: Path, observations: str, *arguments: str) -> Any:
    given = ["--observations", observations, *arguments, "--out", "fitted", "--json"]
    ran = sinew(folder, "calibrate", "fit", MACHINE[0], "out/readings.csv", *MACHINE[1:], *given)
    assert ran.returncode == 0, ran.stderr
    document = json.loads(ran.stdout)
    # Whether a file was there before.
    return {key: value for key, value in document.items() if key != "written"}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = tmp_path_factory.mktemp("observations")
    ran = sinew(made, "calibrate", *MACHINE, "--poses", "8", "--check", "3", "--out", "out")
    assert ran.returncode == 0, ran.stderr
    return made


def sightings(folder: Path) -> list[Sighting]:
    """Stamp in ns, marker, place."""
    lines = [line for line in (folder / "out/observations.csv").read_text().splitlines() if line[0] != "#"]
    return [
        (round(float(row["time_s"]) * 1e9), row["marker"], [float(row[axis]) for axis in ("x_m", "y_m", "z_m")])
        for row in csv.DictReader(lines)
    ]


def by_time(seen: list[Sighting]) -> dict[int, list[tuple[str, list[float]]]]:
    frames: dict[int, list[tuple[str, list[float]]]] = {}
    for ns, marker, place in seen:
        frames.setdefault(ns, []).append((marker, place))
    return frames


@pytest.mark.parametrize("compressed", [False, True])
@pytest.mark.parametrize("start", [0, NOW])
def test_a_bag_of_rosbags_is_the_table(folder: Path, tmp_path: Path, compressed: bool, start: int) -> None:
    rosbag2: Any = pytest.importorskip("rosbags.rosbag2", reason="rosbags is not installed")
    typesys: Any = pytest.importorskip("rosbags.typesys", reason="rosbags is not installed")
    store = typesys.get_typestore(typesys.Stores.ROS2_HUMBLE)
    of = {name.split("/")[-1]: kind for name, kind in store.types.items()}
    writer = rosbag2.Writer(tmp_path / "bag", version=9, storage_plugin=rosbag2.StoragePlugin.MCAP)
    if compressed:
        writer.set_compression(rosbag2.CompressionMode.STORAGE, rosbag2.CompressionFormat.ZSTD)
    with writer:
        connection = writer.add_connection("/tf", "tf2_msgs/msg/TFMessage", typestore=store)
        for ns, seen in by_time(sightings(folder)).items():
            stamp = of["Time"](sec=start + ns // 10**9, nanosec=ns % 10**9)
            still = of["Quaternion"](x=0.0, y=0.0, z=0.0, w=1.0)
            transforms = [
                of["TransformStamped"](
                    header=of["Header"](stamp=stamp, frame_id="camera"),
                    child_frame_id=marker,
                    transform=of["Transform"](translation=of["Vector3"](*place), rotation=still),
                )
                for marker, place in seen
            ]
            # It arrives late: the stamp of the exposure counts.
            message = store.serialize_cdr(of["TFMessage"](transforms=transforms), "tf2_msgs/msg/TFMessage")
            writer.write(connection, (start + 5) * 10**9 + ns, message)
    clock = ["--clock", str(start)] if start else []
    assert fit(folder, str(tmp_path / "bag/bag.mcap"), *clock) == fit(folder, "out/observations.csv")


@pytest.mark.parametrize("transforms", [False, True])
def test_a_bag_of_mcap_ros2_support_is_the_table(folder: Path, tmp_path: Path, transforms: bool) -> None:
    writing: Any = pytest.importorskip("mcap_ros2.writer", reason="mcap-ros2-support is not installed")
    with (tmp_path / "seen.mcap").open("wb") as file, writing.Writer(file) as writer:
        name = "tf2_msgs/msg/TFMessage" if transforms else "geometry_msgs/msg/PoseStamped"
        schema = writer.register_msgdef(name, TRANSFORMS if transforms else POSE)
        still = SimpleNamespace(x=0.0, y=0.0, z=0.0, w=1.0)
        for ns, marker, place in sightings(folder):
            at = SimpleNamespace(**dict(zip("xyz", place, strict=True)))
            header = SimpleNamespace(stamp=SimpleNamespace(sec=ns // 10**9, nanosec=ns % 10**9), frame_id="camera")
            transform = SimpleNamespace(translation=at, rotation=still)
            child = SimpleNamespace(header=header, child_frame_id=marker, transform=transform)
            pose = SimpleNamespace(header=header, pose=SimpleNamespace(position=at, orientation=still))
            message = SimpleNamespace(transforms=[child]) if transforms else pose
            writer.write_message("/tf" if transforms else f"/{marker}", schema, message, log_time=ns)
    assert fit(folder, str(tmp_path / "seen.mcap")) == fit(folder, "out/observations.csv")


def test_stamps_of_another_clock_and_bags_of_other_topics_are_refused(folder: Path, tmp_path: Path) -> None:
    writing: Any = pytest.importorskip("mcap_ros2.writer", reason="mcap-ros2-support is not installed")
    with (tmp_path / "other.mcap").open("wb") as file, writing.Writer(file) as writer:
        schema = writer.register_msgdef("std_msgs/msg/String", "string data\n")
        writer.write_message("/word", schema, SimpleNamespace(data="a"), log_time=0)
    arguments = ["out/readings.csv", *MACHINE[1:], "--out", "fitted", "--observations"]
    ran = sinew(folder, "calibrate", "fit", MACHINE[0], *arguments, str(tmp_path / "other.mcap"))
    assert ran.returncode == 2 and "/word (std_msgs/String)" in ran.stderr, ran.stderr
    ran = sinew(folder, "calibrate", "fit", MACHINE[0], *arguments, "out/observations.csv", "--clock", "-100")
    assert ran.returncode == 2 and "--clock" in ran.stderr, ran.stderr
