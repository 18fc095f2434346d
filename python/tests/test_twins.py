"""Batches of simulated machines: every world has the bits of the same machine alone."""

from __future__ import annotations

import copy
import threading
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import sinew

MACHINES = {name: sinew.Machine(name) for name in sinew.Machine.built_in()}
JOINT = MACHINES["bench_joint"]
QUANTITIES = [name for name, kind in vars(sinew.Twin).items() if not callable(kind) and not name.startswith("_")]


def same(batch: sinew.TwinBatch, alone: list[sinew.Twin]) -> None:
    for quantity in QUANTITIES:
        rows = np.array([getattr(twin, quantity) for twin in alone])
        found = getattr(batch, quantity)
        assert found.shape == rows.shape and found.tobytes() == rows.tobytes(), quantity


def test_a_batch_has_what_a_twin_has() -> None:
    assert {"q", "tension_out", "measured_joint", "time_s"} <= set(QUANTITIES)
    assert set(dir(sinew.Twin)) <= set(dir(sinew.TwinBatch))


@pytest.mark.parametrize("name", MACHINES)
def test_every_world_has_the_bits_of_a_twin(name: str) -> None:
    random = np.random.default_rng(len(name))
    machine, worlds = MACHINES[name], int(random.integers(9, 20))
    muscles, (low, high) = len(machine.muscle_names), machine.ranges.T
    seeds: list[int | None] = [int(seed) for seed in random.integers(0, 2**40, worlds)]
    seeds[int(random.integers(worlds))] = None
    batch = sinew.TwinBatch(machine, seeds, threads=int(random.integers(1, 4)))
    starts: list[dict[str, Any]] = [{"seed": seed} for seed in seeds]
    alone = [sinew.Twin(machine, **start) for start in starts]
    assert len(batch) == worlds
    for turn in range(6):
        same(batch, alone)
        kind, scale = [("speed", 0.1), ("tension", 60.0), ("current", 2.0)][turn % 3]
        command = scale * random.normal(size=(worlds, muscles))
        command[random.random(command.shape) < 0.1] = np.nan
        interval = [None, 0.02, 0.013][turn % 3]
        batch.step(command, interval, kind=kind)
        for world, twin in enumerate(alone):
            if not batch.failed[world]:
                twin.step(command[world], interval, kind=kind)
            else:
                with pytest.raises(ValueError) as refused:
                    twin.step(command[world], interval, kind=kind)
                assert str(refused.value) == batch.failures[world]
        same(batch, alone)
        mask, changes = random.random(worlds) < 0.5, {}
        mask |= batch.failed
        if turn % 2:
            changes["seeds"] = [int(seed) for seed in random.integers(0, 1000, worlds)]
        if turn % 3 == 1:
            changes["q"] = machine.start + 0.02 * random.random((worlds, len(low))) * (high - low)
        batch.reset(mask, **changes)
        for world in np.flatnonzero(mask):
            starts[world] |= {"seed": changes["seeds"][world]} if "seeds" in changes else {}
            starts[world] |= {"q": changes["q"][world]} if "q" in changes else {}
            alone[world] = sinew.Twin(machine, **starts[world])
    assert not batch.failed.any() and batch.failures == [None] * worlds


def test_copies_and_single_worlds_go_on_by_themselves() -> None:
    batch = sinew.TwinBatch(JOINT, range(10), tension_n=[60.0, 50.0], threads=2)
    other, one = copy.copy(batch), batch.twin(3)
    other.step([0.01, 0.0])
    one.step([0.01, 0.0])
    assert (batch.time_s == 0.0).all() and (other.time_s == 1e-3).all()
    assert (other.q[3] == one.q).all() and (other.tension_in[3] == one.tension_in).all()


def test_batches_step_beside_each_other_and_beside_the_interpreter() -> None:
    batches = [sinew.TwinBatch(JOINT, range(200), threads=2) for _ in range(2)]
    alone = copy.deepcopy(batches[0])

    def run(batch: sinew.TwinBatch) -> None:
        for _ in range(10):
            batch.step(np.full(2, 0.05), 0.02)

    threads = [threading.Thread(target=run, args=(batch,)) for batch in batches]
    for thread in threads:
        thread.start()
    turns = 0
    while any(thread.is_alive() for thread in threads):
        turns += 1
    run(alone)
    assert turns > 100, "no other thread could run"
    assert all((batch.q == alone.q).all() for batch in batches)


@pytest.mark.parametrize(
    ("call", "kind", "message"),
    [
        (lambda _: sinew.TwinBatch(JOINT, []), ValueError, "number of worlds must be from 1 to 1 000 000, but is 0"),
        (lambda _: sinew.TwinBatch(JOINT, [1, -1]), OverflowError, "negative"),
        (lambda _: sinew.TwinBatch(JOINT, [1.5]), TypeError, "seeds"),
        (lambda _: sinew.TwinBatch(JOINT, 3), TypeError, "seeds"),
        (lambda _: sinew.TwinBatch("bench_joint", [1]), TypeError, "machine"),
        (lambda _: sinew.TwinBatch(JOINT, [1], threads=0), ValueError, "number of threads must be from 1 to 1024"),
        (lambda _: sinew.TwinBatch(JOINT, [1, 2], q=np.ones(2)), ValueError, r"q must have the shape \(..., 1\)"),
        (lambda _: sinew.TwinBatch(JOINT, [1, 2], q=np.ones((3, 1))), ValueError, r"\(2, 1\) or \(1,\), but has \(3, 1\)"),
        (lambda _: sinew.TwinBatch(JOINT, [1, 2], q=[[0.1], [np.nan]]), ValueError, "row 1: q"),
        (lambda _: sinew.TwinBatch(JOINT, [1, 2], tension_n=[-5.0, 50.0]), ValueError, "row 0: .*tension"),
        (lambda batch: batch.step(np.zeros((2, 2))), ValueError, r"command must have the shape \(3, 2\) or \(2,\)"),
        (lambda batch: batch.step(np.zeros(2), 0.5), ValueError, "h must be a number of seconds in"),
        (lambda batch: batch.step(np.zeros(2), kind="force"), ValueError, "kind must be"),
        (lambda batch: batch.step(["a", "b"]), TypeError, "command must be real numbers"),
        (lambda batch: batch.reset([True]), ValueError, r"mask must have the shape \(3,\), but has \(1,\)"),
        (lambda batch: batch.reset(np.ones(3)), TypeError, "mask"),
        (lambda batch: batch.reset(seeds=[1]), ValueError, r"seeds must have the shape \(3,\), but has \(1,\)"),
        (lambda batch: batch.reset(q=[[0.1], [0.1], [np.inf]]), ValueError, "row 2: q"),
        (lambda batch: batch.twin(3), ValueError, "world must be below 3, but is 3"),
    ],
)
def test_bad_input_is_named_and_changes_nothing(
    call: Callable[[sinew.TwinBatch], Any], kind: type[Exception], message: str
) -> None:
    batch = sinew.TwinBatch(JOINT, range(3))
    before = batch.copy()
    with pytest.raises(kind, match=message):
        call(batch)
    for quantity in QUANTITIES:
        assert getattr(batch, quantity).tobytes() == getattr(before, quantity).tobytes()
    batch.step([0.01, 0.0])
    before.step([0.01, 0.0])
    assert batch.q.tobytes() == before.q.tobytes()
