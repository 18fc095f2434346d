"""Sheaths in MJX's JAX backend: exact laws, the plugin in C, and what would lose friction without a word."""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest

pytest.importorskip("mujoco", reason="MuJoCo is not installed")
jax = pytest.importorskip("jax", reason="JAX is not installed")
mjx = pytest.importorskip("mujoco.mjx", reason="MJX is not installed", exc_type=ImportError)
sx = pytest.importorskip("sinew.mjx", reason="MJX cannot be used", exc_type=ImportError)

import mujoco  # noqa: E402
from mujoco_models import FINGER, GRAVITY, HOIST, MASS, WEIGHT  # noqa: E402

import sinew.mujoco as sm  # noqa: E402
from sinew.batch import Sheath, prepare  # noqa: E402
from sinew.mjx import _check  # noqa: E402

jnp = jax.numpy
LONG = bool(os.environ.get("SINEW_LONG"))
long = pytest.mark.skipif(not LONG, reason="long: set SINEW_LONG")


@pytest.fixture
def double() -> Iterator[None]:
    """Numbers of 64 bits, for one test."""
    before = jax.config.jax_enable_x64
    jax.config.update("jax_enable_x64", True)
    yield
    jax.config.update("jax_enable_x64", before)


def without_contacts(xml: str) -> Any:
    """A model; MJX and MuJoCo differ in contacts."""
    model = mujoco.MjModel.from_xml_string(xml)
    model.geom_contype[:] = model.geom_conaffinity[:] = 0
    return model


@pytest.fixture(scope="module")
def hoist() -> tuple[Any, Any, Any]:
    """A hoist in MJX with its sheaths, and a world of it."""
    model = prepare(without_contacts(HOIST), {"cable": Sheath(mu=0.2, bend=3.0)})
    mx, sheaths = sx.put_model(model)
    return mx, sheaths, mjx.make_data(mx)


@pytest.fixture(scope="module")
def lift(hoist: tuple[Any, Any, Any]) -> Callable[..., Any]:
    """Worlds after controls of shape `(worlds, steps)`, with sheaths of every world: `lift(sheaths, data, controls)`."""
    mx, _, _ = hoist

    def run(sheaths: Any, data: Any, pulls: Any) -> Any:
        return jax.lax.scan(lambda d, pull: (sx.step(mx, d.replace(ctrl=pull[None]), sheaths), None), data, pulls)[0]

    compiled: dict[Any, Any] = {}

    def lifted(sheaths: Any, data: Any, pulls: Any) -> Any:
        axes = sheaths.axes
        key = str(axes)
        if key not in compiled:
            compiled[key] = jax.jit(jax.vmap(run, in_axes=(axes, 0, 0)))
        return compiled[key](sheaths, data, jnp.asarray(pulls, jnp.float32))

    return lifted


def worlds_of(data: Any, count: int) -> Any:
    return jax.tree_util.tree_map(lambda x: jnp.repeat(jnp.asarray(x)[None], count, 0), data)


def test_each_world_has_its_own_friction_with_exact_edges_and_holds_without_creep(
    hoist: tuple[Any, Any, Any], lift: Callable[..., Any]
) -> None:
    _, sheaths, data = hoist
    angles = np.repeat(np.linspace(0.06, 1.8, 16), 4)
    signs, shares = np.tile([1.0, 1.0, -1.0, -1.0], 16), np.tile([0.99, 1.01], 32)
    tension = WEIGHT * np.exp(signs * angles) * shares
    end = lift(sheaths.set(mu=angles[:, None] / 3.0), worlds_of(data, 64), np.repeat(tension[:, None], 60, 1))
    slides = tension * np.exp(-signs * angles) - WEIGHT
    free = signs * slides > 0.0
    # The weight in float32 is what limits the difference of two tensions a hundredth apart.
    np.testing.assert_allclose(end.qacc[free, 0], slides[free] / MASS, rtol=1e-3)
    assert np.abs(end.qvel[~free, 0]).max() < 1e-4


def test_no_world_sees_another_when_some_begin_again(hoist: tuple[Any, Any, Any], lift: Callable[..., Any]) -> None:
    _, sheaths, data = hoist
    random = np.random.default_rng(3)
    sheaths = sheaths.set(mu=np.linspace(0.1, 0.4, 64)[:, None])
    seen = []
    for other in range(2):
        world, drawn = worlds_of(data, 64), np.random.default_rng(4)
        for _ in range(4):
            pulls = WEIGHT * drawn.uniform(0.3, 3.0, (64, 60))
            # Only the worlds with odd numbers differ, in their controls and in when they begin again.
            pulls[1::2] *= 1.0 + other * random.uniform(0.0, 1.0, (32, 60))
            world = lift(sheaths, world, pulls)
            again = drawn.random(64) < 0.3
            again[1::2] ^= bool(other)
            world = jax.tree_util.tree_map(
                lambda now, first, again=again: jnp.where(again.reshape(64, *[1] * (now.ndim - 1)), first, now),
                world,
                worlds_of(data, 64),
            )
        seen.append(world)
    np.testing.assert_array_equal(seen[0].qpos[::2], seen[1].qpos[::2])
    np.testing.assert_array_equal(seen[0]._impl.efc_force[::2], seen[1]._impl.efc_force[::2])
    assert (np.asarray(seen[0].qpos[1::2]) != np.asarray(seen[1].qpos[1::2])).mean() > 0.5


def test_a_checkpoint_continues_to_the_bit(hoist: tuple[Any, Any, Any], lift: Callable[..., Any]) -> None:
    _, sheaths, data = hoist
    sheaths = sheaths.set(mu=np.linspace(0.1, 0.4, 64)[:, None])
    pulls = WEIGHT * np.random.default_rng(5).uniform(0.3, 3.0, (64, 120))
    half = lift(sheaths, worlds_of(data, 64), pulls[:, :60])
    leaves, tree = jax.tree_util.tree_flatten((half, sheaths))
    saved = pickle.dumps([np.asarray(leaf) for leaf in leaves])
    again, same = jax.tree_util.tree_unflatten(tree, [jnp.asarray(leaf) for leaf in pickle.loads(saved)])
    assert same.names == sheaths.names == ("cable",) and pickle.loads(pickle.dumps(same.layout)) == sheaths.layout
    expected = lift(sheaths, half, pulls[:, 60:])
    np.testing.assert_array_equal(lift(same, again, pulls[:, 60:]).qpos, expected.qpos)


def test_an_environment_steps_as_its_time_steps(hoist: tuple[Any, Any, Any], lift: Callable[..., Any]) -> None:
    mx, sheaths, data = hoist
    action = jnp.array([2.0 * WEIGHT], jnp.float32)
    once = jax.jit(sx.env_step, static_argnums=3)((mx, sheaths), data, action, 60)
    alone = lift(sheaths.set(mu=np.full((64, 1), 0.2)), worlds_of(data, 64), np.full((64, 60), 2.0 * WEIGHT))
    assert once.qpos[0] > 1e-3
    np.testing.assert_allclose(once.qpos, alone.qpos[5], rtol=1e-5)
    kinds = [jax.tree_util.tree_map(lambda x: getattr(x, "dtype", None), part) for part in (once, data)]
    assert kinds[0] == kinds[1]


def plugin_of(xml: str, sheaths: dict[str, Sheath], change: Callable[[Any], None]) -> Any:
    """The same model with the plugin."""
    spec = mujoco.MjSpec.from_string(xml)
    sm.add_sheaths(spec, sheaths)
    model = spec.compile()
    change(model)
    model.geom_contype[:] = model.geom_conaffinity[:] = 0
    return model


def beside_the_plugin(xml: str, sheaths: dict[str, Sheath], controls: np.ndarray, every: int, integrator: str = "EULER") -> float:
    """Largest distance of positions from those of the plugin in C, rad, with controls that change every so many steps.

    The plugin's constraints do not begin at the force of the last step: MJX forgets it here as well.
    """

    def change(model: Any) -> None:
        model.opt.integrator = getattr(mujoco.mjtIntegrator, f"mjINT_{integrator}")
        model.opt.tolerance = 1e-12

    plain = without_contacts(xml)
    change(plain)
    mx, found = sx.put_model(prepare(plain, sheaths))

    @jax.jit
    def run(mx: Any, found: Any, data: Any, held: Any) -> Any:
        def one(d: Any, ctrl: Any) -> tuple[Any, Any]:
            d = d.tree_replace({"ctrl": ctrl, "_impl.efc_force": jnp.zeros_like(d._impl.efc_force)})
            d = sx.step(mx, d, found)
            return d, d.qpos

        return jax.lax.scan(one, data, held)[1]

    held = np.repeat(controls, every, 0)
    seen = np.asarray(run(mx, found, mjx.make_data(mx), jnp.asarray(held)))
    model = plugin_of(xml, sheaths, change)
    data, exact = mujoco.MjData(model), []
    for ctrl in held:
        data.ctrl[:] = ctrl
        mujoco.mj_step(model, data)
        exact.append(np.array(data.qpos))
    assert np.isfinite(seen).all() and np.ptp(np.array(exact), axis=0).max() > 1e-3
    return float(np.abs(seen - np.array(exact)).max())


def test_a_finger_follows_the_plugin_with_turning_and_forces_that_are_limited(double: None) -> None:
    sheaths = {"*": Sheath(mu=0.1, bend=4.0, turning=1.0), "tip": Sheath(mu=0.2, bend=1.0, rise=0.3, pretension=0.5)}
    controls = np.random.default_rng(1).uniform(0.0, 20.0, (10, 3))
    assert beside_the_plugin(FINGER, sheaths, controls, 20) < 1e-6


def random_model(random: np.random.Generator) -> tuple[str, dict[str, Sheath]]:
    """A chain with tendons through sites, fixed and coupled ones, limits, friction of joints, an equality."""
    joints = int(random.integers(2, 5))
    inside, path = "", ['<site name="s0" pos="0 0 .03"/><site name="t0" pos="0 0 -.03"/>']
    for k in reversed(range(joints)):
        loss = f'frictionloss="{random.uniform(0.01, 0.1):.3f}"' if random.random() < 0.3 else ""
        inside = (
            f'<body pos=".15 0 0"><joint name="j{k}" axis="{random.choice(["0 1 0", "0 1 .3"])}" range="-1.2 1.2" '
            f'limited="{random.choice(["true", "false"])}" damping="{random.uniform(0.05, 0.3):.3f}" armature="1e-3" '
            f'stiffness="{random.choice([0.0, 2.0, 10.0])}" {loss}/>'
            f'<geom type="capsule" size=".01" fromto="0 0 0 .12 0 0" mass="{random.uniform(0.1, 0.5):.3f}"/>'
            f'<site name="s{k + 1}" pos=".06 0 {random.uniform(0.02, 0.05):.3f}"/>'
            f'<site name="t{k + 1}" pos=".06 0 -{random.uniform(0.02, 0.05):.3f}"/>{inside}</body>'
        )
    tendons, actuators, sheaths = "", "", {}
    for k in range(int(random.integers(2, 5))):
        side, last = random.choice(["s", "t"]), int(random.integers(1, joints + 1))
        if random.random() < 0.25:
            some = "".join(f'<joint joint="j{i}" coef="{random.uniform(-0.04, 0.04):.4f}"/>' for i in range(last))
            tendons += f'<fixed name="f{k}">{some}</fixed>'
        else:
            limit = 'limited="true" range="0 .6"' if random.random() < 0.2 else ""
            sites = "".join(f'<site site="{side}{i}"/>' for i in range(last + 1))
            tendons += f'<spatial name="f{k}" {limit}>{sites}</spatial>'
        # Two actuators on one tendon, one of them limited; gears of both signs.
        for _ in range(int(random.integers(1, 3))):
            force = 'forcelimited="true" forcerange="-30 5"' if random.random() < 0.3 else ""
            actuators += f'<motor tendon="f{k}" gear="{random.choice([-1.0, -2.0, 1.0])}" {force}/>'
        if random.random() < 0.85 or not sheaths:
            sheaths[f"f{k}"] = Sheath(
                mu=float(random.choice([0.0, 0.1, 0.3])), bend=random.uniform(0.5, 4.0), turning=float(random.integers(2)),
                efficiency=random.uniform(0.8, 1.0), pretension=random.uniform(0.0, 2.0), rise=float(random.choice([0.0, 0.3])),
            )  # fmt: skip
    equality = '<equality><joint joint1="j0" joint2="j1" polycoef="0 .5 0 0 0"/></equality>' if random.random() < 0.3 else ""
    xml = (
        f'<mujoco><compiler angle="radian"/><option timestep="0.001"/><worldbody>{path[0]}{inside}</worldbody>'
        f"<tendon>{tendons}</tendon>{equality}<actuator>{actuators}</actuator></mujoco>"
    )
    return xml, sheaths


def test_random_models_follow_the_plugin(double: None) -> None:
    random = np.random.default_rng(7)
    for k in range(50 if LONG else 1):
        xml, sheaths = random_model(random)
        count = mujoco.MjModel.from_xml_string(xml).nu
        # Pulls, slack and pushes.
        controls = random.uniform(-4.0, 12.0, (10, count)) * (random.random((10, count)) < 0.8)
        off = beside_the_plugin(xml, sheaths, controls, 50 if LONG else 20, str(random.choice(["EULER", "IMPLICITFAST"])))
        assert off < 1e-6, (k, xml, sheaths)


def arm(sheathed: bool) -> tuple[str, dict[str, Sheath]]:
    import sinew

    spec = sm.spec_of("lm_arm", transmission="sheaths")
    for instance in list(spec.plugins):
        spec.delete(instance)
    return spec.to_xml(), sm.sheaths_of(sinew.Machine("lm_arm"))


@long
def test_the_arm_follows_the_plugin_for_a_second(double: None) -> None:
    if mujoco.__version__ != _check.version("mujoco-mjx"):
        pytest.skip(f"MuJoCo {mujoco.__version__} finds other ways around cylinders than MJX {_check.version('mujoco-mjx')}")
    xml, sheaths = arm(True)
    controls = np.random.default_rng(2).uniform(40.0, 80.0, (20, 15))
    assert beside_the_plugin(xml, sheaths, controls, 50) < 1e-6


def test_friction_gives_no_work_back(double: None) -> None:
    plain = without_contacts(FINGER)
    plain.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_EULERDAMP)
    mx, sheaths = sx.put_model(prepare(plain, {"*": Sheath(mu=0.1, bend=4.0, turning=1.0)}))
    controls = np.repeat(np.random.default_rng(3).uniform(0.0, 15.0, (40 if LONG else 12, 3)), 50, 0)

    @jax.jit
    def run(data: Any, controls: Any) -> Any:
        def one(d: Any, ctrl: Any) -> tuple[Any, Any]:
            after = sx.step(mx, d.replace(ctrl=ctrl), sheaths)
            impl = after._impl
            speed = impl.efc_J[:3] @ (0.5 * (d.qvel + after.qvel))
            return after, -(impl.efc_force[:3] * speed) * 1e-3

        return jax.lax.scan(one, data, controls)[1]

    work = np.asarray(run(mjx.make_data(mx), jnp.asarray(controls)))
    taken, given_back = work.clip(min=0.0).sum(), -work.clip(max=0.0).sum()
    assert taken > 0.02 and given_back < 1e-3 * taken


@long
def test_the_speed_of_a_load_has_the_derivative_of_the_law(hoist: tuple[Any, Any, Any]) -> None:
    mx, sheaths, data = hoist

    def speed(mu: Any, pull: float) -> Any:
        at = data.replace(ctrl=jnp.array([pull], jnp.float32))
        of = sheaths.set(mu=mu)
        return jax.lax.scan(lambda d, _: (sx.step(mx, d, of), None), at, None, 50)[0].qvel[0]

    slope = jax.jit(lambda pull: jax.jvp(lambda mu: speed(mu, pull), (jnp.float32(0.2),), (jnp.float32(1.0),))[1])
    # v = t (T exp(-mu bend)/m - g).
    pull = 2.5 * WEIGHT
    assert float(slope(pull)) == pytest.approx(-0.05 * 3.0 * pull * np.exp(-0.6) / MASS, rel=1e-3)
    assert abs(float(slope(WEIGHT))) < 1e-3


def test_what_would_step_without_friction_is_refused(hoist: tuple[Any, Any, Any]) -> None:
    mx, sheaths, data = hoist
    good = {"cable": Sheath(mu=0.2, bend=3.0)}

    def model(change: Callable[[Any], None]) -> Any:
        plain = without_contacts(HOIST)
        change(plain)
        return prepare(plain, good)

    runge_kutta = model(lambda m: setattr(m.opt, "integrator", mujoco.mjtIntegrator.mjINT_RK4))
    with pytest.raises(ValueError, match="RK4"):
        sx.put_model(runge_kutta)
    with pytest.raises(ValueError, match="impl must be 'jax'.*sinew.warp"):
        sx.put_model(model(lambda m: None), impl="warp")
    with pytest.raises(ValueError, match="not prepared"):
        sx.put_model(without_contacts(HOIST))
    limited = HOIST.replace('<spatial name="cable">', '<spatial name="cable" actuatorfrclimited="true" actuatorfrcrange="-9 9">')
    with pytest.raises(ValueError, match="tendon cable has a limit"):
        sx.put_model(prepare(without_contacts(limited), good))

    class Forwards:
        """As environments wrap models."""

        def __getattr__(self, name: str) -> Any:
            return getattr(mx, name)

    with pytest.raises(TypeError, match="mx must be a mujoco Model, but is Forwards"):
        sx.step(Forwards(), data, sheaths)
    with pytest.raises(TypeError, match="sheaths must be a sinew Sheaths"):
        sx.step(mx, data, None)
    for changed, part in (
        (mx.tree_replace({"opt.integrator": mjx.IntegratorType.RK4}), "RK4"),
        (mx.tree_replace({"opt.iterations": 4}), "iterations is 4, expected at least 10"),
        (mx.tree_replace({"opt.disableflags": mjx.DisableBit.FRICTIONLOSS}), "frictionloss"),
    ):
        with pytest.raises(ValueError, match=part):
            sx.step(changed, data, sheaths)
    other, _ = sx.put_model(prepare(without_contacts(FINGER), {"*": Sheath(mu=0.1, bend=1.0)}))
    with pytest.raises(ValueError, match="1 tendons, but this one has 3"):
        sx.step(other, mjx.make_data(other), sheaths)


def test_parameters_are_checked_by_name(hoist: tuple[Any, Any, Any]) -> None:
    _, sheaths, _ = hoist
    for wrong, part in (
        ({"friction": 0.1}, "'friction' is no parameter"),
        ({"mu": -0.1}, "mu must be at least zero"),
        ({"efficiency": [1.5]}, "efficiency must be at most 1"),
        ({"mu": np.ones((4, 2))}, r"shape \(1,\) or \(worlds, 1\)"),
    ):
        with pytest.raises(ValueError, match=part):
            sheaths.set(**wrong)
    assert not sheaths.layout.turning and sheaths.set(turning=0.5).layout.turning
    assert sheaths.set(mu=np.ones((4, 1))).axes.mu == 0 and sheaths.axes.mu is None


def test_versions_that_do_not_fit_are_named_and_nothing_is_imported_unless_asked_for(
    hoist: tuple[Any, Any, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    code = "import sys, sinew, sinew.batch; assert not {'jax', 'mujoco.mjx', 'sinew.jax', 'sinew.mjx'} & set(sys.modules)"
    subprocess.run([sys.executable, "-c", code], check=True)
    mx, _, data = hoist
    monkeypatch.setattr(_check, "OF_DATA", ("efc_force", "efc_bound"))
    with pytest.raises(ImportError, match=r"cannot use mujoco-mjx .*, mujoco .*, jax .*Data\._impl\.efc_bound"):
        _check.check_fields(mx, data)
    monkeypatch.setattr(_check, "PARTS", ("solve", "fwd_everything"))
    with pytest.raises(ImportError, match="it has no fwd_everything"):
        _check.connect()
    from sinew.batch import _hoist

    held = [0.0, 3e-4, -3e-4, 0.0]
    assert _hoist.wrong(held) is None
    for k in range(4):
        moved = list(held)
        moved[k] = 1e-3 if k in (0, 3) else 0.0
        assert "must hold at 0.99" in str(_hoist.wrong(moved))
    assert _hoist.GRAVITY == GRAVITY
