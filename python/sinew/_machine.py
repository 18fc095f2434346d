"""Machines on cables, and the distribution of torques over their muscles."""

from __future__ import annotations

import json
import os
import warnings
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any, Self, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _sinew
from ._display import html_table, number

#: A desired motion; see `Machine.plan`.
Path: TypeAlias = str | Mapping[str, ArrayLike] | ArrayLike


@dataclass(frozen=True, slots=True)
class Routing:
    """Another route of the cable of one muscle, relative to the design; see `Machine`.

    The drive stays where it is, and the sheath keeps its directions at both ends: an S of two equal arcs `a`, by which its
    end moves sideways by `h = L (1 - cos a) / a`, adds `2 a` to its bend. The drag of a sheath grows with its length.
    """

    #: Displacement of the sheath's end in its body's frame, m, at most 0.63 of the sheath's length sideways.
    origin_m: tuple[float, float, float] = (0.0, 0.0, 0.0)
    #: Displacement of the anchor in its body's frame, m.
    anchor_m: tuple[float, float, float] = (0.0, 0.0, 0.0)
    #: Factor on the radii of the surfaces around which the cable wraps, > 0.
    wrap_factor: float = 1.0
    #: Length of the sheath, m, > 0; by default that of the design.
    sheath_m: float | None = None
    #: Bend of the sheath before its end is displaced, rad, >= 0; by default that of the design.
    bend_rad: float | None = None


class Machine(_sinew.Machine):
    """A machine on cables as designed.

    `source`: the name of a built-in machine (`Machine.built_in()`), or a path to a machine file (TOML) or to a body in MJCF
    (`.xml`), URDF, OpenSim (`.osim`) or TOML, with defaults for everything but the body. `muscles`: file with the muscles of a body in
    URDF; by default `NAME.muscles.toml` beside `NAME.urdf`. `routing`: other routes of cables by the names of
    their muscles.

    Coordinates `q` are those of the independent joints, in the order of `joint_names`: rad for hinges, m for slides. All
    functions of a pose take one, shape `(joints,)`, or many, shape `(..., joints)`.

    Raises `FileNotFoundError`, and `ValueError` that names file, line and key; warns of content that the reader ignores.

    >>> machine = Machine("lm_arm")
    >>> machine.moment_arms(machine.start).shape
    (15, 7)
    """

    __slots__ = ()

    def __new__(
        cls,
        source: str | os.PathLike[str],
        *,
        muscles: str | os.PathLike[str] | None = None,
        routing: Mapping[str, Routing] | str | None = None,
    ) -> Self:
        if routing is not None and not isinstance(routing, str):
            routing = json.dumps({name: asdict(route) for name, route in routing.items()})
        machine = super().__new__(cls, source, muscles=muscles, routing=routing)
        for text in machine.warnings:
            warnings.warn(text, UserWarning, stacklevel=2)
        return machine

    def plan(self, path: Path | None = None, *, duration_s: float | None = None) -> _sinew.Trajectory:
        """Plans a motion from rest to rest.

        `path`: the name of a closed path of the machine, two turns of it; `"tour"`, a closed motion of all joints; a position
        of the end point, m, shape `(3,)`; positions at times, rows of `(time_s, x, y, z)`, shape `(n, 4)`; a mapping of
        joint names to positions, rad or m; or a mapping of `"time_s"` and joint names to arrays of shape `(n,)`. By default
        the machine's first path, else a tour. `duration_s`: s, not with times.
        """
        return _sinew.plan_motion(self, _desired(self, path), duration_s)

    def __repr__(self) -> str:
        return f"Machine({self.name}: {len(self.joint_names)} joints, {len(self.muscle_names)} muscles)"

    def _repr_html_(self) -> str:
        lengths, arms = self.lengths(self.start), self.moment_arms(self.start)
        joints = self.joint_names

        def row(k: int) -> list[str]:
            most = int(np.argmax(np.abs(arms[k])))
            return [
                self.muscle_names[k],
                f"{1e3 * lengths[k]:.1f}",
                joints[most],
                f"{1e3 * arms[k, most]:.1f}",
                number(self.wrap_angles(self.start)[k], 3),
            ]

        head = ["muscle", "length, mm", "strongest at", "moment arm, mm", "wrap, rad"]
        rows = [row(k) for k in range(len(lengths))]
        return html_table(f"{self!r}, {self.mass:.2f} kg, in its start pose", head, rows)


def _load_machine(source: str, muscles: str | None, routing: str | None = None) -> Machine:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)
        return Machine(source, muscles=muscles, routing=routing)


def _desired(machine: Machine, path: Path | None) -> Any:
    if path is None:
        return machine.path_names[0] if machine.path_names else "tour"
    if isinstance(path, str):
        return path
    if isinstance(path, Mapping):
        return _joint_motion(machine, path)
    points = np.asarray(path, dtype=float)
    if not np.isfinite(points).all():
        raise ValueError("path must be finite numbers")
    if points.shape == (3,):
        return {"point": points.tolist()}
    if points.ndim == 2 and points.shape[1] == 4:
        return {"waypoints": [(row[0], row[1:]) for row in points.tolist()]}
    raise ValueError(f"path must have the shape (3,) or (n, 4), but has {points.shape}")


def _joint_motion(machine: Machine, path: Mapping[str, ArrayLike]) -> Any:
    columns = {name: np.asarray(values, dtype=float) for name, values in path.items()}
    for name, values in columns.items():
        if name != "time_s" and name not in machine.joint_names:
            known = ", ".join(machine.joint_names)
            raise ValueError(f"path: expected time_s or an independent joint ({known}), but is {name!r}")
        if not np.isfinite(values).all():
            raise ValueError(f"path[{name!r}] must be finite numbers")
    times = columns.pop("time_s", None)
    shape = () if times is None else times.shape
    if len(shape) > 1 or any(values.shape != shape for values in columns.values()):
        raise ValueError("path: expected single numbers, or arrays of one axis as long as time_s")
    poses = np.tile(machine.start, (*shape, 1))
    for name, values in columns.items():
        poses[..., machine.joint_names.index(name)] = values
    if times is None:
        return {"pose": poses.reshape(-1).tolist()}
    return {"joint_waypoints": list(zip(np.atleast_1d(times).tolist(), np.atleast_2d(poses).tolist(), strict=True))}


@dataclass(frozen=True, slots=True)
class Distribution:
    """Tensions that give torques at least cost, one problem or `n`."""

    #: Tensions within their limits, N, shape `(muscles,)` or `(n, muscles)`.
    tension: NDArray[np.float64]
    #: Torque minus `R^T F`, N m, shape `(joints,)` or `(n, joints)`.
    residual: NDArray[np.float64]
    #: 0 where the torque is reached at least cost, 1 where it is proved to be out of reach and the closest is given,
    #: 2 where nothing is proved; shape `()` or `(n,)`.
    status: NDArray[np.int8]
    #: Newton steps, shape `()` or `(n,)`.
    iterations: NDArray[np.uint32]

    @property
    def optimal(self) -> NDArray[np.bool_]:
        """Where the torque is reached at least cost, shape `()` or `(n,)`."""
        return np.asarray(self.status == 0)


def distribute(
    moment_arms: ArrayLike,
    torque: ArrayLike,
    minimum: ArrayLike,
    maximum: ArrayLike,
    *,
    reference: ArrayLike = 0.0,
    weight: ArrayLike = 1.0,
    warm_start: bool = False,
) -> Distribution:
    """Distributes torques over muscles within limits: least `sum w (F - F_ref)^2` with `R^T F = torque`.

    `moment_arms`: `R = -dl/dq`, m, shape `(muscles, joints)`. `torque`: N m, shape `(joints,)`. `minimum`, `maximum`,
    `reference`: N, `weight`: 1, shapes `(muscles,)` or one number. Each may have a leading axis of `n` problems; those
    without it hold for all. With `warm_start` a problem starts from the solution of the one before: faster for similar
    ones, equal up to rounding; without it every problem has the bits that it has alone.

    A torque out of reach is no error: see `Distribution.status`.

    >>> float(distribute([[0.03], [-0.03]], [1.5], 20.0, 400.0).tension[0])
    70.0
    """
    arms = np.asarray(moment_arms)
    muscles = arms.shape[-2] if arms.ndim in (2, 3) else 0

    def each(value: ArrayLike) -> ArrayLike:
        return np.full(muscles, value) if np.ndim(value) == 0 else value

    found = _sinew.distribute(
        moment_arms, torque, each(minimum), each(maximum), each(reference), each(weight), warm_start
    )
    return Distribution(**found)
