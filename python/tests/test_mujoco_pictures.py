"""What MuJoCo shows of a machine that nobody has lit or aimed a camera at."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import sinew

mujoco = pytest.importorskip("mujoco", reason="MuJoCo is not installed")

sm = pytest.importorskip("sinew.mujoco", reason="MuJoCo cannot be used", exc_type=ImportError)
from sinew import _sinew  # noqa: E402
from sinew.mujoco._appearance import bones_of  # noqa: E402
from sinew.mujoco._machine import bare  # noqa: E402

#: Draws every machine with the renderer's own camera, once as it is and once the sky alone.
DRAW = """
import json, sys, mujoco, numpy as np, sinew, sinew.mujoco
told = {}
for name in sinew.Machine.built_in():
    model = sinew.mujoco.load(name, transmission="none")
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    mujoco.mj_forward(model, data)
    with mujoco.Renderer(model) as renderer:
        pictures = []
        for shown in (1, 0):
            option = mujoco.MjvOption()
            for groups in (option.geomgroup, option.sitegroup, option.tendongroup):
                groups[:] = shown
            renderer.update_scene(data, scene_option=option)
            pictures.append(renderer.render().astype(int))
    seen = np.abs(pictures[0] - pictures[1]).max(axis=2) > 40
    rows, columns = np.flatnonzero(seen.any(axis=1)), np.flatnonzero(seen.any(axis=0))
    high, wide = seen.shape
    edge = min(rows[0] / high, 1 - rows[-1] / high, columns[0] / wide, 1 - columns[-1] / wide)
    told[name] = {"sky": pictures[1].mean(), "seen": seen.mean(), "edge": edge, "height": np.ptp(rows) / high}
print(json.dumps(told))
"""


def plain(machine: sinew.Machine) -> tuple[Any, list[float]]:
    """A machine as its description alone has it, without a transmission, and its start."""
    xml, described = _sinew.mujoco_machine(machine)
    told = json.loads(described)
    return bare(xml, [muscle["name"] for muscle in told["muscles"]], 1e-3).compile(), told["start"]


def test_every_built_in_machine_is_seen_whole_in_the_first_picture_of_it() -> None:
    surroundings = os.environ | {"MUJOCO_GL": os.environ.get("MUJOCO_GL", "egl")}
    drawn = subprocess.run([sys.executable, "-c", DRAW], env=surroundings, capture_output=True, text=True)
    if drawn.returncode != 0 and any(name in drawn.stderr for name in ("OpenGL", "EGL", "GLFW", "OSMesa")):
        pytest.skip("MuJoCo cannot draw here: no OpenGL")
    assert drawn.returncode == 0, drawn.stderr
    told = json.loads(drawn.stdout)
    assert list(told) == list(sinew.Machine.built_in())
    for name, picture in told.items():
        assert picture["sky"] > 150.0 and picture["seen"] > 0.005, name
        # Neither cut off nor a dot.
        assert picture["edge"] > 0.05 and picture["height"] > 0.2, name


@pytest.mark.parametrize("name", ["lm_arm", "two_finger_hand"])
def test_what_is_there_for_pictures_moves_nothing(name: str) -> None:
    machine = sinew.Machine(name)
    reference, start = plain(machine)
    seen = sm.load(machine, transmission="none")
    assert seen.ngeom > reference.ngeom
    ends = []
    for model in (reference, seen):
        data = mujoco.MjData(model)
        data.qpos[:] = start
        data.ctrl[:] = 5.0
        mujoco.mj_step(model, data, 300)
        ends.append(np.concatenate([data.qpos, data.qvel, data.ten_length]))
    assert np.array_equal(*ends) and (ends[0][: reference.nq] != start).any()
    for values in ("body_mass", "body_inertia", "body_ipos", "jnt_range", "tendon_range"):
        assert np.array_equal(getattr(reference, values), getattr(seen, values))


def test_bones_lead_from_joint_to_joint_and_the_last_one_to_the_end_point() -> None:
    model = sm.load("lm_arm", transmission="none")
    bones = {model.body(index).name: ends for index, ends in enumerate(bones_of(model))}
    assert not len(bones["world"]) and not len(bones["scapula"])  # The humerus begins where the scapula does.
    assert np.array_equal(bones["humerus"], [model.body("ulna").pos])
    assert np.array_equal(bones["hand"], [model.site("endpoint").pos])


def test_what_the_file_of_a_body_draws_takes_the_place_of_its_bone(tmp_path: Path) -> None:
    source = (Path(__file__).parents[2] / "models/planar_leg.toml").read_text()
    drawn = tmp_path / "drawn.toml"
    box = '\n[[geom]]\nbody = "shank"\nkind = "box"\nsize_m = [0.02, 0.02, 0.1]\n'
    drawn.write_text(source.replace("\n[task]", box + "\n[task]"))
    plain_leg, drawn_leg = (sm.load(machine, transmission="none") for machine in ("planar_leg", drawn))
    kinds = [leg.geom_type[leg.geom_bodyid == leg.body("shank").id] for leg in (plain_leg, drawn_leg)]
    assert mujoco.mjtGeom.mjGEOM_CAPSULE in kinds[0] and mujoco.mjtGeom.mjGEOM_CAPSULE not in kinds[1]
    assert mujoco.mjtGeom.mjGEOM_BOX in kinds[1]


def test_a_machine_in_a_scene_leaves_the_light_and_the_view_of_the_scene() -> None:
    view = '<visual><global azimuth="10"/><headlight diffuse=".2 .2 .2"/></visual><statistic extent="3"/>'
    scene = mujoco.MjSpec.from_string(f'<mujoco><option timestep=".001"/>{view}</mujoco>')
    scene.attach(sm.spec_of("finger", transmission="none"), prefix="left:", frame=scene.worldbody.add_frame())
    model = scene.compile()
    assert model.vis.global_.azimuth == 10.0 and model.stat.extent == 3.0 and model.body("left:distal").id > 0
    assert np.allclose(model.vis.headlight.diffuse, 0.2)
