"""ODrive's messages by somebody else on both sides: cantools with the DBC file of PyPI odrive-can, on python-can over slcan."""

from __future__ import annotations

import importlib.util
import os
import subprocess
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from program import PROGRAM, ROOT, bare, pseudo_terminals, relay

pytestmark = pseudo_terminals

can: Any = pytest.importorskip("can", reason="python-can is not installed")
cantools: Any = pytest.importorskip("cantools", reason="cantools is not installed")
PACKAGE = importlib.util.find_spec("odrive_can")
if PACKAGE is None or PACKAGE.origin is None:
    pytest.skip("odrive-can is not installed", allow_module_level=True)

# Its file alone: the package itself is not loaded.
DATABASE = cantools.database.load_file(Path(PACKAGE.origin).parent / "dbc/odrive-cansimple-0.6.10.dbc")


def message(node: int, name: str, **signals: Any) -> Any:
    """A message to an axis; the file describes eight of them, of which the first serves for all."""
    known = DATABASE.get_message_by_name(f"Axis0_{name}")
    data = known.encode(signals) if signals else b""
    return can.Message(arbitration_id=node << 5 | known.frame_id, data=data, is_extended_id=False)


def decoded(frame: Any) -> tuple[int, str, dict[str, Any]]:
    """Node, name and signals of a message."""
    known = DATABASE.get_message_by_frame_id(frame.arbitration_id & 0x1F)
    signals = known.decode(frame.data, decode_choices=False) if known.length == len(frame.data) else {}
    return frame.arbitration_id >> 5, known.name.removeprefix("Axis0_"), signals


def machine(path: Path, nodes: tuple[int, int]) -> Path:
    """The bench joint with two axes on CANSimple, the second of which counts up while it pays out."""
    source = (ROOT / "models/bench_joint.toml").read_text()
    tables = [
        f'[[device]]\nname = "{muscle}"\nmuscle = "{muscle}"\nnode = {node}\nprotocol = "cansimple"\n'
        f"counts_per_turn = {turn}\n"
        for muscle, node, turn in zip(("front", "back"), nodes, (1, -1))
    ]
    path.write_text(bare(source) + "\n" + "\n".join(tables))
    return path


@pytest.fixture
def simulated(tmp_path: Path) -> Iterator[Any]:
    """A bus behind which two simulated axes answer, 3 and 50."""
    command = [str(PROGRAM), "can", "simulate", str(machine(tmp_path / "joint.toml", (3, 50))), "--pty"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout
        path = process.stdout.readline().strip()
        assert "SIMULATED" in process.stdout.readline()
        with can.Bus(interface="slcan", channel=path, bitrate=1_000_000, sleep_after_open=0.1) as bus:
            yield bus
        process.terminate()


def heard(bus: Any, node: int, name: str, patience: float = 3.0) -> dict[str, Any]:
    """The next message of a name of an axis."""
    end = time.monotonic() + patience
    while time.monotonic() < end:
        frame = bus.recv(0.2)
        if frame is not None and not frame.is_remote_frame and decoded(frame)[:2] == (node, name):
            return decoded(frame)[2]
    raise AssertionError(f"no {name} of axis {node}")


def asked(bus: Any, node: int, name: str) -> dict[str, Any]:
    """What an axis answers to a remote frame."""
    identifier = node << 5 | DATABASE.get_message_by_name(f"Axis0_{name}").frame_id
    bus.send(can.Message(arbitration_id=identifier, is_remote_frame=True, dlc=8, is_extended_id=False))
    return heard(bus, node, name)


def test_messages_of_the_file_enable_and_move_simulated_axes(simulated: Any) -> None:
    """Version, states, modes, limits, errors, watchdog and motion, all by the names of the file."""
    bus = simulated
    for node in (3, 50):
        version = asked(bus, node, "Get_Version")
        assert (version["Protocol_Version"], version["Fw_Version_Major"], version["Fw_Version_Minor"]) == (2, 0, 6)
        assert asked(bus, node, "Get_Bus_Voltage_Current")["Bus_Voltage"] == 24.0
        assert asked(bus, node, "Get_Temperature")["FET_Temperature"] > 0.0
        assert heard(bus, node, "Heartbeat")["Axis_State"] == 1
        bus.send(message(node, "Set_Controller_Mode", Control_Mode="VELOCITY_CONTROL", Input_Mode="PASSTHROUGH"))
        bus.send(message(node, "Set_Limits", Velocity_Limit=1.5, Current_Limit=10.0))
        bus.send(message(node, "Set_Axis_State", Axis_Requested_State="CLOSED_LOOP_CONTROL"))
        before = asked(bus, node, "Get_Encoder_Estimates")["Pos_Estimate"]
        # Above the limit: 1.5 turns/s.
        end = time.monotonic() + 0.6
        while time.monotonic() < end:
            bus.send(message(node, "Set_Input_Vel", Input_Vel=4.0, Input_Torque_FF=0.0))
            time.sleep(0.005)
        estimates = asked(bus, node, "Get_Encoder_Estimates")
        assert 0.3 < estimates["Pos_Estimate"] - before < 1.2, estimates
        assert asked(bus, node, "Get_Iq")["Iq_Measured"] != 0.0
        # Silence: its watchdog takes the power and says so.
        time.sleep(0.3)
        errors = asked(bus, node, "Get_Error")
        assert errors["Disarm_Reason"] == 1 << 24, errors
        while bus.recv(0.0) is not None:
            pass
        assert heard(bus, node, "Heartbeat")["Axis_State"] == 1
        bus.send(message(node, "Clear_Errors", Identify=0))
        assert asked(bus, node, "Get_Error")["Disarm_Reason"] == 0
        bus.send(message(node, "Estop"))
        assert asked(bus, node, "Get_Error")["Active_Errors"] == 1 << 25


class Axis:
    """An axis as the file describes it, in velocity mode, whose motor follows at once."""

    def __init__(self, bus: Any, node: int) -> None:
        self.bus, self.node = bus, node
        self.state, self.errors, self.velocity, self.position = 1, 0, 0.0, 0.0
        self.modes: tuple[int, int] = (0, 0)
        self.limits: dict[str, float] = {}
        self.fed = self.last = self.beat = time.monotonic()
        self.states: list[int] = [1]
        self.velocities: list[float] = []

    def show(self, name: str, **signals: Any) -> None:
        self.bus.send(message(self.node, name, **signals))

    def move(self) -> None:
        """Time passes."""
        now = time.monotonic()
        self.position += (now - self.last) * self.velocity if self.state == 8 else 0.0
        self.last = now
        if self.state == 8 and now - self.fed > 0.03:
            self.state, self.errors = 1, 1 << 24
        if self.states[-1] != self.state:
            self.states.append(self.state)
        if now - self.beat > 0.02:
            self.beat = now
            self.show(
                "Heartbeat", Axis_Error=self.errors, Axis_State=self.state, Procedure_Result=0, Trajectory_Done_Flag=0
            )

    def take(self, name: str, remote: bool, signals: dict[str, Any]) -> None:
        """A message to it."""
        self.move()
        if remote:
            # A cable that hardly gives: the current grows with what is wound in.
            current = max(-2.0, min(2.0, 0.1 * self.position))
            versions = dict.fromkeys([signal.name for signal in DATABASE.get_message_by_frame_id(0).signals], 0)
            {
                "Get_Version": lambda: self.show(
                    "Get_Version", **(versions | {"Protocol_Version": 2, "Fw_Version_Minor": 6})
                ),
                "Get_Error": lambda: self.show("Get_Error", Active_Errors=self.errors, Disarm_Reason=self.errors),
                "Get_Encoder_Estimates": lambda: self.show(
                    "Get_Encoder_Estimates", Pos_Estimate=self.position, Vel_Estimate=self.velocity
                ),
                "Get_Iq": lambda: self.show("Get_Iq", Iq_Setpoint=current, Iq_Measured=current),
            }[name]()
            return
        self.fed = time.monotonic()
        if name == "Set_Axis_State":
            self.state = signals["Axis_Requested_State"]
        elif name == "Set_Controller_Mode":
            self.modes = (signals["Control_Mode"], signals["Input_Mode"])
        elif name == "Set_Limits":
            self.limits = signals
        elif name == "Clear_Errors":
            self.errors = 0
        elif name == "Set_Input_Vel":
            self.velocity = signals["Input_Vel"]
            if self.state == 8:
                self.velocities.append(self.velocity)


def serve(bus: Any, axes: list[Axis], stop: threading.Event) -> None:
    """Lets axes answer."""
    while not stop.is_set():
        frame = bus.recv(0.005)
        for axis in axes:
            if frame is not None and frame.arbitration_id >> 5 == axis.node:
                _, name, signals = decoded(frame)
                axis.take(name, frame.is_remote_frame, signals)
            axis.move()


def test_our_master_drives_axes_of_the_file(tmp_path: Path) -> None:
    """Found, set up, its watchdog tried, enabled and moved in real time; at the end every axis is idle."""
    import tty

    (ours, near), (theirs, far) = os.openpty(), os.openpty()
    for end in (ours, near, theirs, far):
        tty.setraw(end)
    stop = threading.Event()
    carrier = threading.Thread(target=relay, args=([ours, theirs], stop))
    carrier.start()
    bus = can.Bus(interface="slcan", channel=os.ttyname(far), bitrate=1_000_000, sleep_after_open=0.1)
    axes = [Axis(bus, 0), Axis(bus, 51)]
    server = threading.Thread(target=serve, args=(bus, axes, stop))
    server.start()
    path = machine(tmp_path / "joint.toml", (0, 51))
    try:
        scanned = subprocess.run(
            [str(PROGRAM), "can", "scan", os.ttyname(near)], capture_output=True, text=True, timeout=60, check=False
        )
        assert scanned.returncode == 0 and "firmware 0.6.0" in scanned.stdout, scanned.stdout + scanned.stderr
        command = ["run", str(path), "--bus", "can", "--interface", os.ttyname(near), "--duration", "6"]
        ran = subprocess.run(
            [str(PROGRAM), *command, "--unverified"], capture_output=True, text=True, timeout=120, check=False
        )
    finally:
        stop.set()
        carrier.join()
        server.join()
        bus.shutdown()
        for end in (ours, near, theirs, far):
            os.close(end)
    for axis in axes:
        report = (ran.returncode, ran.stdout, ran.stderr, axis.states)
        # Once for its watchdog, once for the run.
        assert axis.states.count(8) == 2 and axis.states[-1] == 1, report
        assert axis.modes == (2, 1) and axis.limits["Velocity_Limit"] > 0.0 and axis.limits["Current_Limit"] > 0.0
        assert len(axis.velocities) > 20 and any(axis.velocities), report
        assert axis.velocities[-1] == 0.0, report
