"""Bad input gives an exception of the kinds that are promised, with a message; never a crash, never a panic."""

from __future__ import annotations

import copy
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_dtypes, array_shapes, arrays, scalar_dtypes

import sinew

#: What a caller may have to catch. A panic of Rust would be none of these: it is no `Exception`.
PROMISED = (ValueError, TypeError, OverflowError, OSError)

junk = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(-(2**70), 2**70),
    st.floats(),
    st.text(max_size=8),
    st.binary(max_size=8),
    st.complex_numbers(),
    st.just(object()),
    st.lists(st.floats(), max_size=20),
    st.lists(st.lists(st.floats(), max_size=4), max_size=4),
    st.lists(st.text(max_size=4), max_size=4),
    st.dictionaries(st.text(max_size=8), st.one_of(st.floats(), st.lists(st.floats(), max_size=4)), max_size=4),
    arrays(st.one_of(scalar_dtypes(), array_dtypes()), array_shapes(min_dims=0, max_dims=4, min_side=0, max_side=16)),
    arrays(float, st.sampled_from([(7,), (15,), (3, 7), (0, 7), (15, 7), (7, 2), (1,), (3,), (4, 4)])),
)

ARM = sinew.Machine("lm_arm")
JOINT = sinew.Machine("bench_joint")
TWIN, CONTROLLER, CABLE = sinew.Twin(JOINT, 1), JOINT.controller(), sinew.Cable()
BATCH = sinew.TwinBatch(JOINT, [1, 2])
MOTION = JOINT.plan("tour")
RULES = sinew.verify(JOINT, MOTION, repeats=1)
Q, ZERO = ARM.start, np.zeros(7)
COLUMNS = {"time_s": np.arange(5.0), "tension_in_n": np.ones(5), "tension_out_n": np.ones(5)}

Call = tuple[Callable[..., Any], list[Any]]


def keyword(function: Callable[..., Any], *leading: Any, name: str) -> Callable[..., Any]:
    return lambda value: function(*leading, **{name: value})


#: Every function with valid arguments, of which one at a time is replaced. Stateful objects are copies.
CALLS: dict[str, Callable[[], Call]] = {
    "Machine": lambda: (sinew.Machine, ["lm_arm"]),
    "Machine muscles": lambda: (keyword(sinew.Machine, "lm_arm", name="muscles"), [None]),
    "lengths": lambda: (ARM.lengths, [Q]),
    "moment_arms": lambda: (ARM.moment_arms, [Q]),
    "wrap_angles": lambda: (ARM.wrap_angles, [Q]),
    "mass_matrix": lambda: (ARM.mass_matrix, [Q]),
    "inverse_dynamics": lambda: (ARM.inverse_dynamics, [Q, ZERO, ZERO]),
    "forward_dynamics": lambda: (ARM.forward_dynamics, [Q, ZERO, np.full(15, 50.0)]),
    "position": lambda: (ARM.position, [Q]),
    "position site": lambda: (keyword(ARM.position, Q, name="site"), [None]),
    "jacobian": lambda: (ARM.jacobian, [Q]),
    "distribute": lambda: (sinew.distribute, [np.array([[0.03], [-0.03]]), [1.5], [20.0, 20.0], [400.0, 400.0]]),
    "distribute reference": lambda: (
        keyword(sinew.distribute, [[0.03], [-0.03]], [1.5], 20.0, 400.0, name="reference"),
        [0.0],
    ),
    "distribute weight": lambda: (
        keyword(sinew.distribute, [[0.03], [-0.03]], [1.5], 20.0, 400.0, name="weight"),
        [1.0],
    ),
    "Cable": lambda: (sinew.Cable, [None]),
    "Cable cells": lambda: (keyword(sinew.Cable, name="cells"), [12]),
    "Cable friction": lambda: (keyword(sinew.Cable, name="friction"), [0.1]),
    "Cable segment": lambda: (
        lambda a, b, c: sinew.Cable([sinew.Free(a), sinew.Sheath(b, 1.0, c), sinew.Free(0.1)]),
        [0.1, 0.5, ()],
    ),
    "Cable.step": lambda: (CABLE.copy().step, [1e-3, 1e-4, 0.0]),
    "Cable.run": lambda: (CABLE.copy().run, [1e-3, np.full(7, 1e-4), np.zeros(7)]),
    "Cable.settle": lambda: (CABLE.copy().settle, [100.0]),
    "Cable.travel_to": lambda: (CABLE.copy().travel_to, [100.0]),
    "Twin": lambda: (sinew.Twin, [JOINT, 1]),
    "Twin q": lambda: (keyword(sinew.Twin, JOINT, 1, name="q"), [JOINT.start]),
    "Twin tension": lambda: (keyword(sinew.Twin, JOINT, 1, name="tension_n"), [[50.0, 50.0]]),
    "Twin.step": lambda: (TWIN.copy().step, [np.zeros(2), 1e-3]),
    "TwinBatch": lambda: (sinew.TwinBatch, [JOINT, [1, None]]),
    "TwinBatch q": lambda: (keyword(sinew.TwinBatch, JOINT, [1, 2], name="q"), [JOINT.start]),
    "TwinBatch threads": lambda: (keyword(sinew.TwinBatch, JOINT, [1, 2], name="threads"), [1]),
    "TwinBatch.step": lambda: (BATCH.copy().step, [np.zeros((2, 2)), 1e-3]),
    "TwinBatch.reset": lambda: (BATCH.copy().reset, [[True, False]]),
    "TwinBatch.reset seeds": lambda: (keyword(BATCH.copy().reset, name="seeds"), [[1, 2]]),
    "TwinBatch.reset q": lambda: (keyword(BATCH.copy().reset, name="q"), [np.zeros((2, 1))]),
    "TwinBatch.twin": lambda: (BATCH.twin, [1]),
    "Twin.step kind": lambda: (keyword(TWIN.copy().step, np.zeros(2), name="kind"), ["speed"]),
    "Controller.step": lambda: (
        CONTROLLER.copy().step,
        [np.zeros(2), np.full(2, 50.0), JOINT.start, JOINT.start, np.zeros(1), np.zeros(1)],
    ),
    "Controller.step interval": lambda: (
        keyword(CONTROLLER.copy().step, np.zeros(2), np.full(2, 50.0), JOINT.start, JOINT.start, name="interval_s"),
        [1e-3],
    ),
    "controller poses": lambda: (keyword(JOINT.controller, name="poses"), [None]),
    "plan": lambda: (ARM.plan, [Q[:3]]),
    "plan duration": lambda: (keyword(JOINT.plan, "tour", name="duration_s"), [None]),
    "verify repeats": lambda: (keyword(sinew.verify, JOINT, MOTION, name="repeats"), [1]),
    "verify payload": lambda: (keyword(sinew.verify, JOINT, MOTION, name="payload_kg"), [0.0]),
    "Trajectory.sample": lambda: (MOTION.sample, [0.5]),
    "Model.load": lambda: (sinew.Model.load, ["model.json"]),
    "Model.from_json": lambda: (sinew.Model.from_json, ["{}"]),
    "Model": lambda: (sinew.Model, [None]),
    "identify": lambda: (sinew.identify, [COLUMNS, "tension_out_n"]),
    "identify effort": lambda: (keyword(sinew.identify, COLUMNS, "tension_out_n", name="effort"), [()]),
    "identify skip": lambda: (keyword(sinew.identify, COLUMNS, "tension_out_n", name="skip_s"), [0.0]),
    "identify seed": lambda: (keyword(sinew.identify, COLUMNS, "tension_out_n", name="seed"), [1]),
    "identify column": lambda: (lambda x: sinew.identify(COLUMNS | {"tension_in_n": x}), [np.ones(5)]),
    "reproduce part": lambda: (lambda part: sinew.reproduce(part=part if part != "all" else "al"), ["al"]),
}


def returns_or_raises(function: Callable[..., Any], arguments: list[Any]) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            function(*arguments)
        except PROMISED as error:
            assert str(error), repr(error)


@pytest.mark.parametrize("name", CALLS)
@given(data=st.data())
def test_bad_input_gives_a_promised_exception(name: str, data: st.DataObject) -> None:
    function, arguments = CALLS[name]()
    arguments = list(arguments)
    arguments[data.draw(st.integers(0, len(arguments) - 1))] = data.draw(junk)
    returns_or_raises(function, arguments)


@given(data=st.data())
def test_bad_input_to_a_model_gives_a_promised_exception(model: sinew.Model, data: st.DataObject) -> None:
    predictor = model.predictor()
    sample = [0.0, np.ones(len(model.inputs))]
    sample[data.draw(st.integers(0, 1))] = data.draw(junk)
    returns_or_raises(predictor.step, sample)
    returns_or_raises(predictor.run, sample)
    for function in (model.evaluate, model.predict, model.adapt, model.save):
        value = data.draw(junk)
        # Names of files are not drawn here: something could be written.
        if not (function == model.save and isinstance(value, str | bytes | int)):
            returns_or_raises(function, [value])


@pytest.mark.parametrize(
    ("call", "kind", "message"),
    [
        (lambda: ARM.lengths(np.ones(6)), ValueError, r"q must have the shape \(..., 7\), but has \(6,\)"),
        (lambda: ARM.lengths([[0.0] * 7, [np.nan] * 7]), ValueError, r"row 1: q\[\d\] must be finite, but is NaN"),
        (lambda: ARM.lengths(["a"] * 7), TypeError, "q must be real numbers, but is an array of <U1"),
        (lambda: ARM.lengths(np.ones(7, complex)), TypeError, "complex128"),
        (lambda: ARM.inverse_dynamics(Q, [[0.0] * 7] * 2, [[0.0] * 7] * 3), ValueError, "same leading axes"),
        (lambda: ARM.position(Q, site="hand"), ValueError, "site: expected one of .*endpoint.*, but is hand"),
        (lambda: sinew.Machine("no_such.toml"), FileNotFoundError, "no_such.toml"),
        (lambda: sinew.Machine("lm_leg"), ValueError, "lm_leg: expected a machine or robot file ending in .*lm_arm"),
        (lambda: sinew.identify("no_such.csv"), FileNotFoundError, "no_such.csv"),
        (lambda: sinew.identify(COLUMNS, "force"), ValueError, "has no column `force`"),
        (lambda: sinew.identify(COLUMNS, effort="tension_in_n"), TypeError, "a list of names"),
        (lambda: sinew.identify({"a": [1.0], "b": [1.0, 2.0]}), ValueError, "column `b` must have 1 rows"),
        (lambda: sinew.identify(COLUMNS, keep="all"), TypeError, "keep must be a list of names"),
        (lambda: sinew.identify(COLUMNS, seed=-1), ValueError, "seed must be a whole number of at least 0, but is -1"),
        (lambda: sinew.identify(COLUMNS, threads=0), ValueError, "threads must be 1 to 1024"),
        (lambda: sinew.Cable(mass=1.0), TypeError, "'mass' is no parameter of a cable, expected one of friction"),
        (lambda: sinew.Cable(friction=-1.0), ValueError, "friction must be a finite number >= 0, but is -1"),
        (lambda: CABLE.copy().step(1.0, 0.0), ValueError, r"interval must be a number of seconds in \[1e-7, 0.02\]"),
        (lambda: sinew.distribute([[1.0]], [1.0], 2.0, 1.0), ValueError, "minimum.0. must be <= maximum"),
        (lambda: JOINT.plan("circle"), ValueError, "path must be one of .*tour, but is .circle."),
        (lambda: sinew.track(JOINT, "tour", compensation="magic"), ValueError, "expected none, capstan.*got magic"),
        (lambda: sinew.track(JOINT, "tour", faults="cable"), ValueError, "faults: .cable.: expected COMPONENT:NAME@START"),
        (lambda: sinew.track(JOINT, "tour", faults=["cable:x@3"]), ValueError, "cable:x@3: expected the name of a muscle: "),
        (lambda: sinew.track(JOINT, "tour", faults="drive:front@900"), ValueError, "a start before the end of the run"),
        (lambda: sinew.track(JOINT, "tour", faults=[3.0]), TypeError, "faults"),
        (lambda: sinew.track(JOINT, "tour", duration_s=0.2), ValueError, "the machine cannot track the motion: at"),
        (lambda: sinew.verify(JOINT, "tour", duration_s=0.2), ValueError, "the machine cannot track the motion: at"),
        (lambda: sinew.verify(JOINT, "tour", duration_s=1e9), ValueError, "must take at most 3600 s, but takes 1000000000"),
        (lambda: sinew.track(JOINT, "tour", duration_s=4000.0), ValueError, "must take at most 3600 s, but takes 4000 s"),
        (lambda: sinew.track(JOINT, "tour", rules=RULES | {"gain": 1.0}), ValueError, "unknown field `gain`"),
        (lambda: sinew.track(JOINT, "tour", rules=RULES | {"margin": np.nan}), ValueError, "rules must be those of"),
        (lambda: sinew.track(JOINT, "tour", rules=RULES | {"margin": 2.0}), ValueError, r"margin.*\(0, 1\]"),
        (lambda: sinew.Model.from_json('{"format": "sinew transmission model", "version": 9}'), ValueError, "version 1;"),
    ],
)
def test_messages_name_place_value_and_expectation(call: Callable[[], Any], kind: type, message: str) -> None:
    with pytest.raises(kind, match=message):
        call()


def test_a_damaged_model_is_refused_with_its_file(model: sinew.Model, tmp_path: Path) -> None:
    file = tmp_path / "model.json"
    model.save(file)
    assert sinew.Model.load(file).to_json() == model.to_json()
    text = file.read_text()
    file.write_text(text.replace("tension_in_n", "tension_on_n", 1))
    with pytest.raises(ValueError, match=r"model.json: .*checksum"):
        sinew.Model.load(file)
    with pytest.raises(ValueError, match="read from a file"):
        sinew.Model.from_json(text).report(tmp_path / "report.html")
    with pytest.raises(FileNotFoundError):
        model.save(tmp_path / "none" / "model.json")
    assert list(tmp_path.iterdir()) == [file]


def test_a_failed_step_leaves_the_cable_as_it_was() -> None:
    cable = CABLE.copy()
    cable.settle(100.0)
    before = cable.tensions
    with pytest.raises(ValueError, match="motion of the motor's end"):
        cable.step(1e-3, 1.0)
    assert (cable.tensions == before).all()
    assert (copy.deepcopy(cable).tensions == before).all()


def test_an_object_of_another_thread_at_work_is_refused_not_shared(model: sinew.Model) -> None:
    import threading

    predictor = model.predictor()
    count, width = 400_000, len(model.inputs)
    time, inputs = np.arange(count) * 1e-3, np.ones((count, width))
    thread = threading.Thread(target=predictor.run, args=(time, inputs))
    thread.start()
    refused = 0
    while thread.is_alive():
        try:
            predictor.step(0.0, inputs[0])
        except RuntimeError as error:
            assert "borrowed" in str(error)
            refused += 1
    thread.join()
    assert refused > 0
