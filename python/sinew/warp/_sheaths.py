"""Sheaths of every world of a model in MuJoCo Warp."""

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp
from numpy.typing import ArrayLike, NDArray

from ..batch._prepare import check_solver, table_of
from ..batch._table import PARAMETERS
from . import _kernels
from ._attach import Hub, hub_of

#: Fields of a model of MuJoCo Warp that `sinew.batch.prepare` changes.
PREPARED = ("tendon_frictionloss", "tendon_solref_fri", "tendon_solimp_fri")


class Sheaths:
    """Friction of sheaths on the tendons of many worlds.

    `model`: a `mujoco.MjModel` from `sinew.batch.prepare`. `worlds`: how many. `device`: of Warp, by default the current one.

    Until `attach` nothing happens; from then on every step of the data has friction, in CUDA graphs as well.
    """

    def __init__(self, model: Any, *, worlds: int, device: Any = None) -> None:
        if isinstance(worlds, bool) or not isinstance(worlds, int) or worlds < 1:
            raise ValueError(f"worlds must be a whole number of at least 1, but is {worlds!r}")
        self._table = table = table_of(model)
        self._model, self._worlds = model, worlds
        self._device = device = wp.get_device(device)
        self._attached: tuple[Hub, Any] | None = None
        tendons = len(table.names)
        full = np.stack([table.filled(name, table.parameters[name], worlds) for name in PARAMETERS])

        def array(values: NDArray[Any], kind: Any) -> Any:
            return wp.array(values, dtype=kind, device=device)

        # One array of one shape: parameters can change between replays of a graph.
        self._parameters = array(full.astype(np.float32), float)
        self._sheathed, self._own = array(table.sheathed, bool), array(table.own, float)
        self._begins, self._pulls = array(table.begins, int), array(table.pulls, int)
        self._gear, self._limits = array(table.gear, float), array(table.limits, wp.vec2)
        self._found, self._last = (wp.full((worlds, tendons), _kernels.NONE, dtype=int, device=device) for _ in range(2))
        self._all = wp.full(worlds, True, dtype=bool, device=device)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the model's tendons, in the order of all arrays."""
        return self._table.names

    @property
    def parameters(self) -> dict[str, Any]:
        """Of the sheaths, as Warp arrays of shape `(worlds, tendons)`, by the names of the fields of `sinew.mujoco.Sheath`."""
        return {name: self._parameters[place] for place, name in enumerate(PARAMETERS)}

    def attach(self, m: Any, d: Any) -> Sheaths:
        """Lets the sheaths act on a model and data of MuJoCo Warp, whenever it is stepped; returns them.

        `m`, `d`: as of `mujoco_warp.put_model` and `make_data` or `put_data`, or `solver.mjw_model` and `solver.mjw_data` of
        Newton's MuJoCo solver. A callback that the model has already is called before.

        Raises `ValueError` where model and data do not fit the sheaths or lose friction, and `ImportError` where a hoist with
        this version of MuJoCo Warp does not hold and slide at the edges of friction, tried once.
        """
        from ._check import hoist_holds_and_slides

        if self._attached is not None:
            raise ValueError("the sheaths are attached already: make others for another model or data")
        check_solver(m.opt)
        for name, found, expected in (
            ("tendons", m.ntendon, len(self._table.names)),
            ("actuators", m.actuator_trntype.shape[0], len(self._table.gear)),
            ("worlds", d.nworld, self._worlds),
        ):
            if found != expected:
                raise ValueError(f"the sheaths are made for {expected} {name}, but there are {found}")
        if d.efc.aref.device != self._device:
            raise ValueError(f"the sheaths are on {self._device}, but the data is on {d.efc.aref.device}")
        hoist_holds_and_slides()
        self._attach(m, d)
        return self

    def _attach(self, m: Any, d: Any) -> None:
        self._rub_inputs = self._inputs(d)
        self._rows = m.nv + m.ntendon
        # Newton has made its model of its own.
        for name in PREPARED:
            _overwrite(getattr(m, name), np.asarray(getattr(self._model, name)), self._table.sheathed)
        limited = m.actuator_forcelimited.numpy()
        limited[self._table.pulls] = False
        m.actuator_forcelimited.assign(limited)
        hub = hub_of(m)
        hub.add(d, self)
        self._attached = hub, d

    def detach(self) -> None:
        """Ends the friction; the constraints that `prepare` made stay and hold nothing."""
        if self._attached is not None:
            hub, d = self._attached
            hub.remove(d, self)
            self._attached = None

    def set(self, *, worlds: Any = None, **parameters: Any) -> None:
        """Changes parameters, fields of `sinew.mujoco.Sheath`, of all worlds or of those of a mask.

        Each is one number, one for each tendon, or one for each world and tendon. `worlds`: booleans of shape `(worlds,)`.
        Arrays of Warp, `float` of shape `(1 or worlds, tendons)`, are taken without a look at what they hold and without
        waiting for the device.
        """
        values = {name: self._values(name, given) for name, given in parameters.items()}
        mask = self._mask(worlds)
        shape = self._found.shape
        for name, given in values.items():
            inputs = [PARAMETERS.index(name), given, mask, self._parameters]
            wp.launch(_kernels.put, dim=shape, inputs=inputs, device=self._device)

    def reset(self, worlds: Any = None) -> None:
        """Forgets the forces of the last step, in all worlds or in those of a mask: where an episode begins."""
        wp.launch(_kernels.forget, dim=self._last.shape, inputs=[self._mask(worlds), self._last], device=self._device)

    def act(self, m: Any, d: Any) -> None:
        """One step's friction: two launches. MuJoCo Warp calls it."""
        found = self._found
        inputs = [d.ne, d.nf, d.efc.type, d.efc.id, found]
        wp.launch(_kernels.find_rows, dim=(self._worlds, self._rows), inputs=inputs, device=self._device)
        wp.launch(_kernels.rub, dim=found.shape, inputs=self._rub_inputs, device=self._device)

    def _inputs(self, d: Any) -> list[Any]:
        own = [self._parameters, self._sheathed, self._own, self._begins, self._pulls, self._gear, self._limits]
        path = [d.ten_velocity, d.ten_wrapadr, d.ten_wrapnum, d.wrap_xpos, d.wrap_obj]
        rows = [d.efc.D, d.efc.force, self._found, self._last]
        return [*own, *path, *rows, d.actuator_force, d.efc.frictionloss, d.efc.aref]

    def _values(self, name: str, given: ArrayLike | Any) -> Any:
        if not isinstance(given, wp.array):
            shaped = self._table.filled(name, given, self._worlds if np.ndim(given) == 2 else None)
            return wp.array(np.atleast_2d(shaped), dtype=float, device=self._device)
        tendons = len(self._table.names)
        if name not in PARAMETERS or given.dtype != wp.float32 or given.shape not in ((1, tendons), (self._worlds, tendons)):
            expected = f"float32 of shape (1 or {self._worlds}, {tendons}) of one of {', '.join(PARAMETERS)}"
            raise ValueError(f"{name} must be {expected}, but is {given.dtype.__name__} of shape {given.shape}")
        return given

    def _mask(self, worlds: Any) -> Any:
        if worlds is None:
            return self._all
        mask = worlds if isinstance(worlds, wp.array) else np.asarray(worlds)
        boolean = mask.dtype in (wp.bool, np.dtype(np.bool_))
        if not boolean or mask.shape != (self._worlds,):
            raise ValueError(f"worlds must be {self._worlds} booleans, but is {mask.dtype} of shape {mask.shape}")
        return mask if isinstance(mask, wp.array) else wp.array(mask, dtype=bool, device=self._device)


def _overwrite(array: Any, values: NDArray[Any], chosen: NDArray[np.bool_]) -> None:
    """Writes values of the tendons with sheaths into an array of a model, whatever number of worlds it has."""
    there = array.numpy()
    changed = there.copy()
    changed[:, chosen] = values[chosen].astype(there.dtype)
    if not np.array_equal(there, changed):
        array.assign(changed)
