"""Winches and elastic cables of every world of a model in MuJoCo Warp."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import mujoco
import numpy as np
import warp as wp
from numpy.typing import ArrayLike, NDArray

from .. import _cable
from ..batch._cables import check_damping, winches_of
from ..mujoco import Cable
from . import _cable_kernels as kernels
from . import _kernels
from ._attach import Part, unlimit

#: Most substeps of one step.
MOST_SUBSTEPS = 64


class Cables(Part):
    """Winches and elastic cables in the place of the actuators of tendons of many worlds.

    `model`: a `mujoco.MjModel`. `cables`: cable by tendon name or pattern; each of these tendons has one actuator, whose control,
    or activation where it has one, becomes the displacement of its winch, m, positive where it takes cable in. `cells`: pieces
    into which each cable is cut; `substeps`: of the cable per time step.

    Every forward pass is a step of the cables: `mujoco_warp.step` alone, once per time step.

    Raises `ValueError` that names the pattern, tendon or parameter, for cables that are stiff for the time step of the
    model as well (`sinew.batch.damp` is the cure), and for the integrator RK4.
    """

    def __init__(
        self,
        model: Any,
        cables: Mapping[str, Cable],
        *,
        cells: int = 12,
        substeps: int = 1,
        worlds: int,
        device: Any = None,
    ) -> None:
        for name, value, most in (("cells", cells, 1024), ("substeps", substeps, MOST_SUBSTEPS)):
            if isinstance(value, bool) or not isinstance(value, int) or not 1 <= value <= most:
                raise ValueError(f"{name} must be a whole number from 1 to {most}, but is {value!r}")
        self._winches = winches = winches_of(model, cables)
        self._check(model)
        super().__init__(worlds, device)
        self._model, self._cells, self._substeps = model, cells, substeps
        laws = [_law(winch.name, winch.cable, cells) for winch in winches]
        count = len(winches)

        def array(values: ArrayLike, kind: Any = float) -> Any:
            return wp.array(np.asarray(values), dtype=kind, device=self._device)

        self._tendon = array([winch.tendon for winch in winches], int)
        self._actuator = array([winch.actuator for winch in winches], int)
        self._control = array([winch.control for winch in winches], int)
        self._activation = array([winch.activation for winch in winches], int)
        self._gear = array([winch.gear for winch in winches])
        law = kernels.Law()
        for name in ("compliance", "friction", "loss", "viscous", "drag"):
            setattr(law, name, array(np.stack([one[name] for one in laws], axis=1)[:, np.newaxis]))
        law.fade, law.pretension = (array([[float(one[name]) for one in laws]]) for name in ("drag_fade", "pretension"))
        starts = [winch.cable.pretension_n if winch.cable.start_n is None else winch.cable.start_n for winch in winches]
        factors = np.ones((len(kernels.FACTORS), worlds, count))
        factors[kernels.FACTORS.index("start_n")] = starts
        self._factors = law.factors = array(factors)
        self._law, self._state = law, self._begin(count)

    def _begin(self, count: int) -> Any:
        state, shape = kernels.State(), (self._worlds, count)
        for name in ("winch", "length", "stretch"):
            setattr(state, name, wp.zeros(shape, dtype=float, device=self._device))
        for name in ("tension", "slip", "next", "sup", "rhs"):
            setattr(state, name, wp.zeros((self._cells, *shape), dtype=float, device=self._device))
        state.begun = wp.zeros(shape, dtype=int, device=self._device)
        return state

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the tendons with cables, in the order of all arrays."""
        return tuple(winch.name for winch in self._winches)

    @property
    def tension_out(self) -> NDArray[np.float32]:
        """Tensions at the anchors after the last step, N, shape `(worlds, cables)`; waits for the device."""
        return np.asarray(self._state.tension[self._cells - 1].numpy() + self._law.pretension.numpy(), dtype=np.float32)

    @property
    def tension_in(self) -> NDArray[np.float32]:
        """Tensions at the winches after the last step, N, shape `(worlds, cables)`; waits for the device."""
        return np.asarray(self._state.tension[0].numpy(), dtype=np.float32)

    def set(self, *, worlds: Any = None, **factors: Any) -> None:
        """Changes factors on `friction`, `drag` and `compliance` of the cables as given, or `start_n`, the tension, N, with which
        they begin after the next `reset`, of all worlds or of those of a mask.

        Each is one number, one for each cable, or one for each world and cable; arrays of Warp as for `Sheaths.set`. A cable
        that is under way keeps its tensions where its compliance changes, not its lengths: change it before a reset.
        """
        count, ready = len(self._winches), []
        for name, given in factors.items():
            if name not in kernels.FACTORS:
                raise ValueError(f"{name!r} cannot be set, expected one of {', '.join(kernels.FACTORS)}")
            if not isinstance(given, wp.array):
                given = self._filled(name, given)
            ready.append((kernels.FACTORS.index(name), self._columns(name, given, count)))
        mask = self.mask(worlds)
        for place, values in ready:
            inputs = [place, values, mask, self._factors]
            wp.launch(_kernels.put, dim=(self._worlds, count), inputs=inputs, device=self._device)

    def _filled(self, name: str, given: ArrayLike) -> NDArray[np.float64]:
        shape = (self._worlds, len(self._winches)) if np.ndim(given) == 2 else (len(self._winches),)
        values = np.asarray(given, dtype=float)
        try:
            full = np.broadcast_to(values, shape)
        except ValueError:
            raise ValueError(f"{name} must be of a shape that fits {shape}, but is of {values.shape}") from None
        if not np.isfinite(full).all() or (full < 0.0).any() or (name == "compliance" and not full.all()):
            above = "above" if name == "compliance" else "of at least"
            raise ValueError(f"{name} must be finite numbers {above} zero")
        return full

    def reset(self, worlds: Any = None) -> None:
        """Lays the cables anew with their start at the next step, in all worlds or in those of a mask."""
        inputs = [self.mask(worlds), self._state.begun]
        wp.launch(kernels.begin_anew, dim=self._state.begun.shape, inputs=inputs, device=self._device)

    def act(self, m: Any, d: Any) -> None:
        """One step of the cables: one launch. MuJoCo Warp calls it."""
        wp.launch(kernels.pull, dim=self._state.begun.shape, inputs=self._inputs, device=self._device)

    def _check(self, model: Any) -> None:
        check_damping(model, {winch.tendon: winch.cable for winch in self._winches})

    def pulled(self) -> frozenset[str]:
        return frozenset(self.names)

    def _sizes(self) -> tuple[int, int]:
        return int(self._model.ntendon), len(self._model.actuator_trntype)

    def _fit(self, m: Any, d: Any) -> None:
        if m.opt.integrator == mujoco.mjtIntegrator.mjINT_RK4:
            raise ValueError("option integrator is RK4, whose stages would each move the cables: expected another one")
        unlimit(m, [winch.actuator for winch in self._winches])
        wiring = [self._tendon, self._actuator, self._control, self._activation, self._gear]
        numbers = [self._substeps, m.opt.timestep, d.ctrl, d.act, d.ten_length, d.actuator_force]
        self._inputs = [self._law, self._state, *wiring, *numbers]


def _law(name: str, cable: Cable, cells: int) -> dict[str, NDArray[np.float64]]:
    parameters = {key: value for key, value in cable._numbers().items() if key != "start_n"}
    try:
        return _cable.Cable(cable.path, cells=cells, **parameters).law
    except ValueError as error:
        raise ValueError(f"tendon {name}: {error}") from None
