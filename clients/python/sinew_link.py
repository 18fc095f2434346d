"""A client of a Sinew link with the standard library alone; docs/link.md documents every byte."""
import hmac, os, socket, struct, time

STOPS = TURN_OFF, GET_READY, SAFE_STOP = 1, 2, 6
HEAD, STATE = struct.Struct("<4sBBH6Q"), struct.Struct("<QQ4B3HBHHx4Q3d6H")
NAMES = ("machine_time_ns cycle mode request setpoint flags fault fault_index queued last_rejection joint_size muscle_size accepted lost "
         "rejected late x y z joints muscles first_joint joint_count first_muscle muscle_count").split()

class Link:
    def __init__(self, address, key=bytes(32), seconds=5.0):
        self.socket = socket.socket(socket.AF_INET6 if ":" in address[0] else socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.settimeout(0.1)
        self.address, self.keys, nonce, end = address, (key, key), os.urandom(16), time.monotonic() + seconds
        self.session, self.sent, self.newest, self.heard, self.held, self.reflected = 0, 0, 0, 0, 0, 0
        self.stop, self.asked = None, 0  # a stop that was asked for and not yet taken, and the packet that asked first
        while self.session == 0:  # asked again until a host answers and its session is free
            if time.monotonic() > end: raise TimeoutError(f"{address}: expected a session within {seconds} s, got none")
            self.send(1, nonce + bytes(88))
            kind, body = self.receive()
            if kind == 2 and body[:16] == nonce:
                self.session, = struct.unpack("<Q", body[16:24])
                self.keys = [hmac.digest(key, b"sinew-link 1 " + side + body[:32], "sha256") for side in (b"client", b"host")]
            elif kind: time.sleep(0.1)
    def send(self, kind, body):
        self.sent, now = self.sent + (kind != 1), time.monotonic_ns()
        data = HEAD.pack(b"SNWL", 2, kind, 88 + len(body), self.session, self.sent, self.newest, now, self.heard,
                         now - self.held if self.newest else 0) + body
        self.socket.sendto(data + hmac.digest(self.keys[0], data, "sha256"), self.address)
    def receive(self):  # kind and body of the next valid datagram; kind 0 where none came within 0.1 s
        try: data = self.socket.recv(2048)
        except OSError: return 0, b""
        if len(data) < 88 or not hmac.compare_digest(hmac.digest(self.keys[1], data[:-32], "sha256"), data[-32:]): return 0, b""
        _, version, kind, _, session, sequence, reflected, sent_ns, _, _ = HEAD.unpack_from(data)
        if version != 2 or session != self.session or kind == 5 and sequence <= self.newest: return 0, b""
        self.newest, self.heard, self.held, self.reflected = sequence, sent_ns, time.monotonic_ns(), reflected
        return kind, data[56:-32]
    def command(self, request=0, setpoint=0, points=(), advance_to_ns=0):  # points: (time stamp in ns or 0, numbers)
        stop = (request, 0, (), advance_to_ns) if request in STOPS else None
        if request and stop != self.stop: self.stop, self.asked = stop, self.sent + 1
        head = struct.pack("<BBHHxxQ", request, setpoint, len(points[0][1]) if points else 0, len(points), advance_to_ns)
        self.send(4, head + b"".join(struct.pack(f"<Q{len(numbers)}d", at, *numbers) for at, numbers in points))
    def state(self):  # one datagram of a state by NAMES, `numbers` of its joints (`joint_size` / 8 each) and muscles; None: none
        kind, body = self.receive()
        if kind != 5: return None
        state = dict(zip(NAMES, STATE.unpack_from(body)), numbers=struct.unpack(f"<{len(body) // 8 - 12}d", body[100:]))
        if self.stop and state["request"] == self.stop[0] and self.reflected >= self.asked: self.stop = None
        return state
    def close(self, seconds=1.0):  # False where a stop that was asked for, again and again until then, is not taken in time
        end = time.monotonic() + seconds
        while self.stop and time.monotonic() < end: self.command(*self.stop), self.state()
        self.send(6, b""), self.socket.close()
        return self.stop is None
