"""Whole experiments on simulated machines."""

from __future__ import annotations

import json
import os
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from . import _sinew
from ._display import html_table, number
from ._machine import Machine, Path
from ._progress import Progress, reported
from ._refused import whole, wrong_kind

if TYPE_CHECKING:
    from matplotlib.figure import Figure

#: What the controller knows of the cables; see `track`.
Compensation: TypeAlias = Literal[
    "observer", "no_observer", "no_disturbance_observer", "paper", "capstan", "inverted", "none", "perfect"
]


@dataclass(frozen=True, slots=True)
class Run:
    """A tracking run of a simulated machine."""

    #: How it ended, errors of end point, joints and muscles, faults; units are part of the names.
    numbers: dict[str, Any]
    #: Over time, arrays of shape `(n,)`, `(n, 3)` and `(n, muscles)`; units are part of the names.
    trace: dict[str, NDArray[Any]]
    #: Names of the muscles.
    muscle_names: tuple[str, ...]
    #: Name of the machine.
    machine: str

    @property
    def completed(self) -> bool:
        """Whether it ended as planned."""
        return bool(self.numbers["ended"] == "as_planned")

    def plot(self) -> Figure:
        """Error of the end point, of the joints where there is none, with its limits, and tensions at the anchors over time.

        The title says how the run ended and why, a red line where it was stopped. Needs matplotlib.
        """
        from matplotlib.figure import Figure

        figure = Figure(figsize=(9, 6), layout="constrained")
        above, below = figure.subplots(2, 1, sharex=True)
        time, numbers = self.trace["time_s"], self.numbers
        offset = self.trace["end_point_m"] - self.trace["end_point_reference_m"]
        if np.isfinite(offset).any():
            above.plot(time, 1e3 * (offset**2).sum(axis=1) ** 0.5, label="true place from the reference")
            if (limit := numbers["end_point_limit_m"]) is not None:
                above.axhline(1e3 * limit, color="0.4", linestyle="--", linewidth=0.8, label="limit")
            above.set_ylabel("end-point error, mm")
        else:
            errors = 1e3 * (self.trace["joint_true"] - self.trace["joint_reference"])
            joints = numbers["joints"]
            units = ["mrad" if "limit_rad" in joint else "mm" for joint in joints]
            mixed = len(set(units)) > 1
            for k, (error, joint, unit) in enumerate(zip(errors.T, joints, units, strict=True)):
                name = f"{joint['joint']}, {unit}" if mixed else joint["joint"]
                above.plot(time, error, label=name, linewidth=0.8, color=f"C{k % 10}")
                limit = 1e3 * (joint["limit_rad"] if unit == "mrad" else joint["limit_m"])
                for side in (-limit, limit):
                    above.axhline(side, color=f"C{k % 10}", linestyle="--", linewidth=0.6)
            above.set_ylabel(f"joint error, {' or '.join(sorted(set(units)))} (dashed: limits)")
        for tension, name in zip(self.trace["tension_out_n"].T, self.muscle_names, strict=True):
            below.plot(time, tension, label=name, linewidth=0.8)
        below.set_ylabel("tension at the anchors, N")
        below.set_xlabel("time, s (simulated)")
        # As it ended, and why where it did not end as planned.
        ended = numbers["ended"].replace("_", " ")
        why = f": {numbers['reason']}" if numbers["reason"] else ""
        above.set_title(f"{self.machine}, simulated: {ended}{why}", fontsize="medium", wrap=True)
        if (stopped := numbers["stopped_s"]) is not None or numbers["ended"] in ("stopped", "diverged"):
            moment = float(time[-1]) if stopped is None else stopped
            for axes in (above, below):
                axes.axvline(moment, color="tab:red", linewidth=1.0, label=f"{ended} at {moment:.2f} s")
        for axes in (above, below):
            axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), fontsize="small")
        return figure

    def __repr__(self) -> str:
        return f"Run({self.machine}: {self.numbers['ended']}, {len(self.trace['time_s'])} rows, simulated)"

    def _repr_html_(self) -> str:
        return _tracking_table({"this run": self.numbers})


def track(
    machine: Machine | str | os.PathLike[str],
    path: Path | _sinew.Trajectory | None = None,
    *,
    duration_s: float | None = None,
    repeats: int | None = None,
    learning: bool = True,
    hold_s: float = 0.0,
    compensation: Compensation = "observer",
    payload_kg: float | None = None,
    faults: str | Sequence[str] = (),
    seed: int = 1,
    unverified: bool = False,
    rules: Mapping[str, float] | None = None,
    trace_interval_s: float = 0.01,
    progress: Progress | None = None,
) -> Run:
    """Moves a SIMULATED machine, which deviates from the design by errors unknown to the controller, along a motion.

    Each cable is calibrated first. `machine`: a machine, or its name or file. `path`, `duration_s`: as in `Machine.plan`.
    `repeats`: of a closed motion, by default 1,
    with iterative `learning` from one to the next. `hold_s`: rest after the motion, s. `compensation`: `"observer"`,
    `"no_observer"`, `"no_disturbance_observer"`, `"paper"`, `"capstan"`, `"none"` or `"perfect"`.
    `payload_kg`: by default the machine's. `faults`: to inject, each as `"load-cell:MUSCLE:lost@3"`, that is
    `COMPONENT:NAME[:MODE]@START[+DURATION]`, s from the start of the run, as `sinew track --fault` has them. What
    the supervisor made of them is in `Run.numbers["incidents"]`.
    `seed`: draws the machine. `trace_interval_s`: s between rows of the trace.

    Warns of a motion that simulated machines of the design come to the end of, but not well. Raises `ValueError` for one
    that the machine cannot track, with the reason; `unverified` starts one that only
    simulated machines of the design did not track. `rules`: those of `verify` for the same motion, which is then not
    simulated before the start again: many specimens of a machine need it once.
    """
    known = machine if isinstance(machine, Machine) else Machine(machine)
    trajectory = _planned(known, path, duration_s)
    conditions = {
        "repeats": repeats,
        "learning": learning,
        "hold_s": hold_s,
        "compensation": compensation,
        "payload_kg": payload_kg,
        "faults": [faults] if isinstance(faults, str) else list(faults),
        "seed": whole("seed", seed),
        "unverified": unverified,
        "rules": None if rules is None else json.dumps(dict(rules)),
        "trace_interval_s": trace_interval_s,
    }
    try:
        with reported(progress) as said:
            numbers, trace, warning = _sinew.track(known, trajectory, conditions, said)
    except TypeError as error:
        raise wrong_kind(error, conditions) from None
    if warning is not None:
        warnings.warn(warning, UserWarning, stacklevel=2)
    return Run(json.loads(numbers), trace, tuple(known.muscle_names), known.name)


def verify(
    machine: Machine | str | os.PathLike[str],
    path: Path | _sinew.Trajectory | None = None,
    *,
    duration_s: float | None = None,
    repeats: int | None = None,
    payload_kg: float | None = None,
    progress: Progress | None = None,
) -> dict[str, float]:
    """Rules of control with which SIMULATED machines, sampled within the tolerances, track a motion.

    `machine`, `path`, `duration_s`, `repeats`, `payload_kg`: as in `track`.
    The gains are lowered until all sampled machines come to the end of the motion with
    taut cables and small errors. Units are part of the names; the rules are those of the machine file's table `[control]`.
    `joint_error:JOINT` is the largest error of a joint on these machines, rad or m, by which `track` judges a run.

    Warns where the dead bands of the cables leave a joint inaccurate. Raises `ValueError` for a motion that the machine cannot track, with the reason.
    """
    known = machine if isinstance(machine, Machine) else Machine(machine)
    trajectory = _planned(known, path, duration_s)
    with reported(progress) as said:
        text, warning = _sinew.verify(known, trajectory, repeats, payload_kg, said)
    if warning is not None:
        warnings.warn(warning, UserWarning, stacklevel=2)
    rules: dict[str, float] = json.loads(text)
    return rules


def _planned(machine: Machine, path: Path | _sinew.Trajectory | None, duration_s: float | None) -> _sinew.Trajectory:
    if not isinstance(path, _sinew.Trajectory):
        return machine.plan(path, duration_s=duration_s)
    if duration_s is not None:
        raise ValueError("duration_s must be none with a planned trajectory, which has its own")
    return path


@dataclass(frozen=True, slots=True)
class Reproduction:
    """Numbers of one paper's experiments, repeated on a SIMULATED plant: those of `results.json`."""

    #: Tables and errors by name; units are part of the names.
    results: dict[str, Any]

    def _repr_html_(self) -> str:
        text = ""
        if "table1" in self.results:
            rows = [
                [variant, side, *(number(value, 3) for value in indices["rmse_n"])]
                for variant, sides in self.results["table1"].items()
                for side, indices in sides.items()
            ]
            head = ["SIMULATED bench", "muscle", *(f"speed {k}" for k in range(1, 7))]
            text += html_table("Tracking error of the far tension, N rms, by speed", head, rows)
        if "tracking" in self.results:
            text += _tracking_table(self.results["tracking"])
        return text


def reproduce(
    *,
    part: Literal["all", "bench", "arm"] = "all",
    quick: bool = False,
    seed: int = 1,
    threads: int | None = None,
    progress: Progress | None = None,
) -> Reproduction:
    """Repeats the experiments of Yuan et al. (2023) on a SIMULATED bench and arm.

    `part`: `"all"`, `"bench"` or `"arm"`. `quick`: in seconds, coarser. The same `seed` gives the same bits.
    """
    first = whole("seed", seed)
    with reported(progress) as said:
        return Reproduction(json.loads(_sinew.reproduce(part, quick, first, threads, said)))


def _tracking_table(tracking: dict[str, dict[str, Any]]) -> str:
    def row(name: str, found: dict[str, Any]) -> list[str]:
        error = found["end_point_error_m"]
        in_mm = [number(None if error[key] is None else 1e3 * error[key], 3) for key in ("mean", "std", "max")]
        return [name, found["ended"], *in_mm, number(1e3 * found["muscle_length_error_m"]["mean"], 3)]

    head = ["SIMULATED machine", "ended", "end point, mm: mean", "std", "max", "muscle length, mm"]
    return html_table("Tracking", head, [row(name, found) for name, found in tracking.items()])
