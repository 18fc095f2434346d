"""Wall-clock time of a study on actors of Ray beside that on threads, in turn, with the same trials.

    python python/benches/ray_overhead.py [MACHINE] [TRIALS] [BATCH] [ROUNDS] [DURATION_S]

The study is `sinew.study.robustness`. Ray's start and that of its actors, which a study pays once, is shown apart: a study of two
trials. Needs a release build of the package (`pip install .`), Ray, and an idle machine.
"""

from __future__ import annotations

import os
import statistics
import sys
import tempfile
import time
from collections.abc import Callable, Mapping
from typing import Any

import ray

from sinew.study import Study, robustness

#: Values of a specimen, given no parameters and its seed.
Objective = Callable[[dict[str, float], int], Mapping[str, float]]


def seconds(objective: Objective, trials: int, **keywords: Any) -> tuple[float, list[Any]]:
    """Of a study from its first proposal to its last result, and what it found."""
    with tempfile.TemporaryDirectory() as folder, Study(folder, objective, {}) as study:
        began = time.perf_counter()
        ended = study.run(trials, **keywords)
        return time.perf_counter() - began, [(trial.values, trial.error) for trial in ended]


def main(machine: str = "lm_arm", trials: int = 100, batch: int = 4, rounds: int = 3, duration_s: float = 0.0) -> None:
    objective, workers = robustness(machine, duration_s=duration_s or None), os.cpu_count() or 1
    began = time.perf_counter()
    ray.init(include_dashboard=False, log_to_driver=False)
    started = time.perf_counter() - began
    actors, _ = seconds(objective, 2, backend="ray", workers=workers)
    print(f"Ray {ray.__version__}: started in {started:.1f} s, a study of two trials takes {actors:.1f} s")
    ratios = []
    for k in range(rounds):
        load = os.getloadavg()[0]
        runs = {
            "threads": lambda: seconds(objective, trials, workers=workers),
            "ray": lambda: seconds(objective, trials, backend="ray", workers=workers, batch=batch),
        }
        # The one that begins changes, so that a machine that grows slower favours neither.
        times = {name: runs[name]() for name in sorted(runs, reverse=k % 2 == 0)}
        assert times["ray"][1] == times["threads"][1], "both must find the same"
        ratios.append(times["ray"][0] / times["threads"][0] - 1)
        print(
            f"{machine}, {trials} trials, {workers} workers, batches of {batch}: threads {times['threads'][0]:.1f} s, "
            f"Ray {times['ray'][0]:.1f} s, {100 * ratios[-1]:+.1f} %; load before {load:.2f}",
            flush=True,
        )
    print(f"median {100 * statistics.median(ratios):+.1f} %")


if __name__ == "__main__":
    convert = (str, int, int, int, float)
    main(*(kind(argument) for kind, argument in zip(convert, sys.argv[1:], strict=False)))
