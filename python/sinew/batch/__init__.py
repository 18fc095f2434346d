"""Models and parameters for simulators with many worlds: what `sinew.warp` and `sinew.mjx` have in common.

Needs `pip install mujoco`. See docs/batch.md.
"""

from ..mujoco import Cable, Sheath
from ._cables import damp
from ._prepare import prepare, table_of
from ._table import Table

__all__ = ["Cable", "Sheath", "Table", "damp", "prepare", "table_of"]
