"""A finger on two tendons, with and without sheaths: what friction does to its closing and opening.

Run: `python tendon_hand.py`. Needs MuJoCo (`pip install mujoco`). Prints the angle of the knuckle
while the difference of the tensions at the motors goes up and down.
"""

from __future__ import annotations

import mujoco
import numpy as np

import sinew.mujoco

FINGER = """<mujoco><compiler angle="radian"/><option timestep="0.001" gravity="0 0 0"/>
<default><geom type="capsule" size=".006" mass=".02"/>
 <joint axis="0 1 0" armature="2e-5" damping="2e-3" stiffness=".2" range="-1.5 1.5" limited="true"/></default>
<worldbody><site name="f0" pos="0 0 -.012"/><site name="e0" pos="0 0 .012"/>
<body pos=".02 0 0"><joint name="knuckle"/><geom fromto="0 0 0 .04 0 0"/>
 <site name="f1" pos=".02 0 -.01"/><site name="e1" pos=".02 0 .01"/>
 <body pos=".04 0 0"><joint name="middle"/><geom fromto="0 0 0 .03 0 0"/>
  <site name="f2" pos=".015 0 -.009"/><site name="e2" pos=".015 0 .009"/></body></body></worldbody>
<tendon><spatial name="flexor"><site site="f0"/><site site="f1"/><site site="f2"/></spatial>
 <spatial name="extensor"><site site="e0"/><site site="e1"/><site site="e2"/></spatial></tendon>
<actuator><motor tendon="flexor" gear="-1"/><motor tendon="extensor" gear="-1"/></actuator></mujoco>"""


def loop(model: mujoco.MjModel) -> tuple[np.ndarray, np.ndarray]:
    """Difference of tensions, N, and angle of the knuckle, rad, over one slow cycle after another."""
    data = mujoco.MjData(model)
    pulls, angles = [], []
    for k in range(8000):
        pull = 2.0 * np.sin(2.0 * np.pi * k / 4000)
        data.ctrl[:] = [4.0 + pull, 4.0 - pull]
        mujoco.mj_step(model, data)
        pulls.append(pull)
        angles.append(data.qpos[0])
    return np.array(pulls)[4000:], np.array(angles)[4000:]


def main() -> None:
    """Prints both loops."""
    free = mujoco.MjModel.from_xml_string(FINGER)
    spec = mujoco.MjSpec.from_string(FINGER)
    sinew.mujoco.add_sheaths(spec, {"*": sinew.mujoco.Sheath(mu=0.08, bend=4.0)})
    columns = [loop(free), loop(spec.compile())]
    print("pull, N   knuckle without sheaths, rad   with sheaths, rad")
    for k in range(0, 4000, 250):
        print(f"{columns[0][0][k]:+7.2f}   {columns[0][1][k]:+28.3f}   {columns[1][1][k]:+17.3f}")
    width = [float(np.ptp(angle[np.abs(pull) < 0.05])) for pull, angle in columns]
    print(f"width of the loop at zero pull: {width[0]:.3f} and {width[1]:.3f} rad")


if __name__ == "__main__":
    main()
