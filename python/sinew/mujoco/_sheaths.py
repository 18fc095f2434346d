"""Sheaths on the tendons of a model."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from difflib import get_close_matches
from fnmatch import fnmatchcase
from math import log, pi, radians
from typing import Any, TypeVar

import mujoco
import numpy as np
from numpy.typing import ArrayLike

from .. import _cable as segment

T = TypeVar("T")

#: Friction, N, that a tendon has of its own: its constraint exists only above zero.
MIN_FRICTION = 1e-9
#: Time constant, s, which MuJoCo raises to two steps: a constraint that sticks stops slip in one.
SHORTEST = 1e-6
#: Turns of a sheath beyond which its bend is taken for degrees, and the angle of friction, rad, that locks its far end.
MOST_TURNS, LOCKED = 6, 20.0


@dataclass(frozen=True, slots=True)
class Sheath:
    """A bent sheath between a tendon's actuators and the model.

    The tension at its far end is within `T exp(-theta)` and `T exp(theta)` of the pull `T` of the actuators, `theta =
    min(20, mu (bend + turning * angle of the path) (1 + rise/(1 + (v/speed)^2)) - ln(efficiency))`, plus `pretension`.
    """

    #: Coefficient of friction, >= 0.
    mu: float
    #: Sum of the magnitudes of its bends, rad, from 0 to 37.7 (six turns), independent of the pose.
    bend: float
    #: Fraction of the turning of the tendon's path in the model that counts as bend, >= 0.
    turning: float = 0.0
    #: Fraction of the tension left by losses that do not depend on the bend, in (0, 1].
    efficiency: float = 1.0
    #: Constant force in parallel at the far end, N, >= 0.
    pretension: float = 0.0
    #: Friction at rest is `1 + rise` times that of fast sliding, >= 0.
    rise: float = 0.0
    #: Speed at which half of the rise remains, m/s, > 0.
    speed: float = 0.01

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if isinstance(value, bool) or not isinstance(value, (int, float)):
                raise ValueError(f"{field.name} must be a finite number, but is {value!r}")
            check(field.name, value)
        check_angle(self.mu * self.bend * (1.0 + self.rise), self.efficiency, "mu bend (1 + rise)")

    def _text(self) -> str:
        defaults = {field.name: field.default for field in fields(self)}
        given = {name: float(getattr(self, name)) for name in defaults}
        return " ".join(f"{name}={value!r}" for name, value in given.items() if value != defaults[name])


def check(name: str, values: ArrayLike) -> None:
    """Raises `ValueError` for numbers outside of the domain of a sheath's parameter."""
    numbers = np.ravel(np.asarray(values, dtype=float))
    positive = name in ("efficiency", "speed")
    for wrong, expected in (
        (~np.isfinite(numbers), "a finite number"),
        (numbers <= 0.0 if positive else numbers < 0.0, f"{'above' if positive else 'at least'} zero"),
        ((numbers > 1.0) & (name == "efficiency"), "at most 1"),
    ):
        if wrong.any():
            raise ValueError(f"{name} must be {expected}, but is {numbers[wrong].tolist()[0]!r}")
    if name == "bend":
        check_bend(float(numbers.max(initial=0.0)), name)


def check_bend(bend: float, name: str) -> None:
    """Raises `ValueError` for a bend that must be in degrees."""
    if bend > 2.0 * pi * MOST_TURNS:
        most, hint = f"{2.0 * pi * MOST_TURNS:.1f} rad ({MOST_TURNS} turns)", f"math.radians({bend:g}) = {radians(bend):.4g}"
        raise ValueError(f"{name} must be at most {most}, but is {bend:g}: is it in degrees? {hint}")


def check_angle(angle: float, efficiency: float, name: str) -> None:
    """Raises `ValueError` for friction that leaves nothing of the tension at the far end."""
    if (theta := angle - log(efficiency)) > LOCKED:
        raise ValueError(
            f"the friction angle {name} - ln efficiency must be at most {LOCKED:g}, but is {theta:.3g}: "
            "bends are in rad, not degrees"
        )


def add_sheaths(spec: Any, sheaths: Mapping[str, Sheath], *, impedance: float = 0.995) -> list[str]:
    """Puts sheaths on the tendons of a `mujoco.MjSpec`; returns the names of these tendons.

    `sheaths`: sheath by tendon name or by pattern (`*`, `?`, `[..]`); the last one that fits a tendon counts. Only
    tendons on which actuators pull get one. `impedance`: of the friction constraint at rest, in (0, 1): a cable that
    is held creeps by `(1 - impedance)/impedance * dt * force/mass`; 0.999 makes steps of large models slower by a
    third.

    Sets the friction of these tendons (`frictionloss`, `solref_friction`, `solimp_friction`) and moves the limits of
    their actuators' forces before the sheath (`forcelimited` false, `forcerange` applied by the plugin); everything
    else stays as it is.

    Raises `ValueError` that names the pattern, tendon or parameter, for a tendon that has a sheath or a cable already as well,
    and `TypeError` for anything but a spec.
    """
    if not isinstance(spec, mujoco.MjSpec):
        raise TypeError(f"spec must be a mujoco.MjSpec (mujoco.MjSpec.from_file), but is {type(spec).__name__}")
    check_impedance(impedance)
    chosen = choose(spec, sheaths, Sheath)
    check_free(spec, chosen, "sheath")
    text = "; ".join(f"{name}: {sheath._text()}" for name, sheath in chosen.items())
    add_instance(spec, "sinew.sheath", {"sheaths": text})
    solref, solimp = sticking(spec.option, impedance)
    for tendon in spec.tendons:
        if tendon.name in chosen:
            tendon.frictionloss = max(tendon.frictionloss, MIN_FRICTION)
            tendon.solref_friction, tendon.solimp_friction = solref, solimp
    for actuator in spec.actuators:
        if pulls_on(actuator) in chosen:
            low, high = actuator.forcerange
            automatic = actuator.forcelimited == mujoco.mjtLimited.mjLIMITED_AUTO
            limited = low < high if automatic else bool(actuator.forcelimited)
            actuator.forcelimited = mujoco.mjtLimited.mjLIMITED_FALSE
            actuator.forcerange = [low, high] if limited else [0.0, 0.0]
    return list(chosen)


def check_free(spec: Any, chosen: Mapping[str, Any], kind: str) -> None:
    """Raises `ValueError` where a tendon that gets a sheath or cable has one already: friction would act twice, or not at all."""
    plugins = {pulls_on(actuator): actuator.plugin.plugin_name for actuator in spec.actuators if actuator.plugin.active}
    names = [tendon.name for tendon in spec.tendons]
    texts = [instance.config.get("sheaths", "") for instance in spec.plugins if instance.plugin_name == "sinew.sheath"]
    sheathed = {names[k] for text in texts for k in written(text, names)}
    for name in chosen:
        there = "cable" if plugins.get(name) == "sinew.cable" else "sheath" if name in sheathed else None
        if there == kind:
            raise ValueError(f"tendon {name} has a {there} already: name every tendon in one call of add_{kind}s alone")
        if there is not None:
            raise ValueError(
                f"tendon {name} has a {there} already, expected only one of both: "
                "a Cable has the friction of its own sheath, so leave the tendon out of add_sheaths"
            )


def check_impedance(impedance: float) -> None:
    """Raises `ValueError` for anything outside of (0, 1)."""
    if not 0.0 < impedance < 1.0:
        raise ValueError(f"impedance must be in (0, 1), but is {impedance}")


def sticking(option: Any, impedance: float) -> tuple[list[float], list[float]]:
    """`solref` and `solimp` of friction constraints that stop slip in one step, for the options of a model or spec."""
    safe = not option.disableflags & mujoco.mjtDisableBit.mjDSBL_REFSAFE
    return [SHORTEST if safe else 2.0 * option.timestep, 1.0], [impedance, impedance, 0.001, 0.5, 2.0]


def choose(spec: Any, given: Mapping[str, Any], kind: type) -> dict[str, Any]:
    """What each tendon of a spec with an actuator gets."""
    names = [tendon.name for tendon in spec.tendons]
    pulled = {pulls_on(actuator) for actuator in spec.actuators}
    found = match(names, [name in pulled for name in names], given, kind)
    chosen = {name: value for name, value in zip(names, found, strict=True) if value is not None}
    for name in chosen:
        if ";" in name or ": " in name or name != name.strip():
            raise ValueError(
                f"tendon {name!r}: a name with semicolons, or with spaces at its ends or behind a colon, cannot be used"
            )
    return chosen


def match(names: Sequence[str], pulled: Sequence[bool], given: Mapping[str, T], kind: type[T]) -> list[T | None]:
    """What each of a model's tendons gets; `pulled`: whether an actuator pulls on it."""
    if not isinstance(given, Mapping):
        raise TypeError(f"expected a mapping of tendon names to {called(kind)}, but it is a {called(type(given))}")
    if not names:
        raise ValueError("the model has no tendons")
    if not given:
        raise ValueError(f"no tendon is named, expected some of {', '.join(names)}")
    found: list[T | None] = [None] * len(names)
    for pattern, value in given.items():
        if not isinstance(value, kind):
            part = ", one part of the path of a Cable" if type(value) is segment.Sheath else ""
            raise TypeError(f"{pattern}: expected a {called(kind)}, but it is a {called(type(value))}{part}")
        hits = [k for k, name in enumerate(names) if name == pattern or fnmatchcase(name, pattern)]
        if not hits:
            near = get_close_matches(pattern, names, 1)
            meant = f"; did you mean {near[0]}?" if near else ""
            raise ValueError(f"{pattern!r} fits no tendon of the model: {', '.join(names)}{meant}")
        if not any(pulled[k] for k in hits):
            raise ValueError(f"{pattern!r}: no actuator pulls on {', '.join(names[k] for k in hits)}")
        for k in hits:
            if pulled[k]:
                found[k] = value
    return found


def called(kind: type) -> str:
    """Name of a type as a user writes it."""
    place = [part for part in kind.__module__.split(".") if not part.startswith("_")]
    return ".".join([*place, kind.__name__]) if place[:1] == ["sinew"] else kind.__name__


def written(text: str, names: Sequence[str]) -> dict[int, dict[str, str]]:
    """Sheaths as the plugin's configuration has them, by the number of the tendon; the last pattern that fits one counts."""
    found = {}
    for entry in text.split(";"):
        # A name may have colons of its own.
        parts = re.match(r"(.*?):(?:\s+(.*))?$", entry.strip(), re.DOTALL)
        if parts is not None:
            values = dict(pair.split("=", 1) for pair in (parts[2] or "").split() if "=" in pair)
            # Brackets are no patterns there.
            fits = parts[1].strip().replace("[", "[[]")
            found.update({k: values for k, name in enumerate(names) if fnmatchcase(name, fits)})
    return found


def pulls_on(actuator: Any) -> str | None:
    """Name of the tendon on which an actuator of a spec pulls."""
    return str(actuator.target) if actuator.trntype == mujoco.mjtTrn.mjTRN_TENDON else None


def add_instance(spec: Any, plugin: str, config: dict[str, str]) -> Any:
    """Adds an instance of a plugin with its configuration to a spec."""
    taken = {instance.name for instance in spec.plugins}
    names = (plugin if k == 1 else f"{plugin}.{k}" for k in range(1, len(taken) + 2))
    if not hasattr(mujoco.MjsPlugin, "config"):
        raise RuntimeError(
            f"MuJoCo {mujoco.__version__} cannot configure plugins through MjSpec: use 3.3.3 or newer, or write them in XML"
        )
    instance = spec.add_plugin()
    if hasattr(spec, "activate_plugin"):
        spec.activate_plugin(plugin)
    instance.name = next(name for name in names if name not in taken)
    instance.plugin_name = plugin
    instance.active = True
    instance.config = config
    return instance
