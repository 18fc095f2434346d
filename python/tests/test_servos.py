"""Masters of others on a chain of simulated servos: dynamixel-sdk and rustypot, each skipped where it is not installed."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

PROGRAM = Path(os.environ.get("SINEW_PROGRAM", Path(__file__).parents[2] / "target/debug/sinew"))
IDS = [1, 2, 3, 4, 5]

pytestmark = [
    pytest.mark.skipif(sys.platform != "linux", reason="pseudo-terminals of Linux"),
    pytest.mark.skipif(not PROGRAM.is_file(), reason=f"{PROGRAM} is not built"),
]


@pytest.fixture
def port() -> Iterator[str]:
    """Path of a terminal behind which the five servos of `finger` answer."""
    command = [str(PROGRAM), "servos", "simulate", "finger", "--pty"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout
        path = process.stdout.readline().strip()
        assert "SIMULATED" in process.stdout.readline()
        yield path
        process.terminate()


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
