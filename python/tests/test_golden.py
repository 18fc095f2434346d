"""Python and Rust agree bit for bit: random requests, answered by both."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.typing import NDArray

import sinew

Rust = Callable[..., Any]
MACHINES = {name: sinew.Machine(name) for name in sinew.Machine.built_in()}


def bits(value: Any) -> list[int]:
    """The bits of numbers, in C order."""
    return np.ascontiguousarray(value, dtype=float).view(np.int64).ravel().tolist()


def numbers(count: int, most: float) -> st.SearchStrategy[NDArray[np.float64]]:
    return arrays(float, count, elements=st.floats(-most, most))


@st.composite
def states(draw: st.DrawFn) -> dict[str, Any]:
    name = draw(st.sampled_from(sorted(MACHINES)))
    machine = MACHINES[name]
    low, high = machine.ranges.T
    joints, muscles = len(machine.joint_names), len(machine.muscle_names)
    fraction = draw(arrays(float, joints, elements=st.floats(0.0, 1.0)))
    return {
        "machine": name,
        "q": low + fraction * (high - low),
        "v": draw(numbers(joints, 5.0)),
        "a": draw(numbers(joints, 50.0)),
        "tension": draw(arrays(float, muscles, elements=st.floats(0.0, 400.0))),
        "site": draw(st.sampled_from(machine.site_names)),
    }


@given(states())
def test_geometry_and_dynamics_have_the_bits_of_rust(rust: Rust, state: dict[str, Any]) -> None:
    machine = MACHINES[state["machine"]]
    q, v, a, tension, site = (state[name] for name in ("q", "v", "a", "tension", "site"))
    found = {
        "lengths": machine.lengths(q),
        "moment_arms": machine.moment_arms(q),
        "wrap_angles": machine.wrap_angles(q),
        "inverse_dynamics": machine.inverse_dynamics(q, v, a),
        "forward_dynamics": machine.forward_dynamics(q, v, tension),
        "mass_matrix": machine.mass_matrix(q),
        "position": machine.position(q, site=site),
        "jacobian": machine.jacobian(q, site=site),
    }
    plain = {key: value.tolist() if isinstance(value, np.ndarray) else value for key, value in state.items()}
    expected = rust("pose", **plain)
    assert found.keys() == expected.keys()
    for name, value in found.items():
        assert bits(value) == bits(expected[name]), name


@given(states(), st.integers(2, 20))
def test_many_poses_have_the_bits_of_one(state: dict[str, Any], count: int) -> None:
    machine = MACHINES[state["machine"]]
    q = np.linspace(machine.start, state["q"], count).reshape(1, count, -1)
    v, a = state["v"], np.repeat(state["a"][None, None], count, axis=1)
    many = machine.inverse_dynamics(q, v, a)
    arms = machine.moment_arms(q)
    assert many.shape == q.shape and arms.shape == (1, count, len(machine.muscle_names), q.shape[-1])
    for k in range(count):
        assert bits(many[0, k]) == bits(machine.inverse_dynamics(q[0, k], v, a[0, k]))
        assert bits(arms[0, k]) == bits(machine.moment_arms(q[0, k]))


@st.composite
def torques(draw: st.DrawFn) -> dict[str, Any]:
    muscles, joints = draw(st.integers(1, 8)), draw(st.integers(1, 4))
    minimum = draw(arrays(float, muscles, elements=st.floats(0.0, 50.0)))
    return {
        "moment_arms": draw(arrays(float, (muscles, joints), elements=st.floats(-0.1, 0.1))),
        "torque": draw(numbers(joints, 20.0)),
        "minimum": minimum,
        "maximum": minimum + draw(arrays(float, muscles, elements=st.floats(0.0, 400.0))),
        "reference": draw(numbers(muscles, 100.0)),
        "weight": draw(arrays(float, muscles, elements=st.floats(0.1, 10.0))),
    }


@given(st.lists(torques(), min_size=1, max_size=5))
def test_distributions_have_the_bits_of_rust_alone_and_among_others(
    rust: Rust, problems: list[dict[str, Any]]
) -> None:
    shape = problems[0]["moment_arms"].shape
    problems = [problem for problem in problems if problem["moment_arms"].shape == shape]
    together = sinew.distribute(**{name: np.stack([p[name] for p in problems]) for name in problems[0]})
    for k, problem in enumerate(problems):
        expected = rust("distribute", **{name: value.ravel().tolist() for name, value in problem.items()})
        alone = sinew.distribute(**problem)
        for name in ("tension", "residual", "status", "iterations"):
            assert bits(getattr(alone, name)) == bits(expected[name]), name
            assert bits(getattr(together, name)[k]) == bits(expected[name]), name


def test_the_arrays_of_a_law_are_those_of_its_parameters() -> None:
    path = [sinew.Free(0.2), sinew.Sheath(0.8, 3.0), sinew.Pulley(0.5), sinew.Free(0.3)]
    parameters = {"friction": 0.1, "efficiency": 0.9, "viscous_s_per_m": 0.02, "drag_n_s_per_m": 60.0, "compliance_per_n": 2e-4}
    cable = sinew.Cable(path, cells=9, drag_fade_n=4.0, pretension_n=7.0, **parameters)
    law = cable.law
    assert {name: values.shape for name, values in law.items()} == {
        "compliance": (9,), "friction": (8,), "loss": (8,), "viscous": (8,), "drag": (8,), "drag_fade": (), "pretension": (),
    }  # fmt: skip
    assert law["compliance"].sum() == pytest.approx(2e-4 * 1.3)
    assert law["friction"].sum() == pytest.approx(0.5 * 0.1 * 3.5) and law["viscous"].sum() == pytest.approx(0.5 * 0.02 * 3.5)
    assert law["loss"].tolist() == pytest.approx([-0.5 * np.log(0.9), *[0.0] * 7])
    assert law["drag"].sum() == pytest.approx(60.0) and law["drag_fade"] == 4.0 and law["pretension"] == 7.0
    cable.settle(50.0)
    assert cable.stretch == pytest.approx(float((law["compliance"] * cable.tensions).sum()))


@given(
    st.lists(st.tuples(st.floats(-1e-3, 1e-3), st.floats(-1e-4, 1e-4)), min_size=1, max_size=50),
    st.floats(1e-5, 0.02),
    st.floats(20.0, 300.0),
    # A node may not turn the cable by a friction angle above 0.8.
    st.floats(0.0, 0.3),
    st.floats(0.0, 6.0),
    st.integers(16, 40),
)
def test_cables_have_the_bits_of_rust(
    rust: Rust,
    steps: list[tuple[float, float]],
    interval: float,
    settle: float,
    friction: float,
    bend: float,
    cells: int,
) -> None:
    path = [sinew.Free(0.2), sinew.Sheath(0.8, bend, (1.0, 3.0)), sinew.Pulley(1.0), sinew.Free(0.5)]
    cable = sinew.Cable(path, cells=cells, friction=friction)
    cable.settle(settle)
    other = cable.copy()
    rows = []
    for motor, anchor in steps:
        ends = cable.step(interval, motor, anchor)
        rows.append([ends.tension_in, ends.tension_out, ends.dissipated, cable.stretch])
    parameters = json.loads(sinew.Cable.bench_parameters()) | {"friction": friction}
    expected = rust(
        "cable",
        path=[
            {"free": {"length_m": 0.2}},
            {"sheath": {"length_m": 0.8, "bend_rad": bend, "curvature": [1.0, 3.0]}},
            {"pulley": {"wrap_rad": 1.0}},
            {"free": {"length_m": 0.5}},
        ],
        parameters=parameters,
        cells=cells,
        settle=settle,
        interval=interval,
        steps=steps,
    )
    assert bits(rows) == bits(expected["rows"])
    assert bits(cable.tensions) == bits(expected["tensions"])
    assert bits(cable.energy) == bits(expected["energy"])
    motor, anchor = np.array(steps).T
    columns = other.run(interval, motor, anchor)
    assert bits(np.stack([columns[n] for n in ("tension_in", "tension_out", "dissipated", "stretch")], 1)) == bits(rows)


@pytest.mark.parametrize("candidate", ["cell", "linear"])
def test_identification_has_the_bits_of_rust(
    rust: Rust, log_files: list[Path], candidate: str, tmp_path: Path
) -> None:
    found = sinew.identify(log_files[:2], far="tension_out_n", models=[candidate], seed=7, threads=1)
    expected = rust(
        "identify",
        logs=[str(file) for file in log_files[:2]],
        unseen=[str(log_files[2])],
        far="tension_out_n",
        models=[candidate],
        seed=7,
    )
    assert found.to_json() == expected["model"]
    assert found.identification == expected["report"]
    found.report(tmp_path / "report.html")
    assert (tmp_path / "report.html").read_text(encoding="utf-8") == expected["page"]
    evaluation = found.evaluate(log_files[2])
    assert asdict(evaluation.overall) == expected["evaluation"]["overall"]
    assert evaluation.far_unit == expected["evaluation"]["far_unit"]
    assert bits(found.predict(log_files[2]).mean) == bits(expected["means"])


@given(
    st.lists(st.tuples(st.floats(-10, 400), st.floats(-0.2, 0.2), st.floats(-0.01, 0.01)), min_size=1, max_size=60),
    st.floats(1e-4, 0.05),
)
def test_a_predictor_has_the_bits_of_rust_in_steps_and_in_one_run(
    rust: Rust, model: sinew.Model, rows: list[tuple[float, float, float]], interval: float
) -> None:
    time = [k * interval for k in range(len(rows))]
    width = len(model.inputs)
    inputs = [list(row[:width]) for row in rows]
    predictor = model.predictor()
    stepped = [predictor.step(t, row) for t, row in zip(time, inputs, strict=True)]
    found = [[p.mean, p.standard_deviation, p.half_width, p.gate] for p in stepped]
    assert bits(found) == bits(rust("predict", model=model.to_json(), time=time, inputs=inputs))
    predictor.reset()
    columns = model.predictor().run(time, inputs)
    assert bits(columns["mean"]) == bits([p.mean for p in stepped])
    assert columns["out_of_range"].tolist() == [p.out_of_range for p in stepped]


@pytest.mark.parametrize("name", ["lm_arm", "finger", "surgical_wrist"])
def test_twin_and_controller_have_the_bits_of_rust(rust: Rust, name: str) -> None:
    machine, cycles = MACHINES[name], 300
    trajectory = machine.plan("tour")
    twin, controller = sinew.Twin(machine, seed=5), machine.controller()
    halfway = None
    for k in range(cycles):
        now = trajectory.sample(k * 1e-3)
        ahead = trajectory.sample(k * 1e-3 + 0.12)
        measured = twin.measured_motor, twin.measured_tension, twin.measured_joint
        command = controller.step(*measured, *now, previewed=ahead)
        twin.step(command.speed)
        if k == cycles // 2:
            halfway = twin.copy(), twin.q
    assert halfway and bits(halfway[0].q) == bits(halfway[1])
    expected = rust("simulate", machine=name, seed=5, cycles=cycles)
    assert trajectory.duration_s == expected["duration"]
    for quantity in ("q", "v", "tension_out"):
        assert bits(getattr(twin, quantity)) == bits(expected[quantity]), quantity


def test_a_tracking_run_has_the_bits_of_rust(rust: Rust) -> None:
    run = sinew.track(MACHINES["bench_joint"], "tour", repeats=1, seed=3)
    expected = rust("track", machine="bench_joint", seed=3)
    assert run.numbers == expected["numbers"]
    assert len(run.trace["time_s"]) == expected["rows"]
    for name, column in run.trace.items():
        if name != "repeat":
            assert bits(column[-1]) == bits(expected["last"][name]), name
