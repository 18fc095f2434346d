"""The built-in arm in MuJoCo, its cables those of this library, beside the library's own simulated machine.

Run: `python python/examples/arm_beside_twin.py`. Needs MuJoCo. A twin is driven by its controller along a motion of
the elbow, and the winches of the model in MuJoCo are where the encoders of the twin's winches are. All data are
simulated. The first twin is the machine as designed, the second a specimen that deviates within the tolerances of its
manufacture and has effects that no model knows.
"""

from __future__ import annotations

import mujoco
import numpy as np

import sinew
import sinew.mujoco


def largest_difference(specimen: int | None, seconds: float = 2.5) -> tuple[float, float]:
    """Largest motion of a joint of the twin, rad, and its largest difference from MuJoCo."""
    arm = sinew.Machine("lm_arm")
    twin, controller = sinew.Twin(arm, seed=specimen), arm.controller()
    target = {"elbow_flexion": float(arm.start[arm.joint_names.index("elbow_flexion")]) + 0.6}
    trajectory = arm.plan(target, duration_s=2.0)
    model = sinew.mujoco.load(arm, cells=24, substeps=2, tension_n=twin.tension_out)
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    start, zero = np.array(twin.q), np.array(twin.measured_motor)
    moved = difference = 0.0
    for k in range(round(1e3 * seconds)):
        now, ahead = trajectory.sample(1e-3 * k), trajectory.sample(1e-3 * k + 0.12)
        measured = twin.measured_motor, twin.measured_tension, twin.measured_joint
        command = controller.step(*measured, *now, previewed=ahead)
        twin.step(command.speed)
        data.ctrl[:] = twin.measured_motor - zero
        mujoco.mj_step(model, data)
        moved = max(moved, float(np.abs(twin.q - start).max()))
        difference = max(difference, float(np.abs(data.qpos - twin.q).max()))
    return moved, difference


def main() -> None:
    """Prints both."""
    for name, specimen in (("as designed", None), ("specimen 3", 3)):
        moved, difference = largest_difference(specimen)
        print(
            f"{name}: joints moved by up to {moved:.2f} rad; twin and MuJoCo differ by up to {1e3 * difference:.0f} mrad"
        )


if __name__ == "__main__":
    main()
