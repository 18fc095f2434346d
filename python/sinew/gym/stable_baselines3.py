"""The vector environment for Stable-Baselines3, which has a vector interface of its own. Needs `pip install stable-baselines3`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from gymnasium.vector import AutoresetMode
from numpy.typing import NDArray
from stable_baselines3.common.vec_env.base_vec_env import VecEnv

from ._vector import MachineVectorEnv


class MachineVecEnv(VecEnv):
    """Many simulated machines as a `VecEnv`; keywords are those of `MachineVectorEnv`, without `autoreset_mode` and `copy`.

    Episodes that end begin again in the same step; `infos[k]["terminal_observation"]` is the last observation of the old
    one and `infos[k]["TimeLimit.truncated"]` tells whether time alone ended it.
    """

    def __init__(self, num_envs: int = 1, **keywords: Any) -> None:
        self.vector = MachineVectorEnv(num_envs, autoreset_mode=AutoresetMode.SAME_STEP, **keywords)
        self.render_mode = None
        self._next: NDArray[Any] = np.zeros(self.vector.action_space.shape or (), dtype=np.float32)
        super().__init__(num_envs, self.vector.single_observation_space, self.vector.single_action_space)

    def reset(self) -> NDArray[np.float32]:
        """Begins an episode in every environment, with the seeds that `seed` was given."""
        seeds = self._seeds if any(seed is not None for seed in self._seeds) else None
        observations, infos = self.vector.reset(seed=seeds)
        self.reset_infos = [{"error": float(error)} for error in infos["error"]]
        self._reset_seeds()
        self._reset_options()
        return observations

    def step_async(self, actions: NDArray[Any]) -> None:
        """Keeps the actions for `step_wait`."""
        self._next = actions

    def step_wait(self) -> tuple[NDArray[np.float32], NDArray[np.float64], NDArray[np.bool_], list[dict[str, Any]]]:
        """Steps every environment: observations, rewards, whether episodes ended, infos."""
        observations, rewards, terminated, truncated, told = self.vector.step(self._next)
        infos: list[dict[str, Any]] = [{"error": float(error)} for error in told["error"]]
        ended = terminated | truncated
        for index in np.flatnonzero(ended):
            infos[index] = {
                "error": float(told["final_info"]["error"][index]),
                "terminal_observation": told["final_obs"][index],
                "TimeLimit.truncated": bool(truncated[index] and not terminated[index]),
            }
            self.reset_infos[index] = {"error": float(told["error"][index])}
        return observations, rewards, ended, infos

    def close(self) -> None:
        """Frees the simulated machines; every later call is refused."""
        self.vector.close()

    def get_attr(self, attr_name: str, indices: None | int | Sequence[int] = None) -> list[Any]:
        """An attribute of the vector environment, as often as there are indices."""
        return [getattr(self.vector, attr_name) for _ in self._get_indices(indices)]

    def set_attr(self, attr_name: str, value: Any, indices: None | int | Sequence[int] = None) -> None:
        """Refused: the environments are no Python objects."""
        raise AttributeError(f"{attr_name} cannot be set: the environments are no Python objects")

    def env_method(
        self, method_name: str, *method_args: Any, indices: None | int | Sequence[int] = None, **method_kwargs: Any
    ) -> list[Any]:
        """Refused: the environments are no Python objects."""
        raise AttributeError(f"{method_name} cannot be called: the environments are no Python objects")

    def env_is_wrapped(
        self, wrapper_class: type[Any], indices: None | int | Sequence[int] = None
    ) -> list[bool]:
        """False for each."""
        return [False for _ in self._get_indices(indices)]
