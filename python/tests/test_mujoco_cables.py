"""Elastic cables in MuJoCo models, against the library's own cable."""

from __future__ import annotations

import json
import os
import warnings
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

mujoco = pytest.importorskip("mujoco", reason="MuJoCo is not installed")

sm = pytest.importorskip("sinew.mujoco", reason="MuJoCo cannot be used", exc_type=ImportError)
import mujoco_models as models  # noqa: E402
from mujoco_models import FINGER, HOIST, MASS, WEIGHT  # noqa: E402

import sinew  # noqa: E402

if not hasattr(mujoco.MjsPlugin, "config"):
    pytest.skip(f"MuJoCo {mujoco.__version__} configures plugins in XML alone", allow_module_level=True)

PATH = (sinew.Free(0.2), sinew.Sheath(0.8, 4.0), sinew.Pulley(1.0), sinew.Free(0.5))
NUMBERS = {"friction": 0.12, "compliance_per_n": 2.5e-4, "drag_n_s_per_m": 50.0, "pretension_n": 3.0}
CABLE = sm.Cable(PATH, **NUMBERS, start_n=WEIGHT)
#: For a finger: thin, short, light.
THIN = sm.Cable(
    (sinew.Free(0.05), sinew.Sheath(0.3, 3.0), sinew.Free(0.1)), friction=0.1, compliance_per_n=2e-3, start_n=2.0
)
WITHIN = (-2e-3, 4e-3)


def cabled(xml: str, cables: dict[str, Any], **keywords: Any) -> tuple[Any, Any]:
    spec = mujoco.MjSpec.from_string(xml)
    sm.add_cables(spec, cables, **keywords)
    model = spec.compile()
    return model, mujoco.MjData(model)


def finger_of(xml: str, **keywords: Any) -> Any:
    return cabled(xml, {"*": THIN}, damp=False, **keywords)[0]


def finger(**keywords: Any) -> Any:
    return finger_of(FINGER, **keywords)


def tension(model: Any, data: Any, actuator: int = 0) -> float:
    return float(-data.actuator_force[actuator] * model.actuator_gear[actuator, 0])


def own(path: Any, cells: int, **numbers: float) -> sinew.Cable:
    nothing = {
        "viscous_s_per_m": 0.0,
        "efficiency": 1.0,
        "drag_n_s_per_m": 0.0,
        "drag_fade_n": 5.0,
        "pretension_n": 0.0,
    }
    return sinew.Cable(path, cells=cells, **(nothing | {"sheath_compliance_per_n": 0.0} | numbers))


@given(
    friction=st.floats(0.0, 0.3),
    bend=st.floats(0.0, 6.0),
    wrap=st.floats(0.0, 2.0),
    compliance=st.floats(5e-5, 1e-3),
    drag=st.sampled_from([0.0, 40.0]),
    cells=st.integers(10, 30),
    substeps=st.sampled_from([1, 2, 4]),
    seed=st.integers(0, 1000),
)
def test_the_law_is_that_of_the_library_to_the_bit(
    friction: float, bend: float, wrap: float, compliance: float, drag: float, cells: int, substeps: int, seed: int
) -> None:
    path = (sinew.Free(0.2), sinew.Sheath(0.8, bend), sinew.Pulley(wrap), sinew.Free(0.5))
    numbers = {"friction": friction, "compliance_per_n": compliance, "drag_n_s_per_m": drag, "pretension_n": 2.0}
    cable = sm.Cable(path, **numbers, start_n=WEIGHT)
    model, data = cabled(HOIST, {"cable": cable}, cells=cells, substeps=substeps, damp=False)
    reference = own(path, cells, **numbers)
    expected = reference.settle(WEIGHT).tension_out
    random = np.random.default_rng(seed)
    before = np.zeros(2)
    for k in range(150):
        if k % 30 == 0:
            speed = random.uniform(-0.1, 0.2)
        data.ctrl[0] += 1e-3 * speed
        mujoco.mj_step1(model, data)
        mujoco.mj_step2(model, data)
        now = np.array([data.ctrl[0], data.ten_length[0]])
        if k > 0:
            motor, longer = now - before
            for _ in range(substeps):
                ends = reference.step(1e-3 / substeps, motor / substeps, -longer / substeps)
            expected = ends.tension_out
        before = now
        assert tension(model, data) == expected


def test_copies_pickles_resets_and_threads_agree_to_the_bit() -> None:
    models.assert_copies_agree(finger(), WITHIN)
    models.assert_copies_agree(finger(cells=9, substeps=2, speed=True), WITHIN)


def test_split_steps_and_extra_forward_passes_agree_to_the_bit() -> None:
    models.assert_split_steps_agree(finger(), WITHIN)


def test_extra_forward_passes_agree_with_runge_kutta_too() -> None:
    model = finger()
    model.opt.integrator = mujoco.mjtIntegrator.mjINT_RK4
    models.assert_copies_agree(model, WITHIN)
    one, forward = mujoco.MjData(model), mujoco.MjData(model)
    for k in range(200):
        one.ctrl[:] = forward.ctrl[:] = 2e-3 * np.sin(0.05 * k)
        warm = np.array(forward.qacc_warmstart)
        mujoco.mj_forward(model, forward)
        forward.qacc_warmstart[:] = warm
        mujoco.mj_step(model, forward)
        mujoco.mj_step(model, one)
    np.testing.assert_array_equal(one.qpos, forward.qpos)


@pytest.mark.parametrize("threads", [1, 2])
def test_rollouts_agree_with_steps_to_the_bit(threads: int) -> None:
    rollout = models.part("rollout")
    models.assert_rollouts_agree(rollout, finger(), threads, WITHIN)


@pytest.mark.parametrize("threads", [1, 2])
def test_batches_agree_with_steps_to_the_bit(threads: int) -> None:
    batch = models.part("batch")
    models.assert_batches_agree(batch, finger(), threads, WITHIN)


def test_data_interleaved_on_one_thread_do_not_disturb_each_other() -> None:
    model = finger()
    alone = models.drive(model, mujoco.MjData(model), 100, within=WITHIN)
    one, other = mujoco.MjData(model), mujoco.MjData(model)
    random, seen = np.random.default_rng(1), []
    for k in range(100):
        if k % 20 == 0:
            one.ctrl[:] = random.uniform(*WITHIN, model.nu)
        mujoco.mj_step1(model, one)
        other.ctrl[:] = -1e-3
        mujoco.mj_step(model, other)
        mujoco.mj_step2(model, one)
        seen.append(np.array(one.qpos))
    np.testing.assert_array_equal(np.array(seen), alone)


def test_data_of_models_leave_no_memory_behind() -> None:
    pytest.importorskip("resource")
    model, _ = cabled(HOIST.replace("<worldbody>", '<size memory="64K"/><worldbody>'), {"cable": CABLE})
    count = 100_000 if os.environ.get("SINEW_LONG") else 8_000
    assert models.growth_of(lambda: mujoco.mj_step(model, mujoco.MjData(model)), count) < 4_000


def apart(step: float, of: Any, duration: float, amplitude: float) -> tuple[float, float]:
    """Largest coordinate, rad, after a motion, and the largest difference between Runge-Kutta and Euler."""
    ends = []
    for integrator in (mujoco.mjtIntegrator.mjINT_EULER, mujoco.mjtIntegrator.mjINT_RK4):
        model = of(step)
        model.opt.integrator = integrator
        data = mujoco.MjData(model)
        if model.nkey:
            mujoco.mj_resetDataKeyframe(model, data, 0)
        for k in range(round(duration / step)):
            data.ctrl[:] = amplitude * np.sin(10.0 * k * step + np.arange(model.nu))
            mujoco.mj_step(model, data)
        start = model.key_qpos[0] if model.nkey else 0.0
        ends.append(data.qpos - start)
    return float(np.abs(ends[0]).max()), float(np.abs(ends[0] - ends[1]).max())


def test_runge_kutta_and_euler_agree_on_the_arm() -> None:
    moved, difference = apart(1e-4, lambda step: sm.load("lm_arm", timestep_s=step), 0.5, 3e-3)
    assert moved > 0.1 and difference < 1e-4


def test_runge_kutta_and_euler_converge_to_the_same_motion() -> None:
    def light(step: float) -> Any:
        return finger_of(FINGER.replace('timestep="0.001"', f'timestep="{step}"'))

    differences = [apart(step, light, 0.3, 3e-3)[1] for step in (4e-4, 2e-4, 1e-4)]
    assert differences[0] > differences[1] > differences[2] and differences[2] < 2.5e-4


def test_a_hung_mass_loses_energy_and_never_gains_it() -> None:
    model, data = cabled(HOIST, {"cable": CABLE})
    # Out of balance by 20 mm, winch held: a ring-down.
    mujoco.mj_step(model, data)
    data.qpos[0] -= 0.02
    highest, window = np.inf, []
    for _ in range(8):
        for _ in range(500):
            mujoco.mj_step(model, data)
            window.append(0.5 * MASS * data.qvel[0] ** 2)
        peak = max(window[-500:])
        assert peak <= highest + 1e-9
        highest = peak
    assert highest < 0.05 * max(window)


def test_a_slack_cable_does_not_pull_and_tightens_again() -> None:
    model, data = cabled(HOIST, {"cable": sm.Cable(PATH, friction=0.12, compliance_per_n=2.5e-4, start_n=10.0)})
    model.opt.gravity[:] = 0.0
    model.dof_damping[:] = 1e4
    mujoco.mj_step(model, data)
    data.ctrl[0] = -0.05
    for _ in range(50):
        mujoco.mj_step(model, data)
    assert tension(model, data) == 0.0
    data.ctrl[0] = 0.05
    for _ in range(50):
        mujoco.mj_step(model, data)
    assert tension(model, data) > 10.0


def test_a_winch_of_a_speed_takes_cable_in() -> None:
    model, data = cabled(HOIST, {"cable": CABLE}, speed=True)
    data.ctrl[0] = 0.05
    for _ in range(1000):
        mujoco.mj_step(model, data)
    assert data.act[0] == pytest.approx(0.05, rel=1e-9)
    assert 0.03 < data.qpos[0] < 0.055


#: Steel: a hundred times stiffer than the polymer cable.
STEEL = sm.Cable(PATH, friction=0.12, compliance_per_n=1e-6, start_n=WEIGHT)


def noise(model: Any, data: Any) -> float:
    """Largest speed, m/s, in the last half second of two after a push."""
    largest = 0.0
    data.qvel[0] = 0.01
    for k in range(round(2.0 / model.opt.timestep)):
        mujoco.mj_step(model, data)
        if k * model.opt.timestep > 1.5:
            largest = max(largest, abs(float(data.qvel[0])))
    return largest


def test_a_stiff_cable_is_found_damped_and_told() -> None:
    xml = HOIST.replace('timestep="0.001"', 'timestep="0.005"')
    with pytest.warns(
        sm.StiffCableWarning, match=r"1 of 1 cables are stiff for a time step of 0.005 s \(cable: dt sqrt"
    ):
        model, data = cabled(xml, {"cable": STEEL})
    assert model.opt.integrator == mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    assert noise(model, data) < 1e-3
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        explicit, explicit_data = cabled(xml, {"cable": STEEL}, damp=False)
        cabled(HOIST, {"cable": CABLE})
    assert not noise(explicit, explicit_data) < 0.1


def test_written_in_xml_it_is_the_same_model() -> None:
    text = "c*: free=0.2 sheath=0.8/4 pulley=1 free=0.5 friction=0.12 compliance_per_n=2.5e-4 drag_n_s_per_m=50 pretension_n=3"
    config = f'<config key="cables" value="{text} start_n={WEIGHT!r}"/><config key="cells" value="16"/>'
    extension = f'<extension><plugin plugin="sinew.cable"><instance name="w">{config}</instance></plugin></extension>'
    xml = HOIST.replace("<worldbody>", extension + "<worldbody>")
    motor = '<motor name="winch" tendon="cable" gear="-1"/>'
    xml = xml.replace(motor, '<plugin name="winch" tendon="cable" plugin="sinew.cable" instance="w" gear="-1"/>')
    model = mujoco.MjModel.from_xml_string(xml)
    other, data = cabled(HOIST, {"cable": CABLE}, cells=16)
    within = (-0.02, 0.02)
    got = models.drive(model, mujoco.MjData(model), 200, within=within)
    np.testing.assert_array_equal(got, models.drive(other, data, 200, within=within))


def test_wrong_cables_and_models_are_refused_with_one_reason() -> None:
    def refused(xml: str, cables: Any, error: type[Exception], part: str, **keywords: Any) -> None:
        spec = mujoco.MjSpec.from_string(xml)
        with pytest.raises(error, match=part):
            sm.add_cables(spec, cables, **keywords)

    good = {"cable": CABLE}
    refused("<mujoco/>", good, ValueError, "has no tendons")
    refused(HOIST, {"rope": CABLE}, ValueError, "'rope' fits no tendon")
    refused(HOIST, {"cable": 1.0}, TypeError, r"expected a sinew\.mujoco\.Cable")
    refused(HOIST, good, ValueError, "cells must be a whole number", cells=0)
    refused(HOIST, good, ValueError, "tendon cable: .*cells", cells=2)
    refused(HOIST, good, ValueError, "substeps must be a whole number", substeps=1.5)
    doubled = HOIST.replace("</actuator>", '<motor tendon="cable"/></actuator>')
    refused(doubled, good, ValueError, "more than one actuator")
    spec = mujoco.MjSpec.from_string(HOIST)
    sm.add_cables(spec, good)
    with pytest.raises(ValueError, match="tendon cable has a cable already: name every tendon in one call"):
        sm.add_cables(spec, good)
    with pytest.raises(TypeError, match=r"mujoco\.MjSpec"):
        sm.add_cables(mujoco.MjModel.from_xml_string(HOIST), good)
    for wrong, part in [
        ({"friction": -0.1}, "friction"),
        ({"compliance_per_n": 0.0}, "compliance"),
        ({"path": PATH[:2]}, "free cable"),
        ({"start_n": 1.0}, "start_n"),
        ({"drag_fade_n": float("nan")}, "drag_fade_n"),
    ]:
        with pytest.raises(ValueError, match=part):
            sm.Cable(**({"path": PATH} | NUMBERS | wrong))


@pytest.mark.parametrize(
    ("value", "cells", "part"),
    [
        ("rope: free=1 pulley=1 free=1 friction=0.1 compliance_per_n=1e-4", "8", "no pattern fits tendon cable"),
        ("cable: free=1 pulley=1 free=1 friction=0.1", "8", "compliance_per_n is missing"),
        ("cable: free=1 sheath=1/30 free=1 friction=0.5 compliance_per_n=1e-4", "8", "or more cells"),
        ("cable: free=1 pulley=1 free=1 friction=0.1 compliance_per_n=1e-4", "x", "cells: x must be a whole number"),
        ("cable: free=1 mu=1", "8", "unknown key mu"),
    ],
)
def test_wrong_xml_is_refused_with_one_reason(value: str, cells: str, part: str) -> None:
    config = f'<config key="cables" value="{value}"/><config key="cells" value="{cells}"/>'
    extension = f'<extension><plugin plugin="sinew.cable"><instance name="w">{config}</instance></plugin></extension>'
    xml = HOIST.replace("<worldbody>", extension + "<worldbody>")
    xml = xml.replace(
        '<motor name="winch" tendon="cable" gear="-1"/>', '<plugin tendon="cable" plugin="sinew.cable" instance="w"/>'
    )
    with pytest.raises(ValueError, match=r"sinew\.cable: ") as caught:
        mujoco.MjModel.from_xml_string(xml)
    assert part in str(caught.value)


def test_a_sheath_on_a_cable_is_refused_in_xml() -> None:
    def instance(kind: str, key: str, text: str) -> str:
        config = f'<config key="{key}" value="{text}"/>'
        return f'<plugin plugin="sinew.{kind}"><instance name="{kind}">{config}</instance></plugin>'

    cable = instance("cable", "cables", "cable: free=0.2 sheath=0.8/4 free=0.5 friction=0.1 compliance_per_n=1e-4")
    sheath = instance("sheath", "sheaths", "cable: mu=0.1 bend=1")
    motor = '<motor name="winch" tendon="cable" gear="-1"/>'
    winch = '<plugin tendon="cable" plugin="sinew.cable" instance="cable"/>'
    xml = HOIST.replace('<spatial name="cable"', '<spatial name="cable" frictionloss="1e-9"').replace(motor, winch)
    assert mujoco.MjModel.from_xml_string(xml.replace("<worldbody>", f"<extension>{cable}</extension><worldbody>"))
    for both in (cable + sheath, sheath + cable):
        with pytest.raises(ValueError, match=r"sinew\.sheath: tendon cable: its actuator number 0 is a cable"):
            mujoco.MjModel.from_xml_string(xml.replace("<worldbody>", f"<extension>{both}</extension><worldbody>"))


def test_numbers_outside_of_the_law_end_the_pull_and_nothing_else() -> None:
    model, data = cabled(HOIST, {"cable": CABLE})
    mujoco.mj_step(model, data)
    for wrong in (np.nan, np.inf, 1e6):
        other = mujoco.MjData(model)
        mujoco.mj_step(model, other)
        other.ctrl[0] = wrong
        mujoco.mj_forward(model, other)
        assert np.isfinite(other.actuator_force).all()
    # A state written by hand that is none.
    data.plugin_state[6] = np.nan
    mujoco.mj_step(model, data)
    assert np.isfinite(data.actuator_force).all()


@pytest.mark.parametrize("name", sinew.Machine.built_in())
def test_every_built_in_machine_is_held_by_its_cables(name: str) -> None:
    machine = sinew.Machine(name)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", sm.StiffCableWarning)
        model = sm.load(machine)
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    start = np.array(data.qpos)
    mujoco.mj_forward(model, data)
    wrong = np.abs(data.ten_length - machine.lengths(machine.start)) > 1e-12
    if wrong.any() and int(mujoco.__version__.split(".")[0]) < 4:
        pytest.skip(
            f"MuJoCo {mujoco.__version__} finds another way around the cylinders of {wrong.sum()} tendons than version 4"
        )
    assert not wrong.any()
    for _ in range(300):
        mujoco.mj_step(model, data)
    # Where one cable closes several joints against springs, these move to their common equilibrium nearby.
    underactuated = len(machine.muscle_names) < len(start)
    assert np.abs(data.qpos - start).max() < (0.03 if underactuated else 1e-4)
    sheaths = sm.load(machine, transmission="sheaths")
    assert sheaths.nu == len(machine.muscle_names) and sheaths.npluginstate == 0


def test_parameters_come_from_machines_and_identified_models(model: sinew.Model, log_files: list[Any]) -> None:
    sheaths, cables = sm.sheaths_of("lm_arm"), sm.cables_of("lm_arm")
    assert list(sheaths) == list(cables) == sinew.Machine("lm_arm").muscle_names
    name = next(iter(sheaths))
    bend = next(part.bend_rad for part in cables[name].path if isinstance(part, sinew.Sheath))
    assert sheaths[name].bend == bend and sheaths[name].mu == cables[name].friction > 0.0
    with pytest.raises(ValueError, match="describes signals, not a cable"):
        sm.calibrate_from(model)
    observer = sinew.identify(log_files[:2], far="tension_out_n", models=["observer"])
    sheath, cable = sm.calibrate_from(observer)
    written = json.loads(observer.to_json())["model"]["estimator"]["law"]["cable"]["model"]
    assert cable.friction == sheath.mu == written["parameters"]["friction"]
    assert sheath.bend == pytest.approx(sum(part.bend_rad for part in cable.path if isinstance(part, sinew.Sheath)))
    spec = mujoco.MjSpec.from_string(HOIST)
    assert sm.add_cables(spec, {"cable": cable}) == ["cable"]
    spec.compile()
    with pytest.raises(FileNotFoundError):
        sm.calibrate_from("nowhere.json")
    with pytest.raises(ValueError, match="transmission must be"):
        sm.load("lm_arm", transmission="gears")


def test_tensions_of_a_cable_are_those_of_its_ends() -> None:
    model, data = cabled(HOIST, {"cable": CABLE}, cells=24, substeps=2)
    assert np.isnan(sm.tensions(model, data).near[0])
    for k in range(1500):
        data.ctrl[0] = 2e-5 * k
        mujoco.mj_step(model, data)
    found = sm.tensions(model, data)
    assert found.far[0] == tension(model, data) == pytest.approx(WEIGHT, rel=0.05)
    # Hoisted steadily, the cable slides all along its sheath and its pulley.
    drag = 50.0 * 0.02
    angle = 0.12 * (4.0 + 1.0)
    assert found.near[0] == pytest.approx((found.far[0] - 3.0) * np.exp(angle) + drag, rel=0.03)
    spec = mujoco.MjSpec.from_string(FINGER)
    sm.add_cables(spec, {"extensor": THIN}, damp=False)
    sm.add_sheaths(spec, {"flexor": sm.Sheath(mu=0.2, bend=2.0)})
    model = spec.compile()
    data = mujoco.MjData(model)
    data.ctrl[:] = [4.0, 1e-3, 0.5]
    mujoco.mj_step(model, data, 50)
    found = sm.tensions(model, data)
    assert found.names == ("flexor", "extensor", "tip")
    assert found.near[0] == pytest.approx(data.act[0], rel=0.05) and found.near[2] == found.far[2] == -1.0
    assert found.far[1] == tension(model, data, 1) and 0.0 < abs(np.log(found.near[1] / found.far[1])) < 0.31
