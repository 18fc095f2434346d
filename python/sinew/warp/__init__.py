"""Friction of sheaths and elastic cables for thousands of worlds, in MuJoCo Warp.

Needs `pip install mujoco-warp`, version 3.6 or newer. See docs/batch.md.
"""

from ._check import connect

connect()

from ._cables import Cables  # noqa: E402
from ._machine import Machines, load  # noqa: E402
from ._sheaths import Sheaths  # noqa: E402

__all__ = ["Cables", "Machines", "Sheaths", "load"]
