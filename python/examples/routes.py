"""Routes of muscles: the best with friction in the sheaths beside the best that takes no account of it. All simulated; needs Optuna.

    python python/examples/routes.py [TRIALS] [SEED]
"""

from __future__ import annotations

import sys
import tempfile

import optuna

from sinew.study import Range, Study, Trial, routing

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


def search(machine: str, muscle: str, parameters: dict[str, Range], value: str, trials: int, seed: int) -> list[Trial]:
    """Uniform draws and, a quarter of the trials, routes that a sampler of Optuna proposes for the largest `value`."""
    sampler = optuna.samplers.TPESampler(seed=seed, multivariate=True, n_startup_trials=3 * trials // 4)
    with tempfile.TemporaryDirectory() as folder:
        with Study(folder, routing(machine, muscle), parameters, maximize=[value], seed=seed, sampler=sampler) as study:
            return [trial for trial in study.run(trials, workers=1) if trial.error is None]


def main(trials: int = 1200, seed: int = 1) -> None:
    optuna.logging.set_verbosity(optuna.logging.WARNING)
    print("| machine, muscle | route | friction loss | torque, N m | without friction, N m |")
    print("|---|---|---|---|---|")
    for machine, muscle, parameters in CASES:
        goals = {"best with friction": "torque_nm", "best without friction": "frictionless_torque_nm"}
        # Both are the best of the same routes: those of either search.
        found = [t for value in goals.values() for t in search(machine, muscle, parameters, value, trials, seed)]
        rows = {"design": routing(machine, muscle)({}, seed)}
        rows |= {name: dict(max(found, key=lambda t: t.values[value]).values) for name, value in goals.items()}
        for route, values in rows.items():
            loss, torque, frictionless = (values[k] for k in ("friction_loss", "torque_nm", "frictionless_torque_nm"))
            print(f"| {machine}, {muscle} | {route} | {100 * loss:.1f} % | {torque:.2f} | {frictionless:.2f} |")


if __name__ == "__main__":
    main(*(int(argument) for argument in sys.argv[1:3]))
