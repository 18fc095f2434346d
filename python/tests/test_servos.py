"""Masters of others on a chain of simulated servos: dynamixel-sdk, rustypot, feetech-servo-sdk; skipped where not installed."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

PROGRAM = Path(os.environ.get("SINEW_PROGRAM", Path(__file__).parents[2] / "target/debug/sinew"))
IDS = [1, 2, 3, 4, 5]
HAND = Path(__file__).parents[2] / "models/two_finger_hand.toml"

pytestmark = [
    pytest.mark.skipif(sys.platform != "linux", reason="pseudo-terminals of Linux"),
    pytest.mark.skipif(not PROGRAM.is_file(), reason=f"{PROGRAM} is not built"),
]


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
    model = 'model = "STS3215"\nno_watchdog = true'
    machine.write_text(HAND.read_text().replace('model = "XM430-W210"', model))
    with simulated(str(machine)) as path:
        yield path


def test_the_sdk_of_the_manufacturer_drives_simulated_servos(port: str) -> None:
    """Ping, broadcast ping, EEPROM that is locked under torque, sync read."""
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
    assert all(reads.getData(k, 132, 4) > 0 for k in IDS)
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
