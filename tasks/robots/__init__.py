"""Tasks on MuJoCo. Importing this package imports MuJoCo; Gymnasium does so when such an
environment is made, `import tiloilc.tasks` does not."""

from __future__ import annotations

import ctypes
import os
import sys

from gymnasium.error import DependencyNotInstalled


def drawing_library() -> str:
    """What MuJoCo can draw with where there is no screen: "egl", "osmesa", or "disabled"."""
    if _egl_devices():
        return "egl"
    try:
        ctypes.CDLL("libOSMesa.so.8")
    except OSError:
        return "disabled"
    return "osmesa"


def _egl_devices() -> int:
    """How many devices EGL knows: the library is often there without a driver.

    It is asked apart from MuJoCo, which can no longer use OSMesa once it has loaded EGL.
    """
    try:
        egl = ctypes.CDLL("libEGL.so.1")
    except OSError:
        return 0
    egl.eglGetProcAddress.restype = ctypes.c_void_p
    address = egl.eglGetProcAddress(b"eglQueryDevicesEXT")
    if not address:
        return 0
    count = ctypes.c_int(0)
    query = ctypes.CFUNCTYPE(ctypes.c_uint, ctypes.c_int, ctypes.c_void_p, ctypes.c_void_p)(address)
    return count.value if query(0, None, ctypes.byref(count)) else 0


def _import_mujoco() -> None:
    """Import MuJoCo with a way of drawing that works without a screen, or with none.

    MuJoCo reads MUJOCO_GL when it is imported, and not again. Raises DependencyNotInstalled if it
    is not there.
    """
    if sys.platform == "linux":
        os.environ.setdefault("MUJOCO_GL", drawing_library())
    try:
        import mujoco
    except ModuleNotFoundError as error:
        if error.name != "mujoco":
            raise
        raise DependencyNotInstalled("mujoco is not installed") from None
    except Exception:  # MUJOCO_GL names what is not installed: physics works without
        os.environ["MUJOCO_GL"] = "disabled"
        import mujoco  # noqa: F401


_import_mujoco()
