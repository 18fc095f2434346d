"""Environments of a machine in many worlds of MuJoCo Warp, with the calls of the native ones."""

from __future__ import annotations

import json
from typing import Any, TypeAlias

import mujoco
import mujoco_warp as mjw
import numpy as np
import warp as wp
from numpy.typing import NDArray

from .. import _sinew
from ..mujoco._machine import bare, laid
from . import _drive_kernels, _kernels, _layout, _sensor_kernels, _task_kernels
from ._chain import chain
from ._graph import Graph
from ._muscles import Muscles

_Array: TypeAlias = NDArray[Any]

#: Parts of an observation in the order of the kernel's.
_PARTS = ("motor", "motor_rate", "tension", "joint", "joint_rate", "target", "target_rate", "target_point", "last_action")


class Environments:
    """Worlds of MuJoCo Warp under the task of native environments, which draw every episode and its first observation.

    `native`: as many environments as worlds, which are reset, never stepped. The calls are those of `_sinew.Environments`, and
    so is what is not found here.
    """

    def __init__(self, machine: _sinew.Machine, native: _sinew.Environments, worlds: int, mode: str, device: Any) -> None:
        self._native, self._worlds, self._mode = native, worlds, mode
        # First observations of the present episodes.
        self._begun = np.zeros((worlds, native.observations), dtype=np.float32)
        self._errors = np.zeros(worlds)
        self._ended = np.zeros(worlds, dtype=np.bool_)
        # Numbers of the present episodes of all worlds, and those of them that the device has.
        self._kept: dict[str, _Array] = {}
        self._own: dict[tuple[int, str], Any] = {}
        shared = json.loads(native.design())
        self._cycles, self._parts = int(shared["cycles"]), int(shared["parts"])
        (cells, self._substeps), muscles = native.resolution, list(machine.muscle_names)
        self._timestep, self._muscles = shared["step_s"] / self._substeps, muscles
        xml, described = _sinew.mujoco_machine(machine)
        model = self._compile(xml)
        start = mujoco.MjData(model)
        start.qpos[:] = json.loads(described)["start"]
        mujoco.mj_forward(model, start)
        with wp.ScopedDevice(device):
            #: As of `step`, on the device.
            self._actions: Any = wp.zeros((worlds, len(muscles)), dtype=float)
            self._outcomes: Any = wp.zeros((worlds, 4), dtype=float)
            self._observations: Any = wp.zeros((worlds, native.observations), dtype=float)
            cables = laid(machine, json.loads(described)["muscles"], None)  # type: ignore[arg-type]
            part = Muscles(model, cables, self._actions, cells=cells, worlds=worlds, device=device)
            self.m = mjw.put_model(model)
            # Couplings and friction of joints are always there, nothing else is a constraint.
            self.d = mjw.put_data(model, start, nworld=worlds, njmax=int(start.nefc))
            self._part, self._device = part.attach(self.m, self.d), self.d.qpos.device
            self._graph = Graph(self._cycle, self._device)
            self._share(machine, model, shared)
            self._make_room(model, shared)

    def __getattr__(self, name: str) -> Any:
        return getattr(self.__dict__["_native"], name)

    @property
    def poses(self) -> NDArray[np.float64]:
        """True poses, rad or m, shape `(environments, joints)`."""
        return np.asarray(self.d.qpos.numpy()[:, self._part.design.coordinate.numpy()], dtype=np.float64)

    def reset(
        self, seeds: list[int] | None, mask: list[bool] | None, observations: NDArray[np.float32], errors: NDArray[np.float64]
    ) -> None:
        """Begins episodes where `mask` is true, everywhere without one; with seeds, the first episode of each."""
        self._native.reset(seeds, mask, self._begun, self._errors)
        chosen = np.ones(self._worlds, dtype=np.bool_) if mask is None else np.array(mask)
        self._begin(chosen)
        observations[chosen], errors[chosen] = self._begun[chosen], self._errors[chosen]

    def step(
        self,
        actions: NDArray[np.float32],
        observations: NDArray[np.float32],
        rewards: NDArray[np.float64],
        terminated: NDArray[np.bool_],
        truncated: NDArray[np.bool_],
        errors: NDArray[np.float64],
        last_observations: NDArray[np.float32],
        last_errors: NDArray[np.float64],
    ) -> None:
        """One action for every environment; everything is written into the arrays."""
        if not np.isfinite(actions).all():
            raise ValueError("action must be a finite number from -1 to 1")
        again = self._ended.copy()
        if self._mode == "disabled" and again.any():
            raise ValueError(f"environment [{int(again.argmax())}] must be reset after the end of its episode, which has ended")
        self._actions.assign(actions)
        self.advance()
        self.conclude()
        observations[...] = self._observations.numpy()
        outcomes = self._outcomes.numpy()
        errors[...], rewards[...] = outcomes[:, 0], outcomes[:, 1]
        terminated[...], truncated[...] = outcomes[:, 2] > 0.0, outcomes[:, 3] > 0.0
        if self._mode == "next_step" and again.any():
            # They began another episode in place of this step.
            self.reset(None, again.tolist(), observations, errors)
            rewards[again], terminated[again], truncated[again] = 0.0, False, False
        self._ended = terminated | truncated
        if self._mode == "same_step" and self._ended.any():
            ended = self._ended
            last_observations[ended], last_errors[ended] = observations[ended], errors[ended]
            self.reset(None, ended.tolist(), observations, errors)

    def advance(self) -> None:
        """Steps all worlds for the interval of an action; waits for nothing."""
        for _ in range(self._cycles):
            self._graph.launch()

    def _cycle(self) -> None:
        """One cycle of the drives' controller."""
        part = self._part
        for index in range(self._parts * self._substeps):
            within, substep = divmod(index, self._substeps)
            part.stepped, part.read = substep == 0, within + 1 == self._parts
            part.left = 1.0 - (substep + 1) / self._substeps
            mjw.step(self.m, self.d)

    def conclude(self) -> None:
        """Observations and outcomes after an action; waits for nothing."""
        part = self._part
        inputs = [part.design, part.specimen, part.motion, self._actions, self.d.qpos, self._observations, self._outcomes]
        wp.launch(_task_kernels.conclude, dim=self._worlds, inputs=inputs, device=self._device)

    def _compile(self, xml: str) -> Any:
        """A model as the native twin steps it: explicit forces, then the pose by the new speed."""
        spec = bare(xml, self._muscles, self._timestep)
        spec.option.integrator = mujoco.mjtIntegrator.mjINT_EULER
        # Stops are springs of the twin, bodies do not touch.
        off = mujoco.mjtDisableBit
        spec.option.disableflags |= off.mjDSBL_EULERDAMP | off.mjDSBL_CONTACT | off.mjDSBL_LIMIT
        return spec.compile()

    def _share(self, machine: _sinew.Machine, model: Any, shared: dict[str, Any]) -> None:
        """Fills in what all worlds share."""
        design, drives = self._part.design, [dict(drive) for drive in shared["drives"]]
        for drive, (low, high) in zip(drives, self._native.command_bounds, strict=True):
            drive |= {"low": low, "high": high}
        most = max(len(drive["arms"]) for drive in drives)
        if any(len(drive["arms"]) != most for drive in drives):
            raise ValueError("drums with different numbers of layers cannot be stepped in MuJoCo Warp")
        design.numbers = _array([[drive[name] for drive in drives] for name in _layout.NUMBERS])
        design.arms = _array(np.array([drive["arms"] for drive in drives]).T, wp.float64)
        names = list(machine.joint_names)
        joints = [int(model.joint(name).id) for name in names]
        design.tendon = _array([int(model.tendon(name).id) for name in self._muscles], int)
        design.coordinate, design.freedom = _array(model.jnt_qposadr[joints], int), _array(model.jnt_dofadr[joints], int)
        design.encoded, design.resolution = _array(shared["encoded"], int), _array(shared["resolutions"])
        design.ranges = _array(shared["ranges"], wp.vec2)
        design.axes, design.endpoint = wp.vec3(*map(float, shared["axes"])), int(shared["site"] is not None)
        design.half_error, design.effort, design.steps = shared["half_error"], shared["effort"], shared["steps"]
        design.actuation, design.interval, design.part = shared["actuation"], shared["interval_s"], shared["step_s"]
        design.bounds = _array(np.stack(self._native.observation_bounds, axis=1), wp.vec2)
        starts = {name: start for name, _, start, _ in self._native.observation_parts}
        design.starts = _array([starts.get(name, -1) for name in _PARTS], int)
        links = chain(model, shared["site"])
        design.place = _array([link[0] for link in links], wp.transform)
        design.kind, design.link = (_array([link[k] for link in links], int) for k in (1, 2))
        design.axis, design.anchor = (_array([link[k] for link in links], wp.vec3) for k in (3, 4))
        design.zero = _array([link[5] for link in links])

    def _make_room(self, model: Any, shared: dict[str, Any]) -> None:
        """Makes room for what differs from world to world, and begins an episode in each."""
        part, episode = self._part, json.loads(self._native.episode(0))
        motion, count, encoded = part.motion, len(self._muscles), len(shared["encoded"])
        bodies = [sheath[0] if sheath else "world" for sheath in episode["sheaths"]]
        part.design.sheath_body = _array([int(model.body(name).id) for name in bodies], int)
        depth = int(shared["longest_delay_ms"] * 1e-3 / shared["step_s"]) + 3
        zeros = {
            wp.float64: ("angle", "winch"),
            wp.uint64: ("noise",),
            wp.vec2: ("warmth",),
            int: ("now",),
            float: (
                *("speed", "current", "correction", "reference", "integral", "tension_integral", "moved", "begin"),
                *("position", "tension", "last_motor"),
            ),
        }
        for kind, names in zeros.items():
            for name in names:
                setattr(motion, name, wp.zeros((self._worlds, count), dtype=kind))
        for name in ("failed", "clock", "step"):
            setattr(motion, name, wp.zeros(self._worlds, dtype=int))
        motion.joint, motion.last_joint = (wp.zeros((self._worlds, encoded), dtype=float) for _ in range(2))
        motion.joint_now = wp.zeros((self._worlds, encoded), dtype=int)
        motion.positions, motion.tensions = (wp.zeros((depth, self._worlds, count), dtype=float) for _ in range(2))
        motion.joints = wp.zeros((depth, self._worlds, encoded), dtype=float)
        motion.slow = wp.zeros((self._native.resolution[0] - 1, self._worlds, count), dtype=float)
        self._periods = shared["step_s"], self._parts * shared["step_s"]
        # What may differ from world to world in a model of MuJoCo Warp, as in the design.
        self._designed = {
            name: np.array(getattr(model, name), dtype=np.float64)
            for name, array in vars(self.m).items()
            if isinstance(array, wp.array) and array.ndim > 1 and array.shape[0] == 1 and hasattr(model, name)
        }
        self._begin(np.ones(self._worlds, dtype=np.bool_))

    def _begin(self, chosen: NDArray[np.bool_]) -> None:
        """Puts worlds at the beginning of the episodes that the native environments are in."""
        for world in np.flatnonzero(chosen):
            for name, row in self._rows(int(world)).items():
                if name not in self._kept:
                    self._kept[name] = np.zeros((self._worlds, *row.shape), dtype=row.dtype)
                self._kept[name][world] = row
        part, mask = self._part, self._part.mask(chosen)
        owners = {"model": self.m, "law": part._law, "specimen": part.specimen}
        with wp.ScopedDevice(self._device):
            for name, rows in self._kept.items():
                owner, _, field = name.partition(".")
                if owner in owners:
                    self._put(owners[owner], field, rows)
        mjw.reset_data(self.m, self.d, mask)
        pose: Any = wp.array(self._kept["pose"], dtype=float, device=self._device)
        wp.launch(_kernels.place, dim=self.d.qpos.shape, inputs=[mask, pose, self.d.qpos], device=self._device)
        part.set(start_n=self._kept["start_n"])
        part.reset(mask)
        inputs = [mask, part.design, part.specimen, part.motion]
        wp.launch(_drive_kernels.begin, dim=self._worlds, inputs=inputs, device=self._device)
        self._ended[chosen] = False

    def _put(self, owner: Any, field: str, rows: _Array) -> None:
        """Writes numbers of all worlds to the device, from the second time on in the same place."""
        key = id(owner), field
        if owner is self.m and key not in self._own and (rows == self._designed[field]).all():
            return
        if field in _NODES:
            rows = np.moveaxis(rows, 0, 1)
        if key in self._own:
            self._own[key].assign(np.ascontiguousarray(rows))
            return
        kind = getattr(self.m, field).dtype if owner is self.m else _KINDS.get(field, float)
        self._own[key] = _array(rows, kind)
        setattr(owner, field, self._own[key])
        self._graph.forget()

    def _rows(self, world: int) -> dict[str, _Array]:
        """Numbers of the episode that one native environment is in."""
        episode = json.loads(self._native.episode(world))
        model, cables, step = self._compile(episode["mjcf"]), episode["cables"], self._periods
        rows = {f"model.{name}": np.array(getattr(model, name), dtype=np.float64) for name in self._designed}
        for field, name in _LAW.items():
            rows[f"law.{field}"] = np.array([cable[name] for cable in cables]).T
        sheaths = [sheath[1] if sheath else [0.0, 0.0, 0.0] for sheath in episode["sheaths"]]
        parts = {name: self._begun[world, start : start + width] for name, _, start, width in self._native.observation_parts}
        empty = np.zeros(0, dtype=np.float32)
        streams = [(episode["seed"] << 16) + k + 4 * int(_sensor_kernels.STRIDE) for k in range(len(cables))]
        given: dict[str, Any] = {
            "friction": np.array([cable["friction"] for cable in cables]).T,
            **{name: [cable[name] for cable in cables] for name in ("mu", "wrap", "pulley", "weakening", "breaks")},
            "axis": sheaths,
            "winch": episode["winches"],
            "gain": episode["gains"],
            "delay": np.array(episode["delays_ms"]) * (1e-3 / step[0]),
            "encoder": np.reshape(episode["encoders"], (-1, 3)),
            "joint_delay": episode["delay_ms"] * (1e-3 / step[1]),
            "stops": episode["stops"],
            "pushes": np.reshape(episode["pushes"], (-1, 4)),
            "targets": episode["targets"],
            "noise": np.array([stream % (1 << 64) for stream in streams], dtype=np.uint64),
            "first": np.concatenate([parts[name] if name in parts else empty for name in ("motor", "tension", "joint")]),
        }
        rows |= {f"specimen.{name}": np.array(values) for name, values in given.items()}
        return rows | {"pose": np.array(episode["pose"]), "start_n": np.array(episode["tension_n"])}


#: Arrays of nodes and cells, in which worlds are the second axis; types of numbers other than float.
_NODES = ("compliance", "friction", "loss", "viscous", "drag")
_KINDS = {"pulley": int, "axis": wp.vec3, "encoder": wp.vec3, "weakening": wp.vec4, "stops": wp.vec4, "noise": wp.uint64}
#: Arrays of a law of cables, and as what the native part gives them.
_LAW = {name: name for name in (*_NODES, "pretension")} | {"fade": "drag_fade"}


def _array(values: Any, kind: Any = float) -> Any:
    return wp.array(np.asarray(values), dtype=kind)
