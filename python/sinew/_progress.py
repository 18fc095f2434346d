"""What a long call says while it runs, where nobody asked for progress."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TypeAlias

#: Receives the stage of a long call and the fraction that is done, 0 to 1.
Progress: TypeAlias = Callable[[str, float], object]

LATER_S = 2.0
"""Calls that end before say nothing."""


@contextmanager
def reported(progress: Progress | None) -> Iterator[Progress | None]:
    """`progress`, or without one a line on standard error, on a terminal and in a notebook alone."""
    if progress is not None or not (sys.stderr.isatty() or "ipykernel" in sys.modules):
        yield progress
        return
    began, shown = time.monotonic(), 0

    def line(stage: str, fraction: float) -> None:
        nonlocal shown
        if time.monotonic() - began > LATER_S:
            text = f"{stage}: {100.0 * fraction:.0f} %"
            print(f"\r{text:{shown}}", end="", file=sys.stderr, flush=True)
            shown = max(shown, len(text))

    try:
        yield line
    finally:
        if shown:
            print(f"\r{'':{shown}}\r", end="", file=sys.stderr, flush=True)
