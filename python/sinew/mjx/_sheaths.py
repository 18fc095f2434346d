"""Sheaths of a model in MJX: arrays that JAX traces, and what of them is fixed."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any

import jax
import jax.numpy as jnp
import mujoco
import mujoco.mjx as mjx
import numpy as np

from ..batch._prepare import check_solver, table_of
from ..batch._table import PARAMETERS, Table
from ..mujoco._sheaths import check
from ._check import check_fields, hoist_holds_and_slides


@dataclass(frozen=True)
class Layout:
    """What of a model's sheaths is fixed when a step is compiled."""

    #: Names of all tendons.
    names: tuple[str, ...]
    #: Tendons with sheaths.
    tendons: tuple[int, ...]
    #: Actuators that pull on them, the sheath of each, and whether it is its first with a gear.
    pulls: tuple[int, ...]
    sheath_of: tuple[int, ...]
    first: tuple[bool, ...]
    #: Place of each sheath's friction constraint among those of tendons.
    places: tuple[int, ...]
    #: Most points of the path of a tendon with a sheath.
    points: int
    #: Whether the turning of paths counts anywhere.
    turning: bool


@dataclass(frozen=True)
class Sheaths:
    """Parameters of the sheaths of a model in MJX, as arrays of JAX of shape `(tendons,)`, or `(worlds, tendons)`.

    The fields are those of `sinew.mujoco.Sheath`; the order of tendons is that of the model. `put_model` makes them. They
    are a pytree: they pass `jit`, `vmap`, `scan` and derivatives, and are saved as other arrays are.
    """

    mu: Any
    bend: Any
    turning: Any
    efficiency: Any
    pretension: Any
    rise: Any
    speed: Any
    #: Least and largest force of the actuators that pull on sheaths, N, applied before friction: shape `(pulls, 2)`.
    limits: Any
    layout: Layout

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the model's tendons, in the order of all arrays."""
        return self.layout.names

    @property
    def axes(self) -> Sheaths:
        """What `jax.vmap` takes as `in_axes`: 0 for parameters of many worlds, None for those of all."""
        many: dict[str, Any] = {name: 0 if jnp.ndim(getattr(self, name)) == 2 else None for name in PARAMETERS}
        return replace(self, limits=None, **many)

    def set(self, **parameters: Any) -> Sheaths:
        """Sheaths with other parameters: one number, one for each tendon, or one for each world and tendon.

        Raises `ValueError` for an unknown name, a wrong shape or, unless JAX traces them, numbers outside of their domain.
        """
        tendons, changed = len(self.names), {}
        for name, given in parameters.items():
            if name not in PARAMETERS:
                raise ValueError(f"{name!r} is no parameter of a sheath, expected one of {', '.join(PARAMETERS)}")
            values = jnp.asarray(given, dtype=self.mu.dtype)
            if values.ndim > 2 or values.ndim and values.shape[-1] != tendons:
                raise ValueError(f"{name} must be of shape ({tendons},) or (worlds, {tendons}), but is of {values.shape}")
            if not isinstance(values, jax.core.Tracer):
                check(name, np.asarray(values))
            changed[name] = values if values.ndim else jnp.full(tendons, values)
        layout = self.layout
        if "turning" in changed:
            values = changed["turning"]
            layout = replace(layout, turning=isinstance(values, jax.core.Tracer) or bool((values > 0.0).any()))
        return replace(self, layout=layout, **changed)


jax.tree_util.register_dataclass(Sheaths, data_fields=[*PARAMETERS, "limits"], meta_fields=["layout"])


def put_model(model: Any, *, impl: str = "jax") -> tuple[Any, Sheaths]:
    """A `mujoco.MjModel` that `sinew.batch.prepare` has made, as a model of MJX, and its sheaths.

    Raises `ValueError` for a model that is not prepared or would be stepped without friction: with another `impl` than
    `"jax"`, or with the integrator RK4, which calls MJX's own step. Raises `ImportError` with the versions where MJX lacks what
    sheaths need, or where a hoist does not hold and slide at the edges of friction, tried once in a process.
    """
    if impl != "jax":
        raise ValueError(
            f"impl must be 'jax', but is {impl!r}: other backends of MJX have no place for sheaths and would step without "
            "friction (for Warp use sinew.warp)"
        )
    table_of(model)
    check_options(model.opt)
    hoist_holds_and_slides()
    return put(model)


def put(model: Any) -> tuple[Any, Sheaths]:
    """As `put_model`, without the trial."""
    table = table_of(model)
    limited = np.flatnonzero(np.asarray(model.tendon_actfrclimited, dtype=bool) & table.sheathed)
    if limited.size:
        raise ValueError(
            f"tendon {table.names[limited[0]]} has a limit of the sum of its actuators' forces (actuatorfrclimited), which MJX "
            "applies before friction and MuJoCo after it: limit the actuators instead"
        )
    mx = mjx.put_model(model, impl="jax")
    check_fields(mx, mjx.make_data(mx))
    kind = mx.opt.gravity.dtype
    parameters = {name: jnp.asarray(table.parameters[name], dtype=kind) for name in PARAMETERS}
    layout = _layout(model, table)
    limits = jnp.asarray(table.limits[table.pulls], dtype=kind)
    return mx, Sheaths(**parameters, limits=limits, layout=layout)


def check_options(option: Any) -> None:
    """Raises `ValueError` for options of a model with which a step would have no friction, or lose it."""
    check_solver(option)
    if option.integrator == mujoco.mjtIntegrator.mjINT_RK4:
        raise ValueError("the integrator RK4 of MJX would step without friction of sheaths: use Euler or implicitfast")


def _layout(model: Any, table: Table) -> Layout:
    tendons = np.flatnonzero(table.sheathed)
    counts = np.diff(table.begins)[tendons]
    owner = np.repeat(np.arange(len(tendons)), counts)
    geared = table.gear[table.pulls] != 0.0
    first = [bool(geared[k]) and not geared[:k][owner[:k] == owner[k]].any() for k in range(len(owner))]
    with_rows = np.flatnonzero(np.asarray(model.tendon_frictionloss) > 0.0)
    # A path around a geometry has two points there.
    around = np.isin(np.asarray(model.wrap_type), [int(mujoco.mjtWrap.mjWRAP_SPHERE), int(mujoco.mjtWrap.mjWRAP_CYLINDER)])
    ranges = [slice(model.tendon_adr[k], model.tendon_adr[k] + model.tendon_num[k]) for k in tendons]
    return Layout(
        names=table.names,
        tendons=_whole(tendons),
        pulls=_whole(table.pulls),
        sheath_of=_whole(owner),
        first=tuple(first),
        places=_whole(np.searchsorted(with_rows, tendons)),
        points=int(max(2 * around[part].sum() + (~around[part]).sum() for part in ranges)),
        turning=bool((table.parameters["turning"] > 0.0).any()),
    )


def _whole(numbers: Iterable[Any]) -> tuple[int, ...]:
    return tuple(int(number) for number in numbers)
