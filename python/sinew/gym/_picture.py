"""Pictures of a machine: bodies and cables by MuJoCo's kinematics, drawn by matplotlib, without OpenGL."""

from __future__ import annotations

import os
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._machine import Machine

#: Right and up of the picture in the world: from the front, a little from the left and above.
_VIEW = np.array([[0.87, -0.5, 0.0], [-0.15, -0.26, 0.95]])


class Picture:
    """Draws one machine in one pose after another; `machine`: as of `Conditions`."""

    def __init__(self, machine: Machine | str | os.PathLike[str]) -> None:
        try:  # both are needed for pictures alone
            import mujoco
            from matplotlib.backends import backend_agg
            from matplotlib.figure import Figure
        except ModuleNotFoundError as error:
            expected = "pictures need MuJoCo and matplotlib: pip install mujoco matplotlib"
            raise ImportError(expected, name=error.name) from error
        from ..mujoco import load

        names = (machine if isinstance(machine, Machine) else Machine(machine)).joint_names
        self._model: Any = load(machine, transmission="none")
        self._data: Any = mujoco.MjData(self._model)
        self._mujoco: Any = mujoco
        self._places = [int(self._model.jnt_qposadr[self._model.joint(name).id]) for name in names]
        figure = Figure(figsize=(4.8, 4.8), dpi=100)
        agg: Any = backend_agg
        self._canvas = agg.FigureCanvasAgg(figure)
        axes = figure.add_axes((0.0, 0.0, 1.0, 1.0), aspect="equal")
        axes.set_axis_off()
        center, half = _VIEW @ self._model.stat.center, 0.65 * self._model.stat.extent
        axes.set(xlim=(center[0] - half, center[0] + half), ylim=(center[1] - half, center[1] + half))
        self._bones = [axes.plot([], [], "-o", color="0.6", linewidth=7)[0] for _ in range(1, self._model.nbody)]
        self._cables = [axes.plot([], [], color="tab:red", linewidth=1.2)[0] for _ in range(self._model.ntendon)]

    def draw(self, pose: NDArray[np.float64]) -> NDArray[np.uint8]:
        """The machine in a pose of its independent joints, rad or m: shape `(480, 480, 3)`."""
        model, data = self._model, self._data
        data.qpos[self._places] = pose
        # Joints that follow others by a polynomial.
        for follower, leader, factors in zip(model.eq_obj1id, model.eq_obj2id, model.eq_data, strict=True):
            to, of = model.jnt_qposadr[follower], model.jnt_qposadr[leader]
            data.qpos[to] = model.qpos0[to] + np.polyval(factors[4::-1], data.qpos[of] - model.qpos0[of])
        self._mujoco.mj_fwdPosition(model, data)
        for body, line in enumerate(self._bones, start=1):
            begin, ends = data.xpos[body], data.xpos[model.body_parentid == body]
            # The last body of a chain reaches as far behind its mass centre as before.
            ends = ends if len(ends) else [2.0 * data.xipos[body] - begin]
            line.set_data(*_VIEW @ np.array([point for end in ends for point in (begin, end)]).T)
        points = data.wrap_xpos.reshape(-1, 3)
        for tendon, line in enumerate(self._cables):
            first = data.ten_wrapadr[tendon]
            line.set_data(*_VIEW @ points[first : first + data.ten_wrapnum[tendon]].T)
        self._canvas.draw()
        return np.asarray(self._canvas.buffer_rgba())[:, :, :3].copy()
