"""Sheaths and cables of many worlds in MuJoCo Warp, on the processor, against laws and the plugin in C."""

from __future__ import annotations

import dataclasses
import gc
import json
import os
import subprocess
import sys
from typing import Any

import numpy as np
import pytest

mujoco = pytest.importorskip("mujoco", reason="MuJoCo is not installed")
mjw = pytest.importorskip("mujoco_warp", reason="MuJoCo Warp is not installed: pip install mujoco-warp")
import warp as wp  # noqa: E402

wp.config.log_level = getattr(wp, "LOG_WARNING", 30)
sw = pytest.importorskip("sinew.warp", reason="MuJoCo Warp cannot be used", exc_type=ImportError)
from mujoco_models import FINGER, GRAVITY, HOIST, MASS, WEIGHT  # noqa: E402

import sinew  # noqa: E402
from sinew import batch  # noqa: E402
from sinew import mujoco as sm  # noqa: E402
from sinew.warp import _check  # noqa: E402
from sinew.warp._graph import Graph  # noqa: E402

THETA = 0.6
SHEATH = batch.Sheath(mu=0.2, bend=THETA / 0.2)
STEP = 1e-3
LONG = bool(os.environ.get("SINEW_LONG"))
long = pytest.mark.skipif(not LONG, reason="minutes: SINEW_LONG=1")

pytestmark = pytest.mark.filterwarnings("ignore::DeprecationWarning")


def placed(model: Any, worlds: int, **keywords: Any) -> tuple[Any, Any]:
    """A model of Warp and worlds of it."""
    return mjw.put_model(model), mjw.make_data(model, nworld=worlds, **keywords)


def sheathed(xml: str, sheaths: dict[str, Any], worlds: int) -> tuple[Any, Any, Any]:
    model = batch.prepare(mujoco.MjModel.from_xml_string(xml), sheaths)
    m, d = placed(model, worlds)
    return m, d, sw.Sheaths(model, worlds=worlds).attach(m, d)


@pytest.fixture(scope="module")
def sound() -> None:
    """Skips where this MuJoCo Warp alone, without sheaths, moves equal worlds differently, as 3.6.0 does on a processor."""
    model = mujoco.MjModel.from_xml_string(FINGER)
    m, d = placed(model, 3)
    pull(d, np.tile([10.0, 3.0, 2.0], (3, 1)))
    steps(m, d, 12)
    poses = d.qpos.numpy()
    if np.abs(poses - poses[0]).max() > 1e-4:
        pytest.skip("this MuJoCo Warp moves equal worlds differently, without sheaths as well")


def pull(d: Any, controls: Any) -> None:
    d.ctrl.assign(np.asarray(controls, dtype=np.float32).reshape(d.ctrl.shape))


def steps(m: Any, d: Any, count: int) -> None:
    stepper = Graph(lambda: mjw.step(m, d), None)
    for _ in range(count):
        stepper.launch()


def forgetful(sheaths: Any, m: Any, d: Any) -> Graph:
    """Steps as of the plugin, whose constraints do not begin at the force of the last step."""

    def work() -> None:
        sheaths.reset()
        mjw.step(m, d)

    return Graph(work, None)


def edge(fraction: float, way: float, theta: float = THETA) -> float:
    """A pull at a fraction of an edge of the friction of a hoist."""
    return float(fraction * WEIGHT * np.exp(way * theta))


def test_a_hoist_holds_below_the_edges_of_friction_and_slides_beyond_them_as_the_law_says() -> None:
    pulls = np.array([edge(f, s) for s in (1.0, -1.0) for f in (0.99, 1.01)])
    m, d, _ = sheathed(HOIST, {"*": SHEATH}, 4)
    pull(d, pulls)
    steps(m, d, 20)
    before = d.qvel.numpy()[:, 0].copy()
    steps(m, d, 50)
    after = d.qvel.numpy()[:, 0]
    assert np.abs(after[[0, 3]]).max() < 1e-6
    for world, way in ((1, 1.0), (2, -1.0)):
        expected = (pulls[world] * np.exp(-way * THETA) - WEIGHT) / MASS
        assert (after[world] - before[world]) / (50 * STEP) == pytest.approx(expected, rel=1e-3)


def test_every_world_has_its_own_friction() -> None:
    worlds = 16
    theta = np.linspace(0.06, 1.8, worlds)
    m, d, sheaths = sheathed(HOIST, {"*": SHEATH}, worlds)
    sheaths.set(mu=(theta / SHEATH.bend)[:, np.newaxis])
    pull(d, WEIGHT * np.exp(theta) * 1.05)
    steps(m, d, 10)
    before = d.qvel.numpy()[:, 0].copy()
    steps(m, d, 40)
    gained = (d.qvel.numpy()[:, 0] - before) / (40 * STEP)
    np.testing.assert_allclose(gained, 0.05 * GRAVITY, rtol=1e-3)
    # Within the band all are held, at once and for good.
    pull(d, [WEIGHT] * worlds)
    steps(m, d, 300)
    assert np.abs(d.qvel.numpy()).max() < 1e-6


@pytest.mark.parametrize("seed", range(10 if LONG else 2))
def test_no_world_sees_another_when_some_begin_anew(seed: int, sound: None) -> None:
    worlds, random = 6, np.random.default_rng(seed)
    model = batch.prepare(
        mujoco.MjModel.from_xml_string(FINGER), {"*": batch.Sheath(mu=0.1, bend=4.0, turning=1.0, rise=0.3)}
    )
    mu = random.uniform(0.02, 0.2, (worlds, model.ntendon))
    controls = random.uniform(0.0, 15.0, (8, worlds, model.nu))
    resets = random.random((8, worlds)) < 0.3

    def run(chosen: list[int]) -> np.ndarray:
        m, d = placed(model, len(chosen))
        sheaths = sw.Sheaths(model, worlds=len(chosen)).attach(m, d)
        sheaths.set(mu=mu[chosen])
        for given, anew in zip(controls[:, chosen], resets[:, chosen], strict=True):
            mask = wp.array(anew, dtype=bool)
            mjw.reset_data(m, d, mask)
            sheaths.reset(mask)
            sheaths.set(mu=2.0 * mu[chosen], worlds=mask)
            pull(d, given)
            steps(m, d, 12)
        return np.array(d.qpos.numpy())

    together = run(list(range(worlds)))
    assert resets.any() and not resets.all() and np.abs(together).max() > 0.02
    for world in range(worlds):
        # Constraints of a world are summed in an order that changes: not bit-identical.
        np.testing.assert_allclose(run([world])[0], together[world], atol=2e-5)


def random_model(seed: int) -> tuple[str, dict[str, Any], dict[str, Any]]:
    """A chain of joints with tendons that wrap, contacts, limits, an equality and a coupling, and sheaths."""
    random = np.random.default_rng(seed)
    joints = int(random.integers(2, 5))
    bodies, ends, sites = "", "", []
    for k in range(joints):
        length = random.uniform(0.08, 0.16)
        axis = ("0 1 0", "0 1 0", "1 0 0")[int(random.integers(3))]
        loss = random.choice([0.0, 0.0, 0.002])
        bodies += f"""<body pos="{0.0 if k == 0 else length:.3f} 0 0"><joint name="j{k}" axis="{axis}" damping=".02" armature=".001"
 frictionloss="{loss}" range="-1 1" limited="true"/><geom type="capsule" size=".012" fromto="0 0 0 {length:.3f} 0 0" mass="{random.uniform(0.1, 0.4):.3f}"/>
 <geom name="w{k}" type="cylinder" size=".014 .02" zaxis="0 1 0" contype="0" conaffinity="0"/>
 <site name="u{k}" pos="{0.6 * length:.3f} 0 .03"/><site name="d{k}" pos="{0.6 * length:.3f} 0 -.03"/><site name="s{k}" pos="0 0 .02"/>"""
        ends += "</body>"
        sites.append(k)
    tendons, actuators, names = "", "", []
    for k in range(joints):
        for side in "ud":
            wrap = f'<geom geom="w{k}" sidesite="s{k}"/>' if side == "u" else ""
            name = f"{side}{k}_t"
            first = f"r{side}" if k == 0 else f"{side}{k - 1}"
            tendons += f'<spatial name="{name}" frictionloss="{random.choice([0.0, 0.05])}"><site site="{first}"/>{wrap}<site site="{side}{k}"/></spatial>'
            extra = random.choice(["", ' forcerange="0 12"'])
            actuators += f'<motor tendon="{name}" gear="-1"{extra}/>'
            names.append(name)
    tendons += f'<fixed name="mix"><joint joint="j0" coef=".02"/><joint joint="j{joints - 1}" coef="-.015"/></fixed>'
    actuators += '<motor tendon="mix" gear="2"/>'
    names.append("mix")
    equality = '<equality><tendon tendon1="mix" polycoef="0 0 0 0 0" solref=".05 1"/></equality>' if seed % 5 == 4 else ""
    xml = f"""<mujoco><compiler angle="radian"/><option timestep=".001" integrator="{random.choice(["Euler", "implicitfast"])}"/>
<worldbody><geom type="plane" size="1 1 .1" pos="0 0 -.12"/><site name="ru" pos="-.05 0 .03"/><site name="rd" pos="-.05 0 -.03"/>{bodies}{ends}</worldbody>
<tendon>{tendons}</tendon><actuator>{actuators}</actuator>{equality}</mujoco>"""
    sheaths = {
        name: batch.Sheath(
            mu=float(random.choice([0.0, random.uniform(0.02, 0.25)])),
            bend=float(random.uniform(0.0, 5.0)),
            turning=float(random.choice([0.0, 1.0])),
            efficiency=float(random.uniform(0.9, 1.0)),
            pretension=float(random.choice([0.0, 1.0])),
            rise=float(random.choice([0.0, 0.4])),
        )
        for name in names
    }
    return xml, sheaths, {"names": names}


def beside_c(seed: int, seconds: float, sheathed: bool = True) -> tuple[float, float]:
    """Largest distance of positions from those of MuJoCo in C, with the plugin or without sheaths in both, and that of C from
    itself, started by up to 1e-7 off and pulled by up to a millionth more or less, the farthest of eight."""
    xml, sheaths, _ = random_model(seed)
    spec = mujoco.MjSpec.from_string(xml)
    model = mujoco.MjModel.from_xml_string(xml)
    if sheathed:
        sm.add_sheaths(spec, sheaths)
        model = batch.prepare(model, sheaths)
    in_c = spec.compile()
    random, far, own = np.random.default_rng(seed), 0.0, 0.0
    data, nudged = mujoco.MjData(in_c), [mujoco.MjData(in_c) for _ in range(8)]
    nudges = np.random.default_rng(seed).uniform(-1.0, 1.0, (8, 2))
    for one, (start, _) in zip(nudged, nudges, strict=True):
        one.qpos += 1e-7 * start
    m, d = placed(model, 1, njmax=96, naconmax=64)
    stepper = Graph(lambda: mjw.step(m, d), None)
    if sheathed:
        stepper = forgetful(sw.Sheaths(model, worlds=1).attach(m, d), m, d)
    for k in range(int(seconds / STEP)):
        if k % 50 == 0:
            # Negative pulls and slack tendons among them.
            given = random.uniform(-3.0, 15.0, model.nu)
            data.ctrl[:] = given
            for one, (_, more) in zip(nudged, nudges, strict=True):
                one.ctrl[:] = (1.0 + 1e-6 * more) * given
            pull(d, given)
        for one in (data, *nudged):
            mujoco.mj_step(in_c, one)
        stepper.launch()
        if k % 10 == 9:
            far = max(far, float(np.abs(d.qpos.numpy()[0] - data.qpos).max()))
            own = max(own, *(float(np.abs(one.qpos - data.qpos).max()) for one in nudged))
    assert np.isfinite(far)
    return far, own


@pytest.mark.parametrize("seed", range(3))
def test_random_models_of_tendons_move_as_with_the_plugin(seed: int, sound: None) -> None:
    far, own = beside_c(seed, 0.1)
    assert far < 1e-4 + 10.0 * own, (far, own)


@long
def test_fifty_random_models_of_tendons_move_as_with_the_plugin_for_half_a_second(sound: None) -> None:
    seen = [beside_c(seed, 0.5) for seed in range(50)]
    far = np.array([one for one, _ in seen])
    print("\nfar from the plugin, rad:", np.sort(far))
    assert np.median(far) < 1e-5 and (far < 1e-3).mean() > 0.9
    # Where contacts, stops and sticking amplify, the plugin leaves itself as well.
    for seed, (off, own) in enumerate(seen):
        if off > 5e-4 + 10.0 * own:
            plain, _ = beside_c(seed, 0.5, sheathed=False)
            assert plain > 0.5 * off, f"model {seed}: {off:.1e} rad, the plugin from itself {own:.1e}, without sheaths {plain:.1e}"


def test_the_arm_moves_as_with_the_plugin_and_friction_gives_no_work_back(sound: None) -> None:
    seconds = 1.0 if LONG else 0.3
    plugin = sm.load("lm_arm", transmission="sheaths")
    data = mujoco.MjData(plugin)
    mujoco.mj_resetDataKeyframe(plugin, data, 0)
    model = batch.prepare(sm.load("lm_arm", transmission="none"), sm.sheaths_of("lm_arm"))
    start = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, start, 0)
    m, d = mjw.put_model(model), mjw.put_data(model, start, nworld=1)
    stepper = forgetful(sw.Sheaths(model, worlds=1).attach(m, d), m, d)
    random, lost, back = np.random.default_rng(3), 0.0, 0.0
    for k in range(int(seconds / STEP)):
        if k % 50 == 0:
            given = random.uniform(5.0, 60.0, model.nu)
            data.ctrl[:] = given
            pull(d, given)
        before = d.qvel.numpy()[0].astype(float)
        mujoco.mj_step(plugin, data)
        stepper.launch()
        # Work of every tendon's friction in the step, J, with the mean of the velocities at its ends.
        count = int(d.nefc.numpy()[0])
        rows = d.efc.type.numpy()[0, :count] == int(mujoco.mjtConstraint.mjCNSTR_FRICTION_TENDON)
        jacobian = d.efc.J.numpy()[0][:count, : model.nv][rows]
        work = d.efc.force.numpy()[0, :count][rows] * (jacobian @ (0.5 * (before + d.qvel.numpy()[0]))) * STEP
        lost, back = lost - work[work < 0.0].sum(), back + work[work > 0.0].sum()
    assert np.abs(d.qpos.numpy()[0] - data.qpos).max() < 1e-4
    assert lost > 0.5 * seconds and back < 1e-3 * lost, (lost, back)


def test_slack_tendons_negative_pulls_and_zero_friction_are_as_without_sheaths() -> None:
    m, d, _ = sheathed(HOIST, {"*": SHEATH}, 3)
    pull(d, [0.0, -20.0, 20.0])
    steps(m, d, 20)
    # With a cable that pushes there is no friction; with one that pulls less than the band holds, it pulls more.
    speed = d.qvel.numpy()[:, 0] / (20 * STEP)
    held = 20.0 * np.exp(THETA)
    np.testing.assert_allclose(speed, [-GRAVITY, -GRAVITY - 4.0, (held - WEIGHT) / MASS], rtol=1e-3)
    m, d, _ = sheathed(HOIST, {"*": batch.Sheath(mu=0.0, bend=5.0)}, 1)
    pull(d, [60.0])
    steps(m, d, 20)
    assert d.qvel.numpy()[0, 0] / (20 * STEP) == pytest.approx(60.0 / MASS - GRAVITY, rel=1e-4)


def test_limits_of_forces_apply_before_friction_and_pretension_behind_it() -> None:
    limited = HOIST.replace('gear="-1"', 'gear="-1" forcerange="0 120"')
    m, d, _ = sheathed(limited, {"*": dataclasses.replace(SHEATH, pretension=10.0)}, 1)
    pull(d, [500.0])
    steps(m, d, 20)
    expected = (120.0 * np.exp(-THETA) + 10.0 - WEIGHT) / MASS
    assert d.qvel.numpy()[0, 0] / (20 * STEP) == pytest.approx(expected, rel=1e-3)


def test_models_side_by_side_have_their_own_sheaths_and_others_their_own_callbacks() -> None:
    called: list[int] = []
    strong = batch.prepare(mujoco.MjModel.from_xml_string(HOIST), {"*": SHEATH})
    weak = batch.prepare(mujoco.MjModel.from_xml_string(HOIST), {"*": dataclasses.replace(SHEATH, mu=0.0)})
    plain = mujoco.MjModel.from_xml_string(HOIST)
    all_of = [placed(model, 1) for model in (strong, weak, plain)]
    all_of[0][0].callback.act_bias = lambda m, d: called.append(d.nworld)
    kept = [sw.Sheaths(model, worlds=1).attach(*all_of[k]) for k, model in ((0, strong), (1, weak))]
    # A callback that several models share is called with each of them.
    all_of[2][0].callback = all_of[1][0].callback
    for m, d in all_of:
        pull(d, [60.0])
        for _ in range(10):
            # Not from a graph, which calls nothing of Python.
            mjw.step(m, d)
    speeds = [float(d.qvel.numpy()[0, 0]) for _, d in all_of]
    assert abs(speeds[0]) < 1e-6 and called == [1] * 10
    assert speeds[1] == pytest.approx(speeds[2], rel=1e-4) and speeds[2] > 0.01
    m, d = all_of[0][0], mjw.make_data(strong, nworld=2)
    with pytest.raises(RuntimeError, match="attach them to it as well"):
        mjw.step(m, d)
    sw.Sheaths(strong, worlds=2).attach(m, d)
    pull(d, [60.0, 150.0])
    steps(m, d, 10)
    assert abs(d.qvel.numpy()[0, 0]) < 1e-6 < d.qvel.numpy()[1, 0]
    kept[1].detach()
    gc.collect()


def test_a_model_that_was_not_prepared_becomes_so_where_it_is_attached() -> None:
    # As Newton has it, which makes its model of Warp on its own.
    limited = HOIST.replace('gear="-1"', 'gear="-1" forcerange="0 120"')
    own = mujoco.MjModel.from_xml_string(limited)
    model = batch.prepare(own, {"*": SHEATH})
    m, d = mjw.put_model(own), mjw.make_data(own, nworld=1, njmax=16)
    sw.Sheaths(model, worlds=1).attach(m, d)
    pull(d, [60.0])
    steps(m, d, 10)
    assert abs(d.qvel.numpy()[0, 0]) < 1e-6


def test_what_does_not_fit_is_refused_by_name() -> None:
    model = batch.prepare(mujoco.MjModel.from_xml_string(HOIST), {"*": SHEATH})
    m, d = placed(model, 2)
    with pytest.raises(ValueError, match="not prepared"):
        sw.Sheaths(mujoco.MjModel.from_xml_string(HOIST), worlds=2)
    with pytest.raises(ValueError, match="worlds must be a whole number"):
        sw.Sheaths(model, worlds=0)
    with pytest.raises(ValueError, match="made for 3 worlds, but there are 2"):
        sw.Sheaths(model, worlds=3).attach(m, d)
    finger = batch.prepare(mujoco.MjModel.from_xml_string(FINGER), {"*": SHEATH})
    with pytest.raises(ValueError, match="made for 3 tendons, but there are 1"):
        sw.Sheaths(finger, worlds=2).attach(m, d)
    sheaths = sw.Sheaths(model, worlds=2).attach(m, d)
    with pytest.raises(ValueError, match="attached already"):
        sheaths.attach(m, d)
    for wrong, reason in [
        ({"mu": -0.1}, "mu must be at least zero"),
        ({"friction": 0.1}, "'friction' is no parameter"),
        ({"mu": np.ones((3, 1))}, r"fits \(2, 1\), but is of \(3, 1\)"),
        ({"mu": wp.zeros((3, 1), dtype=float)}, r"shape \(1 or 2, 1\)"),
        ({"mu": 0.1, "worlds": [True]}, r"worlds must be 2 booleans, but is bool of shape \(1,\)"),
    ]:
        with pytest.raises(ValueError, match=reason):
            sheaths.set(**wrong)
    m.opt.iterations = 4
    with pytest.raises(ValueError, match="iterations is 4"):
        sw.Sheaths(model, worlds=2).attach(m, d)


def test_a_tendon_gets_sheaths_or_cables_once() -> None:
    model = batch.prepare(mujoco.MjModel.from_xml_string(HOIST), {"*": SHEATH})
    m, d = placed(model, 1)
    first = sw.Sheaths(model, worlds=1).attach(m, d)
    for second in (sw.Sheaths(model, worlds=1), sw.Cables(model, {"*": CABLE}, worlds=1)):
        with pytest.raises(ValueError, match="tendon cable has its Sheaths attached already"):
            second.attach(m, d)
    first.detach()
    sw.Cables(model, {"*": CABLE}, worlds=1).attach(m, d)
    with pytest.raises(ValueError, match="tendon cable has its Cables attached already"):
        sw.Sheaths(model, worlds=1).attach(m, d)


def test_versions_that_do_not_fit_are_named_and_nothing_is_imported_unless_asked_for(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    code = "import sys, sinew, sinew.mujoco; assert not {'warp', 'mujoco_warp', 'sinew.warp', 'sinew.batch'} & set(sys.modules)"
    subprocess.run([sys.executable, "-c", code], check=True)
    monkeypatch.setattr(_check, "version", lambda package: {"mujoco-warp": "3.5.0.2", "warp-lang": "1.12.0"}[package])
    with pytest.raises(ImportError, match=r"needs MuJoCo Warp 3\.6 or newer, but it is 3\.5\.0\.2 \(Warp 1\.12\.0\)"):
        _check.connect()
    # A version whose forces do not come from where ours are written.
    monkeypatch.setattr(_check, "version", lambda package: {"mujoco-warp": "9.1.0", "warp-lang": "8.0"}[package])
    monkeypatch.setattr(sw.Sheaths, "act", lambda *_: None)
    _check.hoist_holds_and_slides.cache_clear()
    with pytest.raises(ImportError, match=r"mujoco-warp 9\.1\.0 and warp-lang 8\.0: a hoist must hold at 0\.99"):
        _check.hoist_holds_and_slides()


PATH = [sinew.Free(0.15), sinew.Sheath(0.8, 3.0), sinew.Free(0.25)]
CABLE = batch.Cable(
    PATH, friction=0.12, compliance_per_n=1e-4, drag_n_s_per_m=20.0, viscous_s_per_m=0.05, pretension_n=2.0, start_n=30.0
)


def drive_cable(cables: Any, motor: np.ndarray, anchor: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Tensions at the winch and the anchor of the first cable of all worlds, and those of the cells of the first world's, N;
    its winch and length as given, m, per step."""
    from sinew.warp import _cable_kernels as kernels

    worlds = cables._worlds
    shape = (worlds, 1)
    ctrl, length, force = (wp.zeros(shape, dtype=float) for _ in range(3))
    act, timestep = wp.zeros((worlds, 0), dtype=float), wp.array([STEP], dtype=float)
    wiring = [cables._tendon, cables._actuator, cables._control, cables._activation, cables._gear]
    near, far, cells = [], [], []
    for moved, away in zip(motor, anchor, strict=True):
        ctrl.fill_(float(moved))
        length.fill_(float(away))
        inputs = [cables._law, cables._state, *wiring, 1, timestep, ctrl, act, length, force]
        wp.launch(kernels.pull, dim=shape, inputs=inputs)
        near.append(cables.tension_in[:, 0].astype(float))
        far.append(cables.tension_out[:, 0].astype(float))
        cells.append(cables._state.tension.numpy()[:, 0, 0].astype(float))
    return np.array(near), np.array(far), np.array(cells)


def bench_cable(**changed: float) -> Any:
    """The cable of the bench."""
    known = json.loads(sinew._sinew.Cable.bench_parameters())
    numbers = {key: value for key, value in known.items() if key != "weakening"}
    return batch.Cable(PATH, **numbers | {"start_n": 40.0} | changed)


@pytest.mark.parametrize("seed", range(3))
def test_a_cable_pulls_as_the_law_of_the_library_and_creates_no_energy(seed: int) -> None:
    random, n = np.random.default_rng(seed), 3000
    t, cable = np.arange(n) * STEP, bench_cable()
    waves = [
        sum(
            size * np.sin(rate * t + phase)
            for size, rate, phase in zip(
                random.uniform(low, high, count), random.uniform(2.0, 15.0, count), random.uniform(0.0, 6.0, count), strict=True
            )
        )
        for low, high, count in ((2.0, 12.0, 3), (1.0, 4.0, 2))
    ]
    # In units of what a newton stretches.
    motor, anchor = (cable.compliance_per_n * 1.2 * (wave - wave[0]) for wave in waves)
    motor, length = motor.astype(np.float32), (1.0 - anchor).astype(np.float32)
    cables = sw.Cables(mujoco.MjModel.from_xml_string(HOIST), {"*": cable}, worlds=1)
    near, far, tensions = drive_cable(cables, motor, length)
    parameters = {key: value for key, value in cable._numbers().items() if key != "start_n"}
    law = sinew.Cable(PATH, cells=12, **parameters)
    assert far[0, 0] == pytest.approx(law.settle(40.0).tension_out, rel=1e-6)
    moves = np.diff(motor.astype(float)), -np.diff(length.astype(float))
    out = np.array([law.step(STEP, *move).tension_out for move in zip(*moves, strict=True)])
    # The start is on the edge of the band, where rounding decides between sticking and sliding.
    off = (far[1:, 0] - out)[100:]
    assert np.ptp(out) > 15.0
    assert np.sqrt(np.mean(off**2)) < 1e-3 and np.abs(far[1:, 0] - out).max() < 3.0
    energy = 0.5 * (law.law["compliance"] * tensions**2).sum(axis=1)
    lost = near[1:, 0] * moves[0] - (far[1:, 0] - cable.pretension_n) * moves[1] - np.diff(energy)
    assert lost.sum() > 0.05 and -lost[lost < 0.0].sum() < 1e-6, (lost.sum(), lost[lost < 0.0].sum())


def test_cables_of_worlds_have_their_own_friction_and_begin_anew_alone() -> None:
    cables = sw.Cables(mujoco.MjModel.from_xml_string(HOIST), {"*": CABLE}, worlds=3)
    cables.set(friction=[[0.0], [1.0], [1.5]], drag=0.0)
    motor = np.linspace(0.0, 0.004, 200)
    near, far, _ = drive_cable(cables, motor, np.ones(200))
    # Steady pull: the ratio of the tensions is the angle of friction.
    np.testing.assert_allclose(np.log(near[-1] / (far[-1] - 2.0))[1:], [0.36, 0.54], rtol=0.02)
    assert np.log(near[-1, 0] / (far[-1, 0] - 2.0)) < 2e-2
    cables.set(start_n=50.0, worlds=[False, True, False])
    cables.reset(np.array([False, True, False]))
    _, after, _ = drive_cable(cables, motor[-1:], np.ones(1))
    assert after[0, 1] == pytest.approx(50.0, rel=1e-5)
    assert np.abs(after[0, [0, 2]] - far[-1, [0, 2]]).max() < 0.5


def test_a_weight_on_cables_moves_as_with_the_plugin() -> None:
    spec = mujoco.MjSpec.from_string(HOIST)
    hung = bench_cable(start_n=WEIGHT)
    sm.add_cables(spec, {"*": hung}, damp=False)
    plugin = spec.compile()
    data = mujoco.MjData(plugin)
    model = mujoco.MjModel.from_xml_string(HOIST)
    m, d = placed(model, 2)
    sw.Cables(model, {"*": hung}, worlds=2).attach(m, d)
    for k in range(300):
        data.ctrl[:] = 0.004 * np.sin(0.02 * k)
        pull(d, [data.ctrl[0]] * 2)
        mujoco.mj_step(plugin, data)
        mjw.step(m, d)
    assert np.abs(data.qpos[0]) > 5e-4
    np.testing.assert_allclose(d.qpos.numpy()[:, 0], data.qpos[0], atol=4e-5)


def test_cables_that_cannot_be_are_refused_with_the_cure() -> None:
    model = mujoco.MjModel.from_xml_string(HOIST)
    model.opt.timestep = 5e-3
    stiff = dataclasses.replace(CABLE, compliance_per_n=5e-6)
    with pytest.raises(ValueError, match=r"dt sqrt\(k/m\) = .*sinew\.batch\.damp"):
        sw.Cables(model, {"*": stiff}, worlds=1)
    damped = batch.damp(model, {"*": stiff})
    sw.Cables(damped, {"*": stiff}, worlds=1)
    assert damped.opt.integrator == mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    runge = mujoco.MjModel.from_xml_string(HOIST)
    runge.opt.integrator = mujoco.mjtIntegrator.mjINT_RK4
    with pytest.raises(ValueError, match="RK4"):
        sw.Cables(runge, {"*": CABLE}, worlds=1).attach(*placed(runge, 1))
    with pytest.raises(ValueError, match="'rope' fits no tendon"):
        sw.Cables(mujoco.MjModel.from_xml_string(HOIST), {"rope": CABLE}, worlds=1)
    with pytest.raises(ValueError, match="dynamics of its own"):
        sw.Cables(mujoco.MjModel.from_xml_string(FINGER), {"flexor": CABLE}, worlds=1)


@pytest.mark.parametrize("transmission", ["cables", "sheaths"])
def test_a_machine_of_the_library_moves_as_with_the_plugin_and_begins_anew_by_a_mask(
    transmission: Any, sound: None
) -> None:
    plugin = sm.load("lm_arm", transmission=transmission)
    data, nudged = mujoco.MjData(plugin), mujoco.MjData(plugin)
    for one in (data, nudged):
        mujoco.mj_resetDataKeyframe(plugin, one, 0)
    nudged.qpos += 1e-7
    machines = sw.load("lm_arm", worlds=2, transmission=transmission)
    start = np.array(data.qpos)
    np.testing.assert_allclose(machines.d.qpos.numpy(), [start, start], atol=1e-6)
    random = np.random.default_rng(2)
    for k in range(100):
        if k % 25 == 0:
            low, high = (-1e-3, 2e-3) if transmission == "cables" else (5.0, 60.0)
            data.ctrl[:] = nudged.ctrl[:] = random.uniform(low, high, plugin.nu)
            pull(machines.d, np.tile(data.ctrl, (2, 1)))
        mujoco.mj_step(plugin, data)
        mujoco.mj_step(plugin, nudged)
        if transmission == "sheaths":
            # The plugin does not begin at the force of the last step.
            machines.transmission.reset()
        machines.step()
    off, own = (np.abs(found - data.qpos).max() for found in (machines.d.qpos.numpy(), nudged.qpos))
    # Cables begin on the edge of their friction, where the last digit decides: the plugin leaves itself as well.
    assert np.abs(data.qpos - start).max() > 5e-3 and off < 1e-4 + 5.0 * own, (off, own)
    moved = machines.d.qpos.numpy()[0].copy()
    machines.reset(np.array([False, True]))
    after = machines.d.qpos.numpy()
    np.testing.assert_array_equal(after[0], moved)
    np.testing.assert_allclose(after[1], start, atol=1e-6)


@pytest.mark.skipif(
    not (wp.get_device().is_cuda or hasattr(wp, "capture_save")), reason="this Warp captures on CUDA devices alone"
)
@pytest.mark.parametrize("transmission", ["cables", "sheaths"])
def test_a_machine_steps_in_a_graph_and_is_changed_and_begins_anew_between_replays(transmission: Any) -> None:
    plain, captured = (sw.load("lm_arm", worlds=4, transmission=transmission) for _ in range(2))
    mask, random = wp.array([True, False, True, False], dtype=bool), np.random.default_rng(6)
    factors = wp.array(random.uniform(0.05, 0.3, (4, len(plain.transmission.names))), dtype=float)
    name = "friction" if transmission == "cables" else "mu"
    low, high = (-1e-3, 2e-3) if transmission == "cables" else (5.0, 60.0)

    def anew(machines: Any) -> None:
        machines.reset(mask)
        machines.transmission.set(worlds=mask, **{name: factors})

    graphs = []
    for work in (captured.step, lambda: anew(captured)):
        work()
        with wp.ScopedCapture() as capture:
            work()
        graphs.append(capture.graph)
    captured.transmission.set(**{name: 0.1})
    plain.transmission.set(**{name: 0.1})
    captured.reset()
    for k in range(60):
        if k % 20 == 0:
            given = random.uniform(low, high, plain.d.ctrl.shape)
            pull(plain.d, given)
            pull(captured.d, given)
        if k == 30:
            anew(plain)
            wp.capture_launch(graphs[1])
        plain.step()
        wp.capture_launch(graphs[0])
    found = captured.d.qpos.numpy()
    np.testing.assert_array_equal(found, plain.d.qpos.numpy())
    assert np.abs(found[0] - found[1]).max() > 1e-4
