"""A drum with layers of cable: how much stands on it, and what the winch takes in; the law of `sinew::drive::winch`."""

import warp as wp

from ._layout import FULL, Design, Motion

# mypy: ignore-errors
# Annotations of kernels must be types, not text: no `from __future__ import annotations` here.


@wp.func
def layer_of(design: Design, k: int, winch: wp.float64) -> int:
    layers = design.arms.shape[0]
    per_layer = wp.float64(design.numbers[FULL, k]) / wp.float64(layers)
    return wp.clamp(int(winch / per_layer), 0, layers - 1)


@wp.func
def wound_at(design: Design, k: int, winch: wp.float64) -> wp.float64:
    """Cable on the drum, m."""
    per_layer = wp.float64(design.numbers[FULL, k]) / wp.float64(design.arms.shape[0])
    layer = layer_of(design, k, winch)
    below = wp.float64(0.0)
    for j in range(layer):
        below += per_layer * design.arms[j, k]
    return below + (winch - wp.float64(layer) * per_layer) * design.arms[layer, k]


@wp.kernel(enable_backward=False)
def wind(design: Design, motion: Motion, left: float, control: wp.array(dtype=int), ctrl: wp.array2d(dtype=float)) -> None:
    """Displacement of the winches in the next substep; `left`: the fraction of the motion of this step that is still to come."""
    world, k = wp.tid()
    half = wound_at(design, k, wp.float64(0.5 * design.numbers[FULL, k]))
    there = float(wound_at(design, k, motion.winch[world, k]) - half)
    ctrl[world, control[k]] = there - left * motion.moved[world, k]
