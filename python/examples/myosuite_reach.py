"""The MyoSuite arm, or any other MuJoCo model with tendons, reaches a point in worlds of MuJoCo Warp, with friction of sheaths.

Run: `python python/examples/myosuite_reach.py MODEL.xml [SITE [GENERATIONS]]`, for example `myo_sim/arm/myoarm.xml` of MyoSuite
and its site `IFtip`. Needs mujoco-warp. The cross-entropy method looks for activations that bring a site to a point, a
candidate in each of 64 worlds: once without friction, once with a sheath on every driven tendon. Both are then tried in both.
"""

from __future__ import annotations

import sys
from typing import Any

import mujoco
import mujoco_warp as mjw
import numpy as np
import warp as wp
from numpy.typing import NDArray

import sinew.batch
import sinew.warp

Floats = NDArray[np.float64]

#: Friction coefficients: without and with.
PLANTS = {"without friction": 0.0, "with friction": 0.1}


class Worlds:
    """A model in many worlds, with a sheath on every driven tendon."""

    def __init__(self, file: str, site: str, worlds: int, seconds: float) -> None:
        plain = mujoco.MjModel.from_xml_path(file)
        self.model = model = sinew.batch.prepare(plain, {"*": sinew.batch.Sheath(mu=0.1, bend=3.0, turning=1.0)})
        self._start = mujoco.MjData(model)
        if model.nkey:
            mujoco.mj_resetDataKeyframe(model, self._start, 0)
        mujoco.mj_forward(model, self._start)
        places = 2 * int(self._start.nefc) + model.nv + model.ntendon
        self.m, self.d = mjw.put_model(model), mjw.put_data(model, self._start, nworld=worlds, njmax=places)
        self.sheaths = sinew.warp.Sheaths(model, worlds=worlds).attach(self.m, self.d)
        self.worlds, self._site = worlds, model.site(site).id
        self._steps, self._graph = int(seconds / model.opt.timestep), None
        self._low, self._high = np.where(model.actuator_ctrllimited[:, None], model.actuator_ctrlrange, [0.0, 1.0]).T

    def run(self, activations: Floats, mu: float) -> Floats:
        """Where the site is at the end, m, shape `(worlds, 3)`; activations from 0 to 1, shape `(worlds, actuators)`."""
        mjw.reset_data(self.m, self.d)
        self.d.qpos.assign(np.tile(self._start.qpos, (self.worlds, 1)).astype(np.float32))
        self.sheaths.reset()
        self.sheaths.set(mu=mu)
        self.d.ctrl.assign((self._low + activations * (self._high - self._low)).astype(np.float32))
        for _ in range(self._steps):
            self._step()
        return np.asarray(self.d.site_xpos.numpy()[:, self._site], dtype=np.float64)

    def _step(self) -> None:
        if self._graph is not None:
            wp.capture_launch(self._graph)
            return
        mjw.step(self.m, self.d)
        # Warp captures on CUDA devices, and on processors since it can save graphs.
        if wp.get_device().is_cuda or hasattr(wp, "capture_save"):
            with wp.ScopedCapture() as capture:
                mjw.step(self.m, self.d)
            self._graph = capture.graph


def found(worlds: Worlds, target: Floats, mu: float, generations: int, seed: int = 0) -> Floats:
    """Activations that bring the site to the target, by the cross-entropy method."""
    random = np.random.default_rng(seed)
    mean, size = np.full(worlds.model.nu, -1.0), np.full(worlds.model.nu, 1.0)
    for _ in range(generations):
        drawn = mean + size * random.normal(size=(worlds.worlds, len(mean)))
        off = np.linalg.norm(worlds.run(1.0 / (1.0 + np.exp(-drawn)), mu) - target, axis=1)
        best = drawn[np.argsort(np.where(np.isfinite(off), off, np.inf))[: max(worlds.worlds // 8, 2)]]
        mean, size = best.mean(axis=0), 0.7 * size + 0.3 * best.std(axis=0)
    result: Floats = 1.0 / (1.0 + np.exp(-mean))
    return result


def main(
    file: str, site: str = "IFtip", generations: int = 20, worlds: int = 64, seconds: float = 0.4
) -> dict[tuple[str, str], float]:
    """Prints and returns distances from the target, m, by the plant searched with and the plant tried in."""
    many = Worlds(file, site, worlds, seconds)
    print(f"{many.model.nv} joints, {many.model.nu} actuators, {worlds} worlds", flush=True)
    # A point that some activations reach without friction.
    random = np.random.default_rng(7)
    target = many.run(np.tile(random.uniform(0.0, 0.5, many.model.nu), (worlds, 1)), 0.0)[0]
    began = many.run(np.zeros((worlds, many.model.nu)), 0.0)[0]
    print(f"the target is {1e3 * np.linalg.norm(target - began):.0f} mm from where the site falls", flush=True)
    distances: dict[tuple[str, str], Any] = {}
    for searched, mu in PLANTS.items():
        activations = np.tile(found(many, target, mu, generations), (worlds, 1))
        for tried, other in PLANTS.items():
            off = float(np.linalg.norm(many.run(activations, other)[0] - target))
            distances[searched, tried] = off
            print(f"found {searched}, tried {tried}: {1e3 * off:.1f} mm off", flush=True)
    return distances


if __name__ == "__main__":
    main(*sys.argv[1:3], *map(int, sys.argv[3:4]))  # type: ignore[arg-type]
