"""Robustness of tracking over specimens of a machine."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import ClassVar

from .. import Machine, track, verify
from .._experiment import Compensation
from .._machine import Path
from ._backends import Objective


def robustness(
    machine: Machine | str | os.PathLike[str],
    path: Path | None = None,
    *,
    duration_s: float | None = None,
    compensation: Compensation = "observer",
) -> Objective:
    """The objective of a study without parameters whose trials are SIMULATED specimens, sampled by their seeds.

    `machine`: a machine, or its name or file. Values: `max_end_point_error_m`, `max_joint_error_rad`, `max_joint_error_m` and the means, where the
    machine has them, and whether the motion `completed`, 1 or 0. The motion is verified once for all trials. Raises `ValueError` for one that
    the machine cannot track.
    """
    arm = machine if isinstance(machine, Machine) else Machine(machine)
    trajectory = arm.plan(path, duration_s=duration_s)
    rules = verify(arm, trajectory, repeats=1) if compensation == "observer" else None
    return _Specimens(arm, path, duration_s, compensation, rules)


@dataclass(frozen=True, slots=True)
class _Specimens:
    simulated: ClassVar[bool] = True
    machine: Machine
    path: Path | None
    duration_s: float | None
    compensation: Compensation
    rules: dict[str, float] | None

    def __call__(self, _parameters: dict[str, float], seed: int) -> dict[str, float]:
        run = track(
            self.machine,
            self.path,
            duration_s=self.duration_s,
            repeats=1,
            learning=False,
            seed=seed,
            compensation=self.compensation,
            rules=self.rules,
            trace_interval_s=1.0,
        )
        values = {"completed": float(run.completed)}
        for quantity in ("end_point_error_m", "joint_error_rad", "joint_error_m"):
            error = run.numbers[quantity] or {}
            values |= {f"{key}_{quantity}": error[key] for key in ("mean", "max") if error.get(key) is not None}
        return values
