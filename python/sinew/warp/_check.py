"""Whether this MuJoCo Warp is one that sheaths work with."""

from __future__ import annotations

from functools import cache
from importlib.metadata import PackageNotFoundError, version

#: The first with callbacks.
OLDEST = (3, 6)


def connect() -> None:
    """Raises `ImportError` with the versions where MuJoCo Warp is not there or does not fit."""
    try:
        import mujoco_warp
        import warp  # noqa: F401
    except ModuleNotFoundError as error:
        if error.name not in ("mujoco_warp", "warp"):
            raise
        raise ImportError("sinew.warp needs MuJoCo Warp: pip install mujoco-warp", name=error.name) from error
    found = _version("mujoco-warp")
    numbers = tuple(int(part) for part in found.split(".")[:2] if part.isdigit())
    if numbers < OLDEST or not hasattr(mujoco_warp, "put_model"):
        expected = ".".join(map(str, OLDEST))
        raise ImportError(f"sinew.warp needs MuJoCo Warp {expected} or newer, but it is {found} (Warp {_version('warp-lang')})")


def _version(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:
        return "of an unknown version"


#: Mass of the hoist, kg, and its friction angle, rad.
MASS, ANGLE, GRAVITY = 5.0, 0.6, 9.81
HOIST = f"""<mujoco><option timestep="0.001" gravity="0 0 -{GRAVITY}"/>
<worldbody><site name="top" pos="0 0 1"/>
 <body><joint type="slide" axis="0 0 1"/><geom size=".1" mass="{MASS}" contype="0" conaffinity="0"/><site name="hook"/></body></worldbody>
<tendon><spatial name="cable"><site site="top"/><site site="hook"/></spatial></tendon>
<actuator><motor tendon="cable" gear="-1"/></actuator></mujoco>"""


@cache
def hoist_holds_and_slides() -> None:
    """Raises `ImportError` where a hoist does not hold at 0.99 of both edges of friction, and slide at 1.01."""
    from math import exp

    import mujoco
    import mujoco_warp as mjw
    import numpy as np

    from ..batch import Sheath, prepare
    from ._sheaths import Sheaths

    model = prepare(mujoco.MjModel.from_xml_string(HOIST), {"*": Sheath(mu=0.2, bend=ANGLE / 0.2)})
    pulls = np.array([f * MASS * GRAVITY * exp(s * ANGLE) for s in (1.0, -1.0) for f in (0.99, 1.01)])
    try:
        m = mjw.put_model(model)
        d = mjw.make_data(model, nworld=len(pulls), njmax=16)
        Sheaths(model, worlds=len(pulls))._attach(m, d)
        d.ctrl.assign(pulls[:, np.newaxis].astype(np.float32))
        for _ in range(3):
            mjw.step(m, d)
        # Of the load, m/s: held; up; down; held.
        speed = d.qvel.numpy()[:, 0]
    except (AttributeError, TypeError, RuntimeError) as error:
        raise ImportError(f"{_pair()}: a hoist with a sheath cannot be stepped: {error}") from error
    # A hundredth of friction, multiplied by exp(theta) or not, in three steps.
    least = 0.5 * 0.01 * 3e-3 * GRAVITY
    right = [abs(speed[0]) < 1e-6, speed[1] > least, speed[2] < -least, abs(speed[3]) < 1e-6]
    if not all(right):
        raise ImportError(
            f"{_pair()}: a hoist must hold at 0.99 of both edges of friction and slide at 1.01, "
            f"but moves with {speed[0]:.2g}, {speed[3]:.2g} and {speed[1]:.2g}, {speed[2]:.2g} m/s"
        )


def _pair() -> str:
    import sinew

    versions = f"mujoco-warp {_version('mujoco-warp')} and warp-lang {_version('warp-lang')}"
    return f"sinew {sinew.__version__} cannot use {versions}"
