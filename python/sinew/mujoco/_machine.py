"""Machines of this library, and what identification found, as parts of MuJoCo models."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from typing import Any, Literal

import mujoco
import numpy as np
from numpy.typing import ArrayLike

from .. import _cable, _sinew
from .._machine import Machine, distribute
from .._model import Model
from ._appearance import make_visible
from ._cables import Cable, add_cables
from ._sheaths import Sheath, add_sheaths

#: Tension, N, below which no cable begins; of a machine whose file names no limit.
SLACK, STRONG = 5.0, 1e4


def load(
    machine: Machine | str | os.PathLike[str],
    *,
    transmission: Literal["cables", "sheaths", "none"] = "cables",
    timestep_s: float = 1e-3,
    cells: int = 12,
    substeps: int = 1,
    turning: float = 1.0,
    tension_n: ArrayLike | None = None,
) -> Any:
    """A `mujoco.MjModel` of a machine with its transmissions; see `spec_of`."""
    return spec_of(
        machine,
        transmission=transmission,
        timestep_s=timestep_s,
        cells=cells,
        substeps=substeps,
        turning=turning,
        tension_n=tension_n,
    ).compile()


def spec_of(
    machine: Machine | str | os.PathLike[str],
    *,
    transmission: Literal["cables", "sheaths", "none"] = "cables",
    timestep_s: float = 1e-3,
    cells: int = 12,
    substeps: int = 1,
    turning: float = 1.0,
    tension_n: ArrayLike | None = None,
) -> Any:
    """A `mujoco.MjSpec` of a machine with its transmissions.

    `machine`: as for `sinew.Machine`. With `"cables"` the controls are displacements of the winches, m, and the
    cables begin with `tension_n` at their anchors, N, shape `(muscles,)`, by default such that the machine is held in
    its start, as far as its limits allow; with `"sheaths"` the controls are tensions at the motors, N, and `turning`
    is the fraction of the turning of the muscles' paths that counts beside the bend of the sheaths. With `"none"` they are
    tensions without any loss, and the model has no plugin, as `sinew.batch.prepare` wants it. The start is the key
    `start`: `mujoco.mj_resetDataKeyframe(model, data, 0)`.

    Sheaths have the bend of the start, in all poses. Friction of drives and their dynamics are not part of the model.
    Light, a first view and bones are for pictures alone; what a body's own file draws takes the bone's place.
    """
    if transmission not in ("cables", "sheaths", "none"):
        raise ValueError(f"transmission must be 'cables', 'sheaths' or 'none', but is {transmission!r}")
    if not 0.0 < timestep_s < 1.0:
        raise ValueError(f"timestep_s must be in (0, 1), but is {timestep_s}")
    known = machine if isinstance(machine, Machine) else Machine(machine)
    xml, described = _sinew.mujoco_machine(known)
    muscles, start = (json.loads(described)[part] for part in ("muscles", "start"))
    names = [muscle["name"] for muscle in muscles]
    spec = bare(xml, names, timestep_s)
    make_visible(spec, names, start)
    spec.add_key(name="start", qpos=start)
    if transmission == "none":
        return spec
    if transmission == "sheaths":
        add_sheaths(spec, sheaths_of(known, turning=turning))
        return spec
    add_cables(spec, laid(known, muscles, tension_n), cells=cells, substeps=substeps)
    return spec


def bare(xml: str, muscles: list[str], timestep_s: float) -> Any:
    """A `mujoco.MjSpec` of a machine's MJCF with one motor for every muscle, without transmissions and keys."""
    spec = mujoco.MjSpec.from_string(xml)
    spec.option.timestep = timestep_s
    # MuJoCo wants a mass of every body that moves, one with an armature alone too.
    spec.compiler.boundmass, spec.compiler.boundinertia = 1e-9, 1e-12
    for equality in spec.equalities:
        # Joints that follow others do so exactly, not as softly as contacts.
        equality.solref, equality.solimp = [2.0 * timestep_s, 1.0], [0.9999, 0.9999, 0.001, 0.5, 2.0]
    _one_motor_each(spec, muscles)
    for key in list(spec.keys):
        spec.delete(key) if hasattr(spec, "delete") else key.delete()
    return spec


def laid(machine: Machine, muscles: list[dict[str, Any]], tension_n: ArrayLike | None) -> dict[str, Cable]:
    """The cable of every muscle with the tension at which it begins, by default such that the machine is held in its start."""
    tensions = _holding(machine, muscles) if tension_n is None else _given(tension_n, len(muscles))
    return {
        muscle["name"]: _cable_of(muscle["path"], muscle["parameters"], start)
        for muscle, start in zip(muscles, tensions, strict=True)
    }


def sheaths_of(machine: Machine | str | os.PathLike[str], *, turning: float = 1.0) -> dict[str, Sheath]:
    """The sheath of every muscle of a machine, for `add_sheaths`.

    `turning`: fraction of the turning of the muscle's path in the model that counts beside the bend of the sheath.
    """
    known = machine if isinstance(machine, Machine) else Machine(machine)
    _, described = _sinew.mujoco_machine(known)
    found = {}
    for muscle in json.loads(described)["muscles"]:
        bend = sum(part["sheath"]["bend_rad"] for part in muscle["path"] if "sheath" in part)
        parameters = muscle["parameters"]
        found[muscle["name"]] = Sheath(
            parameters["friction"], bend, turning, parameters["efficiency"], parameters["pretension_n"]
        )
    return found


def cables_of(machine: Machine | str | os.PathLike[str]) -> dict[str, Cable]:
    """The cable of every muscle of a machine as designed, at its start, for `add_cables`."""
    known = machine if isinstance(machine, Machine) else Machine(machine)
    _, described = _sinew.mujoco_machine(known)
    return {
        muscle["name"]: _cable_of(muscle["path"], muscle["parameters"], None)
        for muscle in json.loads(described)["muscles"]
    }


def calibrate_from(model: Model | str | os.PathLike[str]) -> tuple[Sheath, Cable]:
    """Sheath and cable with the parameters that an identification found.

    `model`: a `sinew.Model` or the `model.json` of an observer, which `sinew identify` fits to logs with
    displacements of both ends (`anchor`). Other models describe signals, not a cable: they are refused.

    Raises `ValueError`, and `FileNotFoundError`.
    """
    known = model if isinstance(model, Model) else Model.load(model)
    estimator = json.loads(known.to_json())["model"]["estimator"]
    found = _find(estimator)
    if found is None:
        raise ValueError(
            "the model describes signals, not a cable: expected an observer, identified with the displacement of the anchor "
            '(identify(.., models=["observer"]))'
        )
    path, parameters = found["path"], found["parameters"]
    angle = sum(part["sheath"]["bend_rad"] for part in path if "sheath" in part)
    angle += sum(part["pulley"]["wrap_rad"] for part in path if "pulley" in part)
    sheath = Sheath(
        parameters["friction"], angle, efficiency=parameters["efficiency"], pretension=parameters["pretension_n"]
    )
    return sheath, _cable_of(path, parameters, None)


def _find(value: Any) -> Any:
    """The cable of an estimator."""
    if isinstance(value, dict):
        if {"path", "parameters"} <= value.keys():
            return value
        return next((found for part in value.values() if (found := _find(part)) is not None), None)
    return None


def _cable_of(path: Sequence[dict[str, Any]], parameters: dict[str, Any], start: float | None) -> Cable:
    def part(written: dict[str, Any]) -> _cable.Segment:
        ((kind, values),) = written.items()
        match kind:
            case "free":
                return _cable.Free(values["length_m"])
            case "sheath":
                return _cable.Sheath(values["length_m"], values["bend_rad"], tuple(values.get("curvature", ())))
            case _:
                return _cable.Pulley(values["wrap_rad"])

    numbers = {name: value for name, value in parameters.items() if name != "weakening"}
    if start is not None:
        numbers["start_n"] = max(start, numbers["pretension_n"])
    return Cable(tuple(part(written) for written in path), **numbers)


def _one_motor_each(spec: Any, muscles: list[str]) -> None:
    """Gives every muscle one actuator, whose force is the tension: what a body's file had instead is of another
    drive."""
    for actuator in list(spec.actuators):
        spec.delete(actuator) if hasattr(spec, "delete") else actuator.delete()
    for name in muscles:
        motor = spec.add_actuator(name=name, trntype=mujoco.mjtTrn.mjTRN_TENDON, target=name)
        motor.gear = [-1.0, 0.0, 0.0, 0.0, 0.0, 0.0]


def _given(tension: ArrayLike, count: int) -> list[float]:
    """Tensions of the caller."""
    numbers = np.asarray(tension, dtype=float)
    if numbers.shape != (count,) or not np.isfinite(numbers).all():
        raise ValueError(f"tension_n must be finite numbers of shape ({count},), but has the shape {numbers.shape}")
    return [float(x) for x in numbers]


def _holding(machine: Machine, muscles: list[dict[str, Any]]) -> list[float]:
    """Tensions at the anchors that hold the machine in its start, N, as near as its limits allow."""
    least, most = (
        np.array([otherwise if muscle["tension_n"][k] is None else muscle["tension_n"][k] for muscle in muscles])
        for k, otherwise in ((0, SLACK), (1, STRONG))
    )
    least = np.maximum(least, [muscle["parameters"]["pretension_n"] + 1.0 for muscle in muscles])
    still = np.zeros(len(machine.joint_names))
    torque = machine.inverse_dynamics(machine.start, still, still)
    found = distribute(machine.moment_arms(machine.start), torque, least, np.maximum(most, least + 1.0))
    return [float(x) for x in np.where(np.isfinite(found.tension), found.tension, least)]
