"""Moves the first joint of a machine a little, once around a sine.

python3 example.py 127.0.0.1 7500 2.0 [KEY FILE]
"""
import json
import math
import sys
import time

from sinew_link import Link

HOLD, RUN, JOINT = 4, 5, 1
address, port, seconds = sys.argv[1], int(sys.argv[2]), float(sys.argv[3])
key = bytes.fromhex(open(sys.argv[4]).read().strip()) if len(sys.argv) > 4 else bytes(32)
link = Link((address, port), key)
link.command(HOLD)
state = None
while state is None or state["joint_count"] == 0:
    state = link.state()
each = state["joint_size"] // 8
start = state["numbers"][2 : each * state["joint_count"] : each]  # the reference of every joint
link.socket.settimeout(0.002)
begin, states = time.monotonic(), 0
while (t := time.monotonic() - begin) < seconds:
    desired = [start[0] + 0.05 * math.sin(2 * math.pi * t / seconds), *start[1:]]
    link.command(RUN, JOINT, [(0, desired)])
    arrived = link.state()
    if arrived:
        state, states = arrived, states + 1
print(json.dumps({"states": states, "accepted": state["accepted"], "lost": state["lost"], "mode": state["mode"]}))
link.close()
