"""MIT mode by somebody else on both sides: PyPI damiao-motor and mini-cheetah-motor-driver-socketcan; a watchdog that outlives its program."""

from __future__ import annotations

import os
import re
import select
import signal
import struct
import subprocess
import threading
import time
from pathlib import Path
from typing import Any

import pytest
from test_can import PROGRAM, bare, pytestmark as pytestmark

can: Any = pytest.importorskip("can", reason="python-can is not installed")
pytest.importorskip("serial", reason="pyserial is not installed")
damiao: Any = pytest.importorskip("damiao_motor.core.motor", reason="damiao-motor is not installed")

# Time without a sign of life after which the watchdog acts, at a period of 20 ms, s; a busy computer is later.
WATCHDOG, LATER = 0.08, 0.25
STEPS = {"pos": (12.5, 16), "vel": (45.0, 12), "torq": (54.0, 12)}


def machine(path: Path, nodes: tuple[int, int], model: str) -> Path:
    """The bench joint with two motors."""
    source = (Path(__file__).parents[2] / "models/bench_joint.toml").read_text()
    tables = [
        f'[[device]]\nname = "{muscle}"\nmuscle = "{muscle}"\nnode = {node}\nprotocol = "mit"\nmodel = "{model}"\n'
        for muscle, node in zip(("front", "back"), nodes)
    ]
    text = bare(source).replace("period_s = 0.01", "period_s = 0.02")
    path.write_text(text + "\n" + "\n".join(tables))
    return path


def simulated(path: Path) -> tuple[subprocess.Popen[str], str]:
    """Simulated motors, and the path of their terminal."""
    process = subprocess.Popen([str(PROGRAM), "can", "simulate", str(path), "--pty"], stdout=subprocess.PIPE, text=True)
    assert process.stdout
    port = process.stdout.readline().strip()
    assert "SIMULATED" in process.stdout.readline()
    return process, port


def test_the_package_of_another_drives_simulated_motors(tmp_path: Path) -> None:
    """Registers, power, motion, and the time after which a DAMIAO loses its power by itself."""
    process, port = simulated(machine(tmp_path / "joint.toml", (1, 15), "DM-J8009"))
    bus = can.Bus(interface="slcan", channel=port, bitrate=1_000_000, sleep_after_open=0.1)
    try:
        for node in (1, 15):
            drive(bus, node)
    finally:
        bus.shutdown()
        process.terminate()
        process.communicate(timeout=30)


def drive(bus: Any, node: int) -> None:
    """One motor after the other."""
    motor = damiao.DaMiaoMotor(node, 0x10 + node, bus, motor_type="8009")

    def heard() -> dict[str, Any]:
        while (frame := bus.recv(0.02)) is not None:
            if frame.arbitration_id == 0x10 + node:
                motor.process_feedback_frame(frame.data, frame.arbitration_id)
        states: dict[str, Any] = motor.get_states()
        return states

    for number in (8, 10, 21, 22, 23):
        motor.request_register_reading(number)
    motor.set_can_timeout(200)
    motor.request_register_reading(9)
    heard()
    assert motor.registers == {8: node, 10: 1, 21: 12.5, 22: 45.0, 23: 54.0, 9: 4000}
    motor.disable()
    start = heard()
    assert start["status"] == "DISABLED" and start["can_id"] == node
    motor.enable()
    position, end = start["pos"], time.monotonic() + 0.5
    while time.monotonic() < end:
        motor.send_cmd_mit(target_position=position + 0.2, target_velocity=0.0, stiffness=100.0, damping=3.0)
        state = heard()
    assert state["status"] == "ENABLED" and abs(state["pos"] - position - 0.2) < 0.1, (start, state)
    time.sleep(0.4)
    motor.send_cmd_mit(target_position=position, target_velocity=0.0, stiffness=100.0, damping=3.0)
    assert heard()["status"] == "LOST_COMM"
    motor.enable()
    assert heard()["status"] == "LOST_COMM"
    motor.clear_error()
    assert heard()["status"] == "DISABLED"


def test_answers_of_simulated_motors_are_those_of_another_package(tmp_path: Path) -> None:
    """CubeMars: position and power, as mini-cheetah-motor-driver-socketcan packs and reads them."""
    library: Any = pytest.importorskip("motor_driver.canmotorlib", reason="mini-cheetah-motor-driver is missing")
    motor = library.CanMotorController.__new__(library.CanMotorController)
    motor.motorParams = library.AK10_9_V1p1_PARAMS | {"AXIS_DIRECTION": 1}
    motor._recv_bytes = library.BitArray(uint=0, length=48)
    process, port = simulated(machine(tmp_path / "joint.toml", (1, 99), "AK10-9"))
    bus = can.Bus(interface="slcan", channel=port, bitrate=1_000_000, sleep_after_open=0.1)

    def told(data: bytes) -> tuple[float, float, float]:
        bus.send(can.Message(arbitration_id=99, data=data, is_extended_id=False))
        frame = bus.recv(1.0)
        assert frame is not None and frame.arbitration_id == 99 and frame.dlc == 8 and frame.data[0] == 99
        shown: tuple[float, float, float] = motor.convert_raw_to_physical_rad(
            *motor.decode_motor_status(bytes(frame.data[:6]))
        )
        return shown

    try:
        start = told(b"\xff" * 7 + b"\xfd")
        told(b"\xff" * 7 + b"\xfc")
        raw = motor.convert_physical_rad_to_raw(start[0] + 0.2, 0.0, 100.0, 3.0, 0.0)
        fields = [library.BitArray(uint=value, length=bits) for value, bits in zip(raw, (16, 12, 12, 12, 12))]
        command = sum(fields[1:], fields[0]).tobytes()
        end = time.monotonic() + 0.5
        while time.monotonic() < end:
            shown = told(command)
            time.sleep(0.01)
        assert abs(shown[0] - start[0] - 0.2) < 0.1, (start, shown)
    finally:
        bus.shutdown()
        process.terminate()
        process.communicate(timeout=30)


class Motor:
    """A DAMIAO by the package's numbers, whose motor follows at once."""

    def __init__(self, node: int) -> None:
        self.node, self.power, self.position, self.velocity = node, False, 0.0, 0.0
        self.last = time.monotonic()
        self.registers: dict[int, int] = {10: 1, 9: 0}
        for number, value in zip((21, 22, 23), (12.5, 45.0, 54.0)):
            self.registers[number] = struct.unpack("<I", struct.pack("<f", value))[0]
        # What came, by its last octet or none for a command, and when.
        self.told: list[tuple[float, int | None]] = []
        self.velocities: list[float] = []
        self.theirs: list[tuple[bytes, bytes]] = []

    def compare(self, data: bytes) -> None:
        """What the package packs for the numbers in the middle of the steps that came."""
        word = int.from_bytes(data, "big")
        spans = [(-12.5, 12.5, 16), (-45.0, 45.0, 12), (0.0, 500.0, 12), (0.0, 5.0, 12), (-54.0, 54.0, 12)]
        values = []
        for shift, (low, high, bits) in zip((48, 36, 24, 12, 0), spans):
            step = (high - low) / ((1 << bits) - 1)
            values.append(min(low + ((word >> shift & ((1 << bits) - 1)) + 0.5) * step, high))
        motor = damiao.DaMiaoMotor(self.node, 0x10 + self.node, None, motor_type="8009")
        position, self.velocity, stiffness, damping, torque = values
        self.theirs.append((data, motor.encode_cmd_msg(position, self.velocity, torque, stiffness, damping)))
        self.velocities.append(self.velocity)
        if self.power:
            self.position = position

    def take(self, data: bytes) -> bytes:
        """A frame to it, and its answer."""
        special = data[:7] == b"\xff" * 7
        self.told.append((time.monotonic(), data[7] if special else None))
        if special:
            assert data[7] in (0xFB, 0xFC, 0xFD), data
            self.power = {0xFC: True, 0xFD: False}.get(data[7], self.power)
        else:
            self.compare(data)
        # A cable that hardly gives: the torque grows with what is wound in.
        numbers = (self.position, self.velocity, max(-5.0, min(5.0, 20.0 * self.position)))
        position, velocity, torque = (
            damiao.float_to_uint(value, -most, most, bits) for value, (most, bits) in zip(numbers, STEPS.values())
        )
        word: int = position << 24 | velocity << 12 | torque
        return bytes([self.node | self.power << 4]) + word.to_bytes(5, "big") + bytes([30, 31])

    def register(self, data: bytes) -> bytes:
        """A register, read or written."""
        if data[2] == 0x55:
            self.registers[data[3]] = int.from_bytes(data[4:], "little")
        return data[:4] + self.registers[data[3]].to_bytes(4, "little")


def serve(end: int, motors: dict[int, Motor], stop: threading.Event) -> None:
    """An adapter with motors behind."""
    text = b""
    while not stop.is_set():
        if not select.select([end], [], [], 0.005)[0]:
            continue
        text += os.read(end, 4096)
        *lines, text = text.split(b"\r")
        for line in lines:
            found = re.fullmatch(rb"t([0-9A-F]{3})8([0-9A-F]{16})", line)
            if found is None:
                continue
            identifier, data = int(found[1], 16), bytes.fromhex(found[2].decode())
            answer, motor = None, motors.get(data[0] if identifier == 0x7FF else identifier)
            if motor is not None:
                answer = motor.register(data) if identifier == 0x7FF else motor.take(data)
                os.write(end, f"t{0x10 + motor.node:03X}8{answer.hex().upper()}\r".encode())


@pytest.mark.parametrize("ends", [None, signal.SIGKILL, signal.SIGSTOP])
def test_our_master_drives_motors_of_the_package_and_its_watchdog_outlives_it(
    tmp_path: Path, ends: signal.Signals | None
) -> None:
    """With the octets that the package packs; killed or stopped in mid-motion, every motor is told to leave."""
    import tty

    ours, near = os.openpty()
    for end in (ours, near):
        tty.setraw(end)
    stop, motors = threading.Event(), {node: Motor(node) for node in (1, 15)}
    server = threading.Thread(target=serve, args=(ours, motors, stop))
    server.start()
    path, port = machine(tmp_path / "joint.toml", (1, 15), "DM-J8009"), os.ttyname(near)
    command = [str(PROGRAM), "run", str(path), "--bus", "can", "--interface", port, "--duration", "8", "--unverified"]
    try:
        scan = [str(PROGRAM), "can", "scan", port, "--mit"]
        scanned = subprocess.run(scan, capture_output=True, text=True, timeout=60, check=False)
        assert scanned.returncode == 0 and scanned.stdout.count("damiao") == 2, scanned
        process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        killed = time.monotonic()
        if ends is not None:
            limit = time.monotonic() + 30
            while time.monotonic() < limit and not all(len(motor.velocities) > 120 for motor in motors.values()):
                time.sleep(0.01)
            assert all(motor.power for motor in motors.values())
            killed = time.monotonic()
            process.send_signal(ends)
            time.sleep(WATCHDOG + LATER)
            # Before anything else is said.
            assert not any(motor.power for motor in motors.values())
            process.send_signal(signal.SIGCONT)
        out, err = process.communicate(timeout=60)
        time.sleep(0.1)
    finally:
        stop.set()
        server.join()
        os.close(ours)
        os.close(near)
    for motor in motors.values():
        report = (process.returncode, out, err, motor.told[-20:])
        assert motor.registers[9] == 3200 and len(motor.theirs) > 100, report
        assert all(came == theirs for came, theirs in motor.theirs), motor.theirs
        assert not motor.power and motor.told[-1][1] == 0xFD, report
        if ends is None:
            # Once for the trial of the watchdog, once for the run, with what was not zero in between.
            continue
        left = [at - killed for at, octet in motor.told if octet == 0xFD and at > killed]
        print(f"{ends.name}: told to leave {1e3 * left[0]:.0f} ms after it")
        assert left[0] < WATCHDOG + LATER, report
        assert not [octet for at, octet in motor.told if octet == 0xFC and at > killed], report
