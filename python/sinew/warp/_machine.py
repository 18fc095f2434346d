"""Machines of this library in many worlds of MuJoCo Warp."""

from __future__ import annotations

import json
import os
from typing import Any, Literal

import mujoco
import mujoco_warp as mjw
import numpy as np
import warp as wp
from numpy.typing import ArrayLike

from .. import _sinew
from .. import mujoco as sm
from .._machine import Machine
from ..batch import damp, prepare
from ..mujoco._machine import laid
from . import _kernels
from ._cables import Cables
from ._sheaths import Sheaths


class Machines:
    """A machine in many worlds, made by `load`: everything that MuJoCo Warp has of it, and its transmissions."""

    def __init__(self, model: Any, m: Any, d: Any, transmission: Cables | Sheaths, start: Any) -> None:
        #: The `mujoco.MjModel`.
        self.model = model
        #: Model and data of MuJoCo Warp.
        self.m, self.d = m, d
        #: Cables or sheaths, attached.
        self.transmission = transmission
        self._start: Any = wp.array(np.atleast_2d(start), dtype=float, device=d.qpos.device)
        self.reset()

    @property
    def worlds(self) -> int:
        """How many."""
        return int(self.d.nworld)

    def step(self) -> None:
        """One time step of all worlds."""
        mjw.step(self.m, self.d)

    def reset(self, worlds: Any = None) -> None:
        """Puts all worlds, or those of a mask, into the machine's start: booleans of shape `(worlds,)`."""
        mask = self.transmission.mask(worlds)
        mjw.reset_data(self.m, self.d, mask)
        wp.launch(_kernels.place, dim=self.d.qpos.shape, inputs=[mask, self._start, self.d.qpos], device=mask.device)
        self.transmission.reset(mask)


def load(
    machine: Machine | str | os.PathLike[str],
    *,
    worlds: int,
    transmission: Literal["cables", "sheaths"] = "cables",
    timestep_s: float = 1e-3,
    cells: int = 12,
    substeps: int = 1,
    turning: float = 1.0,
    tension_n: ArrayLike | None = None,
    rows: int | None = None,
    device: Any = None,
) -> Machines:
    """A machine in many worlds of MuJoCo Warp, in its start.

    Everything but `worlds`, `rows` and `device` is as of `sinew.mujoco.load`: controls are displacements of the winches, m,
    with `"cables"`, tensions at the motors, N, with `"sheaths"`. `rows`: places for the constraints of a world, by default
    twice those of the start.

    Friction of drives, their dynamics, sensors and rewards are not part of it: `sinew.gym` has them.
    """
    if transmission not in ("cables", "sheaths"):
        raise ValueError(f"transmission must be 'cables' or 'sheaths', but is {transmission!r}")
    known = machine if isinstance(machine, Machine) else Machine(machine)
    model = sm.load(known, transmission="none", timestep_s=timestep_s)
    part: Cables | Sheaths
    if transmission == "sheaths":
        model = prepare(model, sm.sheaths_of(known, turning=turning))
        part = Sheaths(model, worlds=worlds, device=device)
    else:
        cables = laid(known, json.loads(_sinew.mujoco_machine(known)[1])["muscles"], tension_n)
        model = damp(model, cables)
        part = Cables(model, cables, cells=cells, substeps=substeps, worlds=worlds, device=device)
    start = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, start, 0)
    mujoco.mj_forward(model, start)
    places = max(2 * int(start.nefc), model.nv + model.ntendon + 16) if rows is None else rows
    with wp.ScopedDevice(device):
        m = mjw.put_model(model)
        d = mjw.put_data(model, start, nworld=worlds, njmax=places)
    return Machines(model, m, d, part.attach(m, d), np.array(start.qpos))
