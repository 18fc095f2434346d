"""Newton's capstan tendon for fifteen cables, in nanoseconds per cable and step of a millisecond, on this machine's processor.

    cable_newton.py            (needs PyPI `newton`)

Each cable runs through eleven fixed eyes in a zigzag, so twelve spans and as much bend as the bench has. One end hangs on a mass
that is driven up and down, the other on a mass that a spring holds. Newton is made for graphics processors and many worlds;
Python calls every step here, so that this is what a user of a desk computer gets and no judgement of its algorithm.
"""

import time

import numpy as np
import warp as wp

import newton
from newton import Axis, TendonGuide, TendonGuideType

CABLES, EYES, STEPS, REPEATS = 15, 11, 64, 12
LENGTH, COMPLIANCE, FRICTION, BEND = 1.667, 2.56e-4, 0.156, 6.3  # m, 1/N, 1, rad

wp.config.quiet = True
builder = newton.ModelBuilder(up_axis=Axis.Z, gravity=(0.0, 0.0, 0.0))
span = LENGTH / (EYES + 1)
turn = BEND / EYES
for cable in range(CABLES):
    y = 0.5 * cable
    # A zigzag with the same bend at every eye.
    x, z = np.cumsum(np.full(EYES + 2, span * np.cos(turn / 2))), np.zeros(EYES + 2)
    z[1::2] = span * np.sin(turn / 2)
    ends = []
    for k in (0, EYES + 1):
        place = wp.vec3(float(x[k]), y, float(z[k]))
        body = builder.add_link(xform=wp.transform(p=place), mass=1.0, inertia=wp.mat33(np.eye(3, dtype=np.float32) * 0.01))
        along = newton.ModelBuilder.JointDofConfig(axis=Axis.X, target_ke=2e4, target_kd=200.0)
        joint = builder.add_joint_d6(parent=-1, child=body, linear_axes=[along], angular_axes=[], parent_xform=wp.transform(p=place))
        builder.add_articulation([joint])
        ends.append(body)
    each = dict(axis=(0.0, 1.0, 0.0), compliance=COMPLIANCE * span, damping=0.0)
    guides = [TendonGuide(body=ends[0], guide_type=TendonGuideType.ANCHOR, axis=each["axis"])]
    for k in range(1, EYES + 1):
        place = (float(x[k]), y, float(z[k]))
        guides.append(TendonGuide(body=-1, guide_type=TendonGuideType.PINHOLE, offset=place, mu=FRICTION, rest_length=0.99 * span, **each))
    guides.append(TendonGuide(body=ends[1], guide_type=TendonGuideType.ANCHOR, rest_length=0.99 * span, **each))
    builder.add_tendon(guides)
with wp.ScopedDevice("cpu"):
    model = builder.finalize()
    for iterations in (1, 8, 32):
        solver = newton.solvers.SolverXPBD(model, iterations=iterations)
        states, control = [model.state(), model.state()], model.control()
        runs = []
        for repeat in range(REPEATS):
            start = time.perf_counter_ns()
            for _ in range(STEPS):
                states[0].clear_forces()
                solver.step(states[0], states[1], control, None, 1e-3)
                states.reverse()
            runs.append((time.perf_counter_ns() - start) / (STEPS * CABLES))
        runs = runs[1:]
        if not np.isfinite(states[0].body_q.numpy()).all():
            raise SystemExit("newton: the simulation failed")
        print(f"newton {newton.__version__} capstan tendon, 12 spans, {iterations} iterations: min {min(runs):.0f}, median {np.median(runs):.0f}")
