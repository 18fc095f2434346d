"""The vector environment in worlds of MuJoCo Warp, on the processor, beside the native one."""

from __future__ import annotations

import os
import subprocess
import sys
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

pytest.importorskip("gymnasium", reason="Gymnasium is not installed")
pytest.importorskip("mujoco_warp", reason="MuJoCo Warp is not installed: pip install mujoco-warp")
pytest.importorskip("sinew.warp", reason="MuJoCo Warp cannot be used", exc_type=ImportError)
import warp as wp  # noqa: E402

wp.config.log_level = getattr(wp, "LOG_WARNING", 30)
from gymnasium.error import ResetNeeded  # noqa: E402

from sinew.gym import MachineVectorEnv, Randomisation  # noqa: E402
from sinew.warp.gym import MachineVectorEnv as Worlds  # noqa: E402

pytestmark = pytest.mark.filterwarnings("ignore::DeprecationWarning")
JOINT: dict[str, Any] = {"machine": "bench_joint", "autoreset_mode": "Disabled", "interval_ms": 5}
long = pytest.mark.skipif(not os.environ.get("SINEW_LONG"), reason="minutes: SINEW_LONG=1")


def actions(count: int, env: MachineVectorEnv, seed: int = 0) -> list[NDArray[np.float64]]:
    """Random actions, each taken twice."""
    random = np.random.default_rng(seed)
    drawn = [random.uniform(-0.4, 0.4, env.action_space.shape) for _ in range((count + 1) // 2)]
    return [drawn[k // 2] for k in range(count)]


def beside(count: int, specimens: int = 3, **keywords: Any) -> tuple[dict[str, float], MachineVectorEnv]:
    """Largest differences from the native environments after so many actions, by part of the observation; of the pose as
    well the median over the specimens."""
    native, worlds = MachineVectorEnv(specimens, **keywords), Worlds(specimens, **keywords)
    first, _ = native.reset(seed=11)
    assert np.array_equal(first, worlds.reset(seed=11)[0]), "episodes begin as the native ones"
    assert worlds.observation_space == native.observation_space and worlds.action_space == native.action_space
    for action in actions(count, native):
        expected, found = native.step(action), worlds.step(action)
    off = {
        name: float(np.abs(expected[0] - found[0])[:, part.start : part.stop].max())
        for name, part in native.observation_parts.items()
    }
    poses = np.abs(native.environments.poses - worlds.environments.poses).max(axis=1)
    off |= {"pose": float(poses.max()), "median_pose": float(np.median(poses))}
    off |= {"reward": float(np.abs(expected[1] - found[1]).max())}
    moved = np.abs(found[0] - first)[:, native.observation_parts["tension"].start]
    assert moved.max() > 1.0
    return off, worlds


@pytest.mark.parametrize(
    "keywords",
    [{}, {"actuation": "tension"}, {"actuation": "torque"}, {"substeps": 2}, {"task": "hold", "push": 1.0}],
    ids=lambda keywords: "-".join(map(str, keywords.values())) or "speed",
)
def test_worlds_move_and_tell_as_native_environments(keywords: dict[str, Any]) -> None:
    off, _ = beside(12, **JOINT, **keywords)
    # Counts of load cells, encoders and joints are 0.05 N, 0.9 um and 0.4 mrad.
    assert off["pose"] < 5e-5 and off["reward"] < 1e-3, off
    assert off["tension"] < 0.11 and off["motor"] < 5e-6 and off["joint"] < 5e-4, off
    assert off["target"] == off["last_action"] == 0.0, off


@long
@pytest.mark.parametrize("machine", ["lm_arm", "planar_leg", "shoulder", "chain10", "finger", "surgical_wrist"])
def test_machines_move_as_native_ones_for_half_a_second(machine: str) -> None:
    off, _ = beside(50, 8, machine=machine, autoreset_mode="Disabled")
    # Where a count of an encoder or the edge of sliding decides the other way, a specimen leaves the native one by more.
    assert off["median_pose"] < 2e-3 and off["pose"] < 0.2, off


@pytest.mark.parametrize(("machine", "task"), [("lm_arm", "track"), ("bench_joint", "reach")])
def test_errors_rewards_and_targets_are_those_of_the_native_task_in_any_state(machine: str, task: str) -> None:
    keywords: dict[str, Any] = {"machine": machine, "task": task, "effort": 0.3, "autoreset_mode": "Disabled"}
    native, worlds = MachineVectorEnv(4, **keywords), Worlds(4, **keywords)
    native.reset(seed=2)
    worlds.reset(seed=2)
    many = worlds.environments
    for action in actions(6, native):
        observations, rewards, _, _, infos = native.step(action)
        # Its state, not its motion.
        poses = many.d.qpos.numpy()
        poses[:, many._part.design.coordinate.numpy()] = native.environments.poses
        many.d.qpos.assign(poses)
        many._actions.assign(action.astype(np.float32))
        many.conclude()
        outcomes, told = many._outcomes.numpy(), many._observations.numpy()
        np.testing.assert_allclose(outcomes[:, 0], infos["error"], rtol=2e-5, atol=1e-6)
        np.testing.assert_allclose(outcomes[:, 1], rewards, rtol=2e-5, atol=1e-6)
        for name in ("target", "target_rate", "target_point", "last_action"):
            if name in native.observation_parts:
                part = native.observation_parts[name]
                np.testing.assert_array_equal(told[:, part.start : part.stop], observations[:, part.start : part.stop])


def test_no_world_sees_another_and_one_begun_anew_is_as_a_fresh_one() -> None:
    alone, crowd, fresh = (Worlds(3, **JOINT) for _ in range(3))
    for env in (alone, crowd):
        env.reset(seed=[1, 2, 3])
    given = actions(8, alone)
    for k, action in enumerate(given):
        other = action.copy()
        other[[0, 2]] = -action[[2, 0]]
        expected, found = alone.step(action)[0], crowd.step(other)[0]
        np.testing.assert_array_equal(found[1], expected[1])
        assert k < 1 or not np.array_equal(found[0], expected[0])
        if k == 3:
            crowd.reset(seed=[9, None, None], options={"reset_mask": np.array([True, False, False])})
    # World 1 anew, the others under way.
    begun, _ = crowd.reset(seed=[None, 7, None], options={"reset_mask": np.array([False, True, False])})
    first, _ = fresh.reset(seed=[5, 7, 6])
    np.testing.assert_array_equal(begun[1], first[1])
    for action in given:
        np.testing.assert_array_equal(crowd.step(action)[0][1], fresh.step(action)[0][1])


def graphs() -> bool:
    """Whether this version of Warp captures on this device."""
    return bool(wp.get_device().is_cuda) or hasattr(wp, "capture_save")


@pytest.mark.skipif(not graphs(), reason="this Warp captures on CUDA devices alone")
def test_steps_from_a_graph_are_the_steps_to_the_bit_whatever_episodes_begin_between_them() -> None:
    plain, captured = (Worlds(3, **JOINT, task="hold", push=1.0) for _ in range(2))
    plain.environments._graph._possible = False
    random = np.random.default_rng(8)
    for env in (plain, captured):
        env.reset(seed=[1, 2, 3])
    for k, action in enumerate(actions(12, plain)):
        for expected, found in zip(plain.step(action)[:4], captured.step(action)[:4], strict=True):
            np.testing.assert_array_equal(found, expected)
        if k % 3 == 2:
            mask = random.random(3) < 0.5
            for env in (plain, captured):
                env.reset(options={"reset_mask": mask})
    assert captured.environments._graph._graph is not None and plain.environments._graph._graph is None


def test_what_a_step_of_a_machine_launches_neither_allocates_nor_waits(monkeypatch: pytest.MonkeyPatch) -> None:
    env = Worlds(2, **JOINT)
    env.reset(seed=1)
    env.step(np.zeros((2, 2)))
    many = env.environments

    def refused(*_: Any, **__: Any) -> None:
        raise AssertionError("it allocates, or waits for the device")

    for name in ("numpy", "assign", "__init__", "fill_"):
        monkeypatch.setattr(wp.array, name, refused)
    for name in ("synchronize", "synchronize_device", "copy", "zeros", "empty"):
        monkeypatch.setattr(wp, name, refused)
    many._part.act(many.m, many.d)
    many.conclude()
    with pytest.raises(AssertionError, match="allocates"):
        many.reset([1, 2], None, env._observations, env._errors)


@pytest.mark.parametrize("mode", ["NextStep", "SameStep"])
def test_episodes_begin_again_as_native_ones(mode: str) -> None:
    keywords: dict[str, Any] = {**JOINT, "steps": 2, "autoreset_mode": mode}
    native, worlds = MachineVectorEnv(2, **keywords), Worlds(2, **keywords)
    native.reset(seed=4)
    worlds.reset(seed=4)
    for k, action in enumerate(actions(6, native)):
        expected, found = native.step(action), worlds.step(action)
        for one, other in zip(expected[2:4], found[2:4], strict=True):
            np.testing.assert_array_equal(one, other)
        assert expected[4].keys() == found[4].keys()
        if (k + 1) % 3 == 0 and mode == "NextStep":
            # The next specimen and target of the same random numbers.
            np.testing.assert_array_equal(found[0], expected[0])
        np.testing.assert_allclose(found[1], expected[1], atol=1e-3)


def test_worlds_of_the_design_share_its_numbers() -> None:
    plain, drawn = (Worlds(2, **JOINT, **given) for given in ({"randomisation": Randomisation.none()}, {}))
    own = [sum(key[0] == id(env.environments.m) for key in env.environments._own) for env in (plain, drawn)]
    assert own[0] == 0 and own[1] > 0
    friction = drawn.environments._part.specimen.friction.numpy()
    assert (friction[:, 0] != friction[:, 1]).any()


def test_misuse_is_refused_in_plain_words() -> None:
    with pytest.raises(ValueError, match="num_envs must be a whole number of at least 1, but is 0"):
        Worlds(0, machine="bench_joint")
    with pytest.raises((ValueError, FileNotFoundError), match="no_machine"):
        Worlds(1, machine="no_machine")
    with pytest.raises(TypeError, match="gravity"):
        Worlds(1, machine="bench_joint", gravity=1.0)
    env = Worlds(2, **{**JOINT, "steps": 1})
    env.reset(seed=1)
    for wrong, message in ((np.zeros((2, 3)), r"shape \(2, 2\)"), (np.full((2, 2), np.nan), "finite number from -1 to 1")):
        with pytest.raises(ValueError, match=message):
            env.step(wrong)
    env.step(np.zeros((2, 2)))
    with pytest.raises(ResetNeeded, match="environment 0 has ended"):
        env.step(np.zeros((2, 2)))
    code = "import sys, sinew.gym, sinew.warp; assert 'sinew.warp.gym' not in sys.modules"
    assert subprocess.run([sys.executable, "-W", "ignore", "-c", code], check=False).returncode == 0
