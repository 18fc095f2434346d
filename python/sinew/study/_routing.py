"""Routing of one muscle: how much of its drive's tension is lost to friction, and which torques remain."""

from __future__ import annotations

import os
from dataclasses import dataclass
from itertools import combinations
from math import comb
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from .. import Machine, Routing
from ._backends import Objective

#: Names of the parameters: those of `sinew.Routing`, displacements by axis.
PARAMETERS = (
    *(f"{end}_{axis}_m" for end in ("origin", "anchor") for axis in "xyz"),
    "wrap_factor",
    "sheath_m",
    "bend_rad",
)
#: Poses over the ranges of the joints, sampled by one seed for all trials.
POSES, SEED = 48, 1
#: Fraction of the largest moment arm below which a muscle does not move a joint.
NEGLIGIBLE = 1e-3
#: Sets of muscles whose volumes are added, at most.
MAX_SETS = 20_000


def routing(machine: str | os.PathLike[str], muscle: str) -> Objective:
    """The objective of a study of the routes of one muscle's cable; its parameters are some of `PARAMETERS`.

    Values, over poses of the whole range of the joints and on the geometry and the sheath law of the machine:

    - `friction_loss`, 1: mean fraction of the drive's tension that friction takes from the anchor while the muscle pulls.
    - `torque_nm`: size of the set of torques of the joints that the muscle moves, the k-th root of its volume for k joints, or k
      muscles where there are fewer, in the pose in which it is least: all muscles at up to the drive tension that gives the
      design's largest tension in the start.
    - `frictionless_torque_nm`: the same as if no cable had friction.
    - `stroke_m`: difference between the muscle's largest and smallest length.

    All routes are compared at equal work of the drive: the muscle's tension is that of the design times the ratio of the
    design's stroke to its own, as if the gear were changed with the route.

    Raises `ValueError` for a muscle that the machine does not have.
    """
    design = Machine(machine)
    if muscle not in design.muscle_names:
        raise ValueError(f"muscle: expected one of {', '.join(design.muscle_names)}, but is {muscle!r}")
    index = design.muscle_names.index(muscle)
    low, high = design.ranges.T
    poses = np.random.default_rng(SEED).uniform(low, high, (POSES, len(low)))
    arms = np.abs(design.moment_arms(poses)[:, index]).max(axis=0)
    most = design.tension_limits[:, 1]
    return _Routes(
        machine=os.fspath(machine),
        muscle=muscle,
        index=index,
        poses=poses,
        moved=np.flatnonzero(arms > NEGLIGIBLE * arms.max()),
        anchor_n=most,
        drive_n=design.drive_tensions(design.start, most),
        stroke_m=float(np.ptp(design.lengths(poses)[:, index])),
    )


@dataclass(frozen=True, slots=True)
class _Routes:
    simulated: ClassVar[bool] = True
    machine: str
    muscle: str
    index: int
    poses: NDArray[np.float64]
    #: Joints that the muscle moves.
    moved: NDArray[np.intp]
    #: Largest tensions of the design at the anchors, and those at the drives in the start.
    anchor_n: NDArray[np.float64]
    drive_n: NDArray[np.float64]
    #: Of the design.
    stroke_m: float

    def __call__(self, parameters: dict[str, float], _seed: int) -> dict[str, float]:
        if unknown := sorted(set(parameters) - set(PARAMETERS)):
            raise ValueError(f"a parameter must be one of {', '.join(PARAMETERS)}, but is {unknown[0]!r}")
        changed = Machine(self.machine, routing={self.muscle: route_of(parameters)})
        stroke = float(np.ptp(changed.lengths(self.poses)[:, self.index]))
        tension = self.drive_n.copy()
        tension[self.index] *= self.stroke_m / stroke
        # The law is linear in the tension but for the pretension: the fraction at the largest tension stands for all.
        fraction = self.anchor_n / changed.drive_tensions(self.poses, self.anchor_n)
        moment_arms = changed.moment_arms(self.poses)[:, :, self.moved]
        with_friction = torque_set_size(moment_arms * (tension * fraction)[:, :, None])
        without = torque_set_size(moment_arms * tension[None, :, None])
        return {
            "friction_loss": float(np.mean(1.0 - fraction[:, self.index])),
            "torque_nm": float(with_friction.min()),
            "frictionless_torque_nm": float(without.min()),
            "stroke_m": stroke,
        }


def route_of(parameters: dict[str, float]) -> Routing:
    """The route that a trial's parameters describe."""

    def displacement(end: str) -> tuple[float, float, float]:
        x, y, z = (parameters.get(f"{end}_{axis}_m", 0.0) for axis in "xyz")
        return x, y, z

    return Routing(
        displacement("origin"),
        displacement("anchor"),
        parameters.get("wrap_factor", 1.0),
        parameters.get("sheath_m"),
        parameters.get("bend_rad"),
    )


def torque_set_size(torques: NDArray[np.float64]) -> NDArray[np.float64]:
    """k-th root of the volume of every set of torques that muscles pulling between none and all of their tension give.

    `torques`: of every muscle at its largest tension, N m, shape `(n, muscles, joints)`. The set is a zonotope of `k` dimensions, the
    joints or, where there are fewer muscles than joints, what these move; its volume is the sum of the volumes that all sets of k
    muscles span. Returns N m, shape `(n,)`.
    """
    _, muscles, joints = torques.shape
    dimensions = int(np.linalg.matrix_rank(torques).max())
    if (sets := comb(muscles, dimensions)) > MAX_SETS:
        raise ValueError(f"{joints} joints and {muscles} muscles have {sets} sets, more than {MAX_SETS}")
    spanned = (torques[:, list(chosen)] for chosen in combinations(range(muscles), dimensions))
    volume = sum(np.sqrt(np.maximum(np.linalg.det(set_ @ set_.swapaxes(1, 2)), 0.0)) for set_ in spanned)
    size: NDArray[np.float64] = np.power(volume, 1.0 / dimensions)
    return size
