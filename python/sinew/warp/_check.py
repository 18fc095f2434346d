"""Whether this MuJoCo Warp is one that sheaths work with."""

from __future__ import annotations

from functools import cache
from importlib.metadata import PackageNotFoundError, version

#: The first with callbacks.
OLDEST = (3, 6)


def connect() -> None:
    """Raises `ImportError` with the versions where MuJoCo Warp is not there or does not fit."""
    try:
        import mujoco_warp
        import warp  # noqa: F401
    except ModuleNotFoundError as error:
        if error.name not in ("mujoco_warp", "warp"):
            raise
        raise ImportError("sinew.warp needs MuJoCo Warp: pip install mujoco-warp", name=error.name) from error
    found = _version("mujoco-warp")
    numbers = tuple(int(part) for part in found.split(".")[:2] if part.isdigit())
    if numbers < OLDEST or not hasattr(mujoco_warp, "put_model"):
        expected = ".".join(map(str, OLDEST))
        raise ImportError(f"sinew.warp needs MuJoCo Warp {expected} or newer, but it is {found} (Warp {_version('warp-lang')})")


def _version(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:
        return "of an unknown version"


@cache
def hoist_holds_and_slides() -> None:
    """Raises `ImportError` where a hoist does not hold at 0.99 of both edges of friction, and slide at 1.01."""
    import mujoco_warp as mjw
    import numpy as np

    from ..batch import _hoist
    from ._sheaths import Sheaths

    model, pulls = _hoist.model(), _hoist.pulls()
    try:
        m = mjw.put_model(model)
        d = mjw.make_data(model, nworld=len(pulls), njmax=16)
        Sheaths(model, worlds=len(pulls))._attach(m, d)
        d.ctrl.assign(pulls[:, np.newaxis].astype(np.float32))
        for _ in range(_hoist.STEPS):
            mjw.step(m, d)
        reason = _hoist.wrong(d.qvel.numpy()[:, 0])
    except (AttributeError, TypeError, RuntimeError) as error:
        raise ImportError(f"{_pair()}: a hoist with a sheath cannot be stepped: {error}") from error
    if reason is not None:
        raise ImportError(f"{_pair()}: {reason}")


def _pair() -> str:
    import sinew

    versions = f"mujoco-warp {_version('mujoco-warp')} and warp-lang {_version('warp-lang')}"
    return f"sinew {sinew.__version__} cannot use {versions}"
