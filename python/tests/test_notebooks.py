"""The notebooks run from top to bottom, and are kept with results, which stay small."""

from __future__ import annotations

import re
import warnings
from pathlib import Path
from typing import Any

import pytest

FOLDER = Path(__file__).parents[2] / "docs/notebooks"
#: What notebooks of one name need beside the package.
EXTRA = {"mujoco": "mujoco", "gym": "gymnasium"}
NOTEBOOKS = sorted(FOLDER.glob("*.ipynb"))


def texts(notebook: Any) -> list[str]:
    """What its cells show as text and tables, numbers as #: their last digits may differ from here to there."""
    shown = [output["data"] for cell in notebook.cells for output in cell.get("outputs", []) if "data" in output]
    plain = [data[kind] for data in shown for kind in ("text/plain", "text/html") if kind in data]
    bare = [re.sub(r"np\.float64\((.*?)\)|\s", r"\1", text) for text in plain]
    return [re.sub(r"[-\d][-\d.e]*", "#", text) for text in bare]


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
    told = texts(notebook)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        nbclient.NotebookClient(
            notebook, timeout=180, kernel_name="python3", resources={"metadata": {"path": str(tmp_path)}}
        ).execute()
    assert texts(notebook) == told, "run it anew: what it shows is of an earlier version of the package"


def test_notebooks_say_nothing_of_the_computer_on_which_they_ran() -> None:
    for file in NOTEBOOKS:
        text = re.sub(r'"image/png": "[^"]*"', "", file.read_text())
        assert not re.search(r"/(home|root|Users|tmp|work|usr|opt)/|[A-Z]:\\\\|site-packages", text), file.name
