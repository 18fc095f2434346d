"""How a machine looks in MuJoCo: light, the first view, bones and cables. None of it has mass or contacts."""

from __future__ import annotations

from collections.abc import Collection
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

#: Where the camera looks to, degrees: from the side, a little from the front and above; most machines move in
#: the plane of x and z.
AZIMUTH, ELEVATION = 120.0, -20.0
BONE, CABLE = (0.85, 0.82, 0.75, 1.0), (0.8, 0.15, 0.12, 1.0)
SITE, WRAP = (0.3, 0.3, 0.3, 1.0), (0.4, 0.5, 0.65, 0.35)
#: Radii, as fractions of the machine's extent.
BONE_RADIUS, CABLE_RADIUS, SITE_RADIUS = 0.014, 0.003, 0.005

_Points = NDArray[np.float64]


def make_visible(spec: Any, muscles: Collection[str], start: list[float]) -> None:
    """Makes a machine visible in the first picture that is taken of it; `start`: all coordinates.

    Its description is of masses and cables: MuJoCo alone draws pulleys and guides, dark grey on black, and no
    bones.
    """
    model = spec.compile()
    bones = bones_of(model)
    low, high = _bounds(model, bones, start)
    extent = float(np.linalg.norm(high - low))
    spec.stat.center, spec.stat.extent = 0.5 * (low + high), extent
    _light(spec)
    for index, ends in enumerate(bones):
        body = spec.body(model.body(index).name)
        # What the body's own file draws has no name, and is better.
        if any(not geom.name for geom in body.geoms):
            continue
        for end in ends:
            bone = body.add_geom(type=mujoco.mjtGeom.mjGEOM_CAPSULE, fromto=[0.0, 0.0, 0.0, *end])
            bone.size, bone.rgba = [BONE_RADIUS * extent, 0.0, 0.0], BONE
            bone.mass, bone.contype, bone.conaffinity = 0.0, 0, 0
    for geom in spec.geoms:
        if geom.name:
            geom.rgba = WRAP
    for site in spec.sites:
        site.size, site.rgba = [SITE_RADIUS * extent] * 3, SITE
    for tendon in spec.tendons:
        tendon.width = CABLE_RADIUS * extent
        # Springs stay grey.
        if tendon.name in muscles:
            tendon.rgba = CABLE


def bones_of(model: Any) -> list[_Points]:
    """Ends of the bones that begin in every body's origin, in its frame, shape `(bones, 3)`.

    They are the origins of the next bodies. The last body of a chain reaches to its farthest site, at least as far
    behind its mass centre as before.
    """
    bones = [np.zeros((0, 3))]
    for body in range(1, model.nbody):
        ends = model.body_pos[model.body_parentid == body]
        if not len(ends):
            last = np.vstack([2.0 * model.body_ipos[body], model.site_pos[model.site_bodyid == body]])
            ends = last[[np.linalg.norm(last, axis=1).argmax()]]
        bones.append(ends[np.linalg.norm(ends, axis=1) > 1e-6])
    return bones


def _light(spec: Any) -> None:
    view, lamp = spec.visual.global_, spec.visual.headlight
    view.azimuth, view.elevation = AZIMUTH, ELEVATION
    lamp.ambient, lamp.diffuse, lamp.specular = [0.4] * 3, [0.6] * 3, [0.1] * 3
    sky = spec.add_texture(name="sky", type=mujoco.mjtTexture.mjTEXTURE_SKYBOX, width=32, height=32)
    sky.builtin = mujoco.mjtBuiltin.mjBUILTIN_GRADIENT
    sky.rgb1, sky.rgb2 = [0.95, 0.96, 0.98], [0.7, 0.75, 0.82]


def _bounds(model: Any, bones: list[_Points], start: list[float]) -> tuple[_Points, _Points]:
    """Corners of a box around a machine in its start, and with each joint in turn halfway to its limits."""
    poses = [np.array(start)]
    turning = np.isin(model.jnt_type, [mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE])
    for joint in np.flatnonzero(turning & (model.jnt_limited != 0)):
        place = model.jnt_qposadr[joint]
        for limit in model.jnt_range[joint]:
            poses.append(np.array(start))
            poses[-1][place] = 0.5 * (start[place] + limit)
    data = mujoco.MjData(model)
    radius = model.geom_rbound[:, np.newaxis]
    seen: list[_Points] = []
    for pose in poses:
        data.qpos[:] = pose
        mujoco.mj_kinematics(model, data)
        turns = data.xmat.reshape(-1, 3, 3)
        seen += [data.xpos[body] + ends @ turns[body].T for body, ends in enumerate(bones)]
        seen += [np.array(data.xpos[1:]), np.array(data.site_xpos)]
        seen += [data.geom_xpos - radius, data.geom_xpos + radius]
    points = np.vstack(seen)
    return points.min(axis=0), points.max(axis=0)
