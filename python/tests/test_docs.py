"""The code of the documentation runs as it stands there."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).parents[2]
BLOCK = re.compile(r"^```python\n(.*?)^```", re.MULTILINE | re.DOTALL)


PAGES = ["docs/python.md", "docs/mujoco.md", "docs/batch.md", "docs/worlds.md", "docs/gradients.md", "docs/gym.md", "docs/study.md"]
PAGES += ["docs/tutorials/policy.md", "README.md"]


@pytest.mark.parametrize("page", PAGES)
def test_the_blocks_of_a_page_run_one_after_the_other(
    page: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    if "mujoco" in page or "policy" in page or page == "README.md":
        mujoco = pytest.importorskip("mujoco", reason="MuJoCo is not installed")
        if not hasattr(mujoco.MjsPlugin, "config"):
            pytest.skip(f"MuJoCo {mujoco.__version__} configures plugins in XML alone")
    if "batch" in page:
        pytest.importorskip("mujoco.mjx", reason="MJX is not installed", exc_type=ImportError)
        pytest.importorskip("mujoco_warp", reason="MuJoCo Warp is not installed")
    if "worlds" in page:
        pytest.importorskip("mujoco_warp", reason="MuJoCo Warp is not installed")
    if "gradients" in page:
        pytest.importorskip("jax", reason="JAX is not installed")
    if "policy" in page:
        pytest.importorskip("matplotlib", reason="matplotlib is not installed")
    if "gym" in page or "policy" in page or page == "README.md":
        pytest.importorskip("gymnasium", reason="Gymnasium is not installed")
    if "study" in page:
        pytest.importorskip("polars", reason="polars is not installed")
    text = (ROOT / page).read_text(encoding="utf-8")
    blocks = list(BLOCK.finditer(text))
    assert blocks
    # Programs of a page run as such.
    names: dict[str, Any] = {"__name__": "__main__"}
    for block in blocks:
        # So that an error shows its line on the page.
        above = "\n" * text[: block.start(1)].count("\n")
        exec(compile(above + block[1], page, "exec"), names)
    if "jax" in names:
        # Numbers of 64 bits are for this page alone.
        names["jax"].config.update("jax_enable_x64", False)


def test_the_reference_is_that_of_the_sources() -> None:
    done = subprocess.run([sys.executable, "python/tools/make_api.py", "--check"], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
