"""Robustness of tracking over specimens of a machine."""

from __future__ import annotations

from .. import Machine, track
from .._machine import Path
from ._study import Objective


def robustness(
    machine: Machine, path: Path | None = None, *, duration_s: float | None = None, compensation: str = "observer"
) -> Objective:
    """The objective of a study without parameters whose trials are SIMULATED specimens, drawn by their seeds.

    Values: largest and mean error of the end point, m, and whether the motion `completed`, 1 or 0.
    """
    trajectory = machine.plan(path, duration_s=duration_s)

    def specimen(_parameters: dict[str, float], seed: int) -> dict[str, float]:
        run = track(
            machine, trajectory, repeats=1, learning=False, seed=seed, compensation=compensation, trace_interval_s=1.0
        )
        error = run.numbers["end_point_error_m"]
        values = {"completed": float(run.completed)}
        return values | {f"{key}_error_m": error[key] for key in ("mean", "max") if error[key] is not None}

    return specimen
