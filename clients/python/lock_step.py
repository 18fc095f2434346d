"""Drives a machine on virtual time: all joints on small sines around where they are held, in steps of 0.2 s.

sinew run planar_leg --link 127.0.0.1:7500 --virtual-time &
python3 lock_step.py 127.0.0.1 7500 3600 [KEY FILE]
"""
import json
import math
import sys
import time

from sinew_link import Link

RUN, TURN_OFF, JOINT, MS = 5, 1, 1, 1_000_000
STEP, SPACING, AMPLITUDE, PERIOD = 200 * MS, 20 * MS, 0.05, 8.0
address, port, seconds = sys.argv[1], int(sys.argv[2]), float(sys.argv[3])
key = bytes.fromhex(open(sys.argv[4]).read().strip()) if len(sys.argv) > 4 else bytes(32)
link = Link((address, port), key, 60.0)


def advance(goal, setpoint=0, points=()):
    """Lets the machine's time go on to the goal, ns; asks again where nothing comes back."""
    for _ in range(600):
        link.command(RUN, setpoint, points, goal)
        while state := link.state():
            if state["machine_time_ns"] >= goal:
                return state
    raise TimeoutError(f"the machine does not reach {goal} ns")


started, state = time.monotonic(), advance(0)
begin = state["machine_time_ns"] // STEP * STEP
mode_at_begin = state["mode"]
while state["mode"] != RUN - 1:  # the number of the mode Run is 4
    begin += STEP
    state = advance(begin)
    if begin > 60e9:
        raise TimeoutError(f"the machine is in mode {state['mode']} after a minute")
first = begin
each = state["joint_size"] // 8
held = state["numbers"][2 : each * state["joint_count"] : each]
ends, worst, steps = begin + round(seconds * 1e9), 0.0, 0
while begin < ends and state["mode"] == RUN - 1:
    times = range(begin + SPACING, begin + STEP + 3 * SPACING, SPACING)
    phase = [2 * math.pi * (t - first) * 1e-9 / PERIOD for t in times]
    points = [(t, [q + AMPLITUDE * (1 - math.cos(p)) / 2 for q in held]) for t, p in zip(times, phase)]
    begin += STEP
    state, steps = advance(begin, JOINT, points), steps + 1
    joints = state["numbers"][: each * state["joint_count"]]
    worst = max(worst, *(abs(q - r) for q, r in zip(joints[0::each], joints[2::each])))
print(json.dumps({
    "machine_s": begin * 1e-9, "steps": steps, "mode_at_begin": mode_at_begin, "mode": state["mode"],
    "fault": state["fault"], "largest_error": worst, "late": state["late"], "lost": state["lost"],
    "rejected": state["rejected"], "seconds": time.monotonic() - started,
}))
link.close()
