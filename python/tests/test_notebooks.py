"""The notebooks run from top to bottom, and are kept with results, which stay small."""

from __future__ import annotations

import warnings
from pathlib import Path

import pytest

FOLDER = Path(__file__).parents[2] / "docs/notebooks"
#: What notebooks of one name need beside the package.
EXTRA = {"mujoco": "mujoco", "gym": "gymnasium"}
NOTEBOOKS = sorted(FOLDER.glob("*.ipynb"))


def test_there_are_notebooks() -> None:
    assert len(NOTEBOOKS) >= 5


@pytest.mark.parametrize("file", NOTEBOOKS, ids=lambda file: str(file.stem))
@pytest.mark.filterwarnings("ignore")
def test_a_notebook_runs(file: Path, tmp_path: Path) -> None:
    nbclient = pytest.importorskip("nbclient", reason="nbclient is not installed")
    pytest.importorskip("ipykernel", reason="ipykernel is not installed")
    pytest.importorskip("matplotlib", reason="matplotlib is not installed")
    if file.stem in EXTRA:
        pytest.importorskip(EXTRA[file.stem], reason=f"{EXTRA[file.stem]} is not installed")
    import nbformat

    notebook = nbformat.read(file, as_version=4)
    kept = [output.output_type for cell in notebook.cells for output in cell.get("outputs", [])]
    assert kept and set(kept) <= {"execute_result", "display_data"} and file.stat().st_size < 150_000
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        nbclient.NotebookClient(
            notebook, timeout=180, kernel_name="python3", resources={"metadata": {"path": str(tmp_path)}}
        ).execute()
