"""Routes of muscles: the best with friction in the sheaths beside the best that takes no account of it. All simulated; needs Optuna and cmaes.

    python python/examples/routes.py [TRIALS] [SEEDS]

Both goals are searched apart from each other, with every seed 1 to SEEDS, by uniform draws and by CMA-ES from the best of them. Without friction a sheath's length makes no difference: the
route that is best without friction is given, after its search, the length with which it has the most torque with friction.
"""

from __future__ import annotations

import sys
import tempfile
import warnings
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import optuna

from sinew.study import Range, Study, Trial, routing

#: Values of a route, given its parameters and a seed.
Objective = Callable[[dict[str, float], int], Mapping[str, float]]

#: Machine, muscle, and how far its cable may be moved: end of the sheath and anchor, m, surfaces, and length of the sheath, m.
CASES: list[tuple[str, str, dict[str, Range]]] = [
    (
        "lm_arm",
        "brachialis",
        {
            "origin_x_m": Range(-0.01, 0.03),
            "origin_z_m": Range(-0.05, 0.1),
            "anchor_x_m": Range(0.0, 0.03),
            "anchor_z_m": Range(-0.06, 0.02),
            "wrap_factor": Range(0.6, 1.3),
            "sheath_m": Range(0.3, 0.8),
        },
    ),
    (
        "lm_arm",
        "triceps",
        {
            "origin_x_m": Range(-0.02, 0.01),
            "origin_z_m": Range(-0.05, 0.1),
            "anchor_x_m": Range(-0.02, 0.01),
            "anchor_z_m": Range(-0.04, 0.02),
            "wrap_factor": Range(0.6, 1.3),
            "sheath_m": Range(0.3, 0.8),
        },
    ),
    (
        "planar_leg",
        "hamstrings",
        {
            "origin_x_m": Range(-0.03, 0.03),
            "origin_z_m": Range(-0.05, 0.05),
            "anchor_x_m": Range(-0.02, 0.02),
            "anchor_z_m": Range(-0.05, 0.02),
            "wrap_factor": Range(0.6, 1.3),
            "sheath_m": Range(0.4, 0.9),
        },
    ),
    (
        "exosuit_elbow",
        "flexor",
        {
            "origin_x_m": Range(-0.02, 0.06),
            "origin_z_m": Range(-0.08, 0.06),
            "anchor_x_m": Range(-0.02, 0.03),
            "anchor_z_m": Range(-0.06, 0.06),
            "sheath_m": Range(0.7, 1.2),
        },
    ),
]


#: Lengths of the sheath that are tried for a route that was found without friction.
LENGTHS = 41
#: The values of a route that are shown: with friction, without, loss.
VALUES = ("torque_nm", "frictionless_torque_nm", "friction_loss")


def search(objective: Objective, parameters: dict[str, Range], value: str, trials: int, seed: int) -> dict[str, float]:
    """Parameters of the route with the largest `value`: uniform draws, then, for the other half of the trials, CMA-ES from their best."""
    drawn = best_of(objective, parameters, value, trials // 2, seed, None)
    with warnings.catch_warnings():
        # Where the search begins is given by arguments that Optuna 5 calls deprecated, and has no others for.
        warnings.simplefilter("ignore", FutureWarning)
        sampler = optuna.samplers.CmaEsSampler(x0=drawn.parameters, sigma0=0.1, seed=seed)
    refined = best_of(objective, parameters, value, trials - trials // 2, seed, sampler)
    return max(drawn, refined, key=lambda trial: trial.values[value]).parameters


def best_of(
    objective: Objective, parameters: dict[str, Range], value: str, trials: int, seed: int, sampler: Any
) -> Trial:
    """The trial with the largest `value` of a study."""
    with tempfile.TemporaryDirectory() as folder:
        with Study(folder, objective, parameters, maximize=[value], seed=seed, sampler=sampler) as study:
            ended = [trial for trial in study.run(trials, workers=1) if trial.error is None]
    return max(ended, key=lambda trial: trial.values[value])


def with_best_sheath(objective: Objective, route: dict[str, float], sheath: Range, seed: int) -> dict[str, float]:
    """Values of a route with the length of its sheath that gives the most torque with friction."""
    tried = [route | {"sheath_m": float(length)} for length in np.linspace(sheath.low, sheath.high, LENGTHS)]
    return max((dict(objective(one, seed)) for one in tried), key=lambda values: values["torque_nm"])


def compare(objective: Objective, parameters: dict[str, Range], trials: int, seed: int) -> dict[str, dict[str, float]]:
    """Values of the best route by the goal of its search."""
    apart = {name: value for name, value in parameters.items() if name != "sheath_m"}
    best = search(objective, parameters, "torque_nm", trials, seed)
    blind = search(objective, apart, "frictionless_torque_nm", trials, seed)
    return {
        "best with friction": dict(objective(best, seed)),
        "best without friction": with_best_sheath(objective, blind, parameters["sheath_m"], seed),
    }


def main(trials: int = 1200, seeds: int = 5) -> None:
    optuna.logging.set_verbosity(optuna.logging.WARNING)
    print("| machine, muscle | route | torque, N m | without friction, N m | friction loss | gain of the best with friction |")
    print("|---|---|---|---|---|---|")
    for machine, muscle, parameters in CASES:
        objective = routing(machine, muscle)
        runs = [compare(objective, parameters, trials, seed) for seed in range(1, seeds + 1)]
        print(f"| {machine}, {muscle} | design | {' | '.join(shown([dict(objective({}, 1))]))} | |", flush=True)
        gains = [
            100 * (run["best with friction"]["torque_nm"] / run["best without friction"]["torque_nm"] - 1) for run in runs
        ]
        for route in runs[0]:
            gain = f"{min(gains):.2f} to {max(gains):.2f} %" if route == "best with friction" else ""
            print(f"| {machine}, {muscle} | {route} | {' | '.join(shown([run[route] for run in runs]))} | {gain} |", flush=True)


def shown(values: list[dict[str, float]]) -> list[str]:
    """Smallest and largest of the seeds."""
    texts = []
    for name in VALUES:
        factor, unit, digits = (100, " %", 1) if name == "friction_loss" else (1, "", 3)
        ends = [f"{factor * end([one[name] for one in values]):.{digits}f}" for end in (min, max)]
        texts.append((ends[0] if ends[0] == ends[1] else " to ".join(ends)) + unit)
    return texts


if __name__ == "__main__":
    main(*(int(argument) for argument in sys.argv[1:3]))
