"""Whether this MJX is one that sheaths work with."""

from __future__ import annotations

from functools import cache
from importlib.metadata import PackageNotFoundError, version
from typing import Any

#: The parts of MJX of which a step is composed.
PARTS = (
    "fwd_position", "sensor_pos", "fwd_velocity", "sensor_vel", "fwd_actuation", "fwd_acceleration", "solve", "sensor_acc",
    "euler", "implicit", "put_model", "make_data",
)  # fmt: skip
#: What sheaths read and write beside the public fields of MJX's data, and of its model.
OF_DATA = (
    "actuator_moment", "efc_D", "efc_aref", "efc_force", "efc_frictionloss", "ne", "ten_velocity", "ten_wrapadr",
    "ten_wrapnum", "wrap_obj", "wrap_xpos",
)  # fmt: skip
OF_MODEL = ("dof_hasfrictionloss", "tendon_hasfrictionloss")


def connect() -> None:
    """Raises `ImportError` with the versions where MJX is not there or does not fit."""
    try:
        import jax  # noqa: F401
        import mujoco.mjx as mjx
    except ModuleNotFoundError as error:
        if error.name is None or error.name.split(".")[0] not in ("jax", "jaxlib", "mujoco", "scipy", "etils", "trimesh"):
            raise
        raise ImportError("sinew.mjx needs MJX: pip install mujoco-mjx", name=error.name) from error
    except (ImportError, AttributeError, TypeError) as error:
        raise ImportError(f"{versions()}: MJX cannot be imported: {error}") from error
    missing = [part for part in PARTS if not hasattr(mjx, part)]
    if missing:
        raise ImportError(f"{versions()}: it has no {', '.join(missing)}")


def check_fields(model: Any, data: Any) -> None:
    """Raises `ImportError` where a model or data of MJX lacks a field that sheaths need."""
    missing = [f"Model._impl.{name}" for name in OF_MODEL if not hasattr(getattr(model, "_impl", None), name)]
    missing += [f"Data._impl.{name}" for name in OF_DATA if not hasattr(getattr(data, "_impl", None), name)]
    if missing:
        raise ImportError(f"{versions()}: it has no {', '.join(missing)}")


@cache
def hoist_holds_and_slides() -> None:
    """Raises `ImportError` where a hoist does not hold at 0.99 of both edges of friction, and slide at 1.01."""
    import jax
    import mujoco.mjx as mjx
    import numpy as np

    from ..batch import _hoist
    from ._sheaths import put
    from ._step import step

    try:
        model = _hoist.model()
        mx, sheaths = put(model)
        data = mjx.make_data(model)
        check_fields(mx, data)

        # One world after the other: compiled for many, it would take three times as long.
        stepped = jax.jit(lambda data: step(mx, data, sheaths))
        speeds = []
        for pull in _hoist.pulls():
            world = data.replace(ctrl=data.ctrl.at[0].set(pull))
            for _ in range(_hoist.STEPS):
                world = stepped(world)
            speeds.append(np.asarray(world.qvel)[0])
    except (AttributeError, TypeError, KeyError) as error:
        raise ImportError(f"{versions()}: a hoist with a sheath cannot be stepped: {error}") from error
    # In float32 a held cable trembles, without drift, by 1e-4 m/s.
    trembling = 2e-4 if mx.opt.gravity.dtype == np.float32 else 0.0
    reason = _hoist.wrong(np.where(np.abs(speeds) < trembling, 0.0, speeds))
    if reason is not None:
        raise ImportError(f"{versions()}: {reason}")


def versions() -> str:
    """The beginning of an error."""
    import sinew

    known = []
    for package in ("mujoco-mjx", "mujoco", "jax"):
        try:
            known.append(f"{package} {version(package)}")
        except PackageNotFoundError:
            known.append(f"{package} of an unknown version")
    return f"sinew {sinew.__version__} cannot use {', '.join(known)}"
