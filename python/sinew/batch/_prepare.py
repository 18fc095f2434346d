"""Models prepared for friction of sheaths without a plugin."""

from __future__ import annotations

import copy
from collections.abc import Mapping
from typing import Any
from weakref import WeakKeyDictionary

import mujoco
import numpy as np

from ..mujoco._sheaths import MIN_FRICTION, Sheath, check_impedance, match, sticking
from ._table import Table, table_from, tendon_names, tendon_of_actuators

#: Fewest iterations of MuJoCo's solver, and of its line search, that keep the friction of sheaths. With 4 and 8, as many set
#: them for speed, half of the work of friction is given back; with 10 and 20 at most one percent.
FEWEST_ITERATIONS, FEWEST_LS_ITERATIONS = 10, 20

_tables: WeakKeyDictionary[Any, Table] = WeakKeyDictionary()


def prepare(model: Any, sheaths: Mapping[str, Sheath], *, impedance: float = 0.995) -> Any:
    """A copy of a `mujoco.MjModel` with the friction constraints that sheaths of `sinew.warp` and `sinew.mjx` need.

    `sheaths`, `impedance`: as of `sinew.mujoco.add_sheaths`; a tendon without a name has `#` and its number. The copy has
    no plugin: alone, MuJoCo steps it as if the sheaths had no friction. Limits of the actuators' forces apply before friction.

    Raises `ValueError` for a model without tendons, with plugins, prepared already, or with options of MuJoCo that lose
    friction; a name that matches nothing; a parameter outside of its domain. `TypeError` for anything but a model.
    """
    if not isinstance(model, mujoco.MjModel):
        raise TypeError(f"model must be a mujoco.MjModel, but is {type(model).__name__}")
    check_impedance(impedance)
    if model in _tables:
        raise ValueError("the model is prepared already: prepare the one that it was made of, with all sheaths at once")
    check_options(model)
    names, tendon = tendon_names(model), tendon_of_actuators(model)
    found = match(names, [bool((tendon == k).any()) for k in range(len(names))], sheaths, Sheath)
    chosen = np.array([sheath is not None for sheath in found])
    made = copy.copy(model)
    made.tendon_frictionloss[chosen] = np.maximum(made.tendon_frictionloss[chosen], MIN_FRICTION)
    made.tendon_solref_fri[chosen], made.tendon_solimp_fri[chosen] = sticking(model.opt, impedance)
    limited = np.array(model.actuator_forcelimited, dtype=np.bool_)
    # MuJoCo would apply them after friction.
    made.actuator_forcelimited[(tendon >= 0) & chosen[tendon]] = 0
    _tables[made] = table_from(made, found, limited)
    return made


def table_of(model: Any) -> Table:
    """The sheaths of a model that `prepare` has made; raises `ValueError` for any other, copies of it included."""
    known = isinstance(model, mujoco.MjModel) and model in _tables
    if not known:
        raise ValueError("the model is not prepared: give the one that sinew.batch.prepare returned, not a copy of it")
    return _tables[model]


def check_options(model: Any) -> None:
    """Raises `ValueError` for options or parts of a model with which friction would be lost or applied twice."""
    if model.nplugin:
        raise ValueError(
            f"the model has {model.nplugin} engine plugins, which run on no batch simulator: prepare one without "
            "(add_sheaths and add_cables of sinew.mujoco put plugins into models)"
        )
    check_solver(model.opt)


def check_solver(option: Any) -> None:
    """Raises `ValueError` for options, of a `MjModel` or of one in Warp, with which friction would be lost."""
    bits = mujoco.mjtDisableBit
    for bit, name in ((bits.mjDSBL_CONSTRAINT, "constraint"), (bits.mjDSBL_FRICTIONLOSS, "frictionloss")):
        if option.disableflags & bit:
            raise ValueError(f'friction of sheaths is a constraint, but the model disables them: <flag {name}="disable"/>')
    for name, fewest in (("iterations", FEWEST_ITERATIONS), ("ls_iterations", FEWEST_LS_ITERATIONS)):
        if getattr(option, name) < fewest:
            raise ValueError(
                f"option {name} is {getattr(option, name)}, expected at least {fewest}: with fewer, the solver gives the work of "
                "friction back (at 4 and 8 half of it), without any warning. More cost nothing: it ends once all worlds have converged"
            )
