"""Forces on joints: stops, and pushes from outside."""

import warp as wp

from ._layout import Design, Motion, Specimen

# mypy: ignore-errors
# Annotations of kernels must be types, not text: no `from __future__ import annotations` here.


@wp.kernel(enable_backward=False)
def press(
    design: Design,
    specimen: Specimen,
    motion: Motion,
    begun: int,
    qpos: wp.array2d(dtype=float),
    qvel: wp.array2d(dtype=float),
    applied: wp.array2d(dtype=float),
) -> None:
    """Forces on a joint from its stops, and from outside: of a push start, duration, s, joint, and torque, Nm, or force, N.

    `begun`: how many steps of the drives before the present one the clock counts too much.
    """
    world, joint = wp.tid()
    stop = specimen.stops[world, joint]
    q, v = qpos[world, design.coordinate[joint]], qvel[world, design.freedom[joint]]
    beyond = wp.max(q - stop[1], 0.0) + wp.min(q - stop[0], 0.0)
    total = float(0.0)
    if beyond > 0.0:
        total = wp.min(-stop[2] * beyond - stop[3] * v, 0.0)
    elif beyond < 0.0:
        total = wp.max(-stop[2] * beyond - stop[3] * v, 0.0)
    time = float(motion.clock[world] - begun) * design.part
    for j in range(specimen.pushes.shape[1]):
        elapsed = time - specimen.pushes[world, j, 0]
        if int(specimen.pushes[world, j, 2]) == joint and elapsed >= 0.0 and elapsed < specimen.pushes[world, j, 1]:
            total += specimen.pushes[world, j, 3]
    applied[world, design.freedom[joint]] = total
