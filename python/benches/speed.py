"""Times of the package, least of several runs, beside those of a Rust loop where there is one.

Run with a release build: `pip install . && python python/benches/speed.py PROGRAM [MODEL.xml]`, where PROGRAM is
`sinew-py-golden` of `cargo build --release --package sinew-py-golden`.
"""

from __future__ import annotations

import json
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

import sinew


def least(work: Callable[[], Any], runs: int = 7) -> float:
    """Seconds of the quickest run."""
    times = []
    for _ in range(runs):
        began = time.perf_counter()
        work()
        times.append(time.perf_counter() - began)
    return min(times)


def each(work: Callable[[], Any], count: int = 20_000) -> float:
    """Microseconds of one call."""

    def many() -> None:
        for _ in range(count):
            work()

    return 1e6 * least(many, 3) / count


def rust_loop(program: str, machine: str, count: int) -> float:
    """Seconds of the loop in Rust, least of seven."""
    request = json.dumps({"pose_loop": {"machine": machine, "count": count}}) + "\n"
    done = subprocess.run([program], input=7 * request, capture_output=True, text=True, check=True)
    return min(map(float, done.stdout.split()))


def two_threads(files: list[Path]) -> float:
    """How much faster two threads identify two times than one thread does."""

    def once() -> None:
        sinew.identify(files, far="tension_out_n", models=["hybrid", "cells"], threads=1)

    def twice_at_once() -> None:
        threads = [threading.Thread(target=once) for _ in range(2)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()

    return 2 * least(once, 2) / least(twice_at_once, 2)


def main() -> None:
    for name in ["lm_arm", *sys.argv[2:]]:
        machine, count = sinew.Machine(name), 100_000
        poses = np.tile(machine.start, (count, 1))
        here, there = least(lambda: machine.lengths(poses)), rust_loop(sys.argv[1], name, count)
        print(f"{machine.name}, {count} poses: {1e6 * here / count:.3f} us a pose, {here / there:.3f} of the Rust loop")
    arm = sinew.Machine("lm_arm")
    q, zero = arm.start, np.zeros(7)
    print(f"lm_arm, one pose               {each(lambda: arm.lengths(q)):8.2f} us")
    print(f"lm_arm, inverse dynamics       {each(lambda: arm.inverse_dynamics(q, zero, zero)):8.2f} us")
    arms, torque = arm.moment_arms(q), np.ones(7)
    torques = np.random.default_rng(1).normal(size=(10_000, 7))
    alone = each(lambda: sinew.distribute(arms, torque, 20.0, 400.0))
    many = 1e6 * least(lambda: sinew.distribute(arms, torques, 20.0, 400.0)) / len(torques)
    print(f"distribute, 15 x 7             {alone:8.2f} us, of 10 000 at once {many:.2f} us each")
    cable = sinew.Cable()
    print(f"Cable.step, 12 cells           {each(lambda: cable.step(1e-3, 0.0)):8.2f} us")
    twin, speed = sinew.Twin(arm, 1), np.zeros(15)
    print(f"Twin.step, 15 cables           {each(lambda: twin.step(speed), 2000):8.2f} us")
    with TemporaryDirectory() as folder:
        files = []
        for name, text in list(sinew.demo_logs().items())[:2]:
            files.append(Path(folder) / name)
            files[-1].write_text(text)
        predictor = sinew.identify(files, far="tension_out_n", models=["hybrid"]).predictor()
        sample = np.array([80.0, 0.03, 0.002])
        print(f"Predictor.step, hybrid         {each(lambda: predictor.step(0.0, sample)):8.2f} us")
        print(f"identify on two threads        {two_threads(files):8.2f} times one")


main()
