"""The native part of the package."""

import os
from collections.abc import Callable, Sequence
from typing import Any, Literal, Self, SupportsFloat, SupportsIndex, final

import numpy as np
from numpy.typing import ArrayLike, NDArray
from typing_extensions import disjoint_base

from ._machine import Machine as PythonMachine

__all__ = [
    "Cable",
    "CableEnds",
    "Command",
    "Compensator",
    "Controller",
    "Environments",
    "Machine",
    "Model",
    "NearCommand",
    "Prediction",
    "Predictor",
    "Trajectory",
    "Twin",
    "TwinBatch",
    "__version__",
    "demo_logs",
    "distribute",
    "identify",
    "mujoco_connect_address",
    "mujoco_fields",
    "mujoco_machine",
    "page_style",
    "plan_motion",
    "reproduce",
    "table_text",
    "track",
    "verify",
]

__version__: str

type _Array = NDArray[np.float64]
type _Logs = list[str] | list[tuple[str, bytes]]
type _Progress = Callable[[str, float], object] | None
type _Number = SupportsFloat | SupportsIndex

def identify(
    logs: _Logs,
    roles: dict[str, Any],
    columns: dict[str, Any],
    skip_s: _Number,
    models: list[str],
    keep: list[str] | None,
    loss_percent: float | None,
    seed: SupportsIndex,
    threads: SupportsIndex | None,
    progress: _Progress,
) -> Model: ...
def demo_logs(seed: SupportsIndex) -> list[tuple[str, str]]: ...
def mujoco_connect_address() -> int: ...
def mujoco_fields() -> list[tuple[str, bool, bool]]: ...
def mujoco_machine(machine: Machine) -> tuple[str, str]: ...
def table_text(columns: list[tuple[str, Any]]) -> bytes: ...
def distribute(
    moment_arms: ArrayLike,
    torque: ArrayLike,
    minimum: ArrayLike,
    maximum: ArrayLike,
    reference: ArrayLike,
    weight: ArrayLike,
    warm_start: bool,
) -> dict[str, Any]: ...
def plan_motion(machine: Machine, desired: Any, duration_s: _Number | None) -> Trajectory: ...
def track(
    machine: Machine, trajectory: Trajectory, conditions: dict[str, Any], progress: _Progress
) -> tuple[str, dict[str, NDArray[Any]], str | None]: ...
def verify(
    machine: Machine,
    trajectory: Trajectory,
    repeats: SupportsIndex | None,
    payload_kg: _Number | None,
    progress: _Progress,
) -> tuple[str, str | None]: ...
def page_style() -> str: ...
def reproduce(
    part: str, quick: bool, seed: SupportsIndex, threads: SupportsIndex | None, progress: _Progress
) -> str: ...

@final
class Model:
    """A model of one transmission, with the report of its identification where it was identified in this process."""

    @staticmethod
    def from_json(text: str) -> Model: ...
    def to_json(self) -> str: ...
    @property
    def far(self) -> str: ...
    @property
    def inputs(self) -> list[tuple[str, str]]: ...
    def provenance_json(self) -> str: ...
    def report_json(self) -> str | None: ...
    def report_html(self) -> str | None: ...
    def evaluate(
        self, logs: _Logs, columns: dict[str, Any], skip_s: _Number, anchor_reading_s: _Number | None
    ) -> str: ...
    def predict(
        self, logs: _Logs, columns: dict[str, Any], anchor_reading_s: _Number | None
    ) -> dict[str, Any]: ...
    def adapt(
        self,
        logs: _Logs,
        columns: dict[str, Any],
        skip_s: _Number,
        seed: SupportsIndex,
        threads: SupportsIndex | None,
        progress: _Progress,
    ) -> Model: ...
    def compensator(
        self,
        near: str | None,
        min: _Number | None,
        max: _Number | None,
        rate: _Number | None,
        tolerance: _Number | None,
    ) -> Compensator: ...
    def predictor(self) -> Predictor: ...

@final
class Prediction:
    """Prediction of the far end at one sample."""

    @property
    def mean(self) -> float:
        """The far end, in the unit of the training logs."""
    @property
    def standard_deviation(self) -> float:
        """Standard deviation in the same unit; `mean ± half_width` is the 95 % band."""
    @property
    def half_width(self) -> float:
        """Half width of the 95 % band, in the same unit."""
    @property
    def gate(self) -> float:
        """Gate on the learned correction, 0 to 1."""
    @property
    def state_unknown(self) -> bool:
        """Whether the state in the dead band depends on its start."""
    @property
    def out_of_range(self) -> bool:
        """Whether an input lies outside the range of the training logs."""
    @property
    def input_held(self) -> bool:
        """Whether an input was missing or jumped, and was replaced by its last value."""
    @property
    def reset(self) -> bool:
        """Whether all states were reset at this sample."""
    @property
    def repeated(self) -> bool:
        """Whether the time stamp equals that of the sample before."""
    @property
    def other_specimen(self) -> bool:
        """Whether the loops of near effort over near motion are not those of the specimen in training."""
    def __float__(self) -> float: ...

@final
class Predictor:
    """Predicts the far end of one transmission from its near side, sample by sample and causally.

    Made by `Model.predictor`. Missing (NaN) and implausible inputs are replaced by the last accepted value and flagged.
    """

    def step(self, time_s: _Number, inputs: ArrayLike) -> Prediction:
        """Predicts the far end at one sample; `time_s`: s, `inputs`: shape `(inputs,)`, NaN for missing."""
    def run(self, time_s: ArrayLike, inputs: ArrayLike) -> dict[str, NDArray[Any]]:
        """Predicts the far end at many samples; `time_s`: shape `(n,)`, `inputs`: shape `(n, inputs)`."""
    def read_far_end(self, far: _Number) -> float | None:
        """Takes a reading of the far end at the last sample, as a homing or a stop gives it.

        Later predictions are moved by its error, shrunken by what the folds of the identification say of offsets. Returns that
        offset; None, and nothing changes, before the first sample, for a number that is not finite, and where the folds say
        nothing.
        """
    def reset(self) -> None:
        """Resets all states: the next sample starts a new sequence."""

@final
class NearCommand:
    """Command for the near side at one sample."""

    @property
    def value(self) -> float:
        """The near side for which the far end is as desired, in the unit of the near column."""
    @property
    def low(self) -> float:
        """The command at the lower end of the model's 95 % band, as far as it can be reached in this sample."""
    @property
    def high(self) -> float:
        """The command at the upper end of the model's 95 % band, as far as it can be reached in this sample."""
    @property
    def mean(self) -> float:
        """The far end that the model predicts at this command."""
    @property
    def standard_deviation(self) -> float:
        """Standard deviation of that prediction."""
    @property
    def gate(self) -> float:
        """Gate on the learned correction, 0 to 1."""
    @property
    def not_attainable(self) -> bool:
        """Whether the model's far end at this command is not the desired one."""
    @property
    def rate_limited(self) -> bool:
        """Whether the command moves as fast as it may."""
    @property
    def out_of_range(self) -> bool:
        """Whether the command or another input lies outside the range of the training logs."""
    @property
    def correction_withdrawn(self) -> bool:
        """Whether less than half of the learned correction counts."""
    @property
    def state_unknown(self) -> bool:
        """Whether the state in the dead band depends on its start."""
    @property
    def input_held(self) -> bool:
        """Whether an input or the desired far end was missing or jumped, and was replaced by its last value."""
    @property
    def reset(self) -> bool:
        """Whether all states were reset at this sample."""
    @property
    def repeated(self) -> bool:
        """Whether the time stamp equals that of the sample before."""
    def __float__(self) -> float: ...

@final
class Compensator:
    """The near-side command for a desired far end, sample by sample and causally: the inverse of a model.

    Made by `Model.compensator`. A controller calls `observe` with what it measured and `command` for the time by which its
    drive can be there; `step` and `run` work through what is recorded or planned.
    """

    @property
    def near(self) -> str:
        """The column that is commanded."""
    @property
    def sliding(self) -> float:
        """Direction of sliding by which the last command of a cable's motor went, +1 toward the motor, -1 away; 0 otherwise.

        Set it before a command to the direction to come, where the motion is known; 0: the motion shows it."""
    @sliding.setter
    def sliding(self, direction: _Number) -> None: ...
    def step(self, time_s: _Number, inputs: ArrayLike, desired: _Number) -> NearCommand:
        """The command for one sample, after which the state follows the near column, or the command where that is NaN."""
    def command(self, time_s: _Number, inputs: ArrayLike, desired: _Number) -> NearCommand:
        """The command for the sample at `time_s`, which lies ahead; the model's state is left as it is."""
    def observe(self, time_s: _Number, inputs: ArrayLike) -> float:
        """Moves the model's state by a sample as it was measured; the far end that the model predicts."""
    def run(self, time_s: ArrayLike, inputs: ArrayLike, desired: ArrayLike) -> dict[str, NDArray[Any]]:
        """The commands for many samples; `time_s`, `desired`: shape `(n,)`, `inputs`: shape `(n, inputs)`."""
    def reset(self) -> None:
        """Resets all states: the next sample starts a new sequence."""

@final
class Environments:
    """Many simulated machines under one task; see `sinew.gym`."""

    def __new__(
        cls, machine: Machine, conditions: dict[str, Any], seeds: list[int], reset_mode: str, threads: int
    ) -> Environments: ...
    def reset(
        self,
        seeds: list[int] | None,
        mask: list[bool] | None,
        observations: NDArray[np.float32],
        errors: _Array,
    ) -> None:
        """Begins episodes where `mask` is true, everywhere without one; with seeds, the first episode of each."""
    def step(
        self,
        actions: NDArray[np.float32],
        observations: NDArray[np.float32],
        rewards: _Array,
        terminated: NDArray[np.bool_],
        truncated: NDArray[np.bool_],
        errors: _Array,
        last_observations: NDArray[np.float32],
        last_errors: _Array,
    ) -> None:
        """One action for every environment; everything is written into the arrays."""
    @property
    def interval_ms(self) -> int:
        """Milliseconds that an action holds."""
    @property
    def actions(self) -> int:
        """Entries of an action."""
    @property
    def observations(self) -> int:
        """Entries of an observation."""
    @property
    def observation_bounds(self) -> tuple[list[float], list[float]]:
        """Smallest and largest value of every entry of an observation."""
    @property
    def observation_parts(self) -> list[tuple[str, str, int, int]]:
        """Name, unit, first entry and number of entries of every part of an observation."""
    @property
    def command_bounds(self) -> list[list[float]]:
        """Commands of the actions -1 and 1, m/s, N or A of the motor, one pair for every muscle."""
    @property
    def half_error(self) -> float:
        """Error at which the reward is a half, m or 1."""
    @property
    def resolution(self) -> tuple[int, int]:
        """Cells of every cable, and substeps of a millisecond."""
    @property
    def poses(self) -> _Array:
        """True poses, rad or m, shape `(environments, joints)`."""
    def design(self) -> str:
        """What all environments share, as JSON, for another simulator."""
    def episode(self, index: int) -> str:
        """The episode that one environment is in, as JSON: its specimen, its noise, its pushes, its targets."""

@disjoint_base
class Machine:
    """A machine on cables: bodies, joints, muscles with sheaths, cables and drives."""

    def __new__(
        cls,
        source: str | os.PathLike[str],
        *,
        muscles: str | os.PathLike[str] | None = None,
        routing: str | None = None,
    ) -> Self: ...
    @staticmethod
    def built_in() -> list[str]:
        """Names of the built-in machines."""
    @property
    def warnings(self) -> list[str]:
        """What its file contains and the reader ignored, in sentences."""
    @property
    def name(self) -> str:
        """Its name."""
    @property
    def joint_names(self) -> list[str]:
        """Names of the independent joints, in the order of every `q`."""
    @property
    def muscle_names(self) -> list[str]:
        """Names of the muscles."""
    @property
    def site_names(self) -> list[str]:
        """Names of the sites."""
    @property
    def path_names(self) -> list[str]:
        """Names of the closed paths of its end point."""
    @property
    def start(self) -> _Array:
        """Pose in which motions start, rad or m, shape `(joints,)`."""
    @property
    def ranges(self) -> _Array:
        """Ranges of the joints, rad or m, shape `(joints, 2)`; an unlimited joint has an assumed one."""
    @property
    def tension_limits(self) -> _Array:
        """Smallest and largest tension at every anchor, N, of the design or of cable and drive, shape `(muscles, 2)`."""
    @property
    def mass(self) -> float:
        """Mass of its moving bodies, kg."""
    def lengths(self, q: ArrayLike) -> _Array:
        """Lengths of the muscles, m, shape `(..., muscles)`; `q`: shape `(..., joints)`, rad or m."""
    def moment_arms(self, q: ArrayLike) -> _Array:
        """Moment arms `R = -dl/dq`, m, shape `(..., muscles, joints)`; `q`: shape `(..., joints)`, rad or m."""
    def wrap_angles(self, q: ArrayLike) -> _Array:
        """Wrap angles of the muscles at the joints, rad, shape `(..., muscles)`; `q`: shape `(..., joints)`, rad or m."""
    def drive_tensions(self, q: ArrayLike, tension: ArrayLike) -> _Array:
        """Tensions at the drives, N, with which the cables begin to slide toward them, shape `(..., muscles)`."""
    def mass_matrix(self, q: ArrayLike) -> _Array:
        """Mass matrix `M(q)`, kg m^2, shape `(..., joints, joints)`; `q`: shape `(..., joints)`, rad or m."""
    def inverse_dynamics(self, q: ArrayLike, v: ArrayLike, a: ArrayLike) -> _Array:
        """Torque that the muscles have to give, N m or N, shape `(..., joints)`."""
    def forward_dynamics(self, q: ArrayLike, v: ArrayLike, tension: ArrayLike) -> _Array:
        """Accelerations under tensions at the anchors, rad/s^2 or m/s^2, shape `(..., joints)`."""
    def position(self, q: ArrayLike, *, site: str | None = None) -> _Array:
        """Position of a site, by default of the end point, m, shape `(..., 3)`."""
    def jacobian(self, q: ArrayLike, *, site: str | None = None) -> _Array:
        """Jacobian of a site, shape `(..., 6, joints)`: velocity, m/s, above angular velocity, rad/s."""
    def controller(self, seed: SupportsIndex | None = None, *, poses: ArrayLike | None = None) -> Controller:
        """A controller in its initial state."""
    def __reduce__(
        self,
    ) -> tuple[Callable[[str, str | None, str | None], PythonMachine], tuple[str, str | None, str | None]]: ...

@final
class CableEnds:
    """Tensions at the ends of a cable after a step."""

    @property
    def tension_in(self) -> float:
        """Tension at the drive's outlet, N."""
    @property
    def tension_out(self) -> float:
        """Tension at the anchor, N."""
    @property
    def dissipated(self) -> float:
        """Energy dissipated by friction in the step, J."""

@disjoint_base
class Cable:
    """An elastic cable with friction in its sheath, cut into cells; see `sinew.Cable`."""

    def __new__(cls, path: str | None, parameters: str | None, cells: SupportsIndex) -> Self: ...
    @staticmethod
    def bench_parameters() -> str:
        """The parameters of the bench as JSON."""
    def step(self, interval_s: _Number, motor_m: _Number, anchor_m: _Number = 0.0) -> CableEnds:
        """Advances the cable by `interval_s` seconds while its ends move by `motor_m` and `anchor_m`, m."""
    def run(
        self, interval_s: _Number, motor_m: ArrayLike, anchor_m: ArrayLike | None = None
    ) -> dict[str, _Array]:
        """Many steps; displacements in m, shapes `(n,)`."""
    def settle(self, tension_out_n: _Number, *, toward_motor: bool = True) -> CableEnds:
        """Sets the profile of steady sliding with this tension at the anchor, N."""
    @property
    def ends(self) -> CableEnds:
        """Tensions at the ends after the last step."""
    @property
    def tensions(self) -> _Array:
        """Tension of every cell, N, drive end first, shape `(cells,)`."""
    @property
    def slips(self) -> _Array:
        """Slip of every node in the last step, m, positive toward the motor, shape `(cells - 1,)`."""
    @property
    def stretch(self) -> float:
        """Total stretch, m; negative by the slack of a slack cable."""
    @property
    def energy(self) -> float:
        """Elastic energy, J, without that of the pretension."""
    @property
    def law(self) -> dict[str, _Array]:
        """The law as arrays, drive end first: `compliance`, m/N, shape `(cells,)`; of every node, shape `(cells - 1,)`,
        `friction`, the half angle `mu phi / 2`, `loss`, `-ln(efficiency) / 2`, `viscous`, s/m, and `drag`, N s/m;
        `drag_fade` and `pretension`, N, shape `()`."""
    def travel_to(self, tension_out_n: _Number, *, toward_motor: bool = True) -> float:
        """Travel of the winch, m, that brings the anchor to a tension, N, while it stands still."""
    def _assign(self, other: Cable) -> None: ...

@final
class Trajectory:
    """A reference of the joints over time, from rest to rest.

    Made by `Machine.plan`.
    """

    @property
    def duration_s(self) -> float:
        """From rest to rest, s."""
    @property
    def closed(self) -> bool:
        """Whether it ends in its initial pose."""
    def sample(self, time_s: ArrayLike) -> tuple[_Array, _Array, _Array]:
        """Pose, velocity and acceleration, rad or m, per s, per s^2, shapes `(..., joints)`."""

@final
class Twin:
    """A simulated machine: bodies, elastic cables with friction and effects that no model has, drives, sensors.

    `seed` draws a specimen within the machine's tolerances; without it the machine is as designed.
    """

    def __new__(
        cls,
        machine: Machine,
        seed: SupportsIndex | None = None,
        *,
        q: ArrayLike | None = None,
        tension_n: ArrayLike | None = None,
    ) -> Twin: ...
    def step(
        self,
        command: ArrayLike,
        interval_s: _Number | None = None,
        *,
        kind: Literal["speed", "tension", "current"] = "speed",
    ) -> None:
        """All drives execute their commands for `interval_s` seconds, by default a period; `command`: shape `(muscles,)`."""
    def copy(self) -> Twin:
        """A twin that continues independently from the same state."""
    def __copy__(self) -> Twin: ...
    def __deepcopy__(self, _memo: object) -> Twin: ...
    @property
    def time_s(self) -> float:
        """Time since the start, s."""
    @property
    def q(self) -> _Array:
        """True pose, rad or m, shape `(joints,)`."""
    @property
    def v(self) -> _Array:
        """True velocities, per s, shape `(joints,)`."""
    @property
    def lengths(self) -> _Array:
        """True lengths from sheath to anchor, m, shape `(muscles,)`."""
    @property
    def tension_in(self) -> _Array:
        """True tensions at the drives, N, shape `(muscles,)`."""
    @property
    def tension_out(self) -> _Array:
        """True tensions at the anchors, N, shape `(muscles,)`."""
    @property
    def stretch(self) -> _Array:
        """True stretch of the cables, m, shape `(muscles,)`."""
    @property
    def measured_motor(self) -> _Array:
        """Measured positions of the cables at the motors, m, shape `(muscles,)`."""
    @property
    def measured_tension(self) -> _Array:
        """Measured tensions at the drives' outlets, N, shape `(muscles,)`."""
    @property
    def measured_joint(self) -> _Array:
        """Measured pose by the joints' encoders, rad or m, NaN without one, shape `(joints,)`."""

@final
class TwinBatch:
    """Many simulated machines of one design, stepped together: each has the bits of a `Twin` of its seed.

    `seeds`: one for every world, None for the machine as designed. `q`, rad or m, and `tension_n`, N: as of `Twin`, shapes
    `(worlds, joints)` and `(worlds, muscles)`, or one row for all. `threads`: the calling one among them. Worlds step in
    groups of eight, without the interpreter's lock; what one does depends neither on the others nor on `threads`.
    """

    def __new__(
        cls,
        machine: Machine,
        seeds: Sequence[SupportsIndex | None],
        *,
        q: ArrayLike | None = None,
        tension_n: ArrayLike | None = None,
        threads: SupportsIndex = 1,
    ) -> TwinBatch: ...
    def __len__(self) -> int: ...
    def step(
        self,
        command: ArrayLike,
        interval_s: _Number | None = None,
        *,
        kind: Literal["speed", "tension", "current"] = "speed",
    ) -> None:
        """All drives execute their commands for `interval_s` seconds, by default a period.

        `command`: shape `(worlds, muscles)` or `(muscles,)`; NaN switches a drive off. A world that cannot go on stays as
        it is until it is reset."""
    def reset(
        self,
        mask: Sequence[bool] | NDArray[np.bool_] | None = None,
        *,
        seeds: Sequence[SupportsIndex | None] | None = None,
        q: ArrayLike | None = None,
        tension_n: ArrayLike | None = None,
    ) -> None:
        """Worlds where `mask` is true, all without one, begin anew: as they began last, but for what is given.

        All arguments have a row for every world; those of worlds that do not begin are not used."""
    def copy(self) -> TwinBatch:
        """A batch that continues independently from the same state, on the same threads."""
    def __copy__(self) -> TwinBatch: ...
    def __deepcopy__(self, _memo: object) -> TwinBatch: ...
    def twin(self, world: SupportsIndex) -> Twin:
        """A twin that continues independently from the state of one world."""
    @property
    def failed(self) -> NDArray[np.bool_]:
        """Whether a world cannot go on until it is reset, shape `(worlds,)`."""
    @property
    def failures(self) -> list[str | None]:
        """Why worlds cannot go on; None where they can."""
    @property
    def time_s(self) -> _Array:
        """Time since the start, s, shape `(worlds,)`."""
    @property
    def q(self) -> _Array:
        """True poses, rad or m, shape `(worlds, joints)`."""
    @property
    def v(self) -> _Array:
        """True velocities, per s, shape `(worlds, joints)`."""
    @property
    def lengths(self) -> _Array:
        """True lengths from sheath to anchor, m, shape `(worlds, muscles)`."""
    @property
    def tension_in(self) -> _Array:
        """True tensions at the drives, N, shape `(worlds, muscles)`."""
    @property
    def tension_out(self) -> _Array:
        """True tensions at the anchors, N, shape `(worlds, muscles)`."""
    @property
    def stretch(self) -> _Array:
        """True stretch of the cables, m, shape `(worlds, muscles)`."""
    @property
    def measured_motor(self) -> _Array:
        """Measured positions of the cables at the motors, m, shape `(worlds, muscles)`."""
    @property
    def measured_tension(self) -> _Array:
        """Measured tensions at the drives' outlets, N, shape `(worlds, muscles)`."""
    @property
    def measured_joint(self) -> _Array:
        """Measured poses by the joints' encoders, rad or m, NaN without one, shape `(worlds, joints)`."""

@final
class Controller:
    """The controller of a machine: observers, inverse dynamics, distribution of tensions, winch commands.

    Made by `Machine.controller`.
    """

    def step(
        self,
        motor: ArrayLike,
        tension: ArrayLike,
        joint: ArrayLike,
        q: ArrayLike,
        v: ArrayLike | None = None,
        a: ArrayLike | None = None,
        *,
        previewed: tuple[ArrayLike, ArrayLike, ArrayLike] | None = None,
        interval_s: _Number | None = None,
    ) -> Command:
        """One control cycle: the commands for the `interval_s` seconds to come, by default a period."""
    def copy(self) -> Controller:
        """A controller that continues independently from the same state."""
    def __copy__(self) -> Controller: ...
    def __deepcopy__(self, _memo: object) -> Controller: ...

@final
class Command:
    """Commands for the drives, with the intermediate results that led to them."""

    @property
    def speed(self) -> _Array:
        """Speeds of the cables at the winches, m/s, positive toward the motor, shape `(muscles,)`."""
    @property
    def desired_tension(self) -> _Array:
        """Desired tensions at the anchors, N, shape `(muscles,)`."""
    @property
    def estimated_tension(self) -> _Array:
        """Estimated tensions at the anchors, N, shape `(muscles,)`."""
    @property
    def q(self) -> _Array:
        """Estimated pose, rad or m, shape `(joints,)`."""
    @property
    def reached(self) -> bool:
        """Whether the desired tensions give the desired torque."""
    @property
    def status(self) -> Literal["following", "holding", "degraded", "stopped"]:
        """Operating state."""
    @property
    def fault(self) -> str | None:
        """The fault that degraded or stopped the machine, with the index of its joint or muscle."""
