"""Registration of the plugins with the MuJoCo of this process."""

from __future__ import annotations

import ctypes
import os
import sys
from pathlib import Path
from typing import Any

from .. import _sinew

#: Older versions have another interface of plugins and no `mujoco.introspect` in this form.
OLDEST = (3, 3, 0)


def version(mujoco: Any) -> tuple[int, ...]:
    """Version of MuJoCo as numbers."""
    numbers = (part for part in str(mujoco.__version__).split("."))
    return tuple(int(part) for part in numbers if part.isdigit())


def connect() -> None:
    """Registers the plugins; raises `ImportError` with the reason where that is not possible."""
    try:
        import mujoco
    except ModuleNotFoundError as error:
        if error.name != "mujoco":
            raise
        raise ImportError("sinew.mujoco needs MuJoCo: pip install mujoco", name="mujoco") from error
    if version(mujoco) < OLDEST:
        expected = ".".join(map(str, OLDEST))
        raise ImportError(f"sinew.mujoco needs MuJoCo {expected} or newer, but it is {mujoco.__version__}")
    from ._layout import Layout, Mismatch

    try:
        layout = Layout()
        layout.check(mujoco)
        places = layout.places()
    except (Mismatch, ImportError) as error:
        raise ImportError(f"sinew.mujoco cannot use MuJoCo {mujoco.__version__}: {error}") from error
    library = _library(mujoco)
    numbers = (ctypes.c_int64 * (2 * len(places)))(*(number for place in places for number in place))
    functions = (getattr(library, name) for name in ("mjp_registerPlugin", "mj_getPluginConfig", "mju_warning"))
    addresses = [ctypes.cast(function, ctypes.c_void_p).value or 0 for function in functions]
    # The structure `Connect` of the crate `sinew-mujoco`.
    given = (ctypes.c_size_t * 5)(*addresses, ctypes.addressof(numbers), len(places))
    kind = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_void_p, ctypes.c_char_p, ctypes.c_size_t)
    message = ctypes.create_string_buffer(400)
    if kind(_sinew.mujoco_connect_address())(ctypes.byref(given), message, len(message)) != 0:
        reason = message.value.decode(errors="replace")
        raise ImportError(f"sinew.mujoco cannot use MuJoCo {mujoco.__version__}: {reason}")


def _library(mujoco: Any) -> ctypes.CDLL:
    """The library that MuJoCo's package has loaded."""
    folder = Path(os.fspath(mujoco.__file__)).parent
    name = {
        "win32": "mujoco.dll",
        "darwin": f"libmujoco.{mujoco.__version__}.dylib",
    }.get(sys.platform, f"libmujoco.so.{mujoco.__version__}")
    # Newer packages keep it beside their core modules, which may be another folder.
    folders = [folder, *(Path(place) for place in mujoco.__path__)]
    found = next((place / name for place in folders if (place / name).is_file()), None)
    if found is None:
        raise ImportError(f"sinew.mujoco cannot find {name} in {folder}")
    if sys.platform == "win32":
        return ctypes.CDLL(str(found))
    # Only what is loaded already: a second copy would have plugins of its own.
    return ctypes.CDLL(str(found), mode=os.RTLD_NOW | os.RTLD_NOLOAD)
