"""Encoders and load cells, with counts, noise and delays: the laws of `sinew::drive::sensor`."""

import warp as wp

from ._layout import COUNTS, FULL, NOISE, OFFSET, RANGE, RATIO, RESOLUTION, ZERO, Design, Motion, Specimen
from ._winch_kernels import wound_at

# mypy: ignore-errors
# Annotations of kernels must be types, not text: no `from __future__ import annotations` here.

#: Of splitmix64.
STRIDE, FIRST, SECOND = (
    wp.constant(wp.uint64(x)) for x in (0x9E3779B97F4A7C15, 0xBF58476D1CE4E5B9, 0x94D049BB133111EB)
)
TURN = wp.constant(wp.float64(6.283185307179586))

Layers = wp.array3d(dtype=float)


@wp.func
def bits(state: wp.uint64) -> wp.uint64:
    z = (state ^ (state >> wp.uint64(30))) * FIRST
    z = (z ^ (z >> wp.uint64(27))) * SECOND
    return z ^ (z >> wp.uint64(31))


@wp.func
def normal(one: wp.uint64, other: wp.uint64) -> float:
    """The sum of eight numbers of 16 bits, of variance 1."""
    total = wp.uint64(0)
    mask = wp.uint64(0xFFFF)
    for part in range(4):
        total += (one >> wp.uint64(16 * part)) & mask
        total += (other >> wp.uint64(16 * part)) & mask
    return (float(total) - 4.0 * 65535.0) * (1.224744871391589 / 65536.0)


@wp.func
def passed(ring: Layers, now: int, steps: float, world: int, k: int, value: float) -> float:
    """Stores the present value and returns the one of so many steps ago, between steps by interpolation."""
    depth = ring.shape[0]
    whole = int(steps)
    ring[now, world, k] = value
    younger = ring[(now - whole + depth) % depth, world, k]
    older = ring[(now - whole - 1 + depth) % depth, world, k]
    return younger + (steps - float(whole)) * (older - younger)


@wp.func
def position_at(design: Design, k: int, angle: wp.float64) -> float:
    """Cable on the drum beyond its half by the motor's encoder, m."""
    count = TURN / wp.float64(design.numbers[COUNTS, k])
    read = wp.rint((angle + wp.float64(design.numbers[ZERO, k])) / count) * count
    half = wound_at(design, k, wp.float64(0.5 * design.numbers[FULL, k]))
    return float(wound_at(design, k, read / wp.float64(design.numbers[RATIO, k])) - half)


@wp.func
def sense(design: Design, specimen: Specimen, motion: Motion, world: int, k: int, tension: float) -> float:
    """The motor's encoder and the load cell, N, at the beginning of the step, after their delay."""
    n = design.numbers
    one = motion.noise[world, k] + STRIDE
    other = one + STRIDE
    motion.noise[world, k] = other
    cell = specimen.gain[world, k] * tension + n[OFFSET, k] + n[NOISE, k] * normal(bits(one), bits(other))
    if n[RESOLUTION, k] > 0.0:
        cell = wp.rint(cell / n[RESOLUTION, k]) * n[RESOLUTION, k]
    cell = wp.clamp(cell, -0.1 * n[RANGE, k], n[RANGE, k])
    now, delay = motion.now[world, k], specimen.delay[world, k]
    position = position_at(design, k, motion.angle[world, k])
    motion.position[world, k] = passed(motion.positions, now, delay, world, k, position)
    seen = passed(motion.tensions, now, delay, world, k, cell)
    motion.tension[world, k] = seen
    motion.now[world, k] = (now + 1) % motion.positions.shape[0]
    return seen


@wp.kernel(enable_backward=False)
def read_joints(design: Design, specimen: Specimen, motion: Motion, qpos: wp.array2d(dtype=float)) -> None:
    """A joint's encoder, after its delay."""
    world, k = wp.tid()
    q = qpos[world, design.coordinate[design.encoded[k]]]
    off, count = specimen.encoder[world, k], design.resolution[k]
    read = wp.rint((q + off[0] + off[1] * wp.sin(q) + off[2] * wp.cos(q)) / count) * count
    now = motion.joint_now[world, k]
    motion.joint[world, k] = passed(motion.joints, now, specimen.joint_delay[world], world, k, read)
    motion.joint_now[world, k] = (now + 1) % motion.joints.shape[0]
