"""Servos by somebody else: dynamixel-sdk, rustypot and feetech-servo-sdk drive our simulated ones, and our master servos made of the SDK."""

from __future__ import annotations

import json
import os
import select
import struct
import subprocess
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from program import PROGRAM, ROOT, bare, pseudo_terminals

IDS = [1, 2, 3, 4, 5]
HAND = ROOT / "models/two_finger_hand.toml"

pytestmark = pseudo_terminals


@contextmanager
def simulated(machine: str) -> Iterator[str]:
    """Path of a terminal behind which the servos of a machine answer."""
    command = [str(PROGRAM), "servos", "simulate", machine, "--pty"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout
        path = process.stdout.readline().strip()
        assert "SIMULATED" in process.stdout.readline()
        yield path
        process.terminate()


@pytest.fixture
def port() -> Iterator[str]:
    """Path of a terminal behind which the five servos of `finger` answer."""
    with simulated("finger") as path:
        yield path


@pytest.fixture
def feetech(tmp_path: Path) -> Iterator[str]:
    """Path of a terminal behind which the servos of the hand answer as those of the STS series."""
    machine = tmp_path / "hand.toml"
    machine.write_text(HAND.read_text().replace('model = "XM430-W210"', 'model = "STS3215"'))
    with simulated(str(machine)) as path:
        yield path


def test_the_sdk_of_the_manufacturer_drives_simulated_servos(port: str) -> None:
    """Ping, broadcast ping, EEPROM that is locked under torque, sync read and fast sync read."""
    sdk: Any = pytest.importorskip("dynamixel_sdk", reason="dynamixel-sdk is not installed")
    line, packet = sdk.PortHandler(port), sdk.PacketHandler(2.0)
    assert line.openPort() and line.setBaudRate(1_000_000)
    assert packet.ping(line, 3) == (1020, sdk.COMM_SUCCESS, 0)
    found, _ = packet.broadcastPing(line)
    assert sorted(found) == IDS
    assert packet.write1ByteTxRx(line, 1, 64, 1) == (sdk.COMM_SUCCESS, 0)
    assert packet.write1ByteTxRx(line, 1, 11, 1) == (sdk.COMM_SUCCESS, 7), "access is refused under torque"
    assert packet.write1ByteTxRx(line, 1, 64, 0) == (sdk.COMM_SUCCESS, 0)
    assert packet.write1ByteTxRx(line, 1, 11, 1) == (sdk.COMM_SUCCESS, 0)
    assert packet.read1ByteTxRx(line, 1, 11) == (1, sdk.COMM_SUCCESS, 0)
    reads = sdk.GroupSyncRead(line, packet, 132, 4)
    assert all(reads.addParam(k) for k in IDS)
    # A loaded computer exceeds the time-out of the SDK now and then.
    done = [reads.txRxPacket() == sdk.COMM_SUCCESS for _ in range(100)]
    assert sum(done) >= 95
    shown = [reads.getData(k, 132, 4) for k in IDS]
    assert all(position > 0 for position in shown)
    done = [reads.fastSyncRead() == sdk.COMM_SUCCESS for _ in range(20)]
    assert sum(done) >= 18
    assert [reads.getData(k, 132, 4) for k in IDS] == pytest.approx(shown, abs=4)
    line.closePort()


def test_rustypot_reads_simulated_servos_in_one_fast_packet(port: str) -> None:
    """Ping, sync read and fast sync read."""
    rustypot: Any = pytest.importorskip("rustypot", reason="rustypot is not installed")
    servos = rustypot.Xl330PyController(port, 1_000_000, 0.5)
    assert all(servos.ping(k) for k in IDS)
    positions = servos.sync_read_present_position(IDS)
    assert len(positions) == len(IDS)
    servos.set_fast_sync_read(True)
    assert servos.sync_read_present_position(IDS) == pytest.approx(positions, abs=0.01)


def test_the_sdk_of_feetech_drives_simulated_servos(feetech: str) -> None:
    """Ping, read, write, sync read, sync write; what is written without the lock open is lost without power."""
    sdk: Any = pytest.importorskip("scservo_sdk", reason="feetech-servo-sdk is not installed")
    ids = list(range(1, 11))
    line, packet = sdk.PortHandler(feetech), sdk.PacketHandler(0)
    assert line.openPort() and line.setBaudRate(1_000_000)
    assert packet.ping(line, 3) == (777, sdk.COMM_SUCCESS, 0)
    assert packet.ping(line, 11)[1] != sdk.COMM_SUCCESS, "no such servo"
    assert packet.write1ByteTxRx(line, 1, 33, 1) == (sdk.COMM_SUCCESS, 0)
    assert packet.read1ByteTxRx(line, 1, 33) == (1, sdk.COMM_SUCCESS, 0)
    assert packet.read1ByteTxRx(line, 1, 55) == (1, sdk.COMM_SUCCESS, 0), "locked after power-on"
    writes = sdk.GroupSyncWrite(line, packet, 46, 2)
    goal = sdk.SCS_TOSCS(-300, 15)
    assert all(writes.addParam(k, [sdk.SCS_LOBYTE(goal), sdk.SCS_HIBYTE(goal)]) for k in ids)
    assert writes.txPacket() == sdk.COMM_SUCCESS
    word, result, _ = packet.read2ByteTxRx(line, 7, 46)
    assert (sdk.SCS_TOHOST(word, 15), result) == (-300, sdk.COMM_SUCCESS)
    reads = sdk.GroupSyncRead(line, packet, 55, 16)
    assert all(reads.addParam(k) for k in ids)
    # A loaded computer exceeds the time-out of the SDK now and then.
    done = [reads.txRxPacket() == sdk.COMM_SUCCESS for _ in range(100)]
    assert sum(done) >= 90
    assert all(reads.getData(k, 62, 1) == 120 for k in ids), "12 V"
    line.closePort()


def test_rustypot_drives_simulated_servos_of_feetech(feetech: str) -> None:
    """Ping, sync read and sync write by its own table of the STS3215."""
    rustypot: Any = pytest.importorskip("rustypot", reason="rustypot is not installed")
    servos, ids = rustypot.Sts3215PyController(feetech, 1_000_000, 0.5), list(range(1, 11))
    assert all(servos.ping(k) for k in ids)
    assert servos.sync_read_lock(ids) == [1] * 10
    assert servos.sync_read_present_voltage(ids) == [120] * 10
    servos.sync_write_torque_enable(ids, [False] * 10)
    servos.sync_write_mode(ids, [1] * 10)
    assert servos.sync_read_mode(ids) == [1] * 10


def test_a_scan_finds_the_servos_of_both_makers(port: str, feetech: str) -> None:
    """`servos scan` lists identifiers, models and firmware of a line of either."""
    for path, count, model, number in [(port, 5, "XM430-W350", 1020), (feetech, 10, "STS3215", 777)]:
        command = [str(PROGRAM), "servos", "scan", path, "--json"]
        answer = subprocess.run(command, capture_output=True, text=True, check=True, timeout=120)
        found = json.loads(answer.stdout)["found"]
        assert [servo["id"] for servo in found] == list(range(1, count + 1))
        assert {(servo["model"], servo["model_number"]) for servo in found} == {(model, number)}


class Servo:
    """A servo of the X series as its manual has it: a control table, a shaft, and a cable that hardly gives."""

    def __init__(self) -> None:
        self.table = bytearray(1024)
        # Model XM430-W210, and what the factory sets: return delay, operating mode, limit of the velocity.
        self.table[0:2], self.table[9], self.table[11] = struct.pack("<H", 1030), 250, 3
        self.table[44:48], self.table[146] = struct.pack("<I", 330), 30
        for k in range(28):
            struct.pack_into("<H", self.table, 168 + 2 * k, 224 + k)
        self.turned, self.last = 0.0, time.monotonic()
        self.velocities: list[int] = []
        self.torques = [0]

    def place(self, address: int) -> int:
        """Where an octet is: some addresses show those that are written before them."""
        return struct.unpack_from("<H", self.table, 168 + 2 * (address - 224))[0] if 224 <= address < 252 else address

    def read(self, address: int, count: int) -> bytes:
        """Octets of the control table, as they are now."""
        now, powered = time.monotonic(), self.table[64]
        (velocity,) = struct.unpack_from("<i", self.table, 104)
        velocity = velocity if powered else 0
        self.turned += 0.229 / 60 * 4096 * velocity * (now - self.last)
        self.last = now
        # The current grows with what is wound in.
        current = max(-1000, min(1000, int(self.turned / 4)))
        struct.pack_into("<hii", self.table, 126, current, velocity, int(self.turned))
        return bytes(self.table[self.place(at)] for at in range(address, address + count))

    def write(self, address: int, octets: bytes) -> int:
        """Error of an attempt to write: 7, no access, below the torque enable where it is on."""
        if address < 64 and self.table[64]:
            return 7
        for at, octet in enumerate(octets, address):
            self.table[self.place(at)] = octet
        if address == 64 and self.torques[-1] != octets[0]:
            self.torques.append(octets[0])
        if address <= 104 < address + len(octets) and self.table[64]:
            self.velocities.append(struct.unpack_from("<i", self.table, 104)[0])
        return 0


def chain(end: int, servos: dict[int, Servo], sdk: Any, stop: threading.Event) -> None:
    """Answers pings, readings and writings of one and of many; knows no fast sync read, as old firmware."""
    codec, stream = sdk.PacketHandler(2.0), bytearray()

    def status(servo: int, error: int, data: bytes = b"") -> None:
        packet = [0xFF, 0xFF, 0xFD, 0, servo, len(data) + 4, 0, 0x55, error, *data, 0, 0]
        packet = codec.addStuffing(packet)
        crc = codec.updateCRC(0, packet, len(packet) - 2)
        os.write(end, bytes(packet[:-2]) + struct.pack("<H", crc))

    def obey(servo: int, instruction: int, data: bytes) -> None:
        address, rest = struct.unpack("<H", data[:2])[0] if len(data) > 1 else 0, data[2:]
        if instruction == 0x82:
            for k in rest[2:]:
                if k in servos:
                    status(k, 0, servos[k].read(address, struct.unpack("<H", rest[:2])[0]))
        elif instruction == 0x83:
            size = struct.unpack("<H", rest[:2])[0] + 1
            for at in range(2, len(rest), size):
                if rest[at] in servos:
                    servos[rest[at]].write(address, rest[at + 1 : at + size])
        elif servo not in servos:
            return
        elif instruction == 1:
            status(servo, 0, bytes(servos[servo].table[0:2]) + b"\x30")
        elif instruction == 2:
            status(servo, 0, servos[servo].read(address, struct.unpack("<H", rest)[0]))
        elif instruction == 3:
            status(servo, servos[servo].write(address, rest))

    while not stop.is_set():
        if not select.select([end], [], [], 0.1)[0]:
            continue
        try:
            stream += os.read(end, 4096)
        except OSError:
            return
        while len(stream) >= 10 and len(stream) >= 7 + (size := struct.unpack_from("<H", stream, 5)[0]):
            packet = list(stream[: 7 + size])
            del stream[: 7 + size]
            assert packet[:4] == [0xFF, 0xFF, 0xFD, 0], bytes(packet).hex()
            assert codec.updateCRC(0, packet, len(packet) - 2) == packet[-2] | packet[-1] << 8, bytes(packet).hex()
            packet = codec.removeStuffing(packet)
            obey(packet[4], packet[7], bytes(packet[8 : 5 + (packet[5] | packet[6] << 8)]))


def test_our_master_drives_servos_made_of_the_sdk(tmp_path: Path) -> None:
    """Found, configured, enabled and moved in real time by sync read; at the end every servo stands without torque."""
    sdk: Any = pytest.importorskip("dynamixel_sdk", reason="dynamixel-sdk is not installed")
    import tty

    ours, near = os.openpty()
    for end in (ours, near):
        tty.setraw(end)
    stop, servos = threading.Event(), {5: Servo(), 200: Servo()}
    server = threading.Thread(target=chain, args=(ours, servos, sdk, stop))
    server.start()
    source = bare((ROOT / "models/bench_joint.toml").read_text())
    devices = [
        f'[[device]]\nname = "{muscle}"\nmuscle = "{muscle}"\nid = {k}\nmodel = "XM430-W210"\n'
        for muscle, k in (("front", 5), ("back", 200))
    ]
    machine = tmp_path / "joint.toml"
    machine.write_text(source + "\n" + "\n".join(devices))
    try:
        command = ["run", str(machine), "--bus", "servos", "--interface", os.ttyname(near), "--duration", "6"]
        ran = subprocess.run(
            [str(PROGRAM), *command, "--unverified"], capture_output=True, text=True, timeout=120, check=False
        )
    finally:
        stop.set()
        server.join()
        os.close(ours)
        os.close(near)
    for servo in servos.values():
        report = (ran.returncode, ran.stdout, ran.stderr, servo.torques)
        assert servo.torques == [0, 1, 0], report
        assert len(servo.velocities) > 20 and any(servo.velocities), report
        assert servo.velocities[-1] == 0, report
        # Return delay, velocity mode, watchdog of 40 ms.
        assert (servo.table[9], servo.table[11], servo.table[98]) == (0, 1, 2), report
