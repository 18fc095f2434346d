"""moteus by somebody else on both sides: PyPI moteus on the text of its adapter, an fdcanusb on a pseudo-terminal."""

from __future__ import annotations

import asyncio
import io
import math
import os
import select
import subprocess
import threading
import time
from pathlib import Path
from typing import Any

import pytest
from program import PROGRAM, ROOT, bare, pseudo_terminals

pytestmark = pseudo_terminals

moteus: Any = pytest.importorskip("moteus", reason="moteus is not installed")
from moteus import multiplex, protocol  # type: ignore[import-not-found]  # noqa: E402

WRITE = multiplex.SubframeType.WRITE
READ = multiplex.SubframeType.READ


def machine(path: Path, nodes: tuple[int, int]) -> Path:
    """The bench joint with two controllers, the second of which counts up while it pays out."""
    source = (ROOT / "models/bench_joint.toml").read_text()
    tables = [
        f'[[device]]\nname = "{muscle}"\nmuscle = "{muscle}"\nnode = {node}\nprotocol = "moteus"\n'
        f"counts_per_turn = {turn}\n"
        for muscle, node, turn in zip(("front", "back"), nodes, (1, -1))
    ]
    path.write_text(bare(source) + "\n" + "\n".join(tables))
    return path


def test_controllers_of_the_package_drive_simulated_ones(tmp_path: Path) -> None:
    """Identity, position mode with a velocity, limits of time, stop, all through the package's own adapter."""
    command = [str(PROGRAM), "can", "simulate", str(machine(tmp_path / "joint.toml", (1, 99))), "--pty"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout
        path = process.stdout.readline().strip()
        assert "SIMULATED" in process.stdout.readline()
        try:
            asyncio.run(drive(path))
        finally:
            process.terminate()


async def drive(path: str) -> None:
    """Two controllers after one another."""
    adapter = moteus.Fdcanusb(path)
    mode, position, fault = (moteus.Register[name] for name in ("MODE", "POSITION", "FAULT"))
    for node in (1, 99):
        controller = moteus.Controller(id=node, transport=adapter)
        first = (await controller.set_stop(query=True)).values
        assert (first[mode], first[fault]) == (0, 0) and math.isfinite(first[position])
        assert first[moteus.Register.VOLTAGE] == 24.0
        identity = await controller.custom_query({moteus.Register.REGISTER_MAP_VERSION: moteus.INT32})
        assert identity.values[moteus.Register.REGISTER_MAP_VERSION] == 5
        end = time.monotonic() + 0.6
        while time.monotonic() < end:
            shown = await controller.set_position(
                position=math.nan, velocity=0.5, maximum_torque=0.2, watchdog_timeout=0.2, query=True
            )
            await asyncio.sleep(0.005)
        assert shown.values[mode] == 10
        assert 0.1 < shown.values[position] - first[position] < 0.5, (first, shown)
        # Silence: it times out, and takes no command until it is stopped.
        await asyncio.sleep(0.5)
        assert (await controller.query()).values[mode] == 11
        for _ in range(3):
            await controller.set_position(position=math.nan, velocity=0.5, query=True)
            await asyncio.sleep(0.02)
        assert (await controller.query()).values[mode] == 11
        stopped = (await controller.set_stop(query=True)).values
        assert stopped[mode] == 0
        # In the integers of the protocol, too.
        coarse = moteus.QueryResolution()
        coarse.position, coarse.velocity, coarse.torque = moteus.INT32, moteus.INT16, moteus.INT8
        shown = (await controller.query(query_override=coarse)).values
        assert abs(shown[position] - stopped[position]) < 1e-3, (shown, stopped)
        refused = await controller.custom_query({0x7FF: moteus.INT8})
        assert 0x7FF not in refused.values


class Motor:
    """A controller by the package's encoder and decoder, whose motor follows at once."""

    def __init__(self, node: int) -> None:
        self.node, self.mode, self.position, self.velocity = node, 0, 0.0, 0.0
        self.timeout, self.fed, self.last = 0.1, time.monotonic(), time.monotonic()
        self.modes = [0]
        self.velocities: list[float] = []
        self.theirs: list[tuple[bytes, bytes]] = []
        self.torques: set[float] = set()

    def move(self) -> None:
        """Time passes."""
        now = time.monotonic()
        self.position += (now - self.last) * self.velocity if self.mode == 10 else 0.0
        self.last = now
        if self.mode == 10 and now - self.fed > self.timeout:
            self.mode = 11
        if self.modes[-1] != self.mode:
            self.modes.append(self.mode)

    def compare(self, data: bytes, written: dict[int, float], asked: list[int]) -> None:
        """What the package would send with the same values, beside what came."""
        controller = moteus.Controller(id=self.node)
        if written.get(0) == 10:
            command = controller.make_position(
                position=written[0x20],
                velocity=written[0x21],
                maximum_torque=written[0x25],
                watchdog_timeout=written[0x27],
                query=True,
            )
        elif written.get(0) == 0:
            command = controller.make_stop(query=True)
        elif 0 in asked:
            command = controller.make_query()
        else:
            registers = dict.fromkeys(range(0x100, 0x103), moteus.INT32)
            command = controller.make_custom_query(registers)
        self.theirs.append((data, command.data))

    def answer(self, data: bytes) -> bytes:
        """A frame to it, and its answer."""
        self.move()
        frames = list(multiplex.parse_frame(data))
        written = {part.register: part.value for part in frames if part.type == WRITE}
        asked = [(part.register, part.resolution) for part in frames if part.type == READ]
        self.compare(data, written, [register for register, _ in asked])
        if written.get(0) == 0:
            self.mode = 0
        if written.get(0) == 10:
            assert math.isnan(written[0x20])
            self.fed, self.velocity, self.timeout = time.monotonic(), written[0x21], written[0x27]
            self.torques.add(written[0x25])
            self.mode = 10 if self.mode == 0 else self.mode
            self.velocities.append(self.velocity)
        self.move()
        # A cable that hardly gives: the torque grows with what is wound in.
        torque = max(-0.1, min(0.1, 0.01 * self.position))
        values = {0: self.mode, 1: self.position, 2: self.velocity, 3: torque, 0xD: 24.0, 0xE: 30.0, 0xF: 0}
        values |= {0x100: 0x204, 0x101: 0x10D, 0x102: 5}
        buffer = io.BytesIO()
        writer = protocol.Writer(buffer)
        for register, resolution in asked:
            writer.write_int8(0x21 | resolution << 2)
            writer.write_varuint(register)
            value = values[register]
            if register == 0xD:
                writer.write_voltage(value, resolution)
            elif register in (1, 2, 3):
                writer.write_position(value, resolution)
            else:
                writer.write_int(value, resolution)
        return buffer.getvalue()


def serve(end: int, motors: dict[int, Motor], stop: threading.Event) -> None:
    """An fdcanusb with controllers."""
    text = b""
    while not stop.is_set():
        if not select.select([end], [], [], 0.005)[0]:
            continue
        text += os.read(end, 4096)
        *lines, text = text.split(b"\n")
        for words in (line.split() for line in lines if line):
            assert words[:2] == [b"can", b"send"] and words[4] == b"BF", words
            os.write(end, b"OK\r\n")
            identifier = int(words[2], 16)
            assert identifier & 0xFF00 == 0x8000
            motor = motors.get(identifier & 0xFF)
            if motor is not None:
                # As it comes on the wire: in one of the lengths that there are.
                data = motor.answer(bytes.fromhex(words[3].decode()))
                size = next(size for size in (*range(9), 12, 16, 20, 24, 32, 48, 64) if size >= len(data))
                shown = (data + bytes([0x50]) * (size - len(data))).hex().upper()
                os.write(end, f"rcv {motor.node << 8:x} {shown} BF\r\n".encode())


def test_our_master_drives_controllers_of_the_package(tmp_path: Path) -> None:
    """Found, its watchdog tried, enabled and moved in real time, with the octets that the package sends."""
    import tty

    ours, near = os.openpty()
    for end in (ours, near):
        tty.setraw(end)
    stop, motors = threading.Event(), {node: Motor(node) for node in (1, 126)}
    server = threading.Thread(target=serve, args=(ours, motors, stop))
    server.start()
    path, port = machine(tmp_path / "joint.toml", (1, 126)), os.ttyname(near)
    try:
        command = [str(PROGRAM), "can", "scan", port, "--fd"]
        scanned = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
        assert scanned.returncode == 0 and scanned.stdout.count("firmware 0x010d") == 2, scanned
        command = [str(PROGRAM), "run", str(path), "--bus", "can", "--interface", port, "--duration", "6"]
        ran = subprocess.run([*command, "--unverified"], capture_output=True, text=True, timeout=120, check=False)
    finally:
        stop.set()
        server.join()
        os.close(ours)
        os.close(near)
    for motor in motors.values():
        report = (ran.returncode, ran.stdout, ran.stderr, motor.modes)
        # Once for its watchdog, which ends it, once for the run.
        assert motor.modes.count(10) == 2 and 11 in motor.modes and motor.modes[-1] == 0, report
        assert len(motor.velocities) > 20 and any(motor.velocities), report
        assert motor.velocities[-1] == 0.0, report
        assert len(motor.torques) == 1 and motor.torques.pop() > 0.0
        assert len(motor.theirs) > 100
        for came, theirs in motor.theirs:
            padding = came[len(theirs) :]
            assert came[: len(theirs)] == theirs and set(padding) <= {0x50}, (came.hex(), theirs.hex())
