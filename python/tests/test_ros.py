"""Eclipse CycloneDDS, with the names of ROS 2, reads and commands a run that is a node (`sinew run --ros`)."""

import json
import math
import os
import subprocess
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest
from program import PROGRAM, ROOT, built

pytestmark = built

# Before CycloneDDS is loaded: loopback alone, without multicast, in a domain of this process.
DOMAIN = 1 + os.getpid() % 99
os.environ["CYCLONEDDS_URI"] = (
    "<General><Interfaces><NetworkInterface address='127.0.0.1'/></Interfaces><AllowMulticast>false</AllowMulticast>"
    "</General><Discovery><Peers><Peer address='127.0.0.1'/></Peers><ParticipantIndex>auto</ParticipantIndex></Discovery>"
)

core: Any = pytest.importorskip("cyclonedds.core", reason="cyclonedds is not installed")
domain: Any = pytest.importorskip("cyclonedds.domain")
idl: Any = pytest.importorskip("cyclonedds.idl")
annotations: Any = pytest.importorskip("cyclonedds.idl.annotations")
types: Any = pytest.importorskip("cyclonedds.idl.types")
pub: Any = pytest.importorskip("cyclonedds.pub")
sub: Any = pytest.importorskip("cyclonedds.sub")
topic: Any = pytest.importorskip("cyclonedds.topic")

IdlStruct, final = idl.IdlStruct, annotations.final
int32, uint32, uint8, float64, sequence = types.int32, types.uint32, types.uint8, types.float64, types.sequence


@dataclass
@final
class Time(IdlStruct, typename="builtin_interfaces::msg::dds_::Time_"):
    sec: int32 = 0
    nanosec: uint32 = 0


@dataclass
@final
class Duration(IdlStruct, typename="builtin_interfaces::msg::dds_::Duration_"):
    sec: int32 = 0
    nanosec: uint32 = 0


@dataclass
@final
class Header(IdlStruct, typename="std_msgs::msg::dds_::Header_"):
    stamp: Time = field(default_factory=Time)
    frame_id: str = ""


@dataclass
@final
class JointState(IdlStruct, typename="sensor_msgs::msg::dds_::JointState_"):
    header: Header = field(default_factory=Header)
    name: sequence[str] = field(default_factory=list)
    position: sequence[float64] = field(default_factory=list)
    velocity: sequence[float64] = field(default_factory=list)
    effort: sequence[float64] = field(default_factory=list)


@dataclass
@final
class Vector3(IdlStruct, typename="geometry_msgs::msg::dds_::Vector3_"):
    x: float64
    y: float64
    z: float64


@dataclass
@final
class Quaternion(IdlStruct, typename="geometry_msgs::msg::dds_::Quaternion_"):
    x: float64
    y: float64
    z: float64
    w: float64


@dataclass
@final
class Transform(IdlStruct, typename="geometry_msgs::msg::dds_::Transform_"):
    translation: Vector3
    rotation: Quaternion


@dataclass
@final
class TransformStamped(IdlStruct, typename="geometry_msgs::msg::dds_::TransformStamped_"):
    header: Header
    child_frame_id: str
    transform: Transform


@dataclass
@final
class TFMessage(IdlStruct, typename="tf2_msgs::msg::dds_::TFMessage_"):
    transforms: sequence[TransformStamped]


@dataclass
@final
class KeyValue(IdlStruct, typename="diagnostic_msgs::msg::dds_::KeyValue_"):
    key: str
    value: str


@dataclass
@final
class DiagnosticStatus(IdlStruct, typename="diagnostic_msgs::msg::dds_::DiagnosticStatus_"):
    level: uint8
    name: str
    message: str
    hardware_id: str
    values: sequence[KeyValue]


@dataclass
@final
class DiagnosticArray(IdlStruct, typename="diagnostic_msgs::msg::dds_::DiagnosticArray_"):
    header: Header
    status: sequence[DiagnosticStatus]


@dataclass
@final
class Point(IdlStruct, typename="trajectory_msgs::msg::dds_::JointTrajectoryPoint_"):
    positions: sequence[float64]
    velocities: sequence[float64]
    accelerations: sequence[float64]
    effort: sequence[float64]
    time_from_start: Duration


@dataclass
@final
class JointTrajectory(IdlStruct, typename="trajectory_msgs::msg::dds_::JointTrajectory_"):
    header: Header
    joint_names: sequence[str]
    points: sequence[Point]


@dataclass
@final
class TriggerRequest(IdlStruct, typename="std_srvs::srv::dds_::Trigger_Request_"):
    """As rmw_fastrtps sends it."""

    structure_needs_at_least_one_member: uint8 = 0


@dataclass
@final
class TriggerResponse(IdlStruct, typename="std_srvs::srv::dds_::Trigger_Response_"):
    success: bool
    message: str


@dataclass
@final
class MarkedRequest(IdlStruct, typename="std_srvs::srv::dds_::Trigger_Request_"):
    """As rmw_cyclonedds sends it: behind the client and a number."""

    client: types.uint64
    number: types.int64
    structure_needs_at_least_one_member: uint8 = 0


@dataclass
@final
class MarkedResponse(IdlStruct, typename="std_srvs::srv::dds_::Trigger_Response_"):
    client: types.uint64
    number: types.int64
    success: bool
    message: str


QUALITY = core.Qos(
    core.Policy.Reliability.Reliable(100_000_000),
    core.Policy.Durability.Volatile,
    core.Policy.History.KeepAll,
    core.Policy.DataRepresentation(use_cdrv0_representation=True),
)


class Node:
    """A participant."""

    def __init__(self) -> None:
        self.participant = domain.DomainParticipant(DOMAIN)

    def reader(self, name: str, kind: type, quality: Any = QUALITY) -> Any:
        return sub.DataReader(self.participant, topic.Topic(self.participant, name, kind, qos=quality), qos=quality)

    def writer(self, name: str, kind: type) -> Any:
        return pub.DataWriter(self.participant, topic.Topic(self.participant, name, kind, qos=QUALITY), qos=QUALITY)

    def call(self, mode: str, *, marked: int | None = None) -> Any:
        """The answer of a service."""
        request, response = (TriggerRequest, TriggerResponse) if marked is None else (MarkedRequest, MarkedResponse)
        answers = self.reader(f"rr/sinew/{mode}Reply", response)
        requests = self.writer(f"rq/sinew/{mode}Request", request)
        until(lambda: matched(requests) and answers.get_subscription_matched_status().current_count > 0)
        time.sleep(0.3)
        requests.write(request() if marked is None else request(client=77, number=marked))
        return until(lambda: [answer for answer in answers.take(10)])[0]


def matched(writer: Any) -> bool:
    return bool(writer.get_publication_matched_status().current_count)


def until(condition: Callable[[], Any], seconds: float = 30.0) -> Any:
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        if found := condition():
            return found
        time.sleep(0.002)
    raise AssertionError(f"not within {seconds} s")


def started(machine: Path | str, *arguments: str) -> subprocess.Popen[str]:
    command = [str(PROGRAM), "run", str(machine), "--ros", "--ros-domain", str(DOMAIN), "--json", *arguments]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


@pytest.fixture(scope="module", autouse=True)
def feature() -> None:
    # Refused before anything is planned: an invalid duration in a program with the feature, else the feature.
    ran = subprocess.run([str(PROGRAM), "run", "--ros", "--virtual-time"], capture_output=True, text=True, check=False)
    if "built with the feature ros" in ran.stderr:
        pytest.skip("the program is built without the feature ros")
    assert "--virtual-time" in ran.stderr


def ended(run: subprocess.Popen[str]) -> Any:
    out, err = run.communicate(timeout=120)
    assert run.returncode == 0, err
    return json.loads(out)


def test_every_state_at_500_hz_is_received_from_the_first_on() -> None:
    node = Node()
    states = node.reader("rt/joint_states", JointState)
    muscles = node.reader("rt/sinew/muscle_states", JointState)
    frames = node.reader("rt/tf", TFMessage)
    run = started("planar_leg", "--path", "to-joints:hip=0.4,knee=1.0", "--duration", "3", "--hold", "8", "--ros-wait", "60")
    taken: list[Any] = []
    while run.poll() is None:
        taken += states.take(1000)
        time.sleep(0.001)
    report = ended(run)["ros"]
    time.sleep(0.5)
    taken += states.take(100_000)
    # The end of the writer is a sample without data.
    found = [state for state in taken if isinstance(state, JointState)]
    assert report["missed"] == 0
    assert math.isnan(found[0].velocity[0]) and not math.isnan(found[1].velocity[0]), "the first is there"
    assert len(found) == report["published"] >= 5000
    stamps = [10**9 * state.header.stamp.sec + state.header.stamp.nanosec for state in found]
    steps = sorted(after - before for before, after in zip(stamps, stamps[1:]))
    # More where the computer was too slow for the cycle.
    assert steps[0] == steps[len(steps) // 2] == 2_000_000
    assert abs(time.time() - 1e-9 * stamps[-1]) < 60
    assert all(state.name == ["hip", "knee"] for state in found)
    last = found[-1]
    assert last.position == pytest.approx([0.4, 1.0], abs=0.02)
    way = [sum(state.velocity[joint] for state in found[1:]) * 0.002 for joint in range(2)]
    assert way == pytest.approx([b - a for a, b in zip(found[0].position, last.position)], abs=0.02)
    assert way[0] > 0.03 or way[1] < -0.05, "it moved"
    assert all(len(state.effort) == 2 for state in found)
    lengths = muscles.take(5000)
    assert len(lengths) == -(-len(found) // 5)
    assert all(len(muscle.position) == len(muscle.name) and min(muscle.effort) > 0 for muscle in lengths[100:])
    moved = {frame.child_frame_id for frame in frames.take(1)[0].transforms}
    assert len(moved) >= 2


@pytest.fixture
def commanded(tmp_path: Path) -> Iterator[tuple[Node, subprocess.Popen[str]]]:
    # A computer with other work is no reason to hold.
    machine = tmp_path / "planar_leg.toml"
    text = (ROOT / "models/planar_leg.toml").read_text()
    machine.write_text(text + "\n[safety]\ncommand_age_s = 1.0\n")
    run = started(machine, "--ros-commands", "--until", "120")
    yield Node(), run
    run.kill()
    run.communicate()


def test_a_trajectory_is_executed_and_modes_are_called(commanded: tuple[Node, subprocess.Popen[str]]) -> None:
    node, run = commanded
    best_effort = core.Qos(
        core.Policy.Reliability.BestEffort, core.Policy.DataRepresentation(use_cdrv0_representation=True)
    )
    states = node.reader("rt/joint_states", JointState, best_effort)
    told = node.reader("rt/diagnostics", DiagnosticArray)
    trajectories = node.writer("rt/joint_trajectory", JointTrajectory)
    said: list[tuple[str, str]] = []
    refusals: list[str] = []

    def says(part: str, text: str) -> bool:
        new = [(status.name, status.message) for array in told.take(100) for status in array.status]
        said.extend(new)
        refusals.extend(message for name, message in new if name == "sinew: commands")
        return any(name == f"sinew: {part}" and text in message for name, message in said)

    def is_in(mode: str) -> bool:
        says("supervisor", mode)
        # With its fault, and the status of the controller.
        newest = [message for name, message in said if name == "sinew: supervisor"][-1:]
        return bool(newest) and newest[0].replace(" (", ", ").startswith(f"{mode}, ")

    def send(names: list[str], *points: tuple[list[float], float]) -> None:
        at = [Point(pose, [], [], [], Duration(int(t), round(1e9 * (t % 1)))) for pose, t in points]
        trajectories.write(JointTrajectory(Header(), names, at))

    until(lambda: matched(trajectories), 60)
    until(lambda: is_in("hold"), 60)
    start = until(lambda: states.take(1))[0].position
    goal = [start[0] + 0.1, start[1] - 0.1]
    send(["hip", "knee"], (goal, 2.0))
    until(lambda: says("commands", "joint_trajectory refused: mode: expected a machine in Run, got Hold"))
    answer = node.call("run")
    assert answer.success and "Run" in answer.message
    until(lambda: is_in("run"))
    send(["hip", "ankle"], (goal, 2.0))
    until(lambda: says("commands", "joint_names: expected each once: hip, knee, got hip, ankle"))
    send(["hip", "knee"], ([float("nan"), 0.0], 2.0))
    until(lambda: says("commands", "points[0].positions of hip"))
    send(["hip", "knee"], (goal, 2.0), (start, 1.0))
    until(lambda: says("commands", "points[1].time_from_start"))
    states.take(100_000)
    assert until(lambda: states.take(1))[0].position == pytest.approx(start, abs=0.005), "nothing has moved"
    assert len(refusals) == 4, refusals
    # In another order than the machine's.
    middle = [(a + b) / 2 for a, b in zip(start, goal)]
    send(["knee", "hip"], (middle[::-1], 1.0), (goal[::-1], 2.0))

    def reached() -> bool:
        taken = states.take(1000)
        return bool(taken) and taken[-1].position == pytest.approx(goal, abs=0.02) and abs(taken[-1].velocity[0]) < 0.05

    until(reached)
    # Set-points that stop: the machine follows them, holds then, and runs again when it is asked to.
    setpoints = node.writer("rt/robot_joint_command", JointState)
    until(lambda: matched(setpoints))
    # The end of the trajectory is behind its last point.
    time.sleep(1.0)
    for step in range(1, 101):
        pose = [b + (a - b) * 0.4 * min(step / 80, 1) for a, b in zip(start, goal)]
        setpoints.write(JointState(Header(), ["hip", "knee"], pose, [], []))
        time.sleep(0.01)
    assert not says("commands", "robot_joint_command")
    until(lambda: is_in("hold"))
    states.take(100_000)
    assert until(lambda: states.take(1))[0].position == pytest.approx(pose, abs=0.02)
    setpoints.write(JointState(Header(), ["hip", "knee"], goal, [], []))
    until(lambda: says("commands", "robot_joint_command refused: mode"))
    assert node.call("run").success
    until(lambda: is_in("run"))
    answer = node.call("safe_stop", marked=5)
    assert (answer.client, answer.number, answer.success) == (77, 5, True)
    until(lambda: is_in("safe stop"))
    assert node.call("turn_off").success
    report = ended(run)
    assert report["run"]["ended"] in ("turned_off", "as_planned")
    assert report["ros"]["refused"] == 5
    assert [mode["mode"] for mode in report["run"]["modes"]][-1] == "off"
