"""Sets of joint torques: `TorqueSet` against pycapacity's `joint_torques_polytope` on random muscles, without friction.

    capability.py TORQUE_SET [PROBLEMS]

TORQUE_SET is the example `torque_set`. Prints, for every size, the largest distance between a vertex of one and the nearest
vertex of the other, the largest amount by which a vertex of one lies beyond a half space of the other, both relative to the
size of the set, and the median times: ours of the library's calls, theirs of one call, each the least of several runs. Ends
with 1 where a difference exceeds 1e-6.
"""

import json
import statistics
import subprocess
import sys
import time

import numpy as np
from pycapacity.human import joint_torques_polytope

SIZES = [(4, 2), (6, 2), (6, 3), (8, 3), (15, 3), (6, 4), (9, 4)]
RUNS = 3
BAR = 1e-6


def problem(rng, muscles, joints):
    arms = 0.04 * rng.normal(size=(muscles, joints))
    low = 30.0 * rng.random(muscles)
    return {
        "moment_arms_m": arms.tolist(),
        "min_n": low.tolist(),
        "max_n": (low + 20.0 + 300.0 * rng.random(muscles)).tolist(),
    }


def theirs(p):
    arms = np.array(p["moment_arms_m"])
    least = np.inf
    for _ in range(RUNS):
        start = time.perf_counter()
        polytope = joint_torques_polytope(arms.T, np.array(p["min_n"]), np.array(p["max_n"]))
        least = min(least, time.perf_counter() - start)
    halves = np.atleast_2d(np.array(polytope.H)), np.array(polytope.d).reshape(-1)
    return np.array(polytope.vertices).T, halves, least


def distance(of, to):
    """Largest distance of a point of the first list to the nearest of the second."""
    return max(np.min(np.linalg.norm(to - point, axis=1)) for point in of)


def beyond(vertices, halves):
    normals, offsets = halves
    return float(np.max(vertices @ normals.T - offsets))


def main():
    program, count = sys.argv[1], int(sys.argv[2]) if len(sys.argv) > 2 else 20
    rng = np.random.default_rng(1)
    worst = 0.0
    print("| muscles | joints | vertices | vertices apart | beyond a half space | ours, us | pycapacity, us | factor |")
    print("|---|---|---|---|---|---|---|---|")
    for muscles, joints in SIZES:
        problems = [problem(rng, muscles, joints) for _ in range(count)]
        done = subprocess.run([program], input=json.dumps(problems), capture_output=True, text=True, check=True)
        apart, outside, times = 0.0, 0.0, []
        for p, answer in zip(problems, json.loads(done.stdout)):
            ours = np.array(answer["vertices"])
            halves = np.array(answer["normals"]), np.array(answer["offsets"])
            vertices, their_halves, seconds = theirs(p)
            size = np.max(np.ptp(ours, axis=0))
            apart = max(apart, distance(ours, vertices) / size, distance(vertices, ours) / size)
            outside = max(outside, beyond(ours, their_halves) / size, beyond(vertices, halves) / size)
            times.append((answer["seconds"], seconds))
        own, other = (1e6 * statistics.median(t) for t in zip(*times))
        worst = max(worst, apart, outside)
        print(f"| {muscles} | {joints} | {len(ours)} | {apart:.1e} | {outside:.1e} | {own:.1f} | {other:.0f} | {other / own:.0f} |", flush=True)
    sys.exit(1 if worst > BAR else 0)


if __name__ == "__main__":
    main()
