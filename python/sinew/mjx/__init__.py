"""Friction of sheaths on tendons for many worlds, in the JAX backend of MuJoCo XLA (MJX).

Needs `pip install mujoco-mjx`. See docs/batch.md.
"""

from ._check import connect

connect()

from ._sheaths import Sheaths, put_model  # noqa: E402
from ._step import env_step, forward, step  # noqa: E402

__all__ = ["Sheaths", "env_step", "forward", "put_model", "step"]
