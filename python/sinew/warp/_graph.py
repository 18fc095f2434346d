"""Launches that are repeated, captured in a graph."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import warp as wp


class Graph:
    """Launches of `work`, run as they are at first and replayed from a graph from the second time on.

    Graphs exist on CUDA devices, and on processors where this version of Warp has them. `work` must not wait for the device.
    """

    def __init__(self, work: Callable[[], None], device: Any) -> None:
        self._work, self._device = work, wp.get_device(device)
        # Graphs that can be saved came with those of processors.
        self._possible = self._device.is_cuda or hasattr(wp, "capture_save")
        self._ready = False
        self._graph: Any = None

    def launch(self) -> None:
        """All launches, once."""
        if not self._ready or not self._possible:
            # Kernels are loaded before a capture.
            self._work()
            self._ready = True
            return
        if self._graph is None:
            with wp.ScopedCapture(device=self._device) as capture:
                self._work()
            self._graph = capture.graph
        wp.capture_launch(self._graph)

    def forget(self) -> None:
        """Captures anew at the next launch: where an array that the launches read or write was replaced."""
        self._graph = None
