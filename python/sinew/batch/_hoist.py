"""A hoist, on which a simulator shows that it holds and slides at the edges of friction."""

from __future__ import annotations

from math import exp
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..mujoco import Sheath

#: Of the load, kg; friction angle, rad.
MASS, ANGLE, GRAVITY, STEP = 5.0, 0.6, 9.81, 1e-3
#: Steps after which the speed of the load is judged.
STEPS = 3
XML = f"""<mujoco><option timestep="{STEP}" gravity="0 0 -{GRAVITY}"/>
<worldbody><site name="top" pos="0 0 1"/>
 <body><joint type="slide" axis="0 0 1"/><geom size=".1" mass="{MASS}" contype="0" conaffinity="0"/><site name="hook"/></body></worldbody>
<tendon><spatial name="cable"><site site="top"/><site site="hook"/></spatial></tendon>
<actuator><motor tendon="cable" gear="-1"/></actuator></mujoco>"""


def model() -> Any:
    """The hoist, prepared."""
    import mujoco

    from ._prepare import prepare

    return prepare(mujoco.MjModel.from_xml_string(XML), {"*": Sheath(mu=0.2, bend=ANGLE / 0.2)})


def pulls() -> NDArray[np.float64]:
    """Tensions, N, at 0.99 and 1.01 of the upper edge, and of the lower one."""
    return np.array([of_edge * MASS * GRAVITY * exp(sign * ANGLE) for sign in (1.0, -1.0) for of_edge in (0.99, 1.01)])


def wrong(speeds: ArrayLike) -> str | None:
    """What is wrong with the speeds, m/s, of the load after `STEPS` steps with `pulls`; nothing where it is as it should be."""
    held, up, down, also_held = np.asarray(speeds, dtype=float)
    # A hundredth of the weight, multiplied by `exp(theta)` or not.
    least = 0.5 * 0.01 * STEPS * STEP * GRAVITY
    if abs(held) < 1e-6 and up > least and down < -least and abs(also_held) < 1e-6:
        return None
    return (
        "a hoist must hold at 0.99 of both edges of friction and slide at 1.01, but moves with "
        f"{held:.2g}, {also_held:.2g} and {up:.2g}, {down:.2g} m/s"
    )
