"""The chain of a model's links to a site, as kernels read it."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from ._layout import HINGE, SLIDE


def chain(model: Any, site: str | None) -> list[tuple[Any, int, int, Any, Any, float]]:
    """From the world to a site: place, kind of joint, its coordinate, axis, anchor and zero."""
    if site is None:
        return []
    still = np.zeros(3), np.zeros(3), 0.0
    links: list[tuple[Any, int, int, Any, Any, float]] = []
    one = model.site(site)
    links.append((_transform(one.pos, one.quat), 0, 0, *still))
    body = int(np.atleast_1d(one.bodyid)[0])
    while body:
        place = _transform(model.body_pos[body], model.body_quat[body])
        own = []
        for joint in range(model.body_jntadr[body], model.body_jntadr[body] + model.body_jntnum[body]):
            hinge = model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_HINGE
            address = int(model.jnt_qposadr[joint])
            kind = int(HINGE if hinge else SLIDE)
            own.append((place, kind, address, model.jnt_axis[joint], model.jnt_pos[joint], float(model.qpos0[address])))
            place = _transform(np.zeros(3), [1.0, 0.0, 0.0, 0.0])
        links[:0] = own or [(place, 0, 0, *still)]
        body = int(model.body_parentid[body])
    return links


def _transform(position: Any, quaternion: Any) -> NDArray[Any]:
    """In the order of Warp, whose quaternions end with the real part."""
    return np.concatenate([position, np.roll(quaternion, -1)])
