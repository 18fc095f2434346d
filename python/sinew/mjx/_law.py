"""The law of sheaths in one world of MJX, between its actuation and its acceleration."""

from __future__ import annotations

from typing import Any

import jax.numpy as jnp
import numpy as np

from ..batch._table import LARGEST_ANGLE
from ._sheaths import Sheaths

#: A pulley in MuJoCo's list of a path: the path ends before it and another branch begins behind it.
PULLEY = -2


def rub(mx: Any, data: Any, sheaths: Sheaths) -> Any:
    """Data with friction: forces of the actuators, bounds of the friction constraints, and where these pull.

    Constraints pull toward the force of the last step, so that cables which are held do not creep.
    """
    layout, impl = sheaths.layout, data._impl
    tendons, pulls, owner = (np.array(part, dtype=int) for part in (layout.tendons, layout.pulls, layout.sheath_of))
    gear = mx.actuator_gear[pulls, 0]
    force = jnp.clip(data.actuator_force[pulls], sheaths.limits[:, 0], sheaths.limits[:, 1])
    pull = jnp.zeros(len(tendons), force.dtype).at[owner].add(-gear * force)
    # Where the actuators push, there is no friction.
    theta = jnp.where(pull > 0.0, _angle(impl, sheaths, tendons), 0.0)
    bound = jnp.where(pull > 0.0, pull * jnp.sinh(theta), 0.0) + mx.tendon_frictionloss[tendons]
    first = np.array(layout.first)
    added = jnp.where(first, sheaths.pretension[tendons][owner] / jnp.where(first, gear, 1.0), 0.0)
    forces = data.actuator_force.at[pulls].set(force * jnp.cosh(theta)[owner] - added)
    rows = impl.ne + int(np.sum(mx._impl.dof_hasfrictionloss)) + np.array(layout.places, dtype=int)
    # The force of the last step, as long as nothing was solved in this one.
    held = jnp.clip(impl.efc_force[rows], -bound, bound)
    return data.tree_replace(
        {
            "actuator_force": forces,
            "qfrc_actuator": _joint_forces(mx, data, forces),
            "_impl.efc_frictionloss": impl.efc_frictionloss.at[rows].set(bound),
            "_impl.efc_aref": impl.efc_aref.at[rows].add(held / impl.efc_D[rows]),
        }
    )


def _angle(impl: Any, sheaths: Sheaths, tendons: Any) -> Any:
    """Friction angle of every sheath, rad."""
    wrap = sheaths.bend[tendons]
    if sheaths.layout.turning:
        wrap += sheaths.turning[tendons] * _turning(impl, tendons, sheaths.layout.points)
    ratio = impl.ten_velocity[tendons] / sheaths.speed[tendons]
    weakening = 1.0 + sheaths.rise[tendons] / (1.0 + ratio * ratio)
    return jnp.minimum(sheaths.mu[tendons] * wrap * weakening - jnp.log(sheaths.efficiency[tendons]), LARGEST_ANGLE)


def _turning(impl: Any, tendons: Any, points: int) -> Any:
    """Sum of the angles at the points of the paths of tendons, rad."""
    xpos, objects = impl.wrap_xpos.reshape(-1, 3), impl.wrap_obj.reshape(-1)
    first, count = impl.ten_wrapadr[tendons], impl.ten_wrapnum[tendons]
    last = before = jnp.zeros((len(tendons), 3), xpos.dtype)
    # Of the branch in hand: whether it has a point, and whether it has a piece.
    begun = turned = jnp.zeros(len(tendons), bool)
    total = jnp.zeros(len(tendons), xpos.dtype)
    for k in range(points):
        at = jnp.minimum(first + k, len(objects) - 1)
        there, point = k < count, xpos[at]
        pulley = there & (objects[at] == PULLEY)
        piece = point - last
        longer = there & ~pulley & begun & (piece != 0.0).any(-1)
        corner = longer & turned
        total += jnp.where(corner, _between(before, piece, corner), 0.0)
        before = jnp.where(longer[:, None], piece, before)
        last = jnp.where((there & ~pulley & (longer | ~begun))[:, None], point, last)
        turned = (turned | longer) & ~pulley
        begun = (begun | there) & ~pulley
    return total


def _between(a: Any, b: Any, where: Any) -> Any:
    """Angle between vectors; its derivative is finite everywhere."""
    cross, dot = jnp.cross(a, b), (a * b).sum(-1)
    square = (cross * cross).sum(-1)
    bent = where & (square > 0.0)
    sine = jnp.where(bent, jnp.sqrt(jnp.where(bent, square, 1.0)), 0.0)
    return jnp.arctan2(sine, jnp.where(where, dot, 1.0))


def _joint_forces(mx: Any, data: Any, forces: Any) -> Any:
    """Forces of actuators on the degrees of freedom, with what MJX adds to them and how it limits them."""
    total = data._impl.actuator_moment.T @ forces
    if mx.flg_gravcomp if hasattr(mx, "flg_gravcomp") else mx.ngravcomp:
        total += data.qfrc_gravcomp * mx.jnt_actgravcomp[mx.dof_jntid]
    if np.any(mx.jnt_actfrclimited):
        limits = jnp.where(np.asarray(mx.jnt_actfrclimited)[:, None], mx.jnt_actfrcrange, jnp.array([-jnp.inf, jnp.inf]))
        limits = limits[mx.dof_jntid]
        total = jnp.clip(total, limits[:, 0], limits[:, 1])
    return total
