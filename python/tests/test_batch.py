"""Models prepared for friction of sheaths in simulators with many worlds."""

from __future__ import annotations

import copy
from typing import Any

import numpy as np
import pytest

mujoco = pytest.importorskip("mujoco", reason="MuJoCo is not installed")
batch = pytest.importorskip("sinew.batch", reason="MuJoCo cannot be used", exc_type=ImportError)
from mujoco_models import FINGER, HOIST  # noqa: E402

from sinew import mujoco as sm  # noqa: E402

SHEATH = batch.Sheath(mu=0.1, bend=4.0, turning=1.0)


def model_of(xml: str) -> Any:
    return mujoco.MjModel.from_xml_string(xml)


def test_a_prepared_model_has_the_constraints_of_the_plugin_and_no_plugin() -> None:
    given = model_of(FINGER)
    prepared = batch.prepare(given, {"*": SHEATH, "tip": batch.Sheath(mu=0.2, bend=1.0)})
    spec = mujoco.MjSpec.from_string(FINGER)
    sm.add_sheaths(spec, {"*": SHEATH})
    plugin = spec.compile()
    assert prepared.nplugin == 0
    for name in ("tendon_frictionloss", "tendon_solref_fri", "tendon_solimp_fri", "actuator_forcelimited"):
        np.testing.assert_array_equal(getattr(prepared, name), getattr(plugin, name))
    assert not given.tendon_frictionloss.any()
    table = batch.table_of(prepared)
    assert table.names == ("flexor", "extensor", "tip")
    np.testing.assert_array_equal(table.parameters["mu"], [0.1, 0.1, 0.2])
    np.testing.assert_array_equal(table.parameters["turning"], [1.0, 1.0, 0.0])
    np.testing.assert_array_equal(table.limits, [[0.0, 18.0], [-np.inf, np.inf], [-np.inf, np.inf]])
    np.testing.assert_array_equal(table.pulls[table.begins[:-1]], [0, 1, 2])


def test_tendons_without_sheath_keep_what_they_have() -> None:
    given = model_of(FINGER)
    given.tendon_frictionloss[1] = 0.5
    prepared = batch.prepare(given, {"flexor": SHEATH})
    np.testing.assert_array_equal(prepared.tendon_frictionloss > 0.0, [True, True, False])
    np.testing.assert_array_equal(prepared.tendon_solref_fri[1], given.tendon_solref_fri[1])
    table = batch.table_of(prepared)
    np.testing.assert_array_equal(table.sheathed, [True, False, False])
    np.testing.assert_array_equal(table.parameters["mu"], [0.1, 0.0, 0.0])
    assert list(table.pulls) == [0] and list(table.begins) == [0, 1, 1, 1]


def test_what_would_lose_friction_in_silence_is_refused_with_the_reason() -> None:
    plugin = mujoco.MjSpec.from_string(HOIST)
    sm.add_sheaths(plugin, {"*": SHEATH})
    hoist = model_of(HOIST)
    few, short, without, off = (copy.copy(hoist) for _ in range(4))
    few.opt.iterations, short.opt.ls_iterations = 4, 8
    without.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_FRICTIONLOSS)
    off.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONSTRAINT)
    for model, sheaths, reason in [
        (few, {"*": SHEATH}, "iterations is 4, expected at least 10"),
        (short, {"*": SHEATH}, "ls_iterations is 8, expected at least 20"),
        (without, {"*": SHEATH}, 'frictionloss="disable"'),
        (off, {"*": SHEATH}, 'constraint="disable"'),
        (plugin.compile(), {"*": SHEATH}, "1 engine plugins"),
        (model_of("<mujoco/>"), {"*": SHEATH}, "has no tendons"),
        (hoist, {"rope*": SHEATH}, "'rope\\*' fits no tendon of the model: cable"),
        (hoist, {}, "no tendon is named"),
        (batch.prepare(hoist, {"*": SHEATH}), {"*": SHEATH}, "prepared already"),
    ]:
        with pytest.raises(ValueError, match=reason):
            batch.prepare(model, sheaths)
    with pytest.raises(TypeError, match=r"mujoco\.MjModel"):
        batch.prepare(plugin, {"*": SHEATH})
    with pytest.raises(ValueError, match="not prepared"):
        batch.table_of(copy.copy(batch.prepare(hoist, {"*": SHEATH})))
    assert hoist.opt.iterations >= 10


def test_parameters_of_worlds_are_checked_by_name_and_shape() -> None:
    table = batch.table_of(batch.prepare(model_of(FINGER), {"*": SHEATH}))
    assert table.filled("mu", 0.3, 5).shape == (5, 3)
    assert table.filled("mu", [0.1, 0.2, 0.3], 5)[4, 2] == 0.3
    for name, values, worlds, reason in [
        ("mu", [0.1, -0.2, 0.3], None, r"mu must be at least zero, but is -0\.2"),
        ("efficiency", 1.2, 4, r"efficiency must be at most 1, but is 1\.2"),
        ("speed", 0.0, 4, "speed must be above zero"),
        ("bend", np.nan, 4, "bend must be a finite number"),
        ("mu", np.ones((4, 2)), 4, r"mu must be of a shape that fits \(4, 3\), but is of \(4, 2\)"),
        ("mu", ["a"], None, "mu must be real numbers"),
        ("friction", 0.1, None, "'friction' is no parameter of a sheath, expected one of mu, bend"),
    ]:
        with pytest.raises(ValueError, match=reason):
            table.filled(name, values, worlds)
