"""Frames of a MuJoCo scene, drawn without a screen."""

from __future__ import annotations

import contextlib
import importlib
import os
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

from tiloilc.tasks.scene import Pixels


@dataclass(frozen=True, slots=True)
class View:
    """Where a camera stands: `distance` metres from the point it looks at; angles in degrees."""

    look_at: tuple[float, float, float]
    distance: float
    azimuth: float
    elevation: float


class Camera:
    """Draws one model. Shadows and reflections are off: they take six times as long as the rest.

    Raises RuntimeError if nothing here can draw.
    """

    def __init__(self, model: Any, view: View, height: int, width: int) -> None:
        self._context = _context(height, width)
        try:
            self._context.make_current()
            self._renderer = mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_150.value)
            mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN.value, self._renderer)
        except Exception as error:
            self._context.free()
            raise RuntimeError(f"MuJoCo cannot draw: {error}") from error
        self._model = model
        self._rectangle = mujoco.MjrRect(0, 0, width, height)
        self._options = mujoco.MjvOption()
        self._scene = mujoco.MjvScene(model, maxgeom=1000)
        self._scene.flags[mujoco.mjtRndFlag.mjRND_SHADOW] = False
        self._scene.flags[mujoco.mjtRndFlag.mjRND_REFLECTION] = False
        self._camera = mujoco.MjvCamera()
        self._camera.lookat[:] = view.look_at
        self._camera.distance = view.distance
        self._camera.azimuth = view.azimuth
        self._camera.elevation = view.elevation

    def picture(self, data: Any, look_at: tuple[float, float, float] | None = None) -> Pixels:
        """The scene as uint8 [height, width, 3]; `look_at` moves the camera along."""
        if look_at is not None:
            self._camera.lookat[:] = look_at
        self._context.make_current()
        mujoco.mjv_updateScene(
            self._model,
            data,
            self._options,
            None,
            self._camera,
            mujoco.mjtCatBit.mjCAT_ALL.value,
            self._scene,
        )
        pixels = np.empty((self._rectangle.height, self._rectangle.width, 3), np.uint8)
        mujoco.mjr_render(self._rectangle, self._scene, self._renderer)
        mujoco.mjr_readPixels(pixels, None, self._rectangle, self._renderer)
        return np.ascontiguousarray(pixels[::-1])

    def close(self) -> None:
        """Give the graphics memory back."""
        with contextlib.suppress(Exception):
            self._context.make_current()
            self._renderer.free()
        self._context.free()


def _context(height: int, width: int) -> Any:
    """An OpenGL context by the library that MUJOCO_GL names. Raises RuntimeError if there is none.

    Whoever imported MuJoCo first may have done so without that name, so it is looked for again.
    """
    name = os.environ.get("MUJOCO_GL", "")
    try:
        offscreen = name in ("egl", "osmesa")
        found = importlib.import_module(f"mujoco.{name}") if offscreen else mujoco
        return _quiet(found.GLContext)(width, height)
    except Exception as error:  # whatever a graphics library does when it is not there
        raise RuntimeError(f"MuJoCo cannot draw with {name or 'this'}: {error!r}") from error


def _quiet(context: Any) -> Any:
    """The context, whose end says nothing: at exit its library may be gone already."""

    class Quiet(context):  # type: ignore[misc]
        _context = None

        def free(self) -> None:
            with contextlib.suppress(Exception):
                super().free()

    return Quiet
