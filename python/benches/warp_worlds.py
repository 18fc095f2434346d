"""What sheaths cost in MuJoCo Warp: edges of friction, an arm beside the plugin, time of a step of many worlds, memory.

    python python/benches/warp_worlds.py [--small] [--worlds 1024 8192 32768] [--out result.json]

Steps are captured in graphs, on processors where Warp can; it takes some minutes, kernels included. `--small` runs on any
processor. Times of variants follow each other on one device; ratios are of them.
"""

from __future__ import annotations

import argparse
import dataclasses
import datetime
import importlib.metadata
import json
import os
import time
from collections.abc import Callable
from typing import Any

import mujoco
import mujoco_warp as mjw
import numpy as np
import warp as wp

import sinew.batch
import sinew.mujoco as sm
import sinew.warp
from sinew.batch import Sheath
from sinew.batch._hoist import ANGLE, GRAVITY, MASS, XML
from sinew.warp._graph import Graph

#: Ratios at 8192 worlds on a graphics processor, and at 64 on a processor.
BARS = {"plain": 1.5, "constant": 1.05, "sheaths": 1.05, "processor": 1.3}
#: Steps between changes of the controls, and range of these, N, and for winches, m.
HOLD, RANGE, TRAVEL = 50, (5.0, 60.0), (-2e-3, 4e-3)
#: Tension, N, with which cables begin.
START = 30.0
#: Steps of a graph.
STEPS = 10
#: Places for constraints of a world: the same for all variants, which share kernels.
ROOM = 48

result: dict[str, Any] = {}
args: argparse.Namespace


def note(name: str, value: Any, text: str) -> None:
    """Prints a line at once and keeps its numbers."""
    print(f"[{time.perf_counter() - BEGAN:6.1f} s] {text}", flush=True)
    result[name] = value
    if args.out:
        with open(args.out, "w") as file:
            json.dump(result, file, indent=1)


def compile_ahead(work: Callable[[], None]) -> None:
    """Loads the kernels that some work launches, many at once, without launching them."""
    found: dict[tuple[int, int | None], Any] = {}
    plain = wp.launch, wp.launch_tiled, wp.capture_while

    def noted(kernel: Any, *_: Any, block_dim: int | None = None, **__: Any) -> None:
        found[id(kernel.module), block_dim] = kernel.module

    wp.launch = wp.launch_tiled = noted
    # Without kernels the solver's loop would not end.
    wp.capture_while = lambda condition, while_body, **given: while_body(**given)
    try:
        work()
    finally:
        wp.launch, wp.launch_tiled, wp.capture_while = plain
    sizes = {size for _, size in found}
    for size in sizes:
        modules = [module for (_, one), module in found.items() if one == size]
        wp.force_load(wp.get_device(), modules, size, max_workers=os.cpu_count())
    note("compile", len(found), f"{len(found)} modules of kernels are loaded")


def all_kernels() -> None:
    """One step of everything that follows."""
    model, _ = hoist()
    m, d = mjw.put_model(model), mjw.make_data(model, nworld=4, njmax=16)
    sinew.warp.Sheaths(model, worlds=4)._attach(m, d)
    mjw.step(m, d)
    for name in ("plain", "sheaths", "cables"):
        _, d, m, part = variant(name, 4, check=False)
        mjw.step(m, d)
        if part is not None:
            part.set(**({"mu": 0.1} if name == "sheaths" else {"friction": 1.0}))


def hoist() -> tuple[Any, np.ndarray]:
    """A hoist with a sheath, and pulls at 0.99 and 1.01 of both edges of its friction, N."""
    model = sinew.batch.prepare(mujoco.MjModel.from_xml_string(XML), {"*": Sheath(mu=0.2, bend=ANGLE / 0.2)})
    return model, np.array([f * MASS * GRAVITY * np.exp(s * ANGLE) for s in (1.0, -1.0) for f in (0.99, 1.01)])


def edges() -> None:
    """Acceleration at 1.01 and creep at 0.99 of both edges of a hoist's friction."""
    model, pulls = hoist()
    m, d = mjw.put_model(model), mjw.make_data(model, nworld=4, njmax=16)
    sinew.warp.Sheaths(model, worlds=4).attach(m, d)
    d.ctrl.assign(pulls[:, np.newaxis].astype(np.float32))
    for _ in range(20):
        mjw.step(m, d)
    before = d.qvel.numpy()[:, 0].copy()
    for _ in range(50):
        mjw.step(m, d)
    after = d.qvel.numpy()[:, 0]
    got = (after - before) / (50 * model.opt.timestep)
    net = np.array([0.0, pulls[1] * np.exp(-ANGLE), pulls[2] * np.exp(ANGLE), 0.0]) - MASS * GRAVITY
    expected = net / MASS
    wrong = [abs(got[k] / expected[k] - 1.0) for k in (1, 2)]
    creep = [float(abs(after[k])) for k in (0, 3)]
    text = f"hoist: acceleration at 1.01 off by {wrong[0]:.1e}, {wrong[1]:.1e} (bar 1e-3); creep at 0.99 {creep[0]:.1e}, {creep[1]:.1e} m/s (bar 1e-6)"
    note("edges", {"acceleration": [float(x) for x in wrong], "creep": creep}, text)


def controls(count: int, worlds: int, actuators: int, within: tuple[float, float] = RANGE) -> np.ndarray:
    """Tensions at the motors, N, or displacements of winches, m."""
    return np.random.default_rng(5).uniform(*within, (count, worlds, actuators)).astype(np.float32)


def arm_beside_c(steps: int) -> None:
    """Positions of the arm after a second, off the plugin's in C, which does not begin at the force of the last step."""
    plugin = sm.load(args.machine, transmission="sheaths")
    data, start = (mujoco.MjData(plugin) for _ in range(2))
    for one in (data, start):
        mujoco.mj_resetDataKeyframe(plugin, one, 0)
    worlds, d, m, sheaths = variant("sheaths", 4)
    all_controls = controls(steps // HOLD, 1, plugin.nu)
    for row in all_controls:
        data.ctrl[:] = row[0]
        d.ctrl.assign(np.repeat(row, worlds, axis=0))
        mujoco.mj_step(plugin, data, HOLD)
        for _ in range(HOLD):
            sheaths.reset()
            mjw.step(m, d)
    off = float(np.abs(d.qpos.numpy() - data.qpos).max())
    note("arm", off, f"{args.machine} beside the plugin in C after {steps * plugin.opt.timestep:g} s: {off:.1e} rad (bar 1e-4)")


_models: dict[str, Any] = {}


def model_of(name: str) -> Any:
    """The arm of a variant."""
    if not _models:
        plain = sm.load(args.machine, transmission="none")
        _models["plain"] = plain
        _models["sheaths"] = sinew.batch.prepare(plain, sm.sheaths_of(args.machine))
        constant = sinew.batch.prepare(plain, sm.sheaths_of(args.machine))
        # As large as the sheaths' at the mean of the controls.
        table = sinew.batch.table_of(constant).parameters
        constant.tendon_frictionloss[:] = np.sinh(table["mu"] * table["bend"]) * sum(RANGE) / 2.0
        _models["constant"] = constant
    return _models[{"random": "sheaths", "cables": "plain"}.get(name, name)]


def put(d: Any, start: Any, worlds: int) -> None:
    """Sets all worlds to a state, at rest."""
    d.qpos.assign(np.tile(start.qpos, (worlds, 1)).astype(np.float32))
    for array in (d.qvel, d.qacc_warmstart, d.efc.force, d.time):
        array.zero_()


def variant(name: str, worlds: int, check: bool = True) -> tuple[int, Any, Any, Any]:
    """Worlds, data, model and sheaths or cables of a variant; `check`: as `attach` does."""
    model, part = model_of(name), None
    start = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, start, 0)
    m, d = mjw.put_model(model), mjw.make_data(model, nworld=worlds, njmax=ROOM, naconmax=worlds)
    if name in ("sheaths", "random"):
        part = sinew.warp.Sheaths(model, worlds=worlds)
    if name == "cables":
        laid = {key: dataclasses.replace(cable, start_n=START) for key, cable in sm.cables_of(args.machine).items()}
        part = sinew.warp.Cables(model, laid, worlds=worlds)
    if part is not None:
        (part.attach if check else part._attach)(m, d)
    if name == "random":
        mu = part.parameters["mu"].numpy() * np.random.default_rng(1).uniform(0.8, 1.2, (worlds, model.ntendon))
        part.set(mu=mu)
    put(d, start, worlds)
    return worlds, d, m, part


def bytes_of(value: Any, seen: set[int]) -> int:
    """Memory of all arrays of a structure, each counted once."""
    if isinstance(value, wp.array):
        known = value.ptr in seen
        seen.add(value.ptr)
        return 0 if known or value.ptr is None else value.capacity
    if isinstance(value, (list, tuple)):
        return sum(bytes_of(one, seen) for one in value)
    parts = getattr(value, "__dict__", None) or getattr(value, "_cls", None)
    if isinstance(parts, dict) and (dataclasses.is_dataclass(value) or isinstance(value, sinew.warp.Sheaths | sinew.warp.Cables)):
        return sum(bytes_of(one, seen) for one in parts.values())
    if hasattr(value, "_ctype"):  # a structure of kernels
        return sum(bytes_of(getattr(value, name), seen) for name in value._cls.vars)
    return 0


def alone(part: Any, m: Any, d: Any) -> float:
    """Time of our own kernels in a step, us."""
    device, count = wp.get_device(), 50
    if not device.is_cuda or part is None:
        return 0.0
    with wp.ScopedCapture() as capture:
        for _ in range(count):
            part.act(m, d)
    wp.capture_launch(capture.graph)
    wp.synchronize()
    start = time.perf_counter()
    for _ in range(5):
        wp.capture_launch(capture.graph)
    wp.synchronize()
    return 1e6 * (time.perf_counter() - start) / (5 * count)


def microseconds(name: str, worlds: int) -> dict[str, float]:
    """Time of a world-step, us, median of rounds; memory of a world, kB; Newton steps of the slowest world, mean and most;
    time of our kernels in a step of all, us."""
    _, d, m, part = variant(name, worlds)
    seen: set[int] = set()
    memory, ours = bytes_of(d, seen), bytes_of(part, seen)
    def some() -> None:
        for _ in range(STEPS):
            mjw.step(m, d)

    # The first launch loads kernels, the second one captures.
    graph, steps = Graph(some, None), HOLD if wp.get_device().is_cuda else STEPS
    for _ in range(2):
        graph.launch()
    given = wp.array(controls(8, worlds, m.nu, TRAVEL if name == "cables" else RANGE), dtype=float)
    # Of a processor its own time, whatever else it does.
    clock = time.perf_counter if wp.get_device().is_cuda else time.process_time
    times: list[float] = []
    newton: list[int] = []
    began = time.perf_counter()
    while len(times) < 40 and (len(times) < 3 or time.perf_counter() - began < args.seconds):
        wp.copy(d.ctrl, given[len(times) % 8])
        spent = 0.0
        for _ in range(steps // STEPS):
            wp.synchronize()
            start = clock()
            graph.launch()
            wp.synchronize()
            spent += clock() - start
            newton.append(int(d.solver_niter.numpy().max()))
        times.append(spent)
    assert np.isfinite(d.qpos.numpy()).all()
    assert int(d.nefc.numpy().max()) <= ROOM
    return {
        "us": 1e6 * float(np.median(times[1:])) / (steps * worlds),
        "kB": memory / worlds / 1e3,
        "kB_ours": ours / worlds / 1e3,
        "newton_mean": float(np.mean(newton)),
        "newton_most": max(newton),
        "ours_us_a_step": alone(part, m, d),
        "rounds": len(times),
    }


def main() -> None:
    device = wp.get_device()
    packages = ("mujoco", "mujoco-warp", "warp-lang")
    versions = {name: importlib.metadata.version(name) for name in packages}
    today = datetime.datetime.now(tz=datetime.UTC).date().isoformat()
    where = {"device": device.name, "date": today, **versions}
    note("where", where, ", ".join(f"{key} {value}" for key, value in where.items()))
    if device.is_cuda or args.ahead:
        try:
            compile_ahead(all_kernels)
        except Exception as error:  # slower, not worse
            print(f"kernels are loaded one by one: {error}", flush=True)
    edges()
    arm_beside_c(200 if args.small else 1000)
    names = ["plain", "constant", "sheaths", "random", "cables"]
    for worlds in args.worlds:
        seen: dict[str, dict[str, float]] = {}
        for name in names:
            seen[name] = one = microseconds(name, worlds)
            text = (
                f"{worlds:6} worlds, {name:9}: {one['us']:8.4f} us a world-step, {one['kB']:6.2f} kB a world and {one['kB_ours']:.2f} of ours, "
                f"slowest world {one['newton_mean']:.2f} Newton steps, at most {one['newton_most']}; ours alone {one['ours_us_a_step']:.1f} us a step of all"
            )
            note(f"{worlds} {name}", one, text)
        ratio = {name: seen["sheaths"]["us"] / seen[name]["us"] for name in ("plain", "constant")}
        cables = seen["cables"]["us"] / seen["plain"]["us"]
        drawn = seen["random"]["us"] / seen["sheaths"]["us"]
        bars = f"(bars {BARS['plain']}, {BARS['constant']}, {BARS['sheaths']} at 8192 on a graphics processor; {BARS['processor']} at 64 on a processor)"
        text = f"{worlds:6} worlds: sheaths {ratio['plain']:.2f} of plain, {ratio['constant']:.2f} of constant bounds; parameters of each world {drawn:.2f}, cables {cables:.2f} of plain {bars}"
        note(f"{worlds} ratios", ratio | {"random": drawn, "cables": cables}, text)


if __name__ == "__main__":
    BEGAN = time.perf_counter()
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--small", action="store_true", help="few worlds and steps, for a processor")
    parser.add_argument("--worlds", type=int, nargs="+")
    parser.add_argument("--seconds", type=float, default=5.0, help="most time for each number, s")
    parser.add_argument("--machine", default="lm_arm")
    parser.add_argument("--ahead", action="store_true", help="load kernels ahead on a processor as well")
    parser.add_argument("--out", help="file for the numbers, JSON")
    args = parser.parse_args()
    args.worlds = args.worlds or ([64] if args.small else [1024, 8192, 32768])
    wp.config.log_level = getattr(wp, "LOG_WARNING", 30)
    main()
