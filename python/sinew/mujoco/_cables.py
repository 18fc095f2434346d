"""Winches and elastic cables in the place of a model's actuators."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from math import ceil, isfinite, sqrt
from typing import Any

import mujoco
import numpy as np

from .. import _cable
from ._sheaths import add_instance, check_angle, check_bend, check_free, choose, pulls_on

#: Product of time step and frequency, up to which a cable needs no damping.
QUIET = 0.5


class StiffCableWarning(UserWarning):
    """Cables that are stiff for the time step were damped."""


@dataclass(frozen=True, slots=True)
class Cable:
    """A winch and an elastic cable in its sheath.

    `path`: `sinew.Free`, `sinew.Sheath` and `sinew.Pulley` from the drive's outlet to the anchor, with free cable at
    both ends.
    """

    path: Sequence[_cable.Segment]
    #: Coefficient of friction, >= 0.
    friction: float
    #: Strain per tension, 1/N, > 0.
    compliance_per_n: float
    #: Growth of friction with speed, s/m.
    viscous_s_per_m: float = 0.0
    #: Fraction of the tension left by losses that do not depend on the bend, in (0, 1].
    efficiency: float = 1.0
    #: Grease drag, N s/m, which fades below `drag_fade_n`, N.
    drag_n_s_per_m: float = 0.0
    drag_fade_n: float = 5.0
    #: Constant force in parallel at the anchor, N.
    pretension_n: float = 0.0
    #: Shortening of the sheath's wall per tension, 1/N.
    sheath_compliance_per_n: float = 0.0
    #: Tension at the anchor with which the simulation begins, N; by default the pretension.
    start_n: float | None = None

    def __post_init__(self) -> None:
        # The law's own check, of everything but the number of cells.
        parameters = {name: value for name, value in self._numbers().items() if name != "start_n"}
        bends = [part.bend_rad for part in self.path if isinstance(part, _cable.Sheath)]
        wraps = [part.wrap_rad for part in self.path if isinstance(part, _cable.Pulley)]
        check_bend(sum(bends), "the sum of the sheaths' bend_rad")
        _cable.Cable(self.path, cells=self.fewest_cells, **parameters)
        check_angle(self.friction * sum(bends + wraps), self.efficiency, "friction (bends + wraps)")
        start = self.start_n
        if start is not None and not (isfinite(start) and start >= self.pretension_n):
            raise ValueError(f"start_n must be a finite number of at least pretension_n, but is {start}")

    def _numbers(self) -> dict[str, float]:
        found = {field.name: getattr(self, field.name) for field in fields(self) if field.name != "path"}
        return {name: _cable._finite(name, value) for name, value in found.items() if value is not None}

    @property
    def fewest_cells(self) -> int:
        """Cells that keep the friction angle of every node below the law's limit."""
        sheaths = [part for part in self.path if isinstance(part, _cable.Sheath)]
        free = sum(isinstance(part, _cable.Free) for part in self.path)
        most = max([self.friction * part.bend_rad for part in sheaths], default=0.0)
        return max(free + len(sheaths) * max(1, ceil(most / 0.3)), 2)

    def _text(self) -> str:
        def part(segment: _cable.Segment) -> str:
            match segment:
                case _cable.Free(length):
                    return f"free={float(length)!r}"
                case _cable.Sheath(length, bend, curvature):
                    return "sheath=" + "/".join(repr(float(x)) for x in (length, bend, *curvature))
                case _cable.Pulley(wrap):
                    return f"pulley={float(wrap)!r}"

        defaults = {field.name: field.default for field in fields(self)}
        numbers = [f"{name}={value!r}" for name, value in self._numbers().items() if value != defaults[name]]
        return " ".join([part(segment) for segment in self.path] + numbers)

    @property
    def stiffness(self) -> float:
        """Of the cable seen from a small motion of the anchor, N/m: that of its last free length, the rest held by
        friction."""
        last = self.path[-1]
        assert isinstance(last, _cable.Free)
        return 1.0 / (self.compliance_per_n * last.length_m)


def add_cables(
    spec: Any,
    cables: Mapping[str, Cable],
    *,
    cells: int = 12,
    substeps: int = 1,
    speed: bool = False,
    damp: bool = True,
) -> list[str]:
    """Puts winches and cables in the place of the actuators of tendons of a `mujoco.MjSpec`; returns these tendons'
    names.

    `cables`: cable by tendon name or pattern, as in `add_sheaths`. Each of these tendons has one actuator, which
    keeps its name and gear; its control becomes the displacement of its winch, m, positive where it takes cable in,
    or with `speed` its speed, m/s. `cells`: pieces into which each cable is cut; `substeps`: of the cable per time
    step of the model.

    Where a cable is stiff for the model's time step (`dt sqrt(k/m)` above 0.5, `m` of the tendon at the reference
    pose), the tendon gets the damping `k dt` and the model the integrator `implicitfast`, which is stable at any
    stiffness, and a `StiffCableWarning` says so; `damp=False` leaves both.

    Raises `ValueError` that names the pattern, tendon or parameter, and `TypeError` for anything but a spec.
    """
    if not isinstance(spec, mujoco.MjSpec):
        raise TypeError(f"spec must be a mujoco.MjSpec (mujoco.MjSpec.from_file), but is {type(spec).__name__}")
    for name, value in (("cells", cells), ("substeps", substeps)):
        if isinstance(value, bool) or not isinstance(value, int) or value < 1:
            raise ValueError(f"{name} must be a whole number of at least 1, but is {value!r}")
    chosen: dict[str, Cable] = choose(spec, cables, Cable)
    check_free(spec, chosen, "cable")
    actuators: dict[str, Any] = {}
    for actuator in spec.actuators:
        tendon = pulls_on(actuator)
        if tendon in chosen:
            if tendon in actuators:
                raise ValueError(f"tendon {tendon} has more than one actuator, expected one to become its winch")
            if actuator.plugin.active:
                raise ValueError(
                    f"tendon {tendon}: its actuator is one of another plugin, {actuator.plugin.plugin_name}"
                )
            actuators[tendon] = actuator
    for name, cable in chosen.items():
        _check_cells(name, cable, cells)
    # Before the model is changed: how heavy each tendon is.
    masses = _masses(spec)
    text = "; ".join(f"{name}: {cable._text()}" for name, cable in chosen.items())
    config = {"cables": text, "cells": str(cells), "substeps": str(substeps)}
    instance = add_instance(spec, "sinew.cable", config)
    for actuator in actuators.values():
        _make_winch(actuator, instance, speed=speed)
    if damp:
        _damp(spec, chosen, masses)
    return list(chosen)


def _check_cells(name: str, cable: Cable, cells: int) -> None:
    parameters = {key: value for key, value in cable._numbers().items() if key != "start_n"}
    try:
        _cable.Cable(cable.path, cells=cells, **parameters)
    except ValueError as error:
        raise ValueError(f"tendon {name}: {error}") from None


def _make_winch(actuator: Any, instance: Any, *, speed: bool) -> None:
    actuator.gaintype = mujoco.mjtGain.mjGAIN_FIXED
    actuator.biastype = mujoco.mjtBias.mjBIAS_NONE
    actuator.dyntype = mujoco.mjtDyn.mjDYN_INTEGRATOR if speed else mujoco.mjtDyn.mjDYN_NONE
    actuator.actdim = 1 if speed else -1
    unlimited = mujoco.mjtLimited.mjLIMITED_FALSE
    actuator.ctrllimited = actuator.forcelimited = actuator.actlimited = unlimited
    actuator.ctrlrange = actuator.forcerange = actuator.actrange = [0.0, 0.0]
    actuator.plugin.name = instance.name
    actuator.plugin.plugin_name = instance.plugin_name
    actuator.plugin.active = True


def _masses(spec: Any) -> dict[str, float]:
    """Mass that each tendon moves at the reference pose, kg."""
    model = spec.copy().compile()
    names = [mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_TENDON, k) or "" for k in range(model.ntendon)]
    return {
        name: 1.0 / max(float(inverse), 1e-12) for name, inverse in zip(names, model.tendon_invweight0, strict=True)
    }


def _damp(spec: Any, chosen: dict[str, Cable], masses: dict[str, float]) -> None:
    step = float(spec.option.timestep)
    stiff = {
        name: ratio for name, cable in chosen.items() if (ratio := step * sqrt(cable.stiffness / masses[name])) > QUIET
    }
    if not stiff:
        return
    for tendon in spec.tendons:
        if tendon.name in stiff:
            added = chosen[tendon.name].stiffness * step
            old = np.atleast_1d(np.asarray(tendon.damping, dtype=float))
            # A number before MuJoCo's polynomials of damping, an array since.
            tendon.damping = (
                float(old[0]) + added if np.ndim(tendon.damping) == 0 else [float(old[0]) + added, *old[1:]]
            )
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    worst = max(stiff, key=lambda name: stiff[name])
    warnings.warn(
        f"{len(stiff)} of {len(chosen)} cables are stiff for a time step of {step:g} s ({worst}: dt sqrt(k/m) = {stiff[worst]:.2g}, "
        f"explicit up to {QUIET}): their tendons are damped by k dt, the integrator is implicitfast",
        StiffCableWarning,
        stacklevel=3,
    )
