"""How calls behave: threads, Ctrl-C, memory, copies of arrays, ends of the interpreter."""

from __future__ import annotations

import _thread
import copy
import gc
import io
import pickle
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import sinew

ARM = sinew.Machine("lm_arm")
POSES = np.tile(ARM.start, (20_000, 1))
LONG_POSES = np.tile(ARM.start, (2_000_000, 1))


def long_calls(log_files: list[Path]) -> dict[str, Callable[[], Any]]:
    """Calls of several seconds."""
    arms = ARM.moment_arms(ARM.start)
    torques = np.random.default_rng(1).normal(size=(3_000_000, 7))
    motion = np.full(5_000_000, 1e-7)
    return {
        "identify": lambda: sinew.identify(log_files[:2], far="tension_out_n"),
        "lengths": lambda: ARM.lengths(LONG_POSES),
        "distribute": lambda: sinew.distribute(arms, torques, 20.0, 400.0),
        "Cable.run": lambda: sinew.Cable().run(1e-3, motion),
        "reproduce": lambda: sinew.reproduce(quick=True),
        "track": lambda: sinew.track(ARM, duration_s=60.0),
        "controller": lambda: ARM.controller(seed=1),
    }


@pytest.mark.parametrize("name", ["identify", "lengths", "distribute", "Cable.run", "reproduce", "track", "controller"])
def test_ctrl_c_ends_a_long_call_and_other_threads_run_meanwhile(name: str, log_files: list[Path]) -> None:
    call = long_calls(log_files)[name]
    turns = 0

    def count() -> None:
        nonlocal turns
        end = time.monotonic() + 0.4
        while time.monotonic() < end:
            time.sleep(1e-3)
            turns += 1
        _thread.interrupt_main()

    began = time.monotonic()
    threading.Thread(target=count).start()
    with pytest.raises(KeyboardInterrupt):
        call()
    assert time.monotonic() - began < 2.0
    # With the interpreter's lock held this would be 1; 400 are possible on an idle machine.
    assert turns > 20


def test_an_exception_of_the_progress_function_ends_the_call(log_files: list[Path]) -> None:
    seen = []

    def progress(stage: str, fraction: float) -> None:
        seen.append((stage, fraction))
        if fraction > 0.1:
            raise LookupError("enough")

    with pytest.raises(LookupError, match="enough"):
        sinew.identify(log_files[:2], far="tension_out_n", progress=progress)
    assert seen[0] == ("reading logs", 0.0) and all(0.0 <= fraction <= 1.0 for _, fraction in seen)


class Terminal(io.StringIO):
    """Standard error of a terminal."""

    def isatty(self) -> bool:
        return True


def test_a_terminal_shows_what_a_long_call_does(log_files: list[Path], monkeypatch: pytest.MonkeyPatch) -> None:
    terminal = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    monkeypatch.setattr("sinew._progress.LATER_S", 0.0)
    sinew.identify(log_files[:2], far="tension_out_n", models=["linear"])
    assert "reading logs: 0 %" in terminal.getvalue() and terminal.getvalue().endswith("\r")


def test_many_threads_share_a_machine() -> None:
    expected = ARM.moment_arms(POSES)
    found: list[Any] = [None] * 8

    def work(k: int) -> None:
        found[k] = ARM.moment_arms(POSES)

    threads = [threading.Thread(target=work, args=(k,)) for k in range(len(found))]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert all((arms == expected).all() for arms in found)


def memory() -> int:
    """Resident memory, bytes."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * 4096


@pytest.mark.skipif(sys.platform != "linux", reason="reads /proc")
def test_a_million_calls_leak_nothing(model: sinew.Model) -> None:
    predictor, cable, twin = model.predictor(), sinew.Cable(), sinew.Twin(ARM, 1)
    near, speed = [1.0] * len(model.inputs), np.zeros(15)
    arms = ARM.moment_arms(ARM.start)

    def calls(count: int) -> None:
        for k in range(count):
            predictor.step(1e-3 * k, near)
            cable.step(1e-3, 1e-6 * (1 - 2 * (k % 2)))
            ARM.lengths(ARM.start)
            try:
                ARM.lengths(near)
            except ValueError:
                pass
            if k % 16 == 0:
                sinew.distribute(arms, np.ones(7), 20.0, 400.0)
                twin.step(speed)
                twin.copy()
                cable.copy()

    calls(20_000)
    gc.collect()
    before = memory()
    calls(250_000)
    gc.collect()
    # A leak of one double a call would be 2 MB; the allocator's own noise is some hundred kilobytes.
    assert memory() - before < 1_500_000


def test_float64_in_c_order_is_read_without_a_copy_and_results_own_their_memory() -> None:
    import tracemalloc

    lengths = np.empty(0)
    tracemalloc.start()
    before = tracemalloc.get_traced_memory()[1]
    tracemalloc.reset_peak()
    lengths = ARM.lengths(POSES)
    peak = tracemalloc.get_traced_memory()[1] - before
    tracemalloc.stop()
    assert peak < POSES.nbytes / 10, "NumPy allocated as much as the argument"
    assert lengths.flags.writeable and lengths.flags.c_contiguous and lengths.dtype == np.float64
    q = ARM.start
    q += 1.0
    assert (ARM.start != q).all()


@pytest.mark.parametrize(
    "changed",
    [
        lambda q: q.tolist(),
        lambda q: np.asfortranarray(q),
        lambda q: np.repeat(q, 2, axis=0)[::2],
        lambda q: q.astype(">f8"),
        lambda q: np.frombuffer(b"x" + q.tobytes(), np.uint8)[1:].view(float).reshape(q.shape),
        lambda q: np.ma.masked_array(q),
        lambda q: memoryview(q),
    ],
)
def test_other_layouts_of_the_same_numbers_give_the_same_bits(changed: Callable[[Any], Any]) -> None:
    q = POSES[:3] + np.arange(3)[:, None] * 0.01
    assert (ARM.lengths(changed(q)) == ARM.lengths(q)).all()
    whole = np.zeros((2, 7), dtype=np.int8)
    assert (ARM.lengths(whole) == ARM.lengths(whole.astype(float))).all()
    assert ARM.lengths(np.empty((0, 7))).shape == (0, 15)


def test_machines_and_models_survive_pickle_and_copies_are_independent(model: sinew.Model) -> None:
    machine = pickle.loads(pickle.dumps(ARM))
    assert isinstance(machine, sinew.Machine) and machine.name == ARM.name
    assert pickle.loads(pickle.dumps(model)).to_json() == model.to_json()
    twin = sinew.Twin(ARM, 1)
    other = copy.copy(twin)
    other.step(np.full(15, 0.01))
    assert twin.time_s == 0.0 and other.time_s == 1e-3


@pytest.mark.parametrize("call", ["sinew.reproduce(quick=True)", "arm.lengths(q)", "sinew.track(arm)"])
def test_the_interpreter_may_end_in_the_middle_of_a_call(call: str) -> None:
    code = f"""
import threading, time, numpy as np, sinew
arm = sinew.Machine("lm_arm")
q = np.tile(arm.start, (3_000_000, 1))
threading.Thread(target=lambda: {call}, daemon=True).start()
time.sleep(0.3)
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
