"""Processor time of a step of many worlds in MJX: plain, with constant friction of tendons, with sheaths.

Run with a release build: `pip install .[mjx] && python python/benches/mjx_steps.py [WORLDS]`, 64 by default. The arm has 15
muscles; all are timed in turn, so that ratios are of runs that follow each other. The plain arm has limits of joints alone, which
MJX's solver is done with at once; what friction costs are the steps of the solver, for all worlds as many as for the worst.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
import mujoco.mjx as mjx
import numpy as np

import sinew
import sinew.batch
import sinew.mjx
import sinew.mujoco


def arm() -> Any:
    """The arm with tensions as controls, without a plugin."""
    spec = sinew.mujoco.spec_of("lm_arm", transmission="sheaths")
    for instance in list(spec.plugins):
        spec.delete(instance)
    model = spec.compile()
    model.tendon_frictionloss[:] = 0.0
    return model


def runner(step: Callable[..., Any], worlds: int, start: np.ndarray, data: Any) -> Callable[[Any], Any]:
    """Steps of worlds whose tensions jump every ten steps."""

    def run(data: Any, controls: Any) -> Any:
        return jax.lax.scan(lambda d, ctrl: (step(d.replace(ctrl=ctrl)), None), data, controls)[0]

    many = jax.jit(jax.vmap(run))
    first = jax.tree_util.tree_map(lambda x: jnp.repeat(jnp.asarray(x)[None], worlds, 0), data.replace(qpos=jnp.asarray(start)))
    return lambda controls: jax.block_until_ready(many(first, controls))


def main(worlds: int = 64, steps: int = 100, rounds: int = 5) -> None:
    """Prints microseconds of processor time a world-step, and ratios to the plain model."""
    plain = arm()
    sheaths = sinew.mujoco.sheaths_of("lm_arm")
    prepared = sinew.batch.prepare(plain, sheaths)
    mx, found = sinew.mjx.put_model(prepared)
    constant = sinew.batch.prepare(plain, sheaths)
    constant.tendon_frictionloss[:] = 20.0
    models = {"plain": plain, "friction of 1e-9 N": prepared, "constant friction": constant}
    others = {name: mjx.put_model(model, impl="jax") for name, model in models.items()}
    start = np.array(sinew.Machine("lm_arm").start)
    runs = {name: runner(lambda d, m=m: mjx.step(m, d), worlds, start, mjx.make_data(m)) for name, m in others.items()}
    runs["sheaths"] = runner(lambda d: sinew.mjx.step(mx, d, found), worlds, start, mjx.make_data(mx))
    drawn = np.random.default_rng(0).uniform(40.0, 80.0, (worlds, steps // 10, plain.nu))
    controls = jnp.asarray(np.repeat(drawn, 10, 1), jnp.float32)
    times: dict[str, list[float]] = {name: [] for name in runs}
    for turn in range(rounds + 1):
        for name, run in runs.items():
            began = time.process_time()
            end = run(controls)
            if turn:
                times[name].append(1e6 * (time.process_time() - began) / (worlds * steps))
            assert np.isfinite(np.asarray(end.qpos)).all(), name
    print(f"lm_arm, {worlds} worlds, float32, {jax.devices()[0].platform}, jax {jax.__version__}, {rounds} rounds")
    base = np.array(times["plain"])
    for name, seen in times.items():
        print(f"  {name:28} {np.min(seen):8.1f} us a world-step at least, median ratio {np.median(np.array(seen) / base):.2f}")


if __name__ == "__main__":
    main(*(int(text) for text in sys.argv[1:2]))
