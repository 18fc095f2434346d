"""What several tests need: the answers of the Rust libraries, simulated logs, a model."""

from __future__ import annotations

import json
import os
import signal
import subprocess
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, settings

import sinew

ROOT = Path(__file__).parents[2]

# A program that a shell starts in the background ignores Ctrl-C: tests of it would then wait indefinitely.
signal.signal(signal.SIGINT, signal.default_int_handler)

settings.register_profile("short", max_examples=40, deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.register_profile("long", settings.get_profile("short"), max_examples=4000)
settings.load_profile("long" if os.environ.get("SINEW_LONG") else "short")


def columns_of(file: Path) -> dict[str, Any]:
    """The columns of a simulated log, every number as it is read by Python."""
    lines = [line for line in file.read_text().splitlines() if not line.startswith("#")]
    rows = [[float(cell) for cell in line.split(",")] for line in lines[1:]]
    return dict(zip(lines[0].split(","), np.array(rows).T, strict=True))


@pytest.fixture(scope="session")
def rust() -> Iterator[Callable[..., Any]]:
    """Answers of the Rust program `sinew-py-golden`: `rust(request, **fields)`."""
    built = os.environ.get("SINEW_GOLDEN")
    manifest = ROOT / "crates/sinew-py/golden/Cargo.toml"
    command = [built] if built else ["cargo", "run", "--quiet", "--manifest-path", str(manifest)]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdin and process.stdout
        questions, answers = process.stdin, process.stdout

        def ask(request: str, **fields: Any) -> Any:
            questions.write(json.dumps({request: fields}) + "\n")
            questions.flush()
            answer = json.loads(answers.readline())
            if isinstance(answer, dict) and "error" in answer:
                raise ValueError(answer["error"])
            return answer

        yield ask
        questions.close()


@pytest.fixture(scope="session")
def log_files(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """Simulated logs of three days."""
    folder = tmp_path_factory.mktemp("logs")
    files = []
    for name, text in sinew.demo_logs(1).items():
        (folder / name).write_text(text)
        files.append(folder / name)
    return files


@pytest.fixture(scope="session")
def model(log_files: list[Path]) -> sinew.Model:
    """A model of the first two days, one candidate only."""
    return sinew.identify(log_files[:2], far="tension_out_n", models=["cell"])


@pytest.fixture(scope="session")
def arm() -> sinew.Machine:
    """The machine with most of everything."""
    return sinew.Machine("lm_arm")
