"""MuJoCo's and Pinocchio's time for the work of `crates/sinew/benches/body.rs`, in nanoseconds per pose.

    body.py ROBOT.xml

Prints: what, least and median of the repetitions. The loops are Python's; the cost of an empty call is taken off.
"""

import sys
import time

import mujoco
import numpy as np

POSES, REPEATS = 64, 200


def nanoseconds(work, inputs):
    """Least and median over the repetitions of the mean time per call, less those of a call which does nothing."""

    def once(function):
        start = time.perf_counter_ns()
        for value in inputs:
            function(value)
        return (time.perf_counter_ns() - start) / len(inputs)

    taken, idle = ([once(function) for _ in range(REPEATS)] for function in (work, lambda _: None))
    return np.array([min(taken) - min(idle), np.median(taken) - np.median(idle)])


def say(what, times):
    print(f"{what}: least {times[0]:.0f} ns, median {times[1]:.0f} ns")


def main():
    model = mujoco.MjModel.from_xml_path(sys.argv[1])
    rng, states = np.random.default_rng(1), []
    for _ in range(POSES):
        data = mujoco.MjData(model)
        for j in range(model.njnt):
            low, high = model.jnt_range[j] if model.jnt_limited[j] else (-1.0, 1.0)
            data.qpos[model.jnt_qposadr[j]] = rng.uniform(low, high)
        data.qvel[:] = rng.normal(size=model.nv)
        mujoco.mj_forward(model, data)
        states.append((data, np.zeros(model.nv)))

    def muscles(pair):
        mujoco.mj_kinematics(model, pair[0])
        mujoco.mj_comPos(model, pair[0])
        mujoco.mj_tendon(model, pair[0])

    say("mujoco kinematics+comPos+tendon", nanoseconds(muscles, states))
    say("mujoco tendon alone", nanoseconds(lambda pair: mujoco.mj_tendon(model, pair[0]), states))
    rne = nanoseconds(lambda pair: mujoco.mj_rne(model, pair[0], 1, pair[1]), states)
    both = nanoseconds(lambda pair: (mujoco.mj_kinematics(model, pair[0]), mujoco.mj_comPos(model, pair[0]),
                                   mujoco.mj_comVel(model, pair[0])), states)
    say("mujoco inverse dynamics with kinematics", rne + both)
    try:
        import pinocchio
    except ImportError:
        return
    arm, parent = pinocchio.Model(), 0
    for k in range(7):
        axis = rng.normal(size=3)
        parent = arm.addJoint(
            parent, pinocchio.JointModelRevoluteUnaligned(axis / np.linalg.norm(axis)), pinocchio.SE3.Random(), f"j{k}"
        )
        arm.appendBodyToJoint(parent, pinocchio.Inertia.Random(), pinocchio.SE3.Identity())
    data, states = arm.createData(), [tuple(rng.normal(size=(3, 7))) for _ in range(POSES)]
    work = nanoseconds(lambda state: pinocchio.rnea(arm, data, *state), states)
    say("pinocchio rnea of seven joints, called from Python", work)


if __name__ == "__main__":
    main()
