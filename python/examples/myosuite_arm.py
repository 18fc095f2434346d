"""The MyoSuite arm, or any other MuJoCo model with tendons, with a sheath on every driven tendon.

Run: `python python/examples/myosuite_arm.py MODEL.xml`, for example `myo_sim/arm/myoarm.xml` of MyoSuite. Needs
MuJoCo. Prints the time of a step with and without sheaths, and the work that friction takes under random activations.
"""

from __future__ import annotations

import sys
import time

import mujoco
import numpy as np

import sinew.mujoco


def steps(model: mujoco.MjModel, count: int) -> tuple[float, float, float]:
    """Microseconds a step, and the work that friction of tendons took and gave back, J."""
    data = mujoco.MjData(model)
    random, seconds, work = np.random.default_rng(0), 0.0, np.zeros(2)
    for k in range(count):
        if k % 50 == 0:
            data.ctrl[:] = random.uniform(0.0, 0.6, model.nu)
        before = np.array(data.qvel)
        began = time.thread_time()
        mujoco.mj_step(model, data)
        seconds += time.thread_time() - began
        rows = np.flatnonzero(np.array(data.efc_type) == mujoco.mjtConstraint.mjCNSTR_FRICTION_TENDON)
        if len(rows):
            jacobian = np.zeros((data.nefc, model.nv))
            if mujoco.mj_isSparse(model):
                mujoco.mju_sparse2dense(jacobian, data.efc_J, data.efc_J_rownnz, data.efc_J_rowadr, data.efc_J_colind)
            else:
                jacobian[:] = data.efc_J.reshape(data.nefc, model.nv)
            speed = jacobian[rows] @ (0.5 * (before + data.qvel))
            done = -data.efc_force[rows] * speed * model.opt.timestep
            work += [done.clip(min=0.0).sum(), -done.clip(max=0.0).sum()]
    return 1e6 * seconds / count, float(work[0]), float(work[1])


def main(file: str, count: int = 1500) -> None:
    """Prints both."""
    spec = mujoco.MjSpec.from_file(file)
    plain = spec.compile()
    names = sinew.mujoco.add_sheaths(spec, {"*": sinew.mujoco.Sheath(mu=0.1, bend=3.0, turning=1.0)})
    sheathed = spec.compile()
    runs = [(steps(plain, count), steps(sheathed, count)) for _ in range(5)]
    least = [min(run[k][0] for run in runs) for k in (0, 1)]
    _, taken, given_back = runs[0][1]
    print(f"{plain.nv} joints, {plain.nu} actuators, {len(names)} sheaths, step {1e3 * plain.opt.timestep:g} ms")
    print(f"{least[0]:.0f} us a step without sheaths, {least[1]:.0f} us with: ratio {least[1] / least[0]:.2f}")
    print(f"friction took {taken:.2f} J in {count * plain.opt.timestep:.1f} s and gave {given_back:.4f} J back")


if __name__ == "__main__":
    main(sys.argv[1])
