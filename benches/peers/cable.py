"""MuJoCo's time for fifteen cables, in nanoseconds per cable and step of a millisecond.

    cable.py

Prints: what, minimum and median of the repetitions. `mj_step` does its steps without Python in between.

MuJoCo has no friction in proportion to tension, so none of its models is a cable in a sheath. Two come near:
- nodes: twelve beads on slides, springs between them, each with a dry friction of its own that tension does not change;
- tendon: a spring from end to end whose dry friction is one number: no slip front, no memory along the cable.
"""

import time

import mujoco
import numpy as np

CABLES, CELLS, STEPS, REPEATS = 15, 12, 256, 40
STIFFNESS, FRICTION = 24e3, 5.0  # N/m of the whole cable, N from end to end
# kg: its springs are explicit, and lighter beads than this fly apart at a step of a millisecond.
MASS = 1.0


def xml(bodies, tendons, actuators, jacobian):
    return f"""<mujoco><option timestep="0.001" integrator="implicitfast" jacobian="{jacobian}"><flag contact="disable" gravity="disable"/></option>
    <worldbody>{bodies}</worldbody><tendon>{tendons}</tendon><actuator>{actuators}</actuator></mujoco>"""


def bead(name, friction):
    return (f'<body name="{name}"><joint name="{name}" type="slide" axis="1 0 0" damping="20" frictionloss="{friction}"/>'
            f'<geom size="0.01" mass="{MASS}"/></body>')


def spring(one, other, stiffness, friction=0.0):
    return (f'<fixed stiffness="{stiffness}" springlength="0" frictionloss="{friction}">'
            f'<joint joint="{one}" coef="1"/><joint joint="{other}" coef="-1"/></fixed>')


def model(cells, bead_friction, tendon_friction, cables, jacobian):
    bodies, tendons, actuators = "", "", ""
    for c in range(cables):
        names = [f"c{c}n{k}" for k in range(cells + 1)]
        bodies += "".join(bead(n, bead_friction if 0 < k < cells else 0.0) for k, n in enumerate(names))
        tendons += "".join(spring(a, b, STIFFNESS * cells, tendon_friction) for a, b in zip(names, names[1:]))
        # The ends are held by stiff servos: motor and anchor.
        actuators += "".join(f'<position joint="{n}" kp="1e5" kv="100"/>' for n in (names[0], names[-1]))
    return mujoco.MjModel.from_xml_string(xml(bodies, tendons, actuators, jacobian))


def times(name, model, cables):
    data, runs = mujoco.MjData(model), []
    data.ctrl[::2] = 3e-3
    mujoco.mj_step(model, data, nstep=STEPS)
    for k in range(REPEATS):
        data.ctrl[::2] = 3e-3 + 2e-3 * np.sin(0.4 * k)
        start = time.perf_counter_ns()
        mujoco.mj_step(model, data, nstep=STEPS)
        runs.append((time.perf_counter_ns() - start) / (STEPS * cables))
    if not np.isfinite(data.qpos).all() or data.warning.number.any():
        raise SystemExit(f"{name}: the simulation failed")
    print(f"mujoco {mujoco.__version__} {name}: min {min(runs):.0f}, median {np.median(runs):.0f}")


def main():
    # Dense or sparse, together or each cable alone: whichever suits it best is for the reader to pick.
    for cables in (CABLES, 1):
        for jacobian in ("dense", "sparse"):
            how = f"{cables} in a model, {jacobian}"
            times(f"nodes, {how}", model(CELLS, FRICTION / CELLS, 0.0, cables, jacobian), cables)
            times(f"tendon, {how}", model(1, 0.0, FRICTION, cables, jacobian), cables)


if __name__ == "__main__":
    main()
