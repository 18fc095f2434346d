"""The program that tests start, machines without sensors of their own, and a wire between two terminals."""

from __future__ import annotations

import os
import select
import sys
import threading
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PROGRAM = Path(os.environ.get("SINEW_PROGRAM", ROOT / "target/debug/sinew"))
built = pytest.mark.skipif(not PROGRAM.is_file(), reason=f"{PROGRAM} is not built")
pseudo_terminals = [pytest.mark.skipif(sys.platform != "linux", reason="pseudo-terminals of Linux"), built]


def bare(source: str) -> str:
    """A machine whose only sensors are those of its drives, at 10 ms."""
    without = source.replace("[every_transmission]\n", '[every_transmission]\nload_cell = "none"\n')
    assert without != source
    return f"period_s = 0.01\n{without}\n[every_joint_encoder]\nnone = true\n"


def relay(ends: list[int], stop: threading.Event) -> None:
    """Carries octets between two terminals, so that each end is the other one's adapter."""
    while not stop.is_set():
        for end in select.select(ends, [], [], 0.1)[0]:
            try:
                os.write(ends[1 - ends.index(end)], os.read(end, 4096))
            except OSError:
                return
