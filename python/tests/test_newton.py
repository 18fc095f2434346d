"""Sheaths in Newton's own loop, with its MuJoCo solver."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("mujoco", reason="MuJoCo is not installed")
newton = pytest.importorskip("newton", reason="Newton is not installed: pip install newton")
sw = pytest.importorskip("sinew.warp", reason="MuJoCo Warp cannot be used", exc_type=ImportError)
import warp as wp  # noqa: E402

wp.config.log_level = getattr(wp, "LOG_WARNING", 30)
from mujoco_models import GRAVITY, HOIST, MASS, WEIGHT  # noqa: E402

from sinew import batch  # noqa: E402

pytestmark = pytest.mark.filterwarnings("ignore::DeprecationWarning", "ignore::UserWarning")
STEP, THETA = 1e-3, 0.6


def test_a_hoist_in_newton_holds_and_slides_at_the_edges_of_friction_and_begins_anew() -> None:
    solver_kind = newton.solvers.SolverMuJoCo
    one, scene = newton.ModelBuilder(), newton.ModelBuilder()
    for builder in (one, scene):
        solver_kind.register_custom_attributes(builder)
    one.add_mjcf(HOIST)
    scene.replicate(one, 4)
    model = scene.finalize()
    solver = solver_kind(model, iterations=100, ls_iterations=50)
    prepared = batch.prepare(solver.mj_model, {"cable": batch.Sheath(mu=0.2, bend=THETA / 0.2)})
    sheaths = sw.Sheaths(prepared, worlds=4).attach(solver.mjw_model, solver.mjw_data)
    pulls = np.array([f * WEIGHT * np.exp(s * THETA) for s in (1.0, -1.0) for f in (0.99, 1.01)])
    control, states = model.control(), [model.state(), model.state()]
    control.mujoco.ctrl.assign(pulls.astype(np.float32))

    def run(count: int) -> np.ndarray:
        for _ in range(count):
            states[0].clear_forces()
            solver.step(*states, control, None, STEP)
            states.reverse()
        return np.array(states[0].joint_qd.numpy(), dtype=float)

    before = run(20)
    after = run(50)
    assert np.abs(after[[0, 3]]).max() < 1e-6
    gained = (after - before)[[1, 2]] / (50 * STEP)
    expected = [(pulls[k] * np.exp(-way * THETA) - WEIGHT) / MASS for k, way in ((1, 1.0), (2, -1.0))]
    np.testing.assert_allclose(gained, expected, rtol=1e-3)
    # Twice the friction holds all of them, from the next step on.
    sheaths.set(mu=0.4)
    sheaths.reset()
    run(20)
    assert np.abs(run(20)).max() < 1e-6
    assert GRAVITY == pytest.approx(-solver.mj_model.opt.gravity[2], rel=1e-6)
