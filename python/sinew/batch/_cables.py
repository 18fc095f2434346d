"""Cables of a model without a plugin: which actuators become their winches, and damping of stiff ones."""

from __future__ import annotations

import copy
from collections.abc import Mapping
from math import sqrt
from typing import Any, NamedTuple

import mujoco
import numpy as np

from ..mujoco._cables import QUIET, Cable
from ..mujoco._sheaths import match
from ._table import tendon_names, tendon_of_actuators


class Winch(NamedTuple):
    """An actuator that becomes the winch of a cable."""

    #: Name and number of its tendon, and number of the actuator.
    name: str
    tendon: int
    actuator: int
    #: Where its displacement stands: its control, or its activation where it has one, else -1.
    control: int
    activation: int
    #: Force per force at the tendon.
    gear: float
    cable: Cable


def winches_of(model: Any, cables: Mapping[str, Cable]) -> list[Winch]:
    """The winches of a `MjModel`'s cables, tendon by tendon.

    Raises `ValueError` that names the pattern or tendon, and `TypeError` for anything but a model.
    """
    if not isinstance(model, mujoco.MjModel):
        raise TypeError(f"model must be a mujoco.MjModel, but is {type(model).__name__}")
    if model.nplugin:
        raise ValueError(f"the model has {model.nplugin} engine plugins, which run on no batch simulator")
    names, tendons = tendon_names(model), tendon_of_actuators(model)
    found = match(names, [bool((tendons == k).any()) for k in range(len(names))], cables, Cable)
    winches = []
    for k, cable in enumerate(found):
        if cable is None:
            continue
        actuators = np.flatnonzero(tendons == k)
        if len(actuators) != 1:
            raise ValueError(f"tendon {names[k]} has {len(actuators)} actuators, expected one to become its winch")
        actuator = int(actuators[0])
        gear = float(model.actuator_gear[actuator, 0])
        kind = int(model.actuator_dyntype[actuator])
        speed = kind == int(mujoco.mjtDyn.mjDYN_INTEGRATOR)
        if gear == 0.0:
            raise ValueError(f"tendon {names[k]}: the gear of its actuator is 0")
        if not speed and kind != int(mujoco.mjtDyn.mjDYN_NONE):
            raise ValueError(
                f"tendon {names[k]}: its actuator has dynamics of its own, expected dyntype none (a displacement) or integrator (a speed)"
            )
        # Newer versions have actuators with several controls.
        controls = getattr(model, "actuator_ctrladr", None)
        control = actuator if controls is None else int(controls[actuator])
        activation = int(model.actuator_actadr[actuator]) if speed else -1
        winches.append(Winch(names[k], k, actuator, control, activation, gear, cable))
    return winches


def stiff(model: Any, cables: Mapping[int, Cable]) -> dict[int, float]:
    """`dt sqrt(k/m)` of the cables, by the number of the tendon, for which the time step is too long without damping."""
    step = float(model.opt.timestep)
    found = {}
    for tendon, cable in cables.items():
        ratio = step * sqrt(cable.stiffness * max(float(model.tendon_invweight0[tendon]), 0.0))
        if ratio > QUIET:
            found[tendon] = ratio
    return found


def check_damping(model: Any, cables: Mapping[int, Cable]) -> None:
    """Raises `ValueError` where cables are stiff for the time step and not damped."""
    names, step = tendon_names(model), float(model.opt.timestep)
    for tendon, ratio in stiff(model, cables).items():
        damping = float(np.atleast_1d(model.tendon_damping[tendon])[0])
        implicit = model.opt.integrator in (
            mujoco.mjtIntegrator.mjINT_IMPLICITFAST,
            mujoco.mjtIntegrator.mjINT_IMPLICIT,
        )
        if not implicit or damping < 0.999 * cables[tendon].stiffness * step:
            raise ValueError(
                f"tendon {names[tendon]}: its cable is stiff for a time step of {step:g} s (dt sqrt(k/m) = {ratio:.2g}, explicit up to "
                f"{QUIET}): take sinew.batch.damp(model, cables), or a shorter step"
            )


def damp(model: Any, cables: Mapping[str, Cable]) -> Any:
    """A copy of a `mujoco.MjModel` in which tendons of cables that are stiff for its time step have the damping `k dt`, and the
    integrator is `implicitfast`, as `sinew.mujoco.add_cables` makes it; a plain copy where none is.

    Raises as `sinew.warp.Cables`.
    """
    chosen = {winch.tendon: winch.cable for winch in winches_of(model, cables)}
    made = copy.copy(model)
    found = stiff(model, chosen)
    for tendon in found:
        damping = made.tendon_damping
        added = chosen[tendon].stiffness * float(model.opt.timestep)
        # A number before MuJoCo's polynomials of damping, a row since.
        if np.ndim(damping) == 1:
            damping[tendon] += added
        else:
            damping[tendon, 0] += added
    if found:
        made.opt.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    return made
