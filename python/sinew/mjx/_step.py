"""A step of MJX with friction of sheaths, composed of MJX's own parts."""

from __future__ import annotations

from typing import Any

import jax
import mujoco
import mujoco.mjx as mjx

from ._law import rub
from ._sheaths import Sheaths, check_options


def forward(mx: Any, data: Any, sheaths: Sheaths) -> Any:
    """As `mjx.forward`, with friction of sheaths."""
    _check(mx, data, sheaths)
    new = mjx.fwd_position(mx, data)
    new = mjx.sensor_pos(mx, new)
    new = mjx.fwd_velocity(mx, new)
    new = mjx.sensor_vel(mx, new)
    new = mjx.fwd_actuation(mx, new)
    new = rub(mx, new, sheaths)
    new = mjx.fwd_acceleration(mx, new)
    new = mjx.solve(mx, new)
    new = mjx.sensor_acc(mx, new)
    return _of_types(new, data)


def step(mx: Any, data: Any, sheaths: Sheaths) -> Any:
    """As `mjx.step`, with friction of sheaths: data after one time step.

    `mx`, `sheaths`: of `put_model`. For many worlds `jax.vmap(step, in_axes=(None, 0, sheaths.axes))`. Passes `jit`, `scan` and
    forward derivatives; reverse ones end at the loop of MJX's solver.

    Raises `ValueError` where options were changed such that a step would have no friction, and `TypeError` for anything but
    a model of MJX.
    """
    new = forward(mx, data, sheaths)
    integrate = mjx.euler if mx.opt.integrator == mujoco.mjtIntegrator.mjINT_EULER else mjx.implicit
    return _of_types(integrate(mx, new), data)


def env_step(model: tuple[Any, Sheaths], data: Any, action: Any, n_substeps: int = 1) -> Any:
    """As `mjx_env.step` of MuJoCo Playground: data after some time steps with an action as controls.

    `model`: the pair that `put_model` returned. An environment whose `step` calls it, with its own pair or one that a
    randomisation made, has friction in every world.
    """
    mx, sheaths = model

    def one(before: Any, _: None) -> tuple[Any, None]:
        return step(mx, before.replace(ctrl=action), sheaths), None

    return jax.lax.scan(one, data, None, n_substeps)[0]


def _check(mx: Any, data: Any, sheaths: Sheaths) -> None:
    for name, given, kind in (("mx", mx, mjx.Model), ("data", data, mjx.Data), ("sheaths", sheaths, Sheaths)):
        # One that forwards attributes would pass through parts of MJX, which know nothing of sheaths.
        if not isinstance(given, kind):
            raise TypeError(f"{name} must be a {kind.__module__.split('.')[0]} {kind.__name__}, but is {type(given).__name__}")
    if type(mx._impl).__name__ != "ModelJAX":
        raise TypeError("mx must be of MJX's JAX backend: use what sinew.mjx.put_model returned")
    check_options(mx.opt)
    if mx.ntendon != len(sheaths.names):
        raise ValueError(f"the sheaths are of a model with {len(sheaths.names)} tendons, but this one has {mx.ntendon}")


def _of_types(new: Any, old: Any) -> Any:
    """The new data with the types of the old: with 64 bits MJX widens some integers, which no `scan` takes."""

    def one(after: Any, before: Any) -> Any:
        kinds = getattr(after, "dtype", None), getattr(before, "dtype", None)
        return after.astype(kinds[1]) if kinds[0] != kinds[1] and None not in kinds else after

    return jax.tree_util.tree_map(one, new, old)
