"""One time step of an elastic cable, and many of them, as functions that JAX differentiates.

The law is that of `sinew.Cable`, whose documentation in the crate `sinew`, module `transmission::cable`, has the equations. The
step is the same; what it leaves out are the exact sweeps for steps whose energy balance does not close, which are rare.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from .. import _sinew

#: Friction bound, N, below which a node cannot stick; work, J, that friction at a node may do by rounding.
NO_FRICTION, FRICTION_WORK = 1e-12, 1e-10
#: Largest argument of the series for `tanh`.
SERIES_END = 0.5


class Law(NamedTuple):
    """A cable, cut into cells, drive end first: the arrays of `sinew.Cable.law`. A pytree of arrays."""

    #: Of every cell, m/N, shape `(cells,)`.
    compliance: Any
    #: Of every node between cells, shape `(cells - 1,)`: half angles of friction and of losses, 1.
    friction: Any
    loss: Any
    #: Growth of the half angle with speed, s/m, and grease drag, N s/m, shape `(cells - 1,)`.
    viscous: Any
    drag: Any
    #: Tension below which the drag fades, N, and constant force in parallel at the anchor, N.
    drag_fade: Any
    pretension: Any


class State(NamedTuple):
    """What a cable is after a step."""

    #: Of every cell, N, shape `(cells,)`.
    tension: Any
    #: Displacement of every node in the last step, m, positive toward the motor, shape `(cells - 1,)`.
    slip: Any
    #: Elongation, m; negative by the slack of a slack cable.
    stretch: Any


class Ends(NamedTuple):
    """Tensions at the ends after a step, N, and the energy that friction took in it, J."""

    tension_in: Any
    tension_out: Any
    dissipated: Any


def law_of(cable: _sinew.Cable) -> Law:
    """The law of a `sinew.Cable` as arrays of JAX."""
    return Law(**{name: jnp.asarray(values) for name, values in cable.law.items()})


def state_of(cable: _sinew.Cable) -> State:
    """The state of a `sinew.Cable` as arrays of JAX."""
    return State(jnp.asarray(cable.tensions), jnp.asarray(cable.slips), jnp.asarray(cable.stretch))


def scaled(law: Law, factors: Mapping[str, Any]) -> Law:
    """A law with some of its fields multiplied by factors."""
    unknown = [name for name in factors if name not in Law._fields]
    if unknown:
        raise ValueError(f"{unknown[0]!r} is no field of a law, expected one of {', '.join(Law._fields)}")
    return law._replace(**{name: getattr(law, name) * factor for name, factor in factors.items()})


def profile(law: Law, tension_in: Any, tension_out: Any) -> State:
    """A cable at rest between two measured tensions at its ends, N, with as much of friction in use at every node.

    Where the tensions are at most as far apart as friction holds them, this is inside of the band of sticking, where no node is
    at its bound and derivatives exist.
    """
    half = law.friction + law.loss
    far = jnp.maximum(tension_out - law.pretension, 0.0)
    near = jnp.maximum(tension_in, 0.0)
    fraction = jnp.concatenate([jnp.zeros(1, half.dtype), jnp.cumsum(half)]) / jnp.maximum(half.sum(), NO_FRICTION)
    taut = (near > 0.0) & (far > 0.0)
    ratio = jnp.where(taut, far, 1.0) / jnp.where(taut, near, 1.0)
    tension = jnp.where(taut, near, 0.0) * ratio**fraction
    return State(tension, jnp.zeros_like(half), (law.compliance * tension).sum())


def cable_step(
    law: Law, state: State, interval_s: Any, motor_m: Any, anchor_m: Any = 0.0, *, newton: int = 3
) -> tuple[State, Ends]:
    """The state after a time step in which the ends move, and the tensions at the ends.

    `motor_m`, `anchor_m`: displacements in the step, m, positive toward the motor. `newton`: steps of Newton's method; one is the
    step of `sinew.Cable`, with three derivatives are those of the function: with one, a node that begins to slip in a step is
    settled in the next one, and which step that is jumps with the parameters.

    For many cables use `jax.vmap`.
    """
    motor, anchor = jnp.asarray(motor_m), jnp.asarray(anchor_m)
    before, stretch = state.stretch, state.stretch + motor - anchor
    slip = jnp.concatenate([motor[None], state.slip, anchor[None]]).astype(state.tension.dtype)
    stiffness, rate = 1.0 / law.compliance, 1.0 / interval_s

    def corrected(_: Any, at: Any) -> Any:
        return at.at[1:-1].add(_correction(law, stiffness, state.tension, at, rate))

    slip = jax.lax.fori_loop(0, newton, corrected, slip)
    # A node whose friction would do work on the cable is held.
    solved = state.tension + (slip[:-1] - slip[1:]) * stiffness
    work = (solved[:-1] - solved[1:]) * slip[1:-1]
    rounding = 4.0 * float(np.finfo(solved.dtype).eps) * (jnp.abs(solved[:-1]) + jnp.abs(solved[1:])) * jnp.abs(slip[1:-1])
    slip = slip.at[1:-1].set(jnp.where(work < -FRICTION_WORK - rounding, 0.0, slip[1:-1]))
    tension = jnp.maximum(state.tension + (slip[:-1] - slip[1:]) * stiffness, 0.0)
    total = (law.compliance * tension).sum()
    taut = (stretch > 0.0) & (total > 0.0)
    tension = tension * jnp.where(taut, stretch, 0.0) / jnp.where(taut, total, 1.0)
    # Tension after slack: the profile of sliding everywhere with the whole stretch.
    slack = before <= 0.0
    sign = jnp.where(motor + anchor >= 0.0, 1.0, -1.0)
    grip = sign * _tanh(law.friction + law.loss)
    ratio = jnp.concatenate([jnp.ones(1, tension.dtype), jnp.cumprod((1.0 - grip) / (1.0 + grip))])
    again = ratio * jnp.maximum(stretch, 0.0) / (law.compliance * ratio).sum()
    tension = jnp.where(slack, again, tension)
    cells = tension.shape[0]
    along = motor + (anchor - motor) * jnp.arange(1, cells) / cells
    moved = jnp.where(stretch > 0.0, jnp.where(slack, along, slip[1:-1]), 0.0)
    # As a product, so that float32 does not lose the difference of two energies.
    gained = 0.5 * (law.compliance * (tension - state.tension) * (tension + state.tension)).sum()
    dissipated = tension[0] * motor - tension[-1] * anchor - gained
    return State(tension, moved, stretch), Ends(tension[0], tension[-1] + law.pretension, dissipated)


def simulate(
    law: Law, state: State, interval_s: Any, motor_m: Any, anchor_m: Any = 0.0, *, newton: int = 3
) -> tuple[State, Ends]:
    """Many steps: the state after the last one, and the tensions after every one, shapes `(steps,)`.

    `motor_m`, `anchor_m`: displacements in every step, m, shapes `(steps,)`; one number for `anchor_m` is that of every step.
    """
    motor = jnp.asarray(motor_m)
    anchor = jnp.broadcast_to(jnp.asarray(anchor_m, dtype=motor.dtype), motor.shape)

    def one(before: State, motion: tuple[Any, Any]) -> tuple[State, Ends]:
        return cable_step(law, before, interval_s, *motion, newton=newton)

    found: tuple[State, Ends] = jax.lax.scan(one, state, (motor, anchor))
    return found


def _correction(law: Law, stiffness: Any, tension: Any, slip: Any, rate: Any) -> Any:
    """One step of Newton's method on the balance of every node: rows of a tridiagonal system, and the Thomas algorithm."""
    inner, half = slip[1:-1], law.friction + law.loss
    at = tension + (slip[:-1] - slip[1:]) * stiffness
    (left, right), (near, far) = (at[:-1], at[1:]), (stiffness[:-1], stiffness[1:])
    both, difference = left + right, left - right
    total = jnp.maximum(both, 0.0)
    # Sliding direction: the difference of tensions that would hold the node at rest, against the bound of friction.
    bound = total * _tanh(half)
    trial = difference + (near + far) * inner
    driven = jnp.where(slip[0] + slip[-1] >= 0.0, 1.0, -1.0)
    sign = jnp.where(bound <= NO_FRICTION, driven, jnp.where(trial > bound, 1.0, jnp.where(trial < -bound, -1.0, 0.0)))
    resistance = (law.viscous + law.drag / (total + 2.0 * law.drag_fade)) * rate
    tau = _tanh(sign * half + resistance * inner)
    sticks = sign == 0.0
    lower, upper = jnp.where(sticks, 0.0, (1.0 - tau) * near), jnp.where(sticks, 0.0, (1.0 + tau) * far)
    main = jnp.where(sticks, 1.0, lower + upper + total * (1.0 - tau * tau) * resistance)
    rhs = jnp.where(sticks, -inner, difference - tau * both)
    # Unrolled: a recursion over a dozen nodes is no loop for a compiler.
    above, done, rows = jnp.zeros_like(rhs[0]), jnp.zeros_like(rhs[0]), []
    for i in range(rhs.shape[0]):
        inverse = 1.0 / (main[i] - lower[i] * above)
        done, above = (rhs[i] + lower[i] * done) * inverse, upper[i] * inverse
        rows.append((done, above))
    found, x = [], jnp.zeros_like(rhs[0])
    for done, above in reversed(rows):
        x = done + above * x
        found.append(x)
    return jnp.stack(found[::-1])


def _tanh(x: Any) -> Any:
    """`tanh` by the series that the law in Rust uses."""
    x = jnp.clip(x, -SERIES_END, SERIES_END)
    z = x * x
    return x * (1.0 + z * (-1.0 / 3.0 + z * (2.0 / 15.0 + z * (-17.0 / 315.0))))
