"""Many environments at once, stepped by the native part."""

from __future__ import annotations

import secrets
from collections.abc import Sequence
from typing import Any, TypeAlias, TypeVar, Unpack

import numpy as np
from gymnasium.error import ResetNeeded
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import ArrayLike, NDArray

from .. import _sinew
from .._machine import Machine
from .._refused import whole
from ._conditions import ConditionKeywords, Conditions, ObservationPart, parts_of, spaces_of

_Floats: TypeAlias = NDArray[np.float64]
_Singles: TypeAlias = NDArray[np.float32]
_Flags: TypeAlias = NDArray[np.bool_]
_Kind = TypeVar("_Kind", bound=np.generic)

_MODES = {
    AutoresetMode.NEXT_STEP: "next_step",
    AutoresetMode.SAME_STEP: "same_step",
    AutoresetMode.DISABLED: "disabled",
}


class MachineVectorEnv(VectorEnv[_Singles, _Singles, NDArray[Any]]):
    """Many simulated machines in one Gymnasium vector environment.

    `num_envs`: how many. `autoreset_mode`: when an environment whose episode has ended begins another one; `threads`: threads
    that step them, 1 for the calling one; `copy`: whether every call returns arrays of its own, or those of the environment,
    which the next call overwrites. Further keywords are the fields of `Conditions`.

    What an environment does depends on its seed and its actions alone, bit for bit, not on `num_envs` or `threads`.
    Actions: shape `(num_envs, muscles)`, from -1 to 1, clipped. `infos["error"]`: distance of the end point, m, or
    root-mean-square error of the joints as a fraction of their ranges, shape `(num_envs,)`.
    """

    def __init__(
        self,
        num_envs: int = 1,
        *,
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
        threads: int = 1,
        copy: bool = True,
        render_mode: None = None,
        **conditions: Unpack[ConditionKeywords],
    ) -> None:
        if render_mode is not None:
            raise ValueError(f"render_mode must be None: a MachineEnv draws pictures, but is {render_mode!r}")
        self.autoreset_mode = mode = AutoresetMode(autoreset_mode)
        self.metadata = {"autoreset_mode": mode, "render_modes": []}
        if isinstance(num_envs, str | Machine):
            raise TypeError(f"num_envs must be a whole number, but is {num_envs!r}: the machine is a keyword, machine={num_envs!r}")
        self.num_envs, self.render_mode, self._copy = whole("num_envs", num_envs, 1), None, copy
        known = Conditions(**conditions)
        entropy = secrets.randbits(48)
        seeds = [entropy + index for index in range(num_envs)]
        self._native: _sinew.Environments | None = self._simulated(known, seeds, _MODES[mode], whole("threads", threads, 1))
        interval, machine = self._native.interval_ms, known.name
        #: What a representation tells.
        self.told = f"{machine}, {known.task}, {known.actuation}, {known.steps} steps of {interval} ms"
        self.single_observation_space, self.single_action_space = spaces_of(self._native)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)
        width, muscles = self._native.observations, self._native.actions
        self._observations, self._last = (np.zeros((num_envs, width), dtype=np.float32) for _ in range(2))
        self._actions = np.zeros((num_envs, muscles), dtype=np.float32)
        self._rewards, self._errors, self._last_errors = (np.zeros(num_envs) for _ in range(3))
        self._terminated, self._truncated = (np.zeros(num_envs, dtype=np.bool_) for _ in range(2))
        self._all = np.ones(num_envs, dtype=np.bool_)
        # Environments without an episode: before the first reset, and after an end where nothing resets them.
        self._idle = np.ones(num_envs, dtype=np.bool_)

    def _simulated(self, conditions: Conditions, seeds: list[int], mode: str, threads: int) -> _sinew.Environments:
        return conditions.environments(seeds, mode, threads)

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self.num_envs} of {self.told})"

    @property
    def environments(self) -> _sinew.Environments:
        """The native environments: bounds of commands, true poses."""
        if self._native is None:
            raise ValueError("the environment is closed")
        return self._native

    @property
    def observation_parts(self) -> dict[str, ObservationPart]:
        """Where in an observation what stands, by name."""
        return parts_of(self.environments)

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[_Singles, dict[str, Any]]:
        """Begins an episode in every environment, or where `options["reset_mask"]`, shape `(num_envs,)`, is true.

        `seed`: one for each environment, or that of the first, the next ones having the next; without it every environment goes
        on with its own random numbers.
        """
        native = self.environments
        mask = None if options is None else options.get("reset_mask")
        if mask is not None:
            flags = np.asarray(mask)
            if flags.dtype != np.bool_ or flags.shape != (self.num_envs,) or not flags.any():
                raise ValueError(f"reset_mask must be {self.num_envs} booleans, some of them true, but is {mask!r}")
            mask = flags.tolist()
        if seed is None:
            native.reset(None, mask, self._observations, self._errors)
        else:
            if isinstance(seed, (Sequence, np.ndarray)):
                seeds = list(seed)
            else:
                seeds = [int(seed) + index for index in range(self.num_envs)]
            if len(seeds) != self.num_envs:
                raise ValueError(f"seed must have {self.num_envs} entries, but has {len(seeds)}")
            chosen = [mask is None or mask[index] for index in range(self.num_envs)]
            seeded = [given is not None and one for given, one in zip(seeds, chosen, strict=True)]
            numbers = [0 if given is None else int(given) for given in seeds]
            if any(not 0 <= number < 1 << 64 for number in numbers):
                raise ValueError(f"seed must be 0 or more and below 2^64, but is {seed}")
            native.reset(numbers, seeded, self._observations, self._errors)
            others = [one and not with_seed for one, with_seed in zip(chosen, seeded, strict=True)]
            if any(others):
                native.reset(None, others, self._observations, self._errors)
        self._idle[self._all if mask is None else np.array(mask)] = False
        return self._told(self._observations), self._infos(self._all if mask is None else np.array(mask))

    def step(self, actions: ArrayLike) -> tuple[_Singles, _Floats, _Flags, _Flags, dict[str, Any]]:
        """One action for every environment: observations, rewards, terminated, truncated, infos.

        Raises `gymnasium.error.ResetNeeded` before the first `reset` and, where nothing resets them, after the end of an episode.
        """
        native = self.environments
        if self._idle.any():
            first = int(self._idle.argmax())
            why = "ended" if self._terminated[first] or self._truncated[first] else "not begun"
            raise ResetNeeded(f"the episode of environment {first} has {why}: call reset() before step()")
        given = np.asarray(actions)
        if given.shape != self._actions.shape or given.dtype.kind not in "fiub":
            expected = f"real numbers in the shape {self._actions.shape}"
            raise ValueError(f"actions must be {expected}, but are {given.dtype} in {given.shape}")
        # Beyond the largest float32 a number would become infinite; both are clipped to -1 and 1 alike.
        with np.errstate(over="ignore"):
            self._actions[...] = given
        native.step(
            self._actions,
            self._observations,
            self._rewards,
            self._terminated,
            self._truncated,
            self._errors,
            self._last,
            self._last_errors,
        )
        if self.autoreset_mode is AutoresetMode.DISABLED:
            self._idle = self._terminated | self._truncated
        infos = self._infos(self._all)
        if self.autoreset_mode is AutoresetMode.SAME_STEP:
            ended = self._terminated | self._truncated
            if ended.any():
                last = np.full(self.num_envs, None, dtype=object)
                for index in np.flatnonzero(ended):
                    last[index] = self._last[index].copy()
                final = {"error": np.where(ended, self._last_errors, 0.0), "_error": ended.copy()}
                infos |= {"final_obs": last, "_final_obs": ended, "final_info": final, "_final_info": ended.copy()}
        outcomes = self._told(self._rewards), self._told(self._terminated), self._told(self._truncated)
        return self._told(self._observations), *outcomes, infos

    def close_extras(self, **_: Any) -> None:
        """Frees the simulated machines; every later call is refused."""
        self._native = None

    def _told(self, array: NDArray[_Kind]) -> NDArray[_Kind]:
        return array.copy() if self._copy else array

    def _infos(self, of: _Flags) -> dict[str, Any]:
        return {"error": self._told(self._errors), "_error": self._told(of)}
