"""Somebody else's CANopen on both sides: PyPI canopen on python-can drives our simulated nodes, and our master its local nodes."""

from __future__ import annotations

import os
import struct
import subprocess
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from program import PROGRAM, ROOT, bare, pseudo_terminals, relay

pytestmark = pseudo_terminals

canopen: Any = pytest.importorskip("canopen", reason="canopen is not installed")
can: Any = pytest.importorskip("can", reason="python-can is not installed")
pytest.importorskip("serial", reason="pyserial is not installed")

U8, U16, U32, I8, I16, I32 = 5, 6, 7, 2, 3, 4
VARIABLES = {
    0x1000: (U32, 0x20192),
    0x1001: (U8, 0),
    0x1017: (U16, 0),
    0x603F: (U16, 0),
    0x6040: (U16, 0),
    0x6041: (U16, 0x40),
    0x6060: (I8, 0),
    0x6061: (I8, 0),
    0x6064: (I32, 0),
    0x6077: (I16, 0),
    0x60FF: (I32, 0),
}
# Number of entries, then the type and value of each.
ARRAYS = {
    0x1016: (1, [(U32, 0)]),
    0x1018: (4, [(U32, 0x123), (U32, 0x456), (U32, 1), (U32, 7)]),
    0x1400: (2, [(U32, 0x200), (U8, 255)]),
    0x1600: (2, [(U32, 0x60400010), (U32, 0x60FF0020), (U32, 0), (U32, 0)]),
    0x1800: (2, [(U32, 0x180), (U8, 255)]),
    0x1A00: (2, [(U32, 0x60410010), (U32, 0x60640020), (U32, 0), (U32, 0)]),
}


def dictionary() -> Any:
    """The objects of a small drive after CiA 402."""
    objects = canopen.ObjectDictionary()

    def variable(index: int, subindex: int, kind: int, value: int) -> Any:
        made = canopen.objectdictionary.ODVariable(f"o{index:x}_{subindex}", index, subindex)
        made.data_type, made.access_type, made.default = kind, "rw", value
        return made

    for index, (kind, value) in VARIABLES.items():
        objects.add_object(variable(index, 0, kind, value))
    for index, (count, entries) in ARRAYS.items():
        record = canopen.objectdictionary.ODRecord(f"o{index:x}", index)
        record.add_member(variable(index, 0, U8, count))
        for subindex, (kind, value) in enumerate(entries, 1):
            record.add_member(variable(index, subindex, kind, value))
        objects.add_object(record)
    return objects


@pytest.fixture
def port() -> Iterator[str]:
    """Path of a terminal behind which the five drives of `finger` answer."""
    command = [str(PROGRAM), "can", "simulate", "finger", "--pty"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout
        path = process.stdout.readline().strip()
        assert "SIMULATED" in process.stdout.readline()
        yield path
        process.terminate()


def test_canopen_enables_simulated_drives(port: str) -> None:
    """Identity, abort codes, mapping, SYNC and the state machine, node by node; then all are moved at once."""
    network = canopen.Network()
    network.connect(interface="slcan", channel=port, bitrate=1_000_000, sleep_after_open=0.1)
    nodes = []
    for k in range(1, 6):
        node = canopen.BaseNode402(k, dictionary())
        network.add_node(node)
        nodes.append(node)
        # A loaded computer exceeds the time-out of 0.3 s now and then.
        node.sdo.RESPONSE_TIMEOUT, node.sdo.MAX_RETRIES = 2.0, 3
        assert node.sdo.upload(0x1008, 0) == b"SIM-DRV1"
        assert node.sdo[0x1018][1].raw == 0x51E37
        with pytest.raises(canopen.SdoAbortedError, match="read only|read-only|0x06010002"):
            node.sdo.download(0x6041, 0, b"\0\0")
        with pytest.raises(canopen.SdoAbortedError, match="0x06020000|exist"):
            node.sdo.upload(0x2000, 0)
        node.nmt.state = "PRE-OPERATIONAL"
        inputs, outputs = node.tpdo[1], node.rpdo[1]
        inputs.clear()
        inputs.add_variable(0x6041)
        inputs.add_variable(0x6064)
        inputs.cob_id, inputs.trans_type, inputs.enabled = 0x180 + k, 1, True
        inputs.save()
        outputs.clear()
        outputs.add_variable(0x6040)
        outputs.add_variable(0x60FF)
        outputs.cob_id, outputs.trans_type, outputs.enabled = 0x200 + k, 255, True
        outputs.save()
        node.sdo[0x6060].raw = 9
        # Our own drives watch no heartbeat unless told to.
        node.nmt.state = "OPERATIONAL"
    network.sync.start(0.01)
    for node in nodes:
        node.setup_402_state_machine(read_pdos=False)
        node.state = "OPERATION ENABLED"
        assert node.state == "OPERATION ENABLED"
    before = [node.sdo[0x6064].raw for node in nodes]
    for node in nodes:
        node.rpdo[1]["o60ff_0"].raw = 2000
        node.rpdo[1].transmit()
    time.sleep(0.5)
    for node in nodes:
        node.rpdo[1]["o60ff_0"].raw = 0
        node.rpdo[1].transmit()
    moved = [node.sdo[0x6064].raw - start for node, start in zip(nodes, before)]
    assert all(abs(counts) > 200 for counts in moved), moved
    for node in nodes:
        node.state = "SWITCH ON DISABLED"
    network.sync.stop()
    network.disconnect()


class Drive:
    """What a canopen LocalNode lacks: process data with SYNC, and the state machine of CiA 402."""

    def __init__(self, network: Any, node: int) -> None:
        self.node = canopen.LocalNode(node, dictionary())
        network.add_node(self.node)
        self.network, self.id = network, node
        self.state, self.next, self.position, self.answered = 0x40, (0, 0), 0.0, 0
        self.states: list[int] = []
        self.velocities: list[int] = []
        self.last = time.monotonic()
        network.subscribe(0x200 + node, lambda _, data, __: setattr(self, "next", struct.unpack("<Hi", data)))
        network.subscribe(0x80, lambda *_: self.synchronize())

    def synchronize(self) -> None:
        if self.node.nmt.state != "OPERATIONAL":
            return
        now = time.monotonic()
        control, velocity = self.next
        enabled = self.state == 0x27
        # A cable that hardly gives: the torque grows with what is wound in.
        self.position += velocity * (now - self.last) if enabled else 0.0
        self.last = now
        torque = max(-1000, min(1000, int(self.position / 20)))
        frame = struct.pack("<Hih", self.state, int(self.position), torque)
        self.network.send_message(0x180 + self.id, frame)
        self.answered += 1
        step = {(0x40, 0x06): 0x21, (0x21, 0x07): 0x23, (0x23, 0x0F): 0x27, (0x27, 0x02): 0x07}
        self.state = step.get((self.state, control), self.state)
        if control & 2 == 0 or (self.state == 0x07 and velocity == 0):
            self.state = 0x40
        if not self.states or self.states[-1] != self.state:
            self.states.append(self.state)
        if enabled:
            self.velocities.append(velocity)


def test_our_master_drives_local_nodes_of_canopen(tmp_path: Path) -> None:
    """Found, configured, enabled and moved in real time; at the end every drive stands without power."""
    import tty

    (ours, near), (theirs, far) = os.openpty(), os.openpty()
    for end in (ours, near, theirs, far):
        tty.setraw(end)
    stop = threading.Event()
    thread = threading.Thread(target=relay, args=([ours, theirs], stop))
    thread.start()
    network = canopen.Network()
    network.connect(interface="slcan", channel=os.ttyname(far), bitrate=1_000_000, sleep_after_open=0.1)
    drives = [Drive(network, node) for node in (1, 2)]
    machine = tmp_path / "joint.toml"
    machine.write_text(bare((ROOT / "models/bench_joint.toml").read_text()))
    try:
        scanned = subprocess.run(
            [str(PROGRAM), "can", "scan", os.ttyname(near)], capture_output=True, text=True, timeout=60, check=False
        )
        assert scanned.returncode == 0 and "0x123" in scanned.stdout, scanned.stdout + scanned.stderr
        command = ["run", str(machine), "--bus", "can", "--interface", os.ttyname(near), "--duration", "6"]
        ran = subprocess.run(
            [str(PROGRAM), *command, "--unverified"], capture_output=True, text=True, timeout=120, check=False
        )
    finally:
        for drive in drives:
            drive.node.nmt.stop_heartbeat()
        stop.set()
        thread.join()
        network.disconnect()
        for end in (ours, near, theirs, far):
            os.close(end)
    for drive in drives:
        report = (ran.returncode, ran.stdout, ran.stderr, drive.states)
        assert 0x27 in drive.states, report
        assert drive.states[-1] == 0x40, report
        assert drive.answered > 20 and any(drive.velocities), report
        assert drive.velocities[-1] == 0, report
        assert drive.node.sdo[0x6060].raw == 9
        assert drive.node.sdo[0x1A00][3].raw == 0x60770010
