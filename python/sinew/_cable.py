"""One cable in its sheath."""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, Self, TypeAlias

from . import _sinew


@dataclass(frozen=True, slots=True)
class Free:
    """Free cable."""

    #: Length, m, > 0.
    length_m: float


@dataclass(frozen=True, slots=True)
class Sheath:
    """Cable inside a bent sheath."""

    #: Length, m, > 0.
    length_m: float
    #: Sum of the magnitudes of its bends, rad, >= 0.
    bend_rad: float
    #: Relative curvature of equal parts of its length; empty for an even bend.
    curvature: Sequence[float] = ()


@dataclass(frozen=True, slots=True)
class Pulley:
    """A fixed surface or a pulley over which the cable slides."""

    #: Wrap angle, rad, >= 0.
    wrap_rad: float


#: One part of the path of a cable.
Segment: TypeAlias = Free | Sheath | Pulley


class Cable(_sinew.Cable):
    """An elastic cable with friction, from the drive's outlet to the anchor.

    `path`: free cable, sheaths and pulleys in order, with free cable at both ends; by default that of a bench. `cells`:
    pieces into which it is cut. Parameters that are not given are those of the bench's cable: `friction` (1), `viscous_s_per_m`,
    `efficiency` (0 to 1), `drag_n_s_per_m`, `drag_fade_n`, `pretension_n`, `compliance_per_n` (strain per tension),
    `sheath_compliance_per_n`. It starts without tension.

    >>> cable = Cable()
    >>> cable.settle(100.0).tension_in > 200.0
    True
    """

    __slots__ = ()

    def __new__(cls, path: Iterable[Segment] | None = None, *, cells: int = 12, **parameters: float) -> Self:
        known: dict[str, Any] = json.loads(_sinew.Cable.bench_parameters())
        for name, value in parameters.items():
            if name not in known or name == "weakening":
                expected = ", ".join(key for key in known if key != "weakening")
                raise TypeError(f"{name!r} is no parameter of a cable, expected one of {expected}")
            known[name] = _finite(name, value)
        text = None if path is None else json.dumps([_segment(segment) for segment in path])
        return super().__new__(cls, text, json.dumps(known), cells)

    def copy(self) -> Self:
        """A cable that continues independently from the same state."""
        other = super().__new__(type(self), None, None, 12)
        other._assign(self)
        return other

    def __copy__(self) -> Self:
        return self.copy()

    def __deepcopy__(self, memo: object) -> Self:
        return self.copy()


def _finite(name: str, value: Any) -> float:
    number = float(value)
    if not abs(number) < float("inf"):
        raise ValueError(f"{name} must be a finite number, but is {number}")
    return number


def _segment(segment: Segment) -> dict[str, Any]:
    match segment:
        case Free(length):
            return {"free": {"length_m": _finite("length_m", length)}}
        case Sheath(length, bend, curvature):
            parts = [_finite("curvature", part) for part in curvature]
            return {
                "sheath": {
                    "length_m": _finite("length_m", length),
                    "bend_rad": _finite("bend_rad", bend),
                    "curvature": parts,
                }
            }
        case Pulley(wrap):
            return {"pulley": {"wrap_rad": _finite("wrap_rad", wrap)}}
        case _:
            raise TypeError(f"a segment must be Free, Sheath or Pulley, but is {segment!r}")
