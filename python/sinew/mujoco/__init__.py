"""Friction of sheaths and elastic cables in any MuJoCo model with tendons.

Importing this module registers two engine plugins with the MuJoCo of this process, `sinew.sheath` and `sinew.cable`;
models that use them load, step, copy and pickle as any other. Needs `pip install mujoco`, version 3.3.0 or newer. See
docs/mujoco.md.
"""

from ._connect import connect

connect()

from ._cables import Cable, StiffCableWarning, add_cables  # noqa: E402
from ._machine import cables_of, calibrate_from, load, sheaths_of, spec_of  # noqa: E402
from ._sheaths import Sheath, add_sheaths  # noqa: E402
from ._tensions import Tensions, tensions  # noqa: E402

__all__ = [
    "Cable",
    "Sheath",
    "StiffCableWarning",
    "Tensions",
    "add_cables",
    "add_sheaths",
    "cables_of",
    "calibrate_from",
    "load",
    "sheaths_of",
    "spec_of",
    "tensions",
]
