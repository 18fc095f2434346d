"""One environment, as most libraries for reinforcement learning want it."""

from __future__ import annotations

import json
from typing import Any, Unpack

import gymnasium
import numpy as np
from gymnasium.vector import AutoresetMode
from numpy.typing import ArrayLike, NDArray

from ._conditions import ConditionKeywords, Conditions, ObservationPart
from ._picture import Picture
from ._vector import MachineVectorEnv


class MachineEnv(gymnasium.Env[NDArray[np.float32], NDArray[np.float32]]):
    """One simulated machine as a Gymnasium environment; keywords are the fields of `Conditions`.

    With the same seed and actions it does the same, bit for bit, as an environment of a `MachineVectorEnv`. Actions: shape
    `(muscles,)`, from -1 to 1, clipped. `info["error"]`: distance of the end point, m, or root-mean-square error of the
    joints as a fraction of their ranges. `render_mode`: `"rgb_array"` for pictures, which need MuJoCo and matplotlib;
    `"human"` of `gymnasium.make` shows them in a window.
    """

    metadata: dict[str, Any] = {"render_modes": ["rgb_array"], "render_fps": 100}

    def __init__(self, *, render_mode: str | None = None, **conditions: Unpack[ConditionKeywords]) -> None:
        if render_mode not in (None, "rgb_array"):
            window = ': gymnasium.make(.., render_mode="human") opens a window' if render_mode == "human" else ""
            raise ValueError(f'render_mode must be None or "rgb_array", but is {render_mode!r}{window}')
        self._many = MachineVectorEnv(1, autoreset_mode=AutoresetMode.DISABLED, **conditions)
        self.render_mode = render_mode
        self.metadata = self.metadata | {"render_fps": round(1000 / self._many.environments.interval_ms)}
        self._picture: Picture | None = None
        if render_mode is not None:
            design = json.loads(self._many.environments.design())
            self._picture = Picture(Conditions(**conditions).machine, design["site"], design["axes"])
        # The desired pose that the agent was last told, of pictures.
        self._desired: NDArray[np.float64] | None = None
        self.observation_space = self._many.single_observation_space
        self.action_space = self._many.single_action_space

    @property
    def many(self) -> MachineVectorEnv:
        """The vector environment of which this is the only one."""
        return self._many

    @property
    def observation_parts(self) -> dict[str, ObservationPart]:
        """Where in an observation what stands, by name."""
        return self._many.observation_parts

    def __repr__(self) -> str:
        return f"MachineEnv({self._many.told})"

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[NDArray[np.float32], dict[str, Any]]:
        """Begins an episode: the first of a seed, or the next one of this environment."""
        super().reset(seed=seed)
        observations, infos = self._many.reset(seed=seed)
        self._keep(observations[0])
        return observations[0], {"error": float(infos["error"][0])}

    def step(self, action: ArrayLike) -> tuple[NDArray[np.float32], float, bool, bool, dict[str, Any]]:
        """One action: observation, reward, terminated, truncated, info.

        Raises `gymnasium.error.ResetNeeded` before the first `reset`, and after the end of an episode.
        """
        given = np.asarray(action)
        if given.shape != self.action_space.shape:
            raise ValueError(f"action must have the shape {self.action_space.shape}, but has {given.shape}")
        observations, rewards, terminated, truncated, infos = self._many.step(given[np.newaxis])
        self._keep(observations[0])
        ended = bool(terminated[0]), bool(truncated[0])
        return observations[0], float(rewards[0]), *ended, {"error": float(infos["error"][0])}

    def render(self) -> NDArray[np.uint8] | None:
        """True pose and what is desired as a picture, shape `(480, 480, 3)`; `None` without a `render_mode`.

        What is desired is green: a ring where the end point should be; of a machine without an end point the
        pose, as thin lines.
        """
        if self._picture is None:
            return None
        return self._picture.draw(self._many.environments.poses[0], self._desired)

    def _keep(self, observation: NDArray[np.float32]) -> None:
        if self._picture is not None:
            part = self.observation_parts["target"]
            self._desired = observation[part.start : part.stop].astype(np.float64)

    def close(self) -> None:
        """Frees the simulated machine; every later call is refused."""
        self._many.close()
