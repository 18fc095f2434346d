"""A client of the link with the standard library alone, written from docs/link.md and nothing else.

python3 from_the_page.py HOST PORT SECONDS [KEY FILE]
"""
import hashlib
import hmac
import json
import math
import os
import re
import socket
import struct
import sys
import time
from pathlib import Path

PAGE = Path(__file__).resolve().parents[4] / "docs" / "link.md"
HEAD = struct.Struct("<4sBBHQQQQQQ")
STATE = struct.Struct("<QQBBBBHHHBHHxQQQQ3d6H")
MAX = 1232
HELLO, WELCOME, REFUSED, COMMAND, STATE_KIND, GOODBYE, WATCH = range(1, 8)


def tag_of(key, data):
    return hmac.new(key, data, hashlib.sha256).digest()


def session_keys(key, client_nonce, host_nonce):
    nonces = client_nonce + host_nonce
    return tag_of(key, b"sinew-link 1 client" + nonces), tag_of(key, b"sinew-link 1 host" + nonces)


def packet(key, kind, session, sequence, reflected, sent_ns, body):
    length = HEAD.size + len(body) + 32
    head = HEAD.pack(b"SNWL", 2, kind, length, session, sequence, reflected[0], sent_ns, reflected[1], reflected[2])
    return head + body + tag_of(key, head + body)


def check_worked_example():
    """The bytes of the page's example come out."""
    cells = dict(re.findall(r"^\| ([^|]+) \| `([0-9a-f]+)` \|$", PAGE.read_text(encoding="utf-8"), re.MULTILINE))
    key, client_nonce, host_nonce = (bytes.fromhex(cells[name]) for name in ("pre-shared key", "`client_nonce`", "`host_nonce`"))
    keys = session_keys(key, client_nonce, host_nonce)
    assert [k.hex() for k in keys] == [cells["key of the client"], cells["key of the host"]]
    session = int.from_bytes(host_nonce[:8], "little")
    goodbye = packet(keys[0], GOODBYE, session, 1, (0, 0, 0), 1000, b"")
    assert goodbye.hex() == cells["a Goodbye, `sequence` 1, `time_ns` 1000"]


class Client:
    def __init__(self, address, key, watch=False):
        self.address, self.key, self.role = address, key, int(watch)
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.sequence, self.newest, self.seen = 0, None, set()
        self.parts, self.refused, self.round_trips = {}, 0, []

    def connect(self, seconds):
        nonce, end = os.urandom(16), time.monotonic() + seconds
        while time.monotonic() < end:
            body = nonce + bytes([self.role]) + bytes(87)
            hello = packet(self.key, HELLO, 0, 0, (0, 0, 0), time.monotonic_ns(), body)
            self.socket.sendto(hello, self.address)
            data = self.receive(0.1)
            if data is None or not self.is_sound(data, self.key) or data[56:72] != nonce:
                continue
            kind = data[5]
            if kind == REFUSED:
                self.refused = data[72]
                time.sleep(0.1)
                continue
            if kind != WELCOME or len(data) != 56 + 104 + 32:
                continue
            host_nonce, machine = struct.unpack_from("<16s32s", data, 56 + 16)
            fields = struct.unpack_from("<HHIQQQQ", data, 56 + 64)
            names = "joints muscles features period_ns state_period_ns playout_delay_ns timeout_ns".split()
            self.welcome = dict(zip(names, fields), machine=machine.rstrip(b"\0").decode())
            self.session = int.from_bytes(host_nonce[:8], "little")
            self.client_key, self.host_key = session_keys(self.key, nonce, host_nonce)
            return True
        return False

    def receive(self, seconds):
        self.socket.settimeout(seconds)
        try:
            return self.socket.recv(2048)
        except (TimeoutError, socket.timeout, BlockingIOError, ConnectionError):
            return None

    @staticmethod
    def is_sound(data, key):
        if not 88 <= len(data) <= MAX or data[:4] != b"SNWL" or data[4] != 2:
            return False
        if int.from_bytes(data[6:8], "little") != len(data):
            return False
        return hmac.compare_digest(tag_of(key, data[:-32]), data[-32:])

    def send(self, kind, body=b""):
        self.sequence += 1
        now = time.monotonic_ns()
        reflected = (0, 0, 0) if self.newest is None else (self.newest[0], self.newest[1], now - self.newest[2])
        data = packet(self.client_key, kind, self.session, self.sequence, reflected, now, body)
        self.socket.sendto(data, self.address)

    def command(self, request=0, kind=0, points=()):
        values = len(points[0][1]) if points else 0
        assert len(points) <= (MAX - 56 - 16 - 32) // (8 + 8 * values) or not points
        body = struct.pack("<BBHHHQ", request, kind, values, len(points), 0, 0)
        for at_ns, numbers in points:
            body += struct.pack(f"<Q{values}d", at_ns, *numbers)
        self.send(COMMAND, body)

    def state(self, seconds):
        """The newest whole state, none where none came in time."""
        end = time.monotonic() + seconds
        while (left := end - time.monotonic()) > 0:
            data = self.receive(left)
            if data is None or not self.is_sound(data, self.host_key) or data[5] != STATE_KIND:
                continue
            _, _, _, _, session, sequence, mine, sent_ns, mine_ns, held_ns = HEAD.unpack_from(data)
            newest = self.newest[0] if self.newest else 0
            if session != self.session or sequence in self.seen or sequence + 64 <= newest:
                continue
            self.seen.add(sequence)
            now = time.monotonic_ns()
            if sequence > newest:
                self.newest = (sequence, sent_ns, now)
                if mine:
                    self.round_trips.append(now - mine_ns - held_ns)
            whole = self.part(data[56:-32])
            if whole:
                return whole
        return None

    def part(self, body):
        names = ("machine_time_ns cycle mode request setpoint flags fault fault_index queued last_rejection joint_size muscle_size accepted lost "
                 "rejected late x y z joints muscles first_joint joint_count first_muscle muscle_count").split()
        head = dict(zip(names, STATE.unpack_from(body)))
        each, of_muscle = head["joint_size"], head["muscle_size"]
        assert len(body) == 100 + each * head["joint_count"] + of_muscle * head["muscle_count"]
        joints, muscles = self.parts.setdefault(head["cycle"], ({}, {}))
        for k in range(head["joint_count"]):
            joints[head["first_joint"] + k] = struct.unpack_from("<3d", body, 100 + each * k)
        begin = 100 + each * head["joint_count"]
        for k in range(head["muscle_count"]):
            muscles[head["first_muscle"] + k] = struct.unpack_from("<4d", body, begin + of_muscle * k)
        if len(joints) < head["joints"] or len(muscles) < head["muscles"]:
            return None
        self.parts = {cycle: part for cycle, part in self.parts.items() if cycle > head["cycle"]}
        return dict(head, joint=joints, muscle=muscles)


def wait(client, what, holds, send, seconds=5.0):
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        send()
        state = client.state(0.02)
        if state and holds(state):
            return state
    raise SystemExit(f"expected {what} within {seconds} s")


def main():
    check_worked_example()
    address, seconds = (sys.argv[1], int(sys.argv[2])), float(sys.argv[3])
    key = bytes.fromhex(Path(sys.argv[4]).read_text().strip()) if len(sys.argv) > 4 else bytes(32)
    client = Client(address, key)
    assert client.connect(5.0), "no session"
    hold, run, joint = 4, 5, 1
    state = wait(client, "a hold", lambda s: s["request"] == hold, lambda: client.command(hold))
    assert [state["joints"], state["muscles"]] == [client.welcome["joints"], client.welcome["muscles"]]
    start = [state["joint"][k][2] for k in range(state["joints"])]
    second = Client(address, key)
    assert not second.connect(0.3) and second.refused == 1, "a second client commands"
    watcher = Client(address, key, watch=True)
    assert watcher.connect(2.0), "no session that watches"
    begin, states, watched = time.monotonic(), 0, 0
    watcher.send(WATCH)
    while (t := time.monotonic() - begin) < seconds:
        desired = [start[0] + 0.05 * math.sin(2 * math.pi * t / seconds), *start[1:]]
        client.command(run, joint, [(0, desired)])
        if (arrived := client.state(0.004)) is not None:
            state, states = arrived, states + 1
        if watcher.state(0.001) is not None:
            watched += 1
        watcher.send(WATCH)
    assert state["request"] == run and state["setpoint"] == joint and state["last_rejection"] == 0, state
    assert 0 < state["accepted"] <= client.sequence and state["lost"] <= 3, state
    assert states > 10 and watched > 10, (states, watched)
    assert all(0 < trip < 2e9 for trip in client.round_trips) and client.round_trips
    print(json.dumps({"states": states, "watched": watched, "accepted": state["accepted"], "mode": state["mode"]}))
    watcher.send(GOODBYE)
    client.send(GOODBYE)


main()
