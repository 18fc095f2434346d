"""The examples run."""

from __future__ import annotations

import runpy
from pathlib import Path

import numpy as np
import pytest

FOLDER = Path(__file__).parents[1] / "examples"
TRAINING = FOLDER.parents[1] / "crates/sinew-cli/examples/training"


@pytest.mark.parametrize("path", [TRAINING / "tendon_hand.py", FOLDER / "arm_beside_twin.py"], ids=lambda path: path.stem)
def test_an_example_with_mujoco_runs(path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    mujoco = pytest.importorskip("mujoco", reason="MuJoCo is not installed")
    if not hasattr(mujoco.MjsPlugin, "config"):
        pytest.skip(f"MuJoCo {mujoco.__version__} configures plugins in XML alone")
    runpy.run_path(str(path), run_name="__main__")
    assert capsys.readouterr().out


@pytest.mark.filterwarnings("ignore::DeprecationWarning", "ignore::UserWarning")
def test_the_example_in_playground_runs_and_its_episodes_begin_again() -> None:
    pytest.importorskip("mujoco_playground", reason="MuJoCo Playground is not installed: pip install playground", exc_type=ImportError)
    pytest.importorskip("sinew.mjx", reason="MJX cannot be used", exc_type=ImportError)
    example = runpy.run_path(str(FOLDER / "tendon_hand_mjx.py"))
    angles = example["main"](8, 30, 25)
    # Friction holds the finger back on its way, and closed when the pull falls again.
    assert np.ptp(angles[23]) > 0.02 and np.abs(angles[23]).max() > 0.1
    assert np.abs(angles[24]).max() == 0.0 < np.abs(angles[29]).max()


@pytest.mark.filterwarnings("ignore::DeprecationWarning")
def test_the_example_that_reaches_in_worlds_runs_on_any_model(tmp_path: Path) -> None:
    pytest.importorskip("mujoco_warp", reason="MuJoCo Warp is not installed: pip install mujoco-warp")
    pytest.importorskip("sinew.warp", reason="MuJoCo Warp cannot be used", exc_type=ImportError)
    from mujoco_models import FINGER

    (tmp_path / "finger.xml").write_text(FINGER)
    example = runpy.run_path(str(FOLDER / "myosuite_reach.py"))
    off = example["main"](str(tmp_path / "finger.xml"), "f2", 8, 16, 0.1)
    # What was found without friction does not reach as far with it.
    same, other = off["without friction", "without friction"], off["without friction", "with friction"]
    assert same < 3e-3 and other > same, off


def test_the_example_for_any_model_runs_on_the_exported_arm(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    mujoco = pytest.importorskip("mujoco", reason="MuJoCo is not installed")
    if not hasattr(mujoco.MjsPlugin, "config"):
        pytest.skip(f"MuJoCo {mujoco.__version__} configures plugins in XML alone")
    from mujoco_models import FINGER

    (tmp_path / "finger.xml").write_text(FINGER)
    example = runpy.run_path(str(FOLDER / "myosuite_arm.py"))
    example["main"](str(tmp_path / "finger.xml"), 100)
    assert "3 sheaths" in capsys.readouterr().out


def test_the_comparison_of_routes_runs(capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("optuna", reason="Optuna is not installed")
    pytest.importorskip("cmaes", reason="cmaes is not installed")
    example = runpy.run_path(str(FOLDER / "routes.py"))
    example["main"](14, 1)
    rows = [line.split("|")[1:-1] for line in capsys.readouterr().out.splitlines()[2:]]
    assert len(rows) == 12
    for design, best, blind in zip(rows[::3], rows[1::3], rows[2::3], strict=True):
        assert all(float(row[2]) < float(row[3]) for row in (design, best, blind))
        gain = 100 * (float(best[2]) / float(blind[2]) - 1)
        assert float(best[5].split(" to ")[0]) == pytest.approx(gain, abs=0.05)


def test_a_route_that_was_found_without_friction_gets_its_best_sheath() -> None:
    pytest.importorskip("optuna", reason="Optuna is not installed")
    example = runpy.run_path(str(FOLDER / "routes.py"))
    machine, muscle, parameters = example["CASES"][0]
    objective, sheath = example["routing"](machine, muscle), parameters["sheath_m"]
    best = example["with_best_sheath"](objective, {"anchor_x_m": 0.01}, sheath, 1)
    for length in (sheath.low, sheath.high):
        assert best["torque_nm"] >= objective({"anchor_x_m": 0.01, "sheath_m": length}, 1)["torque_nm"]
