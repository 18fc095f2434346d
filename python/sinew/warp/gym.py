"""The vector environment of `sinew.gym` in many worlds of MuJoCo Warp.

Needs `pip install gymnasium mujoco-warp`. See docs/worlds.md.
"""

from __future__ import annotations

from typing import Any

from .. import gym
from .._machine import Machine
from ..gym import Conditions
from ._environments import Environments

__all__ = ["MachineVectorEnv"]


class MachineVectorEnv(gym.MachineVectorEnv):
    """`sinew.gym.MachineVectorEnv` whose machines move in worlds of MuJoCo Warp.

    Episodes are drawn by the native part, from the same seeds the same; spaces, rewards and modes of reset are the same.
    `device`: of Warp. Other keywords are those of `sinew.gym.MachineVectorEnv`; `threads` draw episodes.
    """

    def __init__(self, num_envs: int = 1, *, device: Any = None, **keywords: Any) -> None:
        self._device = device
        super().__init__(num_envs, **keywords)

    def _simulated(self, conditions: Conditions, seeds: list[int], mode: str, threads: int) -> Any:
        known = conditions.machine
        machine = known if isinstance(known, Machine) else Machine(known)
        native = super()._simulated(conditions, seeds, "disabled", threads)
        return Environments(machine, native, len(seeds), mode, self._device)
