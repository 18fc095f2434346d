"""Processor time of a MuJoCo step with sheaths and cables beside that of the plain model, in one process.

Run with a release build: `pip install . && python python/benches/mujoco_steps.py [MODEL.xml]`; MODEL.xml is a model of others with
driven tendons, for example the arm of MyoSuite. Times of a busy machine are upper bounds; ratios and differences are of runs
that follow each other.
"""

from __future__ import annotations

import sys
import time

import mujoco
import numpy as np

import sinew
import sinew.mujoco


def plain_arm(arm: sinew.Machine) -> mujoco.MjSpec:
    """The arm with one motor on every tendon, without friction."""
    return sinew.mujoco.spec_of(arm, transmission="none")


def microseconds(model: mujoco.MjModel, start: np.ndarray, low: float, high: float, steps: int = 2000) -> float:
    """Time of a step under controls that change every fifty steps, us."""
    data = mujoco.MjData(model)
    data.qpos[:] = start
    random, seconds = np.random.default_rng(0), 0.0
    for _ in range(steps // 50):
        data.ctrl[:] = random.uniform(low, high, model.nu)
        began = time.thread_time()
        mujoco.mj_step(model, data, 50)
        seconds += time.thread_time() - began
    assert np.isfinite(data.qpos).all()
    return 1e6 * seconds / steps


#: Model by name, with its start and the range of its controls.
Models = dict[str, tuple[mujoco.MjModel, np.ndarray, float, float]]


def compare(title: str, models: Models, rounds: int = 9) -> None:
    """Prints times beside those of the first model."""
    times = {name: [] for name in models}
    for _ in range(rounds):
        for name, model in models.items():
            times[name].append(microseconds(*model))
    first = np.array(next(iter(times.values())))
    print(title)
    for name, seen in times.items():
        one = np.array(seen)
        ratio, more = np.median(one / first), np.median(one - first)
        print(f"  {name:24} least {one.min():7.2f} us, median ratio {ratio:.2f}, median difference {more:+.2f} us")


def main(files: list[str]) -> None:
    """Prints both tables."""
    arm = sinew.Machine("lm_arm")
    start = np.array(arm.start)
    models: Models = {"plain": (plain_arm(arm).compile(), start, 40.0, 80.0)}
    for turning in (0.0, 1.0):
        spec = plain_arm(arm)
        sinew.mujoco.add_sheaths(spec, sinew.mujoco.sheaths_of(arm, turning=turning))
        models[f"sheaths, turning {turning:g}"] = (spec.compile(), start, 40.0, 80.0)
    for cells, substeps in ((12, 1), (24, 2)):
        model = sinew.mujoco.load(arm, cells=cells, substeps=substeps)
        models[f"cables {cells} x {substeps}"] = (model, start, -0.005, 0.005)
    compare(f"lm_arm, 15 muscles, MuJoCo {mujoco.__version__}", models)
    for file in files:
        spec = mujoco.MjSpec.from_file(file)
        plain = spec.compile()
        names = sinew.mujoco.add_sheaths(spec, {"*": sinew.mujoco.Sheath(mu=0.1, bend=3.0, turning=1.0)})
        both = {"plain": (plain, plain.qpos0, 0.0, 0.6), f"{len(names)} sheaths": (spec.compile(), plain.qpos0, 0.0, 0.6)}
        compare(file, both)


if __name__ == "__main__":
    main(sys.argv[1:])
