"""What an environment simulates: machine, task, commands, and how episodes differ."""

from __future__ import annotations

import os
from dataclasses import asdict, dataclass, field
from math import isfinite
from typing import Any, Literal, NamedTuple, TypeAlias, TypedDict

import numpy as np
from gymnasium import spaces

from .. import _sinew
from .._machine import Machine, Path
from .._refused import whole, wrong_kind

#: Two bounds between which a number is drawn at every reset.
Bounds: TypeAlias = tuple[float, float]


@dataclass(frozen=True)
class Randomisation:
    """How the machine of an episode differs from the design; each number is sampled evenly between two bounds.

    `friction`: factor on the coefficient of friction of all cables; `(0, 0)` are cables without any friction, drag or loss.
    `bend`: factor on the bend of all sheaths. `mass`: factor on masses and inertias. `delay_ms`: delay of all sensors beside
    that of the design, ms. `tolerances`: whether every part is sampled within the machine's own tolerances as well.
    """

    friction: Bounds = (0.8, 1.2)
    bend: Bounds = (0.9, 1.1)
    mass: Bounds = (0.9, 1.1)
    delay_ms: Bounds = (0.0, 5.0)
    tolerances: bool = True

    def __post_init__(self) -> None:
        for name in ("friction", "bend", "mass", "delay_ms"):
            bounds = getattr(self, name)
            if not isinstance(bounds, tuple) or len(bounds) != 2:
                raise ValueError(f"{name} must be a tuple of two bounds, such as (0.8, 1.2), but is {bounds!r}")
            if not all(isinstance(bound, (int, float, np.number)) for bound in bounds):
                raise TypeError(f"{name} must be a tuple of two numbers, but is {bounds!r}")
            if not (isfinite(bounds[1]) and 0.0 <= bounds[0] <= bounds[1]):
                raise ValueError(f"{name} must be two bounds of at least 0, the smaller one first, but is {bounds!r}")

    @classmethod
    def none(cls) -> Randomisation:
        """The machine as designed, in every episode."""
        return cls((1.0, 1.0), (1.0, 1.0), (1.0, 1.0), (0.0, 0.0), False)


class ObservationPart(NamedTuple):
    """A part of an observation: its entries are `observation[..., part.start : part.stop]`."""

    #: Index of the first entry.
    start: int
    #: Index behind the last entry.
    stop: int
    #: Unit of its entries.
    unit: str


class ConditionKeywords(TypedDict, total=False):
    """The fields of `Conditions` as keywords."""

    machine: Machine | str | os.PathLike[str]
    task: Literal["reach", "track", "hold"]
    path: Path | _sinew.Trajectory | None
    duration_s: float | None
    push: float | None
    actuation: Literal["speed", "tension", "torque"]
    interval_ms: int | None
    steps: int
    cells: int
    substeps: int
    spread: float
    effort: float
    randomisation: Randomisation


@dataclass(frozen=True)
class Conditions:
    """What the environments of this package take as keywords.

    `machine`: a `sinew.Machine`, or its name or file. `task`: `"reach"` a pose or the position of the end point in it,
    `"track"` a motion, `"hold"` a pose against pushes. `path`, `duration_s`: the motion to be tracked, as of `Machine.plan`,
    or a `sinew.Trajectory`. `push`: of `"hold"`, largest push, as a fraction of what the strongest muscle of a joint exerts on
    it, by default 0.3.

    `actuation`: what actions from -1 to 1 command of every drive, `"speed"` of the cable, `"tension"`, or `"torque"` of the motor.
    `interval_ms`: how long an action holds, ms, a whole number of the machine's periods; by default 10, or the next such
    number. `steps`: actions of an episode. `cells`, `substeps`: cells of every cable, and least steps of a simulated
    millisecond; more are taken where the machine needs them. `spread`: how far initial poses and targets are from the machine's
    start, as a fraction of the joints' ranges. `effort`: weight of the mean square action in the reward. `randomisation`: how
    episodes differ.
    """

    machine: Machine | str | os.PathLike[str] = "lm_arm"
    task: Literal["reach", "track", "hold"] = "reach"
    path: Path | _sinew.Trajectory | None = None
    duration_s: float | None = None
    push: float | None = None
    actuation: Literal["speed", "tension", "torque"] = "speed"
    interval_ms: int | None = None
    steps: int = 500
    cells: int = 12
    substeps: int = 1
    spread: float = 0.5
    effort: float = 0.01
    randomisation: Randomisation = field(default_factory=Randomisation)

    def __post_init__(self) -> None:
        if not isinstance(self.randomisation, Randomisation):
            given = f"but is {self.randomisation!r}: Randomisation.none() is the machine as designed"
            raise TypeError(f"randomisation must be a sinew.gym.Randomisation, {given}")
        if self.interval_ms is not None:
            whole("interval_ms", self.interval_ms, 1)
        if self.push is not None and self.task != "hold":
            raise ValueError(f'push belongs to the task "hold", but task is {self.task!r}')

    @property
    def name(self) -> str:
        """Name or file of the machine."""
        return self.machine.name if isinstance(self.machine, Machine) else os.fspath(self.machine)

    def environments(self, seeds: list[int], reset_mode: str, threads: int) -> _sinew.Environments:
        """Simulated machines, one for each seed."""
        machine = self.machine if isinstance(self.machine, Machine) else Machine(self.machine)
        trajectory = None
        if self.task == "track":
            given = self.path
            trajectory = given if isinstance(given, _sinew.Trajectory) else machine.plan(given, duration_s=self.duration_s)
        elif self.path is not None or self.duration_s is not None:
            raise ValueError(f'path and duration_s belong to the task "track", but task is {self.task!r}')
        names = ("task", "push", "actuation", "interval_ms", "steps", "cells", "substeps", "spread", "effort")
        values: dict[str, Any] = {name: getattr(self, name) for name in names}
        values |= {"trajectory": trajectory, "push": 0.3 if self.push is None else self.push} | asdict(self.randomisation)
        try:
            return _sinew.Environments(machine, values, seeds, reset_mode, threads)
        except TypeError as error:
            raise wrong_kind(error, values) from None


def spaces_of(environments: _sinew.Environments) -> tuple[spaces.Box, spaces.Box]:
    """Spaces of the observations and actions of one environment."""
    low, high = (np.array(bounds, dtype=np.float32) for bounds in environments.observation_bounds)
    return spaces.Box(low, high, dtype=np.float32), spaces.Box(-1.0, 1.0, (environments.actions,), dtype=np.float32)


def parts_of(environments: _sinew.Environments) -> dict[str, ObservationPart]:
    """Parts of an observation by name."""
    parts = environments.observation_parts
    return {name: ObservationPart(start, start + width, unit) for name, unit, start, width in parts}
