"""Friction of sheaths in MuJoCo models, against exact laws."""

from __future__ import annotations

import os
import subprocess
import sys
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

mujoco = pytest.importorskip("mujoco", reason="MuJoCo is not installed")

sm = pytest.importorskip("sinew.mujoco", reason="MuJoCo cannot be used", exc_type=ImportError)
import mujoco_models as models  # noqa: E402
from mujoco_models import FINGER, GRAVITY, HOIST, MASS, WEIGHT, drive  # noqa: E402

import sinew  # noqa: E402
from sinew.mujoco import _layout  # noqa: E402

if not hasattr(mujoco.MjsPlugin, "config"):
    pytest.skip(f"MuJoCo {mujoco.__version__} configures plugins in XML alone", allow_module_level=True)


def sheathed(xml: str, sheaths: dict[str, Any], **keywords: Any) -> tuple[Any, Any]:
    spec = mujoco.MjSpec.from_string(xml)
    sm.add_sheaths(spec, sheaths, **keywords)
    model = spec.compile()
    return model, mujoco.MjData(model)


def finger() -> tuple[Any, Any]:
    return sheathed(
        FINGER, {"*": sm.Sheath(mu=0.1, bend=4.0, turning=1.0), "tip": sm.Sheath(mu=0.2, bend=1.0, rise=0.3)}
    )


def test_the_layout_is_compared_with_memory_in_a_moment() -> None:
    # What comes on top of `import sinew` and `import mujoco`, in processor time: 30 to 60 ms.
    code = "import mujoco, time, sinew; t = time.process_time(); import sinew.mujoco; print(time.process_time() - t)"
    runs = [subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True) for _ in range(5)]
    assert min(float(run.stdout) for run in runs) < 0.25
    assert _layout.Layout().check(mujoco) > 350


def test_a_layout_that_does_not_fit_is_refused_by_field() -> None:
    for name in ("actuator_force", "time", "nefc"):
        layout = _layout.Layout()
        place = layout.data[name]
        layout.data[name] = place._replace(offset=place.offset + 8)
        with pytest.raises(_layout.Mismatch, match=f"mjData.{name}"):
            layout.check(mujoco)


INTEGRATORS = ["mjINT_EULER", "mjINT_RK4", "mjINT_IMPLICIT", "mjINT_IMPLICITFAST"]
SOLVERS = ["mjSOL_NEWTON", "mjSOL_CG", "mjSOL_PGS"]


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize("angle", [0.05, 0.6, 2.0])
def test_the_band_of_sticking_has_exact_edges(angle: float, integrator: str, solver: str) -> None:
    model, data = sheathed(HOIST, {"cable": sm.Sheath(mu=angle / 2.0, bend=2.0)})
    model.opt.integrator = getattr(mujoco.mjtIntegrator, integrator)
    model.opt.solver = getattr(mujoco.mjtSolver, solver)
    for sign in (1.0, -1.0):
        for inside in (0.99, 1.01):
            mujoco.mj_resetData(model, data)
            tension = WEIGHT * np.exp(sign * angle) * inside
            data.ctrl[0] = tension
            for _ in range(50):
                mujoco.mj_step(model, data)
            slides = tension * np.exp(-sign * angle) - WEIGHT
            if sign * slides > 0.0:
                assert data.qacc[0] == pytest.approx(slides / MASS, rel=1e-4)
            else:
                # A cable that is held creeps, see `add_sheaths`.
                creep = 0.005 * model.opt.timestep * abs(tension * np.cosh(angle) - WEIGHT) / MASS
                assert abs(data.qacc[0]) < 1e-3 and abs(data.qvel[0]) < 1.1 * creep + 1e-6


def test_islands_make_no_difference() -> None:
    seen = []
    for islands in (True, False):
        model, data = sheathed(HOIST, {"cable": sm.Sheath(mu=0.2, bend=3.0)})
        bits = getattr(mujoco.mjtDisableBit, "mjDSBL_ISLAND", None)
        if bits is None:
            pytest.skip("this version has no islands")
        model.opt.disableflags = 0 if islands else int(bits)
        seen.append(drive(model, data, 200))
    np.testing.assert_allclose(*seen, atol=1e-12)


def stick_slip(pull: np.ndarray, step: float, angle: float) -> np.ndarray:
    """Positions of the hoist, integrated exactly between events on a grid 50 times finer: an independent reference."""
    fine, x, v, seen = 50, 0.0, 0.0, []
    h = step / fine
    for tension in pull:
        seen.append(x)
        for _ in range(fine):
            up, down = tension * np.exp(-angle) - WEIGHT, tension * np.exp(angle) - WEIGHT
            if v == 0.0:
                force = up if up > 0.0 else min(down, 0.0)
            else:
                force = up if v > 0.0 else down
            a = force / MASS
            after = v + a * h
            if v * after < 0.0:  # it stops within the grid step
                x, v = x - 0.5 * v * v / a, 0.0
            else:
                x, v = x + v * h + 0.5 * a * h * h, after
    return np.array(seen)


@pytest.mark.parametrize(("excess", "frequency"), [(0.084, 0.5), (0.05, 0.3), (0.15, 1.0)])
@pytest.mark.parametrize("integrator", ["mjINT_EULER", "mjINT_RK4"])
def test_stick_and_slip_follow_an_independent_reference(excess: float, frequency: float, integrator: str) -> None:
    angle, step = 0.6, 1e-3
    # Up and down beyond both edges of the band, four seconds.
    pull = WEIGHT * np.exp((angle + excess) * np.sin(2.0 * np.pi * frequency * step * np.arange(4000)))
    exact = stick_slip(pull, step, angle)
    model, data = sheathed(HOIST, {"cable": sm.Sheath(mu=angle / 3.0, bend=3.0)})
    model.opt.integrator = getattr(mujoco.mjtIntegrator, integrator)
    seen = []
    for tension in pull:
        data.ctrl[0] = tension
        # Positions of MuJoCo's Euler lead by half a step of the speed, with and without friction.
        lead = 0.5 * step * data.qvel[0] if integrator == "mjINT_EULER" else 0.0
        seen.append(data.qpos[0] - lead)
        mujoco.mj_step(model, data)
    assert 0.03 < np.ptp(exact) < 0.07
    assert np.abs(np.array(seen) - exact).max() < 0.1e-3


def friction_work(model: Any, data: Any, steps: int) -> tuple[float, float]:
    """Work that friction of all tendons took, and what of it it gave back, J."""
    taken = given_back = 0.0
    kind = mujoco.mjtConstraint.mjCNSTR_FRICTION_TENDON
    random = np.random.default_rng(3)
    for k in range(steps):
        if k % 50 == 0:
            data.ctrl[:] = random.uniform(0.0, 15.0, model.nu)
        mujoco.mj_step1(model, data)
        before = np.array(data.qvel)
        mujoco.mj_step2(model, data)
        rows = np.flatnonzero(np.array(data.efc_type) == kind)
        jacobian = np.zeros((data.nefc, model.nv))
        if mujoco.mj_isSparse(model):
            mujoco.mju_sparse2dense(jacobian, data.efc_J, data.efc_J_rownnz, data.efc_J_rowadr, data.efc_J_colind)
        else:
            jacobian[:] = data.efc_J.reshape(data.nefc, model.nv)
        speed = jacobian[rows] @ (0.5 * (before + data.qvel))
        work = -(data.efc_force[rows] * speed) * model.opt.timestep
        taken += work.clip(min=0.0).sum()
        given_back -= work.clip(max=0.0).sum()
    return taken, given_back


@pytest.mark.parametrize(("implicit", "fraction"), [(False, 4e-4), (True, 2.5e-3)])
def test_friction_gives_no_work_back(implicit: bool, fraction: float) -> None:
    model, data = finger()
    if not implicit:
        model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_EULERDAMP)
    # Where MuJoCo integrates damping of joints implicitly, its constraints do not know; these joints are light and damped.
    taken, given_back = friction_work(model, data, 4000)
    assert taken > 0.1
    assert given_back <= fraction * taken


def test_the_force_behind_the_sheath_is_within_the_band_for_any_tension() -> None:
    model, data = finger()
    random = np.random.default_rng(5)
    kind = mujoco.mjtConstraint.mjCNSTR_FRICTION_TENDON
    seen = 0
    for _ in range(500):
        data.ctrl[:] = random.uniform(0.0, 15.0, model.nu)
        mujoco.mj_step(model, data)
        mujoco.mj_forward(model, data)
        for row in np.flatnonzero(np.array(data.efc_type) == kind):
            tendon, force = int(data.efc_id[row]), float(data.efc_force[row])
            bound = float(data.efc_frictionloss[row])
            mean = -sum(
                data.actuator_force[k] * model.actuator_gear[k, 0]
                for k in range(model.nu)
                if model.actuator_trnid[k, 0] == tendon
            )
            assert abs(force) <= bound + 1e-9
            if mean > 1e-6:
                # mean = T cosh theta and bound = T sinh theta: the ratio of far to near tension is within exp(+-theta).
                tension = np.sqrt(mean**2 - (bound - 1e-9) ** 2)
                angle = np.arctanh((bound - 1e-9) / mean)
                far = mean + force
                assert tension * np.exp(-angle) - 1e-6 <= far <= tension * np.exp(angle) + 1e-6
                seen += 1
    assert seen > 400


def test_the_turning_of_a_path_counts_as_its_arc() -> None:
    model, data = sheathed(FINGER, {"extensor": sm.Sheath(mu=0.3, bend=0.0, turning=1.0)})
    data.qpos[:] = [0.7, 0.5, 0.0]
    data.ctrl[1] = 10.0
    mujoco.mj_forward(model, data)
    tendon = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_TENDON, "extensor")
    first, count = int(data.ten_wrapadr[tendon]), int(data.ten_wrapnum[tendon])
    points = np.array(data.wrap_xpos).reshape(-1, 3)[first : first + count]
    pieces = np.diff(points, axis=0)
    pieces = pieces[np.linalg.norm(pieces, axis=1) > 1e-12]
    cosines = [a @ b / np.linalg.norm(a) / np.linalg.norm(b) for a, b in zip(pieces, pieces[1:], strict=False)]
    turning = np.arccos(np.clip(cosines, -1.0, 1.0)).sum()
    assert turning > 0.5
    assert data.actuator_force[1] == pytest.approx(10.0 * np.cosh(0.3 * turning), rel=1e-9)


def test_an_actuator_that_pushes_has_no_friction() -> None:
    model, data = sheathed(HOIST, {"cable": sm.Sheath(mu=0.2, bend=3.0)})
    data.ctrl[0] = -10.0
    mujoco.mj_forward(model, data)
    assert data.actuator_force[0] == -10.0
    assert data.qacc[0] == pytest.approx(-(10.0 + WEIGHT) / MASS, rel=1e-6)


def test_without_friction_constraints_there_is_no_friction_at_all() -> None:
    model, data = sheathed(HOIST, {"cable": sm.Sheath(mu=0.2, bend=3.0)})
    model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_FRICTIONLOSS)
    data.ctrl[0] = 60.0
    mujoco.mj_forward(model, data)
    assert data.actuator_force[0] == 60.0
    assert data.qacc[0] == pytest.approx((60.0 - WEIGHT) / MASS, rel=1e-9)


def test_sheaths_are_added_to_attached_models() -> None:
    hall, part = mujoco.MjSpec(), mujoco.MjSpec.from_string(HOIST)
    hall.option.timestep = part.option.timestep
    hall.attach(part, prefix="left:", frame=hall.worldbody.add_frame())
    assert sm.add_sheaths(hall, {"left:*": sm.Sheath(mu=0.2, bend=3.0)}) == ["left:cable"]
    model = hall.compile()
    data = mujoco.MjData(model)
    data.ctrl[0] = 60.0
    mujoco.mj_forward(model, data)
    assert data.actuator_force[0] == pytest.approx(60.0 * np.cosh(0.6))


def test_the_limits_of_a_force_hold_before_the_sheath() -> None:
    limited = HOIST.replace('gear="-1"', 'gear="-1" forcerange="0 80"')
    model, data = sheathed(limited, {"cable": sm.Sheath(mu=0.2, bend=3.0)})
    data.ctrl[0] = 500.0
    mujoco.mj_forward(model, data)
    assert data.actuator_force[0] == pytest.approx(80.0 * np.cosh(0.6), rel=1e-12)


def test_a_pretension_adds_to_the_far_end() -> None:
    model, data = sheathed(HOIST, {"cable": sm.Sheath(mu=0.2, bend=3.0, pretension=12.0)})
    data.ctrl[0] = 400.0
    mujoco.mj_forward(model, data)
    assert data.qacc[0] == pytest.approx((400.0 * np.exp(-0.6) + 12.0 - WEIGHT) / MASS, rel=1e-4)


def test_written_in_xml_it_is_the_same_model() -> None:
    xml = HOIST.replace(
        "<worldbody>",
        '<extension><plugin plugin="sinew.sheath"><instance name="s"><config key="sheaths" value="c*: mu=0.2 bend=3"/>'
        "</instance></plugin></extension><worldbody>",
    ).replace('name="cable"', 'name="cable" frictionloss="1e-9" solreffriction="1e-6 1" solimpfriction=".99 .99 .001"')
    model = mujoco.MjModel.from_xml_string(xml)
    other, data = sheathed(HOIST, {"cable": sm.Sheath(mu=0.2, bend=3.0)})
    np.testing.assert_array_equal(drive(model, mujoco.MjData(model), 100), drive(other, data, 100))


def test_a_spec_written_to_xml_reads_back() -> None:
    spec = mujoco.MjSpec.from_string(FINGER)
    sm.add_sheaths(spec, {"*": sm.Sheath(mu=0.1, bend=4.0, turning=1.0)})
    model = spec.compile()
    again = mujoco.MjModel.from_xml_string(spec.to_xml())
    seen = drive(model, mujoco.MjData(model), 200)
    # Written with six digits.
    np.testing.assert_allclose(seen, drive(again, mujoco.MjData(again), 200), atol=1e-4)


def test_copies_pickles_resets_and_threads_agree_to_the_bit() -> None:
    models.assert_copies_agree(finger()[0], (0.0, 15.0))


def test_split_steps_and_extra_forward_passes_agree_to_the_bit() -> None:
    models.assert_split_steps_agree(finger()[0], (0.0, 10.0))


@pytest.mark.parametrize("threads", [1, 2])
def test_rollouts_agree_with_steps_to_the_bit(threads: int) -> None:
    rollout = models.part("rollout")
    models.assert_rollouts_agree(rollout, finger()[0], threads, (0.0, 15.0))


@pytest.mark.parametrize("threads", [1, 2])
def test_batches_agree_with_steps_to_the_bit(threads: int) -> None:
    batch = models.part("batch")
    models.assert_batches_agree(batch, finger()[0], threads, (0.0, 15.0))


def test_data_of_models_leave_no_memory_behind() -> None:
    pytest.importorskip("resource")
    model, _ = sheathed(
        HOIST.replace("<worldbody>", '<size memory="64K"/><worldbody>'), {"cable": sm.Sheath(mu=0.2, bend=3.0)}
    )
    # A kilobyte lost with each would be seen.
    count = 100_000 if os.environ.get("SINEW_LONG") else 8_000
    assert models.growth_of(lambda: mujoco.mj_step(model, mujoco.MjData(model)), count) < 4_000


@given(
    mu=st.floats(0.0, 0.5),
    bend=st.floats(0.0, 6.0),
    mass=st.floats(1e-3, 1e3),
    gear=st.floats(0.1, 10.0),
    step=st.sampled_from([2e-4, 1e-3, 5e-3]),
    pull=st.floats(0.02, 50.0),
)
def test_any_hoist_slides_or_sticks_as_the_law_says(
    mu: float, bend: float, mass: float, gear: float, step: float, pull: float
) -> None:
    xml = HOIST.replace(f'mass="{MASS}"', f'mass="{mass!r}"').replace('gear="-1"', f'gear="-{gear!r}"')
    model, data = sheathed(xml.replace('"0.001"', f'"{step}"', 1), {"cable": sm.Sheath(mu=mu, bend=bend)})
    weight, angle = mass * GRAVITY, mu * bend
    tension = pull * weight
    data.ctrl[0] = tension / gear
    for _ in range(10):
        mujoco.mj_step(model, data)
    up, down = tension * np.exp(-angle) - weight, tension * np.exp(angle) - weight
    expected = up if up > 0.0 else min(down, 0.0)
    assert data.qacc[0] * mass == pytest.approx(expected, abs=2e-3 * weight + 1e-3 * abs(expected))


def refused(change: Any, sheaths: Any, error: type[Exception], *parts: str) -> None:
    spec = mujoco.MjSpec.from_string(change)
    with pytest.raises(error) as caught:
        sm.add_sheaths(spec, sheaths)
        spec.compile()
    for part in parts:
        assert part in str(caught.value), caught.value


def test_wrong_models_are_refused_with_one_reason() -> None:
    good = {"cable": sm.Sheath(mu=0.2, bend=3.0)}
    refused("<mujoco/>", good, ValueError, "has no tendons")
    refused(HOIST, {"rope*": sm.Sheath(mu=0.2, bend=3.0)}, ValueError, "'rope*' fits no tendon", "cable")
    refused(HOIST, {}, ValueError, "no tendon is named")
    refused(HOIST, {"cable": 0.2}, TypeError, "expected a sinew.mujoco.Sheath, but it is a float")
    part = sinew.Sheath(0.5, 3.0)
    refused(HOIST, {"*": part}, TypeError, "sinew.mujoco.Sheath, but it is a sinew.Sheath, one part of the path of a Cable")
    refused(HOIST, {"cabel": sm.Sheath(mu=0.2, bend=3.0)}, ValueError, "'cabel' fits no tendon", "did you mean cable?")
    refused(HOIST, [("cable", 0.2)], TypeError, "expected a mapping")
    refused(HOIST.replace('tendon="cable"', 'joint="lift"'), good, ValueError, "no actuator pulls on cable")
    with pytest.raises(TypeError, match=r"mujoco\.MjSpec"):
        sm.add_sheaths(mujoco.MjModel.from_xml_string(HOIST), good)
    spec = mujoco.MjSpec.from_string(HOIST)
    sm.add_sheaths(spec, good)
    with pytest.raises(ValueError, match="tendon cable has a sheath already: name every tendon in one call of add_sheaths"):
        sm.add_sheaths(spec, good)
    # Written as XML, and with a pattern there.
    again = mujoco.MjSpec.from_string(spec.to_xml().replace('value="cable:', 'value="c*:'))
    with pytest.raises(ValueError, match="tendon cable has a sheath already"):
        sm.add_sheaths(again, good)


def test_a_tendon_gets_a_sheath_or_a_cable() -> None:
    path = (sinew.Free(0.2), sinew.Sheath(0.8, 4.0), sinew.Free(0.5))
    cables = {"cable": sm.Cable(path, friction=0.1, compliance_per_n=1e-3)}
    sheaths = {"*": sm.Sheath(mu=0.2, bend=3.0)}
    for first, second, there in ((cables, sheaths, "cable"), (sheaths, cables, "sheath")):
        spec = mujoco.MjSpec.from_string(HOIST)
        for given in (first, second):
            add = sm.add_sheaths if given is sheaths else sm.add_cables
            if given is first:
                add(spec, given)
                continue
            with pytest.raises(ValueError, match=f"tendon cable has a {there} already, expected only one of both"):
                add(spec, given)
        assert spec.compile().nplugin == 1


@pytest.mark.parametrize(
    ("value", "part"),
    [
        ("cable mu=1", "no colon"),
        ("", "no entry"),
        ("rope: mu=1", "rope fits no tendon of the model: cable"),
        ("cable: friction=1", "unknown key friction, expected one of mu, bend"),
        ("cable: mu=nan", "expected a finite number"),
        ("cable: mu=-1", "friction must be a finite number >= 0"),
        ("cable: mu=0.1 bend=1", "frictionloss must be above zero"),
    ],
)
def test_wrong_xml_is_refused_with_one_reason(value: str, part: str) -> None:
    extension = f'<extension><plugin plugin="sinew.sheath"><instance name="s"><config key="sheaths" value="{value}"/>'
    xml = HOIST.replace("<worldbody>", extension + "</instance></plugin></extension><worldbody>")
    with pytest.raises(ValueError, match=r"sinew\.sheath: ") as caught:
        mujoco.MjModel.from_xml_string(xml)
    assert part in str(caught.value)


@pytest.mark.parametrize(
    "wrong",
    [
        {"mu": -0.1},
        {"bend": float("nan")},
        {"bend": 180.0},
        {"bend": 30.0, "mu": 1.0},
        {"efficiency": 0.0},
        {"efficiency": 1.1},
        {"speed": 0.0},
        {"mu": "a"},
        {"rise": -1.0},
    ],
)
def test_parameters_outside_of_their_domain_are_refused_by_name(wrong: dict[str, Any]) -> None:
    with pytest.raises(ValueError, match=next(iter(wrong))):
        sm.Sheath(**({"mu": 0.1, "bend": 1.0} | wrong))


def test_bends_in_degrees_are_told_from_radians() -> None:
    with pytest.raises(ValueError, match=r"at most 37\.7 rad \(6 turns\), but is 180: is it in degrees\? .* = 3\.142"):
        sm.Sheath(mu=0.1, bend=180.0)
    with pytest.raises(ValueError, match=r"friction angle mu bend .* at most 20, but is 30: bends are in rad"):
        sm.Sheath(mu=1.0, bend=30.0)
    assert sm.Sheath(mu=0.1, bend=37.6).bend == 37.6
    for bend, friction, part in ((180.0, 0.1, "in degrees"), (30.0, 1.0, "friction angle")):
        path = (sinew.Free(0.2), sinew.Sheath(0.8, bend), sinew.Free(0.5))
        with pytest.raises(ValueError, match=part):
            sm.Cable(path, friction=friction, compliance_per_n=1e-3)


@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize(("efficiency", "pretension"), [(1.0, 0.0), (0.9, 5.0)])
def test_tensions_of_both_ends_are_on_the_edges_of_the_capstan(integrator: str, efficiency: float, pretension: float) -> None:
    sheath = sm.Sheath(mu=0.2, bend=3.0, efficiency=efficiency, pretension=pretension)
    model, data = sheathed(HOIST.replace('gear="-1"', 'gear="-2"'), {"cable": sheath})
    model.opt.integrator = getattr(mujoco.mjtIntegrator, integrator)
    angle = 0.6 - np.log(efficiency)
    for sign, pull in ((1.0, 3.0 * WEIGHT), (-1.0, 0.2 * WEIGHT), (0.0, 0.9 * WEIGHT)):
        mujoco.mj_resetData(model, data)
        data.ctrl[0] = pull / 2.0
        mujoco.mj_step(model, data, 20)
        mujoco.mj_forward(model, data)
        found = sm.tensions(model, data)
        assert found.names == ("cable",)
        assert found.near[0] == pytest.approx(pull, rel=1e-7)
        edge = pull * np.exp(-sign * angle) + pretension if sign else WEIGHT
        # Held, it creeps, see `add_sheaths`.
        assert found.far[0] == pytest.approx(edge, rel=1e-6 if sign else 1e-3)
        assert data.qacc[0] == pytest.approx((found.far[0] - WEIGHT) / MASS, abs=1e-6)


@pytest.mark.parametrize("jacobian", ["mjJAC_DENSE", "mjJAC_SPARSE"])
def test_tensions_know_tendons_without_sheaths_and_with_friction_of_their_own(jacobian: str) -> None:
    xml = FINGER.replace('name="tip"', 'name="tip" frictionloss="0.5"').replace('name="flexor"', 'name="flexor" frictionloss="0.2"')
    model, data = sheathed(xml, {"flexor": sm.Sheath(mu=0.1, bend=4.0), "extensor": sm.Sheath(mu=0.1, bend=2.0, turning=1.0)})
    model.opt.jacobian = getattr(mujoco.mjtJacobian, jacobian)
    data.ctrl[:] = [8.0, 5.0, -1.0]
    mujoco.mj_step(model, data, 100)
    found = sm.tensions(model, data)
    # The first one's force is filtered; the last one's actuator pushes.
    assert found.near == pytest.approx([data.act[0], 5.0, 2.0], rel=1e-2)
    assert found.far[2] == found.near[2] == 2.0
    # The flexor slides: the friction of its own is behind the sheath.
    assert found.far[0] == pytest.approx(found.near[0] * np.exp(-0.4) - 0.2, rel=1e-4)
    assert found.near[1] * np.exp(-2.0) < found.far[1] < found.near[1] * np.exp(2.0)
    with pytest.raises(TypeError, match=r"mujoco\.MjModel"):
        sm.tensions(data, model)


def test_other_plugins_stay_beside_it() -> None:
    xml = HOIST.replace(
        "<worldbody>",
        '<extension><plugin plugin="mujoco.pid"><instance name="p"><config key="kp" value="40"/></instance></plugin></extension>'
        "<worldbody>",
    ).replace(
        '<motor name="winch" tendon="cable" gear="-1"/>', '<plugin plugin="mujoco.pid" instance="p" tendon="cable"/>'
    )
    try:
        mujoco.MjModel.from_xml_string(xml)
    except ValueError:
        pytest.skip("MuJoCo came without its own plugins")
    model, data = sheathed(xml, {"cable": sm.Sheath(mu=0.2, bend=3.0)})
    data.ctrl[0] = -3.0
    mujoco.mj_step(model, data)
    # Its force, negative for a pull, from the length of one metre.
    assert data.actuator_force[0] == pytest.approx(-160.0 * np.cosh(0.6), rel=1e-6)
