"""What a two-dimensional task looks like, as plain shapes, and as pixels."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Bounds = tuple[float, float, float, float]
"""x_min, y_min, x_max, y_max."""

Pixels = npt.NDArray[np.uint8]

BACKGROUND = "#f7f7f5"
AGENT = "#222222"
TRACE = "#8a8a8a"


@dataclass(frozen=True, slots=True)
class Circle:
    """A named disc; `color` is `#rrggbb`."""

    name: str
    color: str
    center: tuple[float, float]
    radius: float


@dataclass(frozen=True, slots=True)
class Ring:
    """What lies between two circles about `center`: as far away as `inner`, but not as `outer`."""

    name: str
    color: str
    center: tuple[float, float]
    inner: float
    outer: float


@dataclass(frozen=True, slots=True)
class Rectangle:
    """A named rectangle from its lower left to its upper right corner; `color` is `#rrggbb`."""

    name: str
    color: str
    low: tuple[float, float]
    high: tuple[float, float]


@dataclass(frozen=True, slots=True)
class Scene:
    """All shapes of a task, drawn in this order, in units of the observation (y grows upwards).

    `position` names the two components of an observation that are the agent's x and y. A shape
    with an empty name is part of another one, or nothing to speak of.
    """

    bounds: Bounds
    shapes: tuple[Circle | Rectangle | Ring, ...]
    position: tuple[int, int] = (0, 1)


def rasterise(
    scene: Scene,
    agent: Sequence[float] | npt.NDArray[np.floating],
    trace: npt.NDArray[np.floating] | None = None,
    height: int = 256,
) -> Pixels:
    """The scene with the agent at (x, y) as uint8 [height, width, 3].

    `trace` [k, 2] are points to be dotted in. The agent's dot has 1/40 of the scene's height.
    """
    x_min, y_min, x_max, y_max = scene.bounds
    scale = height / (y_max - y_min)
    width = max(1, round((x_max - x_min) * scale))
    x = x_min + (np.arange(width) + 0.5) / scale
    y = y_max - (np.arange(height) + 0.5) / scale
    grid_x, grid_y = np.meshgrid(x, y)
    frame = np.empty((height, width, 3), np.uint8)
    frame[:] = _rgb(BACKGROUND)
    for shape in scene.shapes:
        frame[_covers(shape, grid_x, grid_y)] = _rgb(shape.color)
    dot = (y_max - y_min) / 40
    points = [] if trace is None else [(float(p[0]), float(p[1])) for p in trace]
    for point in points:
        mark = Circle("", TRACE, point, max(dot / 2, 0.8 / scale))
        frame[_covers(mark, grid_x, grid_y)] = _rgb(TRACE)
    place = (float(agent[0]), float(agent[1]))
    frame[_covers(Circle("", AGENT, place, dot), grid_x, grid_y)] = _rgb(AGENT)
    return frame


def _covers(
    shape: Circle | Rectangle | Ring, x: npt.NDArray[np.floating], y: npt.NDArray[np.floating]
) -> npt.NDArray[np.bool_]:
    if isinstance(shape, Circle):
        inside = np.hypot(x - shape.center[0], y - shape.center[1]) < shape.radius
    elif isinstance(shape, Ring):
        away = np.hypot(x - shape.center[0], y - shape.center[1])
        inside = (shape.inner <= away) & (away < shape.outer)
    else:
        inside = (x >= shape.low[0]) & (x < shape.high[0])
        inside &= (y >= shape.low[1]) & (y < shape.high[1])
    return np.asarray(inside, np.bool_)


def _rgb(color: str) -> tuple[int, int, int]:
    return int(color[1:3], 16), int(color[3:5], 16), int(color[5:7], 16)
