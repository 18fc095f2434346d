"""The elastic cable in JAX beside the law in Rust, its derivatives beside differences, and what they identify."""

from __future__ import annotations

import os
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

jax = pytest.importorskip("jax", reason="JAX is not installed")
jnp = jax.numpy

import sinew  # noqa: E402
import sinew.jax as sj  # noqa: E402

LONG = bool(os.environ.get("SINEW_LONG"))


@pytest.fixture(autouse=True)
def double() -> Iterator[None]:
    """Numbers of 64 bits, for the tests of this file alone."""
    before = jax.config.jax_enable_x64
    jax.config.update("jax_enable_x64", True)
    yield
    jax.config.update("jax_enable_x64", before)


def motions(steps: int, step: float = 1e-3) -> tuple[np.ndarray, np.ndarray]:
    """Displacements of winch and anchor in every step, m: reversals, and slack after five seconds."""
    t = step * np.arange(steps)
    winch = 0.012 * np.sin(np.pi * t) + 0.004 * np.sin(3.4 * np.pi * t) - 0.03 * np.exp(-(((t - 5.0) / 0.3) ** 2))
    anchor = 0.002 * np.sin(1.6 * np.pi * t + 1.0)
    return np.diff(winch, prepend=0.0), np.diff(anchor, prepend=anchor[0])


def rms(values: Any) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


@pytest.mark.parametrize(("kind", "created"), [("float64", 1e-12), ("float32", 1e-6)])
def test_the_cable_follows_the_law_in_rust(kind: str, created: float) -> None:
    motor, anchor = motions(8000)
    cable = sinew.Cable(cells=12)
    cable.settle(40.0)
    narrow = lambda tree: jax.tree_util.tree_map(lambda x: jnp.asarray(x, dtype=kind), tree)  # noqa: E731
    law, state = narrow(sj.law_of(cable)), narrow(sj.state_of(cable))
    exact = cable.run(1e-3, motor, anchor)
    assert exact["stretch"].min() < 0.0 and np.ptp(exact["tension_out"]) > 50.0
    step = jax.jit(lambda *moved: sj.simulate(law, state, jnp.asarray(1e-3, kind), *moved, newton=1))
    last, ends = step(*narrow((motor, anchor)))
    assert ends.tension_out.dtype == kind
    assert rms(ends.tension_out - exact["tension_out"]) < 1e-3
    assert rms(ends.tension_in - exact["tension_in"]) < 5e-3
    taken = np.asarray(ends.dissipated, dtype=float)
    assert -taken.clip(max=0.0).sum() < created * taken.sum()
    assert np.abs(last.tension - cable.tensions).max() < 5e-2


def test_cables_side_by_side_are_cables_alone() -> None:
    motor, anchor = motions(300)
    cables = [sinew.Cable(cells=9, friction=0.05 + 0.03 * k) for k in range(4)]
    for cable in cables:
        cable.settle(50.0)
    many = [jax.tree_util.tree_map(lambda *x: jnp.stack(x), *map(of, cables)) for of in (sj.law_of, sj.state_of)]
    run = jax.jit(lambda law, state: sj.simulate(law, state, 1e-3, motor, anchor, newton=1))
    _, together = jax.vmap(run)(*many)
    for k, cable in enumerate(cables):
        exact = cable.run(1e-3, motor, anchor)
        # They begin at the edge of sliding, where the last bit decides of every node.
        assert rms(together.tension_out[k] - exact["tension_out"]) < 1e-2
        _, alone = run(*(jax.tree_util.tree_map(lambda x, k=k: x[k], part) for part in many))
        assert rms(together.tension_in[k] - alone.tension_in) < 1e-2


def a_cable(random: np.random.Generator, cells: int = 12) -> tuple[sj.Law, tuple[np.ndarray, np.ndarray], float]:
    """A law, motions of half a second that let the whole cable slide both ways, and the tension in which it begins, N."""
    path = [
        sinew.Free(random.uniform(0.1, 0.4)),
        sinew.Sheath(random.uniform(0.3, 1.2), random.uniform(1.0, 6.0)),
        sinew.Free(random.uniform(0.1, 0.5)),
    ]
    parameters = {
        "friction": random.uniform(0.05, 0.2 if cells > 8 else 0.1),
        "compliance_per_n": 10 ** random.uniform(-4.5, -3.3),
        "drag_n_s_per_m": random.uniform(0.0, 90.0) * random.integers(2),
    }
    cable = sinew.Cable(path, cells=cells, efficiency=1.0, pretension_n=0.0, **parameters)
    law, start = sj.law_of(cable), random.uniform(50.0, 90.0)
    angle = 2.0 * float(law.friction.sum())
    tension = start * (np.exp(angle) - 1.0) * random.uniform(0.8, 1.2) + random.uniform(5.0, 20.0)
    travel, phase = tension * float(law.compliance.sum()), np.arange(500) / 500
    motor = np.diff(travel * np.sin(2.5 * np.pi * phase), prepend=0.0)
    return law, (motor, np.diff(0.1 * travel * np.sin(1.6 * np.pi * phase), prepend=0.0)), start


def test_parameters_far_off_are_found_in_six_steps() -> None:
    random = np.random.default_rng(5)
    seen = jax.jit(lambda law, start, *moved: sj.simulate(law, sj.profile(law, start, start), 1e-3, *moved)[1])
    for _ in range(100 if LONG else 20):
        law, moved, start = a_cable(random)
        ends = seen(law, start, *moved)
        off = {name: float(random.choice([0.35, 1.65])) for name in ("friction", "compliance")}
        fit = sj.identify(sj.scaled(law, off), 1e-3, *moved, ends.tension_in, ends.tension_out, start_n=(start, start))
        assert len(fit.rms_n) == 7 and fit.rms_n[0] > 1.0
        for name, factor in off.items():
            assert fit.factors[name] * factor == pytest.approx(1.0, abs=1e-4), (off, fit)
            np.testing.assert_allclose(getattr(fit.law, name), getattr(law, name), rtol=2e-4)


def test_derivatives_are_those_of_the_function_wherever_it_has_one() -> None:
    random, names, near = np.random.default_rng(11), ("friction", "compliance", "drag"), 1e-6
    for _ in range(3 if LONG else 1):
        law, moved, start = a_cable(random)
        law = law._replace(drag=law.drag + 1.0)
        at = lambda law: sj.sensitivity(law, 1e-3, *moved, (start, start), names)  # noqa: E731, B023
        tensions, slope = at(law)
        assert tensions.shape == (500, 2) and slope.shape == (500, 2, 3)
        for k, name in enumerate(names):
            up, down = (np.asarray(at(sj.scaled(law, {name: np.exp(s * near)}))[0]) for s in (1.0, -1.0))
            forth, back = (up - tensions) / near, (tensions - down) / near
            scale = np.abs(slope[..., k]).max()
            # Where both sides agree there is no tie.
            smooth = np.abs(forth - back) < 1e-3 * scale
            assert smooth.mean() > 0.9, name
            assert np.abs(0.5 * (forth + back) - slope[..., k])[smooth].max() < 1e-3 * scale, name


def test_reverse_and_forward_derivatives_agree() -> None:
    law, moved, start = a_cable(np.random.default_rng(2), cells=6)

    def work(law: sj.Law) -> Any:
        return sj.simulate(law, sj.profile(law, start, start), 1e-3, moved[0][:60], moved[1][:60])[1].dissipated.sum()

    backward = jax.jit(jax.grad(work))(law)
    _, forward = jax.jvp(work, (law,), (law,))
    total = sum(float((a * b).sum()) for a, b in zip(backward, law, strict=True))
    assert total == pytest.approx(float(forward), rel=1e-9) and np.isfinite(np.concatenate([np.ravel(x) for x in backward])).all()


def test_a_start_between_two_tensions_is_at_rest_inside_of_the_band() -> None:
    law = sj.law_of(sinew.Cable(cells=12, pretension_n=5.0))
    state = sj.profile(law, 90.0, 70.0)
    assert state.tension[0] == pytest.approx(90.0) and state.tension[-1] == pytest.approx(65.0)
    assert state.stretch == pytest.approx(float((law.compliance * state.tension).sum()))
    after, ends = sj.cable_step(law, state, 1e-3, 0.0)
    np.testing.assert_allclose(after.tension, state.tension, rtol=1e-12)
    assert ends.tension_out == pytest.approx(70.0) and float(jnp.abs(after.slip).max()) < 1e-12
    slack = sj.profile(law, 0.0, 0.0)
    assert float(jnp.abs(slack.tension).max()) == 0.0 and np.isfinite(jax.jacfwd(lambda x: sj.profile(law, x, 0.0).stretch)(1.0))


def test_what_does_not_fit_is_refused() -> None:
    law, (motor, anchor), _ = a_cable(np.random.default_rng(1))
    with pytest.raises(ValueError, match="'mu' is no field of a law"):
        sj.scaled(law, {"mu": 1.0})
    with pytest.raises(ValueError, match="no field of a law"):
        sj.identify(law, 1e-3, motor, anchor, motor, motor, parameters=("mu",))
    with pytest.raises(ValueError, match="one shape"):
        sj.identify(law, 1e-3, motor[1:], anchor, motor, motor)
