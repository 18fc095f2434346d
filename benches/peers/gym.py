"""Simulated milliseconds a second: `sinew.gym` with sheaths, drives and sensors, and MuJoCo's own batches of the same arm without.

    gym.py [ENVIRONMENTS] [ROUNDS]

The arm is `lm_arm`: 15 muscles, 7 joints. MuJoCo steps it with one motor on every tendon, without friction, sheaths, elastic cables,
drives and sensors, in steps of a millisecond: with `mujoco.rollout` and, where this MuJoCo has it, `mujoco.batch`. Ours are
observations, rewards and resets included. Times are processor times of the process, which has one thread at work, so that other programs count little; all
alternate in one process. Two threads are compared by the wall clock, which needs two idle processors. Needs a release build of the
package: `pip install .`, with gymnasium and mujoco.
"""

import sys
import time

import mujoco
import numpy as np
from mujoco import rollout

import sinew
import sinew.mujoco
from sinew.gym import MachineVectorEnv

MILLISECONDS = 100
INTERVAL = 10


def plain_arm():
    """The arm with one motor on every tendon, without friction."""
    return sinew.mujoco.load("lm_arm", transmission="none")


def rollout_run(model, count):
    """A function that rolls all environments out by as many milliseconds."""
    data = mujoco.MjData(model)
    data.qpos[:] = sinew.Machine("lm_arm").start
    state = np.zeros(mujoco.mj_stateSize(model, mujoco.mjtState.mjSTATE_FULLPHYSICS))
    mujoco.mj_getState(model, data, state, mujoco.mjtState.mjSTATE_FULLPHYSICS)
    states = np.tile(state, (count, 1))
    controls = np.random.default_rng(0).uniform(40.0, 80.0, (count, MILLISECONDS, model.nu))
    return lambda: rollout.rollout(model, data, states, controls)


def batch_run(model, count):
    """The same with `mujoco.batch`, or none where it is not there."""
    try:
        from mujoco import batch
    except ImportError:
        return None
    many = batch.Batch(model, count, nthread=1, persistent=True)
    many.qpos[:] = sinew.Machine("lm_arm").start
    random = np.random.default_rng(0)

    def run():
        for _ in range(MILLISECONDS // INTERVAL):
            many.ctrl[:] = random.uniform(40.0, 80.0, (count, model.nu))
            many.step(nstep=INTERVAL)

    return run


def ours(count, **keywords):
    """Environments, and a function that steps them by as many milliseconds."""
    env = MachineVectorEnv(count, interval_ms=INTERVAL, copy=False, autoreset_mode="SameStep", **keywords)
    env.reset(seed=1)
    random = np.random.default_rng(0)

    def run():
        for _ in range(MILLISECONDS // INTERVAL):
            env.step(random.uniform(-0.1, 0.1, (count, env.environments.actions)))

    return env, run


def frame(count, rounds):
    """What a step costs beside the milliseconds, us for each environment: Python's part, and writing observations."""
    env, _ = ours(count)
    actions, nothing = np.zeros((count, 15), dtype=np.float32), [False] * count
    native, python, observe = env.environments, [], []

    class Idle:
        def step(self, *_):
            return None

    for _ in range(rounds):
        env._native = Idle()
        began = time.process_time()
        for _ in range(20):
            env.step(actions)
        python.append((time.process_time() - began) / 20)
        env._native = native
        began = time.process_time()
        for _ in range(20):
            native.reset(None, nothing, env._observations, env._errors)
        observe.append((time.process_time() - began) / 20)
    return [1e6 * min(times) / count for times in (python, observe)]


def main(count=64, rounds=9):
    model = plain_arm()
    runs = {"mujoco.rollout, no friction": rollout_run(model, count)}
    batch = batch_run(model, count)
    if batch is not None:
        runs["mujoco.batch, no friction"] = batch
    for cells, substeps in ((24, 2), (12, 1)):
        env, run = ours(count, cells=cells, substeps=substeps)
        runs[f"sinew.gym, cables {env.environments.resolution[0]} x {env.environments.resolution[1]}"] = run
    rates = {name: [] for name in runs}
    for _ in range(rounds):
        for name, run in runs.items():
            began = time.process_time()
            run()
            rates[name].append(count * MILLISECONDS / (time.process_time() - began))
    best = max(np.median(seen) for name, seen in rates.items() if name.startswith("mujoco"))
    print(f"lm_arm, {count} environments, MuJoCo {mujoco.__version__}; simulated milliseconds a second of one thread")
    for name, seen in rates.items():
        middle = np.median(seen)
        print(f"  {name:32} median {middle:8.0f}, best {max(seen):8.0f}; {middle / best:.2f} of MuJoCo's better median")
    python, observe = frame(4 * count, rounds)
    print(f"  beside the milliseconds, for each of {4 * count} environments: Python {python:.3f} us, observation {observe:.3f} us")
    single, double = (ours(count, threads=threads)[1] for threads in (1, 2))
    ratios = []
    for _ in range(rounds):
        times = []
        for run in (single, double):
            began = time.perf_counter()
            run()
            times.append(time.perf_counter() - began)
        ratios.append(times[0] / times[1])
    print(f"  two threads: {np.median(ratios):.2f} times one by the wall clock, best {max(ratios):.2f}")


if __name__ == "__main__":
    main(*map(int, sys.argv[1:3]))
