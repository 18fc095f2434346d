"""The sheaths of a model's tendons as arrays."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any

import mujoco
import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..mujoco._sheaths import Sheath, check

#: Names of the parameters of a sheath, in the order of every array of them.
PARAMETERS = tuple(field.name for field in fields(Sheath))
#: The angle of friction above which it no longer grows, rad.
LARGEST_ANGLE = 20.0


@dataclass(frozen=True)
class Table:
    """Sheaths of all tendons of a model, and which actuators pull on them.

    Parameters of a tendon without a sheath are those of a straight one without friction.
    """

    #: Names of all tendons.
    names: tuple[str, ...]
    #: Whether a tendon has a sheath, shape `(tendons,)`.
    sheathed: NDArray[np.bool_]
    #: The fields of `Sheath`, each of shape `(tendons,)` or `(worlds, tendons)`.
    parameters: dict[str, NDArray[np.float64]]
    #: Friction, N, that the tendons have of their own beside that of the sheath, shape `(tendons,)`.
    own: NDArray[np.float64]
    #: Actuators that pull on tendons with sheaths, tendon by tendon.
    pulls: NDArray[np.int32]
    #: Where in `pulls` those of a tendon begin, shape `(tendons + 1,)`.
    begins: NDArray[np.int32]
    #: Force per force at the tendon, of every actuator.
    gear: NDArray[np.float64]
    #: Least and largest force of every actuator, N, shape `(actuators, 2)`: infinite without limits.
    limits: NDArray[np.float64]

    def filled(self, name: str, values: ArrayLike, worlds: int | None = None) -> NDArray[np.float64]:
        """Values of a parameter as an array of shape `(tendons,)`, or `(worlds, tendons)`.

        `values`: one for all, one for each tendon, or one for each world and tendon. Raises `ValueError` that names what was
        expected.
        """
        if name not in PARAMETERS:
            raise ValueError(f"{name!r} is no parameter of a sheath, expected one of {', '.join(PARAMETERS)}")
        shape = (len(self.names),) if worlds is None else (worlds, len(self.names))
        given = np.asarray(values)
        if given.dtype.kind not in "fiu":
            raise ValueError(f"{name} must be real numbers, but they are of type {given.dtype}")
        try:
            full = np.broadcast_to(given.astype(np.float64), shape)
        except ValueError:
            raise ValueError(f"{name} must be of a shape that fits {shape}, but is of {given.shape}") from None
        check(name, full)
        return np.array(full)


def table_from(model: Any, found: Sequence[Sheath | None], limited: NDArray[np.bool_]) -> Table:
    """Of a `MjModel` whose tendons have these sheaths; `limited`: which actuators have a range of their force."""
    blank = Sheath(mu=0.0, bend=0.0)
    parameters = {
        name: np.array([getattr(blank if sheath is None else sheath, name) for sheath in found], dtype=float)
        for name in PARAMETERS
    }
    sheathed = np.array([sheath is not None for sheath in found], dtype=np.bool_)
    tendon = tendon_of_actuators(model)
    by_tendon = [np.flatnonzero(tendon == k) if sheathed[k] else np.empty(0, dtype=int) for k in range(len(found))]
    limits = np.where(limited[:, np.newaxis], model.actuator_forcerange, [-np.inf, np.inf])
    return Table(
        names=tendon_names(model),
        sheathed=sheathed,
        parameters=parameters,
        own=np.array(model.tendon_frictionloss, dtype=float),
        pulls=np.concatenate([*by_tendon, np.empty(0)]).astype(np.int32),
        begins=np.cumsum([0, *(len(some) for some in by_tendon)]).astype(np.int32),
        gear=np.array(model.actuator_gear[:, 0], dtype=float),
        limits=limits.astype(float),
    )


def tendon_names(model: Any) -> tuple[str, ...]:
    """Of a `MjModel`; without a name, their numbers."""
    kind = mujoco.mjtObj.mjOBJ_TENDON
    return tuple(mujoco.mj_id2name(model, kind, k) or f"#{k}" for k in range(model.ntendon))


def tendon_of_actuators(model: Any) -> NDArray[np.int32]:
    """The tendon on which each actuator of a `MjModel` pulls, or -1."""
    on_tendon = np.asarray(model.actuator_trntype) == int(mujoco.mjtTrn.mjTRN_TENDON)
    return np.where(on_tendon, np.asarray(model.actuator_trnid)[:, 0], -1).astype(np.int32)
