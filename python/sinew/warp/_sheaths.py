"""Sheaths of every world of a model in MuJoCo Warp."""

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from ..batch._prepare import table_of
from ..batch._table import PARAMETERS
from . import _kernels
from ._attach import Part, unlimit

#: Fields of a model of MuJoCo Warp that `sinew.batch.prepare` changes.
PREPARED = ("tendon_frictionloss", "tendon_solref_fri", "tendon_solimp_fri")


class Sheaths(Part):
    """Friction of sheaths on the tendons of many worlds.

    `model`: a `mujoco.MjModel` from `sinew.batch.prepare`. `worlds`: how many. `device`: of Warp, by default the current one.

    Until `attach` nothing happens; from then on every step of the data has friction, in CUDA graphs as well.
    """

    def __init__(self, model: Any, *, worlds: int, device: Any = None) -> None:
        self._table = table = table_of(model)
        super().__init__(worlds, device)
        self._model = model
        tendons = len(table.names)
        full = np.stack([table.filled(name, table.parameters[name], worlds) for name in PARAMETERS])

        def array(values: NDArray[Any], kind: Any) -> Any:
            return wp.array(values, dtype=kind, device=self._device)

        # One array of one shape: parameters can change between replays of a graph.
        self._parameters = array(full.astype(np.float32), float)
        self._sheathed, self._own = array(table.sheathed, bool), array(table.own, float)
        self._begins, self._pulls = array(table.begins, int), array(table.pulls, int)
        self._gear, self._limits = array(table.gear, float), array(table.limits, wp.vec2)
        self._found, self._last = (
            wp.full((worlds, tendons), _kernels.NONE, dtype=int, device=self._device) for _ in range(2)
        )

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the model's tendons, in the order of all arrays."""
        return self._table.names

    @property
    def parameters(self) -> dict[str, Any]:
        """Of the sheaths, as Warp arrays of shape `(worlds, tendons)`, by the names of the fields of `sinew.mujoco.Sheath`."""
        return {name: self._parameters[place] for place, name in enumerate(PARAMETERS)}

    def set(self, *, worlds: Any = None, **parameters: Any) -> None:
        """Changes parameters, fields of `sinew.mujoco.Sheath`, of all worlds or of those of a mask.

        Each is one number, one for each tendon, or one for each world and tendon. `worlds`: booleans of shape `(worlds,)`.
        Arrays of Warp, `float` of shape `(1 or worlds, tendons)`, are taken without a look at what they hold and without
        waiting for the device. Raises `ValueError` and changes nothing where one of them is wrong.
        """
        tendons, ready = len(self._table.names), []
        for name, given in parameters.items():
            if name not in PARAMETERS or not isinstance(given, wp.array):
                given = self._table.filled(name, given, self._worlds if np.ndim(given) == 2 else None)
            ready.append((PARAMETERS.index(name), self._columns(name, given, tendons)))
        mask = self.mask(worlds)
        for place, values in ready:
            inputs = [place, values, mask, self._parameters]
            wp.launch(_kernels.put, dim=self._found.shape, inputs=inputs, device=self._device)

    def reset(self, worlds: Any = None) -> None:
        """Forgets the forces of the last step, in all worlds or in those of a mask: where an episode begins."""
        wp.launch(_kernels.forget, dim=self._last.shape, inputs=[self.mask(worlds), self._last], device=self._device)

    def act(self, m: Any, d: Any) -> None:
        """One step's friction: two launches. MuJoCo Warp calls it."""
        rows = (self._worlds, m.nv + m.ntendon)
        wp.launch(_kernels.find_rows, dim=rows, inputs=self._row_inputs, device=self._device)
        wp.launch(_kernels.rub, dim=self._found.shape, inputs=self._rub_inputs, device=self._device)

    def pulled(self) -> frozenset[str]:
        return frozenset(name for name, there in zip(self._table.names, self._table.sheathed, strict=True) if there)

    def _sizes(self) -> tuple[int, int]:
        return len(self._table.names), len(self._table.gear)

    def _fit(self, m: Any, d: Any) -> None:
        # Newton has made its model of its own.
        for name in PREPARED:
            _overwrite(getattr(m, name), np.asarray(getattr(self._model, name)), self._table.sheathed)
        unlimit(m, self._table.pulls)
        own = [self._parameters, self._sheathed, self._own, self._begins, self._pulls, self._gear, self._limits]
        path = [d.ten_velocity, d.ten_wrapadr, d.ten_wrapnum, d.wrap_xpos, d.wrap_obj]
        rows = [d.efc.D, d.efc.force, self._found, self._last]
        self._row_inputs = [d.ne, d.nf, d.efc.type, d.efc.id, self._found]
        self._rub_inputs = [*own, *path, *rows, d.actuator_force, d.efc.frictionloss, d.efc.aref]


def _overwrite(array: Any, values: NDArray[Any], chosen: NDArray[np.bool_]) -> None:
    """Writes values of the tendons with sheaths into an array of a model, whatever number of worlds it has."""
    there = array.numpy()
    changed = there.copy()
    changed[:, chosen] = values[chosen].astype(there.dtype)
    if not np.array_equal(there, changed):
        array.assign(changed)
