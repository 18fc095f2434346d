"""Where MuJoCo Warp calls us: its callback, shared with whatever is there already."""

from __future__ import annotations

import weakref
from collections.abc import Callable
from typing import Any, Protocol


class Part(Protocol):
    """Something that acts on the actuators' forces of one model and its data."""

    def act(self, m: Any, d: Any) -> None:
        """Launches kernels: no allocation, nothing that waits."""


class Hub:
    """The one callback of a model: what was there before, then our parts of the data that is stepped.

    Other models, which share the callback where a copy of theirs does, are left alone.
    """

    def __init__(self, m: Any) -> None:
        self.before: Callable[[Any, Any], None] | None = m.callback.act_bias
        # A copy of a model (`dataclasses.replace`) shares its arrays.
        self._mine = weakref.ref(m.tendon_frictionloss)
        self._parts: dict[int, tuple[weakref.ref[Any], list[Part]]] = {}

    def __call__(self, m: Any, d: Any) -> None:
        if self.before is not None:
            self.before(m, d)
        known = self._parts.get(id(d))
        if known is not None and known[0]() is d:
            for part in known[1]:
                part.act(m, d)
        elif m.tendon_frictionloss is self._mine():
            raise RuntimeError(
                "this data of the model has no sheaths or cables, and would be stepped without friction: attach them to it as well"
            )

    def add(self, d: Any, part: Part) -> None:
        """Lets a part act on this data after those that do already."""
        kept = {key: entry for key, entry in self._parts.items() if entry[0]() is not None}
        parts = kept[id(d)][1] if id(d) in kept else []
        kept[id(d)] = (weakref.ref(d), [*parts, part])
        self._parts = kept

    def remove(self, d: Any, part: Part) -> None:
        """Takes a part out; data without any is left alone from then on only if no other has some."""
        known = self._parts.get(id(d))
        if known is not None:
            self._parts[id(d)] = (known[0], [one for one in known[1] if one is not part])


def hub_of(m: Any) -> Hub:
    """The callback of a model, put there if it is not there yet."""
    there = m.callback.act_bias
    if isinstance(there, Hub) and there._mine() is m.tendon_frictionloss:
        return there
    made = Hub(m)
    m.callback.act_bias = made
    return made
