"""Pictures of a machine: bodies and cables by MuJoCo's kinematics, drawn by matplotlib, without OpenGL."""

from __future__ import annotations

import os
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._machine import Machine

_Floats = NDArray[np.float64]


class Picture:
    """Draws one machine in one pose after another; `machine`: as of `Conditions`.

    `site`, `axes`: name of the end point, `None` without one, and along which axes its place counts.
    """

    def __init__(self, machine: Machine | str | os.PathLike[str], site: str | None, axes: list[bool]) -> None:
        try:  # both are needed for pictures alone
            import mujoco
            from matplotlib.backends import backend_agg
            from matplotlib.figure import Figure
        except ModuleNotFoundError as error:
            expected = "pictures need MuJoCo and matplotlib: pip install mujoco matplotlib"
            raise ImportError(expected, name=error.name) from error
        from ..mujoco import load
        from ..mujoco._appearance import bones_of

        names = (machine if isinstance(machine, Machine) else Machine(machine)).joint_names
        self._model: Any = load(machine, transmission="none")
        self._data: Any = mujoco.MjData(self._model)
        self._mujoco: Any = mujoco
        self._places = [int(self._model.jnt_qposadr[self._model.joint(name).id]) for name in names]
        self._site, self._axes = None if site is None else int(self._model.site(site).id), np.array(axes)
        self._ends = bones_of(self._model)
        self._view = _view(self._model.vis.global_)
        figure = Figure(figsize=(4.8, 4.8), dpi=100)
        agg: Any = backend_agg
        self._canvas = agg.FigureCanvasAgg(figure)
        axis = figure.add_axes((0.0, 0.0, 1.0, 1.0), aspect="equal")
        axis.set_axis_off()
        center, half = self._view @ self._model.stat.center, 0.55 * self._model.stat.extent
        axis.set(xlim=(center[0] - half, center[0] + half), ylim=(center[1] - half, center[1] + half))
        # The desired pose lies behind the machine, the desired place of the end point in front of it.
        self._desired = axis.plot([], [], color="tab:green", alpha=0.5, linewidth=3)[0]
        self._bones = axis.plot([], [], "-o", color="0.6", linewidth=7)[0]
        count = self._model.ntendon
        self._cables = [axis.plot([], [], color="tab:red", linewidth=1.2)[0] for _ in range(count)]
        ring: dict[str, Any] = {"markersize": 11, "fillstyle": "none", "markeredgewidth": 2.5}
        self._goal = axis.plot([], [], "o", color="tab:green", **ring)[0]

    def draw(self, pose: _Floats, desired: _Floats | None = None) -> NDArray[np.uint8]:
        """The machine in a pose of its independent joints, rad or m, and what is desired: `(480, 480, 3)`.

        What is desired is the place of the end point, a green ring; of a machine without one the pose, thin
        green lines.
        """
        point, data = None, self._data
        if desired is not None:
            self._place(desired)
            if self._site is None:
                self._desired.set_data(*self._skeleton())
            else:
                point = np.array(data.site_xpos[self._site])
        self._place(pose)
        self._bones.set_data(*self._skeleton())
        if point is not None:
            # Along the other axes any place is as good: the gap in the picture is the error.
            here = data.site_xpos[self._site]
            self._goal.set_data(*(self._view @ np.where(self._axes, point, here))[:, np.newaxis])
        points = data.wrap_xpos.reshape(-1, 3)
        for tendon, line in enumerate(self._cables):
            first = data.ten_wrapadr[tendon]
            line.set_data(*self._view @ points[first : first + data.ten_wrapnum[tendon]].T)
        self._canvas.draw()
        return np.asarray(self._canvas.buffer_rgba())[:, :, :3].copy()

    def _place(self, pose: _Floats) -> None:
        """Puts the machine into a pose of its independent joints."""
        model, data = self._model, self._data
        data.qpos[self._places] = pose
        # Joints that follow others by a polynomial.
        for follower, leader, factors in zip(model.eq_obj1id, model.eq_obj2id, model.eq_data, strict=True):
            to, of = model.jnt_qposadr[follower], model.jnt_qposadr[leader]
            data.qpos[to] = model.qpos0[to] + np.polyval(factors[4::-1], data.qpos[of] - model.qpos0[of])
        self._mujoco.mj_fwdPosition(model, data)

    def _skeleton(self) -> _Floats:
        """Bones as the picture has them, shape `(2, points)`, with a gap behind each."""
        places, turns = self._data.xpos, self._data.xmat.reshape(-1, 3, 3)
        gap = np.full(3, np.nan)
        lines = [
            point
            for body, ends in enumerate(self._ends)
            for end in ends
            for point in (places[body], places[body] + turns[body] @ end, gap)
        ]
        return np.asarray(self._view @ np.array(lines).T)


def _view(camera: Any) -> _Floats:
    """Right and up of the picture in the world, as MuJoCo's own camera has them at first."""
    azimuth, elevation = np.radians([camera.azimuth, camera.elevation])
    level = np.array([np.cos(azimuth), np.sin(azimuth), 0.0])
    forward = np.cos(elevation) * level + np.array([0.0, 0.0, np.sin(elevation)])
    right = np.array([np.sin(azimuth), -np.cos(azimuth), 0.0])
    return np.array([right, np.cross(right, forward)])
