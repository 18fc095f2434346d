"""The examples run."""

from __future__ import annotations

import runpy
from pathlib import Path

import pytest

FOLDER = Path(__file__).parents[1] / "examples"


@pytest.mark.parametrize("name", ["tendon_hand", "arm_beside_twin"])
def test_an_example_with_mujoco_runs(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    mujoco = pytest.importorskip("mujoco", reason="MuJoCo is not installed")
    if not hasattr(mujoco.MjsPlugin, "config"):
        pytest.skip(f"MuJoCo {mujoco.__version__} configures plugins in XML alone")
    runpy.run_path(str(FOLDER / f"{name}.py"), run_name="__main__")
    assert capsys.readouterr().out


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
    example = runpy.run_path(str(FOLDER / "routes.py"))
    example["main"](8, 1)
    rows = [line.split("|")[1:-1] for line in capsys.readouterr().out.splitlines()[2:]]
    assert len(rows) == 12
    for _design, with_friction, without in zip(rows[::3], rows[1::3], rows[2::3], strict=True):
        assert float(with_friction[3]) >= float(without[3]) and float(with_friction[4]) <= float(without[4])
