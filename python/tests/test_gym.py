"""Environments for reinforcement learning."""

from __future__ import annotations

import runpy
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import sinew

gymnasium = pytest.importorskip("gymnasium", reason="Gymnasium is not installed")

from gymnasium.utils.env_checker import check_env  # noqa: E402
from gymnasium.vector import AutoresetMode  # noqa: E402

from sinew.gym import MachineEnv, MachineVectorEnv, Randomisation  # noqa: E402

EXAMPLE = Path(__file__).parents[2] / "crates/sinew-cli/examples/training/train_policy.py"
SHORT: dict[str, Any] = {"machine": "bench_joint", "steps": 5, "interval_ms": 5}


def histories(count: int, steps: int = 12, **keywords: Any) -> list[bytes]:
    """All that is returned in so many steps of same-step environments, one history for each environment."""
    env = MachineVectorEnv(count, autoreset_mode=AutoresetMode.SAME_STEP, **keywords)
    observations, _ = env.reset(seed=3)
    told = [[row.tobytes()] for row in observations]
    random = [np.random.default_rng(index) for index in range(count)]
    for _ in range(steps):
        actions = np.array([one.uniform(-0.3, 0.3, env.single_action_space.shape) for one in random])
        arrays = env.step(actions)[:4]
        for index, history in enumerate(told):
            history.extend(array[index].tobytes() for array in arrays)
    env.close()
    return [b"".join(history) for history in told]


@pytest.mark.parametrize("name", ["Reach", "Track", "Hold", "BenchJoint"])
def test_registered_environments_pass_the_checker_of_gymnasium(name: str) -> None:
    # Track alone takes some time: its motion is planned.
    with gymnasium.make(f"sinew/{name}-v0", steps=20) as env:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            check_env(env.unwrapped)
        reset = [env.reset(seed=seed)[0] for seed in (1, None, 1, 2)]
        assert np.array_equal(reset[0], reset[2])
        assert all((reset[0] != reset[other]).any() for other in (1, 3))


def test_pictures_are_shown_in_a_window(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("matplotlib")
    pytest.importorskip("mujoco")
    pygame = pytest.importorskip("pygame", reason="pygame is not installed")
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # Gymnasium says that its wrapper draws the window.
        env = gymnasium.make("sinew/BenchJoint-v0", render_mode="human")
    env.reset(seed=1)
    window = pygame.display.get_surface()
    assert window.get_size() == (480, 480)
    first = pygame.surfarray.array3d(window)
    for _ in range(10):
        env.step(env.action_space.high)
    assert not np.array_equal(first, pygame.surfarray.array3d(window))
    env.close()


def test_a_picture_shows_the_pose_and_changes_with_it() -> None:
    pytest.importorskip("matplotlib")
    mujoco = pytest.importorskip("mujoco")
    assert MachineEnv(**SHORT).render() is None
    with pytest.raises(ValueError, match="human"):
        MachineEnv(render_mode="human", **SHORT)
    # A finger has a joint that follows another one; its last body is where MuJoCo's constraint would take it.
    env = MachineEnv(machine="finger", render_mode="rgb_array", interval_ms=5)
    env.reset(seed=1)
    first = env.render()
    assert first is not None and first.shape == (480, 480, 3) and first.dtype == np.uint8
    assert env.metadata["render_fps"] == 200
    for _ in range(20):
        env.step(env.action_space.high)
    second = env.render()
    assert second is not None and not np.array_equal(first, second)
    picture = env._picture
    assert picture is not None
    mujoco.mj_makeConstraint(picture._model, picture._data)
    equalities = picture._data.efc_type[: picture._data.ne] == mujoco.mjtConstraint.mjCNSTR_EQUALITY
    assert equalities.any() and np.abs(picture._data.efc_pos[: picture._data.ne]).max() < 1e-12
    env.close()


def green(picture: Any) -> Any:
    """Rows and columns of the pixels of what is desired, shape `(pixels, 2)`."""
    red, of_green, blue = np.moveaxis(picture.astype(int), 2, 0)
    return np.argwhere((of_green > red + 30) & (of_green > blue + 30))


def pictured(machine: str, **keywords: Any) -> MachineEnv:
    pytest.importorskip("matplotlib")
    pytest.importorskip("mujoco")
    return MachineEnv(machine=machine, render_mode="rgb_array", **keywords)


def pixel(env: MachineEnv, point: Any) -> Any:
    """Row and column of a point of the world."""
    assert env._picture is not None
    (axes,) = env._picture._canvas.figure.axes
    column, row = axes.transData.transform(env._picture._view @ point)
    return np.array([480.0 - row, column])


@pytest.mark.parametrize("machine", ["lm_arm", "finger", "chain10"])
def test_a_ring_is_where_the_end_point_should_be(machine: str) -> None:
    env = pictured(machine)
    before = env.render()
    assert before is not None and not len(green(before))  # Nothing is desired before an episode.
    places = []
    for seed in (1, 2):
        told, _ = env.reset(seed=seed)
        part = env.observation_parts["target_point"]
        picture = env.render()
        assert picture is not None
        ring = green(picture)
        places.append(ring.mean(axis=0))
        centre = 0.5 * (ring.min(axis=0) + ring.max(axis=0))
        assert np.abs(centre - pixel(env, told[part.start : part.stop])).max() < 2.0
        assert np.ptp(ring, axis=0).max() < 25
    assert np.abs(places[0] - places[1]).max() > 5.0
    env.close()


def test_the_ring_moves_with_the_motion_that_is_tracked() -> None:
    env = pictured("planar_leg", task="track", interval_ms=20)
    env.reset(seed=1)
    places = []
    for _ in range(2):
        picture = env.render()
        assert picture is not None
        places.append(green(picture).mean(axis=0))
        for _ in range(40):
            env.step(np.zeros(4))
    assert np.abs(places[0] - places[1]).max() > 3.0


def test_along_axes_that_do_not_count_the_ring_is_where_the_end_point_is() -> None:
    env = pictured("shoulder", task="reach")
    told, _ = env.reset(seed=1)
    part = env.observation_parts["target_point"]
    assert part.stop - part.start == 2  # Its height is free.
    picture = env.render()
    assert picture is not None and env._picture is not None
    ring = green(picture)
    height = env._picture._data.site("endpoint").xpos[2]
    wanted = pixel(env, [*told[part.start : part.stop], height])
    assert np.abs(0.5 * (ring.min(axis=0) + ring.max(axis=0)) - wanted).max() < 2.0


def test_a_machine_without_an_end_point_shows_the_desired_pose() -> None:
    env = pictured("bench_joint", spread=0.8)
    told, _ = env.reset(seed=1)
    part = env.observation_parts["target"]
    picture = env.render()
    assert picture is not None and env._picture is not None
    there = env._picture.draw(told[part.start : part.stop].astype(float))
    lines, bones = green(picture), np.argwhere((there == 153).all(axis=2))
    # The far ends of the thin line, and of the bone in the pose that is desired.
    assert len(lines) > 100
    assert np.abs(lines[lines[:, 0].argmax()] - bones[bones[:, 0].argmax()]).max() < 8


def test_a_picture_is_seen_as_by_the_camera_of_mujoco() -> None:
    env = pictured("finger")
    mujoco = pytest.importorskip("mujoco")
    assert env._picture is not None
    model, camera = env._picture._model, mujoco.MjvCamera()
    mujoco.mjv_defaultFreeCamera(model, camera)
    scene, data = mujoco.MjvScene(model, 1000), mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    shown = mujoco.mjtCatBit.mjCAT_ALL
    mujoco.mjv_updateScene(model, data, mujoco.MjvOption(), mujoco.MjvPerturb(), camera, shown, scene)
    eye = scene.camera[0]
    assert np.allclose(env._picture._view, [np.cross(eye.forward, eye.up), eye.up], atol=1e-6)
    assert eye.forward[2] < 0.0  # From above.


def test_every_built_in_machine_has_an_environment_of_every_task() -> None:
    for name in sinew.Machine.built_in():
        machine = sinew.Machine(name)
        halfway = {machine.joint_names[0]: float(machine.start[0])}
        tasks: list[dict[str, Any]] = [{"task": "reach"}, {"task": "hold"}]
        tasks.append({"task": "track", "path": machine.plan(halfway, duration_s=1.0)})
        for task, actuation in zip(tasks, ("tension", "speed", "torque"), strict=True):
            env = MachineEnv(machine=machine, actuation=actuation, steps=3, **task)
            observation, _ = env.reset(seed=1)
            for _ in range(3):
                assert env.observation_space.contains(observation)
                observation, reward, *_ = env.step(np.zeros(len(machine.muscle_names)))
                assert -0.01 <= reward <= 1.0
            env.close()


def test_a_machine_file_of_a_user_has_environments(tmp_path: Path) -> None:
    built_in = Path(__file__).parents[2] / "models" / "finger.toml"
    (tmp_path / "mine.toml").write_text(built_in.read_text().replace('name = "finger"', 'name = "mine"'))
    env = gymnasium.make_vec(
        "sinew/Reach-v0", num_envs=2, vectorization_mode="vector_entry_point", machine=tmp_path / "mine.toml", steps=4
    )
    assert env.reset(seed=1)[0].shape == (2, env.single_observation_space.shape[0])
    env.close()


def test_bits_do_not_depend_on_threads_or_the_number_of_environments() -> None:
    alone = histories(1, **SHORT)
    many = histories(7, **SHORT)
    assert many == histories(7, threads=2, **SHORT) == histories(7, threads=5, copy=False, **SHORT)
    assert many[0] == alone[0] and len(set(many)) == 7


def test_one_environment_is_the_first_of_many_to_the_bit() -> None:
    one, many = MachineEnv(**SHORT), MachineVectorEnv(2, autoreset_mode="Disabled", **SHORT)
    assert np.array_equal(one.reset(seed=9)[0], many.reset(seed=9)[0][0])
    for _ in range(5):
        single, several = one.step([0.1, 0.2]), many.step([[0.1, 0.2], [0.3, -0.1]])
        assert np.array_equal(single[0], several[0][0]) and single[1] == several[1][0]
        assert single[4]["error"] == several[4]["error"][0]


def test_episodes_begin_again_as_the_mode_says() -> None:
    for mode in AutoresetMode:
        env = MachineVectorEnv(3, autoreset_mode=mode, **SHORT)
        assert env.metadata["autoreset_mode"] is mode
        env.reset(seed=1)
        actions = np.zeros((3, 2))
        for _ in range(4):
            assert not env.step(actions)[3].any()
        last, rewards, terminated, truncated, infos = env.step(actions)
        assert truncated.all() and not terminated.any() and (rewards != 0.0).all()
        if mode is AutoresetMode.NEXT_STEP:
            first, rewards, _, truncated, infos = env.step(actions)
            assert (rewards == 0.0).all() and not truncated.any() and (first != last).any()
            assert "final_obs" not in infos
        elif mode is AutoresetMode.SAME_STEP:
            assert infos["_final_obs"].all() and infos["final_info"]["_error"].all()
            assert (np.stack(infos["final_obs"]) != last).any(axis=1).all()
            assert (infos["final_info"]["error"] != infos["error"]).all()
        else:
            with pytest.raises(gymnasium.error.ResetNeeded, match="environment 0 has ended"):
                env.step(actions)
            kept = last[1].copy()
            told, _ = env.reset(options={"reset_mask": np.array([True, False, True])})
            assert np.array_equal(told[1], kept) and (told[0] != last[0]).any()
            with pytest.raises(gymnasium.error.ResetNeeded, match="environment 1 has ended"):
                env.step(actions)
            env.reset(seed=[None, 4, None], options={"reset_mask": np.array([False, True, False])})
            assert not env.step(actions)[3].any()


def test_arrays_are_new_or_written_in_place_as_asked() -> None:
    for copy in (True, False):
        env = MachineVectorEnv(2, copy=copy, **SHORT)
        env.reset(seed=1)
        first, second = env.step(np.zeros((2, 2))), env.step(np.full((2, 2), 0.5))
        assert [np.shares_memory(a, b) for a, b in zip(first[:4], second[:4], strict=True)] == [not copy] * 4


def test_observations_are_those_of_the_sensors_of_the_machine() -> None:
    machine = sinew.Machine("bench_joint")
    env = MachineVectorEnv(8, machine=machine, steps=100, randomisation=Randomisation.none(), cells=16)
    told, _ = env.reset(seed=1)
    for _ in range(30):
        told = env.step(np.zeros((8, 2)))[0]
    parts = env.observation_parts
    assert list(parts) == ["motor", "motor_rate", "tension", "joint", "joint_rate", "target", "last_action"]
    assert parts["tension"].unit == "N" and parts["last_action"].stop == told.shape[1]
    read = {name: told[:, part.start : part.stop] for name, part in parts.items()}
    # Fourteen bits per turn, and the cables' lengths by the motors, but for stretch.
    count = 2 * np.pi / 2**14
    assert np.allclose(read["joint"] / count, np.round(read["joint"] / count), atol=2e-3)
    assert np.abs(read["joint"] - env.environments.poses).max() < count
    home = machine.lengths(machine.start)
    wound = np.array([home - machine.lengths(pose) for pose in env.environments.poses])
    stretch = read["motor"] - wound
    assert (stretch > 0.0).all() and stretch.max() < 0.03
    assert (read["tension"] > 0.0).all() and env.environments.resolution[0] == 16
    assert np.array_equal(read["last_action"], np.zeros((8, 2)))


def test_friction_of_the_sheaths_is_as_asked() -> None:
    def travel(friction: float) -> float:
        randomisation = Randomisation(friction=(friction, friction))
        conditions = {"machine": "bench_joint", "actuation": "tension", "spread": 0.0, "interval_ms": 20}
        env = MachineVectorEnv(4, randomisation=randomisation, **conditions)
        env.reset(seed=1)
        start = env.environments.poses
        for _ in range(10):
            env.step(np.tile([-0.7, -1.0], (4, 1)))
        return float(np.abs(env.environments.poses - start).mean())

    assert travel(0.0) > 1.2 * travel(1.0) > 1.2 * travel(2.0)


WRONG: list[tuple[dict[str, Any], str]] = [
    ({"task": "fly"}, "task must be"),
    ({"actuation": "power"}, "actuation must be"),
    ({"interval_ms": 0}, "interval_ms must be a whole number of at least 1, but is 0"),
    ({"interval_ms": -1}, "interval_ms must be a whole number of at least 1, but is -1"),
    ({"steps": 0}, "steps must be"),
    ({"spread": 2.0}, "spread must be"),
    ({"spread": float("nan")}, "spread must be"),
    ({"push": -1.0, "task": "hold"}, "push must be"),
    ({"cells": 1}, "cells"),
    ({"substeps": 0}, "substeps must be"),
    ({"path": "tour"}, "belong to the task"),
    ({"push": 0.2}, 'push belongs to the task "hold", but task is .reach'),
    ({"randomisation": Randomisation(delay_ms=(0.0, 1e6))}, "delay_ms must be"),
    ({"threads": 0}, "threads must be"),
    ({"num_envs": 0}, "num_envs must be"),
    ({"render_mode": "human"}, "render_mode must be"),
    ({"autoreset_mode": "Never"}, "Never"),
]


@pytest.mark.parametrize(("keywords", "message"), WRONG, ids=[message for _, message in WRONG])
def test_wrong_conditions_are_refused_with_their_name(keywords: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        MachineVectorEnv(**{"num_envs": 2, "machine": "bench_joint"} | keywords)


@pytest.mark.parametrize("bounds", [2.0, [0.8, 1.2], (1.0,)])
def test_bounds_that_are_no_pair_are_refused_with_their_name(bounds: Any) -> None:
    for name in ("friction", "bend", "mass", "delay_ms"):
        with pytest.raises(ValueError, match=f"{name} must be a tuple of two bounds"):
            Randomisation(**{name: bounds})
    for pair in ((2.0, 0.5), (-1.0, 0.5), (0.5, float("nan")), (float("nan"), 0.5)):
        with pytest.raises(ValueError, match=r"mass must be two bounds of at least 0, the smaller one first, but is \("):
            Randomisation(mass=pair)


KINDS: list[tuple[dict[str, Any], str]] = [
    ({"interval_ms": 10.5}, "interval_ms must be a whole number of at least 1, but is 10.5"),
    ({"steps": 1.5}, "steps is 1.5, which is of the wrong kind"),
    ({"spread": "wide"}, "spread is 'wide', which is of the wrong kind"),
    ({"randomisation": None}, r"randomisation must be a sinew\.gym\.Randomisation, but is None: Randomisation\.none\(\)"),
    ({"randomisation": True}, r"randomisation must be a sinew\.gym\.Randomisation, but is True"),
    ({"num_envs": "finger"}, "num_envs must be a whole number, but is 'finger': the machine is a keyword, machine='finger'"),
    ({"threads": None}, "threads must be a whole number"),
]


@pytest.mark.parametrize(("keywords", "message"), KINDS, ids=[str(keywords) for keywords, _ in KINDS])
def test_values_of_the_wrong_kind_are_refused_with_their_name(keywords: dict[str, Any], message: str) -> None:
    with pytest.raises(TypeError, match=message):
        MachineVectorEnv(**{"num_envs": 2, "machine": "bench_joint"} | keywords)


def test_a_step_needs_an_episode() -> None:
    env, many = MachineEnv(**SHORT | {"steps": 2}), MachineVectorEnv(2, autoreset_mode="Disabled", **SHORT | {"steps": 2})
    assert repr(env) == "MachineEnv(bench_joint, reach, speed, 2 steps of 5 ms)"
    assert repr(many) == "MachineVectorEnv(2 of bench_joint, reach, speed, 2 steps of 5 ms)"
    calls = [lambda: env.step(np.zeros(2)), lambda: many.step(np.zeros((2, 2)))]
    for one, step in zip((env, many), calls, strict=True):
        for why in ("not begun", "ended"):
            with pytest.raises(gymnasium.error.ResetNeeded, match=rf"has {why}: call reset\(\) before step\(\)"):
                step()
            one.reset(seed=1)
            step()
            step()
    many.reset(options={"reset_mask": np.array([True, False])})
    with pytest.raises(gymnasium.error.ResetNeeded, match="environment 1 has ended"):
        calls[1]()


def test_a_missing_file_and_unknown_keywords_are_refused() -> None:
    with pytest.raises(FileNotFoundError):
        MachineEnv(machine="no/such/file.toml")
    with pytest.raises(TypeError, match="colour"):
        MachineEnv(colour="red")


def test_wrong_actions_seeds_and_masks_are_refused_and_change_nothing() -> None:
    env, same = (MachineVectorEnv(2, **SHORT) for _ in range(2))
    assert np.array_equal(env.reset(seed=1)[0], same.reset(seed=1)[0])
    for actions in (np.zeros(2), np.zeros((2, 3)), [["a", "b"], ["c", "d"]], np.zeros((2, 2), dtype=complex), None):
        with pytest.raises(ValueError, match="actions must be"):
            env.step(actions)
    for number in (np.nan, np.inf, -np.inf):
        with pytest.raises(ValueError, match=r"action\[3\] must be a finite number"):
            env.step([[0.0, 0.0], [0.0, number]])
    for seed in ([1], [1, 2, 3], -1):
        with pytest.raises(ValueError, match="seed must"):
            env.reset(seed=seed)
    for mask in ([True], [False, False], [1, 0], "no"):
        with pytest.raises(ValueError, match="reset_mask must be"):
            env.reset(options={"reset_mask": mask})
    actions = np.full((2, 2), 0.1)
    assert all(np.array_equal(a, b) for a, b in zip(env.step(actions)[:4], same.step(actions)[:4], strict=True))
    # Beyond the bounds is the bound.
    assert np.array_equal(env.step(np.full((2, 2), 9.0))[1], same.step(np.ones((2, 2)))[1])


def test_a_closed_environment_refuses_every_call() -> None:
    many, one = MachineVectorEnv(2, **SHORT), MachineEnv(**SHORT)
    for env in (many, one):
        env.close()
        env.close()
    calls = [many.reset, one.reset, lambda: many.step(np.zeros((2, 2))), lambda: one.step([0.0, 0.0]), lambda: many.observation_parts]
    for call in calls:
        with pytest.raises(ValueError, match="the environment is closed"):
            call()


@pytest.fixture(scope="module")
def told_anything() -> MachineVectorEnv:
    """Environments that are told whatever comes."""
    env = MachineVectorEnv(2, actuation="torque", **SHORT)
    env.reset(seed=1)
    return env


@given(
    st.lists(st.floats(width=32), min_size=4, max_size=4),
    st.sampled_from(["float16", "float32", "float64", "int8", "bool"]),
)
def test_whatever_the_actions_are_the_answer_is_an_observation_or_an_exception(
    told_anything: MachineVectorEnv, numbers: list[float], dtype: str
) -> None:
    with np.errstate(all="ignore"), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        actions = np.array(numbers).astype(dtype).reshape(2, 2)
    try:
        told, rewards, *_ = told_anything.step(actions)
    except ValueError as error:
        assert "finite" in str(error) and not np.isfinite(actions.astype(float)).all()
        return
    assert told_anything.observation_space.contains(told) and np.isfinite(rewards).all()


def test_the_native_part_refuses_arrays_that_are_not_its_own() -> None:
    env = MachineVectorEnv(2, **SHORT)
    native, width = env.environments, env.environments.observations
    good = [np.zeros((2, 2), np.float32), np.zeros((2, width), np.float32), np.zeros(2), *(np.zeros(2, bool) for _ in range(2))]
    good += [np.zeros(2), np.zeros((2, width), np.float32), np.zeros(2)]
    native.step(*good)
    for index in range(8):
        for wrong in (good[index][:1], good[index].astype("int32"), np.asfortranarray(np.zeros((2, 4, 3)))[:, ::2], None):
            with pytest.raises((ValueError, TypeError)):
                native.step(*good[:index], wrong, *good[index + 1 :])
        if index > 0:
            fixed = good[index].copy()
            fixed.flags.writeable = False
            with pytest.raises(ValueError, match="writable"):
                native.step(*good[:index], fixed, *good[index + 1 :])
    with pytest.raises(ValueError, match="in use"):
        native.step(*good[:5], good[2], *good[6:])


def test_stable_baselines3_accepts_the_environment_and_its_vector_form() -> None:
    pytest.importorskip("stable_baselines3", reason="Stable-Baselines3 is not installed")
    from stable_baselines3.common.env_checker import check_env as check
    from stable_baselines3.common.vec_env import VecMonitor

    from sinew.gym.stable_baselines3 import MachineVecEnv

    check(MachineEnv(**SHORT))
    env = MachineVecEnv(3, **SHORT)
    env.seed(5)
    first = env.reset()
    reference = MachineVectorEnv(3, **SHORT)
    assert np.array_equal(first, reference.reset(seed=5)[0])
    for step in range(5):
        observations, rewards, ended, infos = env.step(np.full((3, 2), 0.1, dtype=np.float32))
        expected = reference.step(np.full((3, 2), 0.1))
        assert np.array_equal(rewards, expected[1]) and ended.all() == (step == 4)
    assert all(info["TimeLimit.truncated"] for info in infos)
    assert np.array_equal([info["terminal_observation"] for info in infos], expected[0])
    assert (observations != expected[0]).any()
    assert env.get_attr("num_envs") == [3, 3, 3] and env.env_is_wrapped(VecMonitor, 1) == [False]
    for refused in (lambda: env.set_attr("steps", 3), lambda: env.env_method("reset")):
        with pytest.raises(AttributeError):
            refused()
    monitored = VecMonitor(env)
    monitored.reset()
    ends = [monitored.step(np.zeros((3, 2), dtype=np.float32))[3] for _ in range(5)][-1]
    assert all(info["episode"]["l"] == 5 for info in ends)
    monitored.close()


def test_stable_baselines3_learns_on_it() -> None:
    pytest.importorskip("stable_baselines3", reason="Stable-Baselines3 is not installed")
    from stable_baselines3 import PPO

    from sinew.gym.stable_baselines3 import MachineVecEnv

    env = MachineVecEnv(4, **SHORT)
    PPO("MlpPolicy", env, n_steps=8, batch_size=16, n_epochs=1, device="cpu", seed=1).learn(64)
    env.close()


def test_the_example_trains_and_evaluates(capsys: pytest.CaptureFixture[str]) -> None:
    example = runpy.run_path(str(EXAMPLE))
    found = example["main"](2, 3, episodes=4)
    assert len(found) == 4 and all(np.isfinite(error) for error in found.values())
    assert capsys.readouterr().out.count("mean error") == 4
