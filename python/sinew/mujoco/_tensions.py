"""Tensions at both ends of the tendons of a model."""

from __future__ import annotations

import ctypes
from dataclasses import dataclass
from typing import Any
from weakref import WeakKeyDictionary

import mujoco
import numpy as np
from numpy.typing import NDArray

from ._connect import _library
from ._sheaths import written

#: In the state of a cable: whether it began, and the tension of its first cell.
BEGUN, FIRST = 0, 6


@dataclass(frozen=True, slots=True)
class Tensions:
    """Tensions of all tendons of a model, N, arrays of shape `(tendons,)`; positive where a tendon is pulled.

    Both are equal where a tendon has neither sheath nor cable, and 0 where no actuator pulls on it.
    """

    #: Names of the tendons; one without a name has `#` and its number.
    names: tuple[str, ...]
    #: At the actuators, before any friction.
    near: NDArray[np.float64]
    #: At the far end, behind all friction of the tendon, pretension included: what moves the model.
    far: NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class _Wiring:
    """What of a model its tensions follow from, and what stays as it is."""

    names: tuple[str, ...]
    #: Actuators on tendons, the places of their forces, and their tendons.
    actuators: NDArray[np.int64]
    places: NDArray[np.int64]
    tendons: NDArray[np.int64]
    sheathed: NDArray[np.bool_]
    pretension: NDArray[np.float64]
    #: Tendons with cables, and where in `plugin_state` the state of each begins.
    cabled: NDArray[np.int64]
    states: NDArray[np.int64]


_wirings: WeakKeyDictionary[Any, _Wiring] = WeakKeyDictionary()


def tensions(model: Any, data: Any) -> Tensions:
    """Tensions at both ends of every tendon of a `mujoco.MjModel`, as of the last forward pass of its `mujoco.MjData`.

    `mj_step` ends with the forces of its beginning: for those of the state that it left, call `mj_forward` before. The near
    end of a cable is that of the last complete step, and NaN before the first. Where friction is so large that 1e-4 of the
    tension reaches the far end, the near end of a sheath has four digits, beyond that fewer.
    """
    if not isinstance(model, mujoco.MjModel) or not isinstance(data, mujoco.MjData):
        given = f"{type(model).__name__} and {type(data).__name__}"
        raise TypeError(f"expected a mujoco.MjModel and its mujoco.MjData, but they are {given}")
    wiring = _wirings.get(model)
    if wiring is None:
        wiring = _wirings[model] = _wiring_of(model)
    # Forces act along a growing length: they are negative where they pull, friction is positive where the tendon is taken in.
    pulls = -np.asarray(data.actuator_force)[wiring.places] * np.asarray(model.actuator_gear)[wiring.places, 0]
    mean: NDArray[np.float64] = np.zeros(model.ntendon)
    np.add.at(mean, wiring.tendons, pulls)
    force, bound = np.zeros(model.ntendon), np.zeros(model.ntendon)
    rows = np.flatnonzero(np.asarray(data.efc_type) == mujoco.mjtConstraint.mjCNSTR_FRICTION_TENDON)
    rows = rows[wiring.sheathed[data.efc_id[rows]]]
    force[data.efc_id[rows]] = data.efc_force[rows]
    bound[data.efc_id[rows]] = data.efc_frictionloss[rows]
    # A sheath makes T cosh(theta) of the pull T, and T sinh(theta) the bound of friction beside what the tendon has of its own.
    grown = mean - wiring.pretension
    bound = np.clip(bound - np.asarray(model.tendon_frictionloss), 0.0, np.maximum(grown, 0.0))
    near = np.where(bound > 0.0, np.sqrt(np.abs((grown - bound) * (grown + bound))), grown)
    if len(wiring.cabled):
        state = np.asarray(data.plugin_state)
        near[wiring.cabled] = np.where(state[wiring.states + BEGUN] != 0.0, state[wiring.states + FIRST], np.nan)
    return Tensions(wiring.names, near, mean - force)


def _wiring_of(model: Any) -> _Wiring:
    names = tuple(mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_TENDON, k) or f"#{k}" for k in range(model.ntendon))
    actuators = np.flatnonzero(np.asarray(model.actuator_trntype) == int(mujoco.mjtTrn.mjTRN_TENDON))
    tendons = np.asarray(model.actuator_trnid)[actuators, 0].astype(np.int64)
    # Newer versions have actuators with several forces.
    places = np.asarray(getattr(model, "actuator_outadr", np.arange(model.nu)))[actuators].astype(np.int64)
    pretension, sheathed = np.zeros(model.ntendon), np.zeros(model.ntendon, dtype=np.bool_)
    cabled: list[int] = []
    states: list[int] = []
    for instance in range(model.nplugin):
        plugin = _plugin_name(int(model.plugin[instance]))
        if plugin == "sinew.sheath":
            text = bytes(model.plugin_attr)[int(model.plugin_attradr[instance]) :].split(b"\0")[0].decode()
            for k, values in written(text, names).items():
                sheathed[k], pretension[k] = True, float(values.get("pretension", 0.0))
        elif plugin == "sinew.cable":
            mine = np.flatnonzero(np.asarray(model.actuator_plugin) == instance)
            begin, count = int(model.plugin_stateadr[instance]), int(model.plugin_statenum[instance])
            cabled += np.asarray(model.actuator_trnid)[mine, 0].tolist()
            states += [begin + k * (count // len(mine)) for k in range(len(mine))]
    return _Wiring(names, actuators, places, tendons, sheathed, pretension, np.array(cabled, int), np.array(states, int))


def _plugin_name(slot: int) -> str:
    """Name of a plugin, which MuJoCo's structure of it begins with."""
    at_slot = _library(mujoco).mjp_getPluginAtSlot
    at_slot.restype, at_slot.argtypes = ctypes.POINTER(ctypes.c_char_p), [ctypes.c_int]
    found = at_slot(slot)
    return (found[0] or b"").decode() if found else ""
