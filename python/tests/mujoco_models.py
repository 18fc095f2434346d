"""What the tests of `sinew.mujoco` fraction: models, motions, comparisons bit for bit."""

from __future__ import annotations

import copy
import importlib
import pickle
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest

MASS, GRAVITY = 5.0, 9.81
WEIGHT = MASS * GRAVITY

#: A mass on a tendon; the actuator pulls upward.
HOIST = f"""<mujoco><option timestep="0.001" gravity="0 0 -{GRAVITY}"/>
<worldbody><site name="top" pos="0 0 1"/>
 <body><joint name="lift" type="slide" axis="0 0 1"/><geom size=".1" mass="{MASS}"/><site name="hook"/></body></worldbody>
<tendon><spatial name="cable"><site site="top"/><site site="hook"/></spatial></tendon>
<actuator><motor name="winch" tendon="cable" gear="-1"/></actuator></mujoco>"""

#: A hand's finger: three joints, two tendons that wrap, each with a muscle-like actuator, and one fixed tendon.
FINGER = """<mujoco><compiler angle="radian"/><option timestep="0.001"/>
<default><geom type="capsule" size=".006" mass=".02"/><joint axis="0 1 0" damping="2e-3" range="-1.5 1.5" limited="true"/></default>
<worldbody><site name="f0" pos="0 0 -.012"/><site name="e0" pos="0 0 .012"/>
<body pos=".02 0 0"><joint name="a"/><geom fromto="0 0 0 .04 0 0"/><geom name="ca" type="cylinder" size=".008 .01" zaxis="0 1 0"/>
 <site name="f1" pos=".02 0 -.01"/><site name="e1" pos=".02 0 .01"/><site name="sa" pos="0 0 .012"/>
 <body pos=".04 0 0"><joint name="b"/><geom fromto="0 0 0 .03 0 0"/><geom name="cb" type="cylinder" size=".007 .01" zaxis="0 1 0"/>
  <site name="f2" pos=".015 0 -.009"/><site name="e2" pos=".015 0 .009"/><site name="sb" pos="0 0 .01"/>
  <body pos=".03 0 0"><joint name="c"/><geom fromto="0 0 0 .02 0 0"/></body></body></body></worldbody>
<tendon>
 <spatial name="flexor"><site site="f0"/><site site="f1"/><site site="f2"/></spatial>
 <spatial name="extensor"><site site="e0"/><geom geom="ca" sidesite="sa"/><site site="e1"/><geom geom="cb" sidesite="sb"/><site site="e2"/></spatial>
 <fixed name="tip"><joint joint="c" coef=".006"/><joint joint="b" coef="-.003"/></fixed></tendon>
<actuator><general name="mf" tendon="flexor" dyntype="filter" dynprm=".03" gainprm="1" gear="-1" ctrlrange="0 20" forcerange="0 18"/>
 <motor tendon="extensor" gear="-1" ctrlrange="0 20"/><motor tendon="tip" gear="2"/></actuator></mujoco>"""

#: Range of the controls that `drive` draws.
Range = tuple[float, float]


def drive(model: Any, data: Any, steps: int, seed: int = 1, within: Range = (0.0, 15.0)) -> np.ndarray:
    """Steps with controls of a seed; returns all positions."""
    random = np.random.default_rng(seed)
    seen = np.empty((steps, model.nq))
    for k in range(steps):
        if k % 20 == 0:
            data.ctrl[:] = random.uniform(*within, model.nu)
        mujoco.mj_step(model, data)
        seen[k] = data.qpos
    return seen


def all_state() -> int:
    """What of `mjData` the next step follows from."""
    return int(mujoco.mjtState.mjSTATE_INTEGRATION)


def assert_copies_agree(model: Any, within: Range) -> None:
    """Copies, pickles, restored states, resets and other threads continue bit for bit."""
    data = mujoco.MjData(model)
    drive(model, data, 100, within=within)
    others = [copy.copy(data), copy.deepcopy(data), pickle.loads(pickle.dumps(data))]
    if hasattr(mujoco, "mj_copyData"):
        copied = mujoco.MjData(model)
        mujoco.mj_copyData(copied, model, data)
        others.append(copied)
    restored = mujoco.MjData(model)
    state = np.empty(mujoco.mj_stateSize(model, all_state()))
    mujoco.mj_getState(model, data, state, all_state())
    mujoco.mj_setState(model, restored, state, all_state())
    others.append(restored)
    twin_model = pickle.loads(pickle.dumps(model))
    extra = copy.copy(data)
    expected = drive(model, data, 200, 2, within)
    for other in others:
        np.testing.assert_array_equal(drive(model, other, 200, 2, within), expected)
    np.testing.assert_array_equal(drive(twin_model, extra, 200, 2, within), expected)
    # After a reset as from the beginning, on another thread as well.
    begun = drive(model, mujoco.MjData(model), 200, 4, within)
    mujoco.mj_resetData(model, data)
    seen: list[np.ndarray] = []
    thread = threading.Thread(target=lambda: seen.append(drive(model, data, 200, 4, within)))
    thread.start()
    thread.join()
    np.testing.assert_array_equal(seen[0], begun)


def assert_split_steps_agree(model: Any, within: Range) -> None:
    """`mj_step1` and `mj_step2` are `mj_step`; forward passes between steps change nothing."""
    middle, half = 0.5 * (within[0] + within[1]), 0.5 * (within[1] - within[0])
    one, split, forward = (mujoco.MjData(model) for _ in range(3))
    for k in range(300):
        for data in (one, split, forward):
            data.ctrl[:] = middle + half * np.sin(0.05 * k)
        mujoco.mj_step(model, one)
        mujoco.mj_step1(model, split)
        mujoco.mj_step2(model, split)
        warm = np.array(forward.qacc_warmstart)
        mujoco.mj_forward(model, forward)
        forward.qacc_warmstart[:] = warm
        mujoco.mj_step(model, forward)
    np.testing.assert_array_equal(one.qpos, split.qpos)
    np.testing.assert_array_equal(one.qpos, forward.qpos)


def stepped(model: Any, controls: np.ndarray) -> np.ndarray:
    """Positions after controls of shape `(steps, nu)`."""
    data = mujoco.MjData(model)
    for row in controls:
        data.ctrl[:] = row
        mujoco.mj_step(model, data)
    return np.array(data.qpos)


def assert_rollouts_agree(rollout: Any, model: Any, threads: int, within: Range) -> None:
    """Rollouts on threads are steps."""
    controls = np.random.default_rng(7).uniform(*within, (6, 60, model.nu))
    kind = int(mujoco.mjtState.mjSTATE_FULLPHYSICS)
    start = np.empty(mujoco.mj_stateSize(model, kind))
    mujoco.mj_getState(model, mujoco.MjData(model), start, kind)
    many = [mujoco.MjData(model) for _ in range(threads)]
    states, _ = rollout.rollout(model, many, np.tile(start, (6, 1)), controls)
    for world in range(6):
        got = mujoco.MjData(model)
        mujoco.mj_setState(model, got, states[world, -1], kind)
        np.testing.assert_array_equal(got.qpos, stepped(model, controls[world]))


def assert_batches_agree(batch: Any, model: Any, threads: int, within: Range) -> None:
    """Worlds of a batch on threads are steps."""
    controls = np.random.default_rng(8).uniform(*within, (6, 60, model.nu))
    worlds = batch.Batch(model, 6, threads)
    for k in range(60):
        worlds.ctrl[:] = controls[:, k]
        worlds.step()
    for world in range(6):
        np.testing.assert_array_equal(worlds.qpos[world], stepped(model, controls[world]))


def part(name: str) -> Any:
    """A module of this MuJoCo; one of another version in the same environment does not count."""
    beside = Path(mujoco.__file__).parent / f"{name}.py"
    if not beside.is_file():
        pytest.skip(f"MuJoCo {mujoco.__version__} has no {name}")
    return importlib.import_module(f"mujoco.{name}")


def growth_of(work: Callable[[], object], count: int) -> int:
    """Growth of the memory of the process, kB, over many calls after some."""
    import resource

    def peak() -> int:
        return int(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)

    for _ in range(2_000):
        work()
    before = peak()
    for _ in range(count):
        work()
    return peak() - before
