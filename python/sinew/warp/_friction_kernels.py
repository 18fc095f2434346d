"""Friction of cables by pose and speed: the laws of `sinew::twin::arm` for the next step of the cables."""

import warp as wp

from ._cable_kernels import Law, State
from ._kernels import turning_of
from ._layout import Design, Motion, Specimen

# mypy: ignore-errors
# Annotations of kernels must be types, not text: no `from __future__ import annotations` here.

#: Largest wrap at a joint that one node represents, rad.
LARGEST_WRAP = wp.constant(4.0)


@wp.kernel(enable_backward=False)
def ease(
    design: Design,
    specimen: Specimen,
    motion: Motion,
    law: Law,
    state: State,
    timestep: wp.array(dtype=float),
    wrap_adr: wp.array2d(dtype=int),
    wrap_num: wp.array2d(dtype=int),
    wrap_xpos: wp.array2d(dtype=wp.spatial_vector),
    wrap_obj: wp.array2d(dtype=wp.vec2i),
    xquat: wp.array2d(dtype=wp.quat),
) -> None:
    """Friction of the next step of the cables: by the wrap at the joint in the present pose, and less at speed."""
    world, k = wp.tid()
    tendon = design.tendon[k]
    axis = specimen.axis[world, k]
    q = xquat[world, design.sheath_body[k]]
    # Along the end of the sheath; MuJoCo's order is w, x, y, z.
    first = wp.quat_rotate(wp.quat(q[1], q[2], q[3], q[0]), axis)
    bend = turning_of(wrap_adr[world, tendon], wrap_num[world, tendon], world, wrap_xpos, wrap_obj, first)
    more = 0.5 * specimen.mu[world, k] * (wp.min(bend, LARGEST_WRAP) - specimen.wrap[world, k])
    slow = specimen.weakening[world, k]
    h = timestep[0]
    for i in range(motion.slow.shape[0]):
        friction = specimen.friction[i, world, k]
        if i == specimen.pulley[world, k]:
            friction = wp.max(friction + more, 0.0)
        speed = motion.slow[i, world, k]
        if state.begun[world, k] == 0:
            # It begins without, as the profile of steady sliding.
            motion.slow[i, world, k] = 0.0
        elif slow[0] > 0.0:
            ratio = speed / slow[1]
            if slow[3] > 0.0:
                friction *= 1.0 + slow[0] * wp.exp(-0.6931472 * ratio * ratio)
            else:
                friction *= 1.0 + slow[0] / (1.0 + ratio * ratio)
            motion.slow[i, world, k] = speed + h / (slow[2] + h) * (wp.abs(state.slip[i + 1, world, k]) / h - speed)
        law.friction[i, world, k] = friction
