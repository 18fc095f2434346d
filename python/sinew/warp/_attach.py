"""Where MuJoCo Warp calls us: its callback, shared with whatever is there already."""

from __future__ import annotations

import weakref
from collections.abc import Callable
from typing import Any, Self

import numpy as np
import warp as wp

from ..batch._prepare import check_solver


class Hub:
    """The one callback of a model: what was there before, then our parts of the data that is stepped.

    Other models, which share the callback where a copy of theirs does, are left alone.
    """

    def __init__(self, m: Any) -> None:
        self.before: Callable[[Any, Any], None] | None = m.callback.act_bias
        # A copy of a model (`dataclasses.replace`) shares its arrays.
        self._mine = weakref.ref(m.tendon_frictionloss)
        self._parts: dict[int, tuple[weakref.ref[Any], list[Part]]] = {}

    def __call__(self, m: Any, d: Any) -> None:
        if self.before is not None:
            self.before(m, d)
        known = self._parts.get(id(d))
        if known is not None and known[0]() is d:
            for part in known[1]:
                part.act(m, d)
        elif m.tendon_frictionloss is self._mine():
            raise RuntimeError(
                "this data of the model has no sheaths or cables, and would be stepped without friction: attach them to it as well"
            )

    def is_of(self, m: Any) -> bool:
        """Whether it was made for this model, or one that shares its arrays."""
        return m.tendon_frictionloss is self._mine()

    def check_free(self, d: Any, part: Part) -> None:
        """Raises `ValueError` where a part of this data acts on a tendon of another one already: friction would act twice."""
        known = self._parts.get(id(d))
        for there in known[1] if known is not None and known[0]() is d else []:
            if both := sorted(part.pulled() & there.pulled()):
                raise ValueError(
                    f"tendon {both[0]} has its {type(there).__name__} attached already, expected one of Sheaths and Cables, once: "
                    "cables have the friction of their own sheaths"
                )

    def add(self, d: Any, part: Part) -> None:
        """Lets a part act on this data after those that do already."""
        kept = {key: entry for key, entry in self._parts.items() if entry[0]() is not None}
        parts = kept[id(d)][1] if id(d) in kept else []
        kept[id(d)] = (weakref.ref(d), [*parts, part])
        self._parts = kept

    def remove(self, d: Any, part: Part) -> None:
        """Takes a part out; the data is known from then on as one without."""
        known = self._parts.get(id(d))
        if known is not None:
            self._parts[id(d)] = (known[0], [one for one in known[1] if one is not part])


class Part:
    """Something that acts on the actuators' forces of the worlds of one data."""

    def __init__(self, worlds: int, device: Any) -> None:
        if isinstance(worlds, bool) or not isinstance(worlds, int) or worlds < 1:
            raise ValueError(f"worlds must be a whole number of at least 1, but is {worlds!r}")
        self._worlds = worlds
        self._device = wp.get_device(device)
        self._attached: tuple[Hub, Any] | None = None
        self._all = wp.full(worlds, True, dtype=bool, device=self._device)

    def attach(self, m: Any, d: Any) -> Self:
        """Acts on a model and data of MuJoCo Warp from now on, whenever it is stepped; returns itself.

        `m`, `d`: as of `mujoco_warp.put_model` and `make_data` or `put_data`, or `solver.mjw_model` and `solver.mjw_data` of
        Newton's MuJoCo solver. A callback that the model has already is called before.

        Raises `ValueError` where model and data do not fit or lose friction, and `ImportError` where a hoist with this version
        of MuJoCo Warp does not hold and slide at the edges of friction, which is tried once.
        """
        from ._check import hoist_holds_and_slides

        if self._attached is not None:
            raise ValueError("attached already: make another one for another model or data")
        check_solver(m.opt)
        tendons, actuators = self._sizes()
        for name, found, expected in (
            ("tendons", m.ntendon, tendons),
            ("actuators", m.actuator_trntype.shape[0], actuators),
            ("worlds", d.nworld, self._worlds),
        ):
            if found != expected:
                raise ValueError(f"made for {expected} {name}, but there are {found}")
        if d.efc.aref.device != self._device:
            raise ValueError(f"made on the device {self._device}, but the data is on {d.efc.aref.device}")
        hoist_holds_and_slides()
        self._attach(m, d)
        return self

    def _attach(self, m: Any, d: Any) -> None:
        there = m.callback.act_bias
        hub = there if isinstance(there, Hub) and there.is_of(m) else Hub(m)
        hub.check_free(d, self)
        self._fit(m, d)
        m.callback.act_bias = hub
        hub.add(d, self)
        self._attached = hub, d

    def detach(self) -> None:
        """Ends what `attach` began; constraints that were made for friction stay and hold nothing."""
        if self._attached is not None:
            hub, d = self._attached
            hub.remove(d, self)
            self._attached = None

    def act(self, m: Any, d: Any) -> None:
        """Launches the kernels of a step, without allocations or anything that waits. MuJoCo Warp calls it."""
        raise NotImplementedError

    def pulled(self) -> frozenset[str]:
        """Names of the tendons on which it acts."""
        raise NotImplementedError

    def _sizes(self) -> tuple[int, int]:
        """Numbers of tendons and actuators of the model."""
        raise NotImplementedError

    def _fit(self, m: Any, d: Any) -> None:
        """Changes the model as is necessary, and notes the arrays of the data."""
        raise NotImplementedError

    def mask(self, worlds: Any = None) -> Any:
        """Worlds as booleans of the device, which `mujoco_warp.reset_data` takes as well: all, or of shape `(worlds,)`."""
        if worlds is None:
            return self._all
        mask = worlds if isinstance(worlds, wp.array) else np.asarray(worlds)
        boolean = mask.dtype in (wp.bool, np.dtype(np.bool_))
        if not boolean or mask.shape != (self._worlds,):
            raise ValueError(f"worlds must be {self._worlds} booleans, but is {mask.dtype} of shape {mask.shape}")
        return mask if isinstance(mask, wp.array) else wp.array(mask, dtype=bool, device=self._device)

    def _columns(self, name: str, given: Any, count: int) -> Any:
        """Numbers of the device of shape `(1 or worlds, count)`; an array of Warp is taken as it is."""
        if not isinstance(given, wp.array):
            return wp.array(np.atleast_2d(given).astype(np.float32), dtype=float, device=self._device)
        if given.dtype != wp.float32 or given.shape not in ((1, count), (self._worlds, count)):
            expected = f"float32 of shape (1 or {self._worlds}, {count})"
            raise ValueError(f"{name} must be {expected}, but is {given.dtype.__name__} of shape {given.shape}")
        return given


def unlimit(m: Any, actuators: Any) -> None:
    """Lifts limits of actuators' forces in a model of Warp, which it would apply after friction."""
    limited = m.actuator_forcelimited.numpy()
    limited[actuators] = False
    m.actuator_forcelimited.assign(limited)
