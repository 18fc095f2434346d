"""Cables with their drives and sensors: one callback for a step of all of them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import warp as wp

from ..mujoco import Cable
from . import _drive_kernels, _friction_kernels, _joint_kernels, _layout, _sensor_kernels, _winch_kernels
from ._cables import Cables


class Muscles(Cables):
    """Cables with their drives and the sensors of a machine: one callback for a step of all of them."""

    def __init__(self, model: Any, cables: Mapping[str, Cable], actions: Any, **keywords: Any) -> None:
        super().__init__(model, cables, **keywords)
        self.actions = actions
        #: Numbers of all worlds, of each, and what changes in a step.
        self.design, self.specimen, self.motion = _layout.Design(), _layout.Specimen(), _layout.Motion()
        #: Fraction of the step of drives and sensors behind this substep, and whether they step in this one and joints are read.
        self.left, self.stepped, self.read = 0.0, True, True

    def _check(self, model: Any) -> None:
        # Substeps are those in which the native twin is stable.
        return

    def act(self, m: Any, d: Any) -> None:
        """Cables, then drives and sensors; MuJoCo Warp calls it."""
        both, shape = [self.design, self.specimen, self.motion], self._state.begun.shape
        path = [m.opt.timestep, d.ten_wrapadr, d.ten_wrapnum, d.wrap_xpos, d.wrap_obj, d.xquat]
        self._launch(_friction_kernels.ease, shape, [*both, self._law, self._state, *path])
        super().act(m, d)
        forces = [0 if self.stepped else 1, d.qpos, d.qvel, d.qfrc_applied]
        self._launch(_joint_kernels.press, (shape[0], len(self.design.freedom)), [*both, *forces])
        if self.stepped:
            if self.read and len(self.design.encoded):
                self._launch(_sensor_kernels.read_joints, (shape[0], len(self.design.encoded)), [*both, d.qpos])
            self._launch(_drive_kernels.drive, shape, [*both, self._law, self._state, self.actions])
        self._launch(_winch_kernels.wind, shape, [self.design, self.motion, self.left, self._control, d.ctrl])

    def _launch(self, kernel: Any, shape: Any, inputs: list[Any]) -> None:
        wp.launch(kernel, dim=shape, inputs=inputs, device=self._device)
