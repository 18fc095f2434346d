"""Models and parameters for simulators with many worlds: what `sinew.warp` and `sinew.mjx` have in common.

Needs `pip install mujoco`. See docs/batch.md.
"""

from ..mujoco import Sheath
from ._prepare import prepare, table_of
from ._table import Table

__all__ = ["Sheath", "Table", "prepare", "table_of"]
