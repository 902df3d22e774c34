"""What a task looks like from above: its zones, and which observations are places in it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from tiloilc.evaluate.seeds import EVALUATION
from tiloilc.plan import importable

__all__ = ["Map", "Shape", "cropped", "map_of"]


@dataclass(frozen=True)
class Shape:
    """A named disc (`radius` > 0, at `low`), a ring between `inner` and `radius`, or a rectangle
    from `low` to `high`. Without `edge` it is a piece of a larger one.
    """

    name: str
    color: str
    low: tuple[float, float]
    high: tuple[float, float]
    radius: float = 0.0
    inner: float = 0.0
    edge: bool = True


@dataclass(frozen=True)
class Map:
    """What a two-dimensional task looks like; `position` are the observation's x and y, which are
    multiplied by `stretch`. `axes` are their names, where they need some.
    """

    bounds: tuple[float, float, float, float]
    shapes: tuple[Shape, ...]
    position: tuple[int, int]
    stretch: tuple[float, float] = (1.0, 1.0)
    axes: tuple[str, str] = ("", "")

    def places(self, observations: npt.NDArray[np.floating]) -> npt.NDArray[np.float64]:
        """Where observations [..., d] are on the map, [..., 2]."""
        return observations[..., list(self.position)].astype(np.float64) * self.stretch


def map_of(
    environment: str, arguments: dict[str, Any], root: Path, seed: int = EVALUATION
) -> Map | None:
    """The map that the environment publishes by `scene()`; None if it has none or is not there.

    It is that of the episode that begins with `seed`: things may lie elsewhere in another.
    A report of a run must be possible where its environment is not installed, so whatever goes
    wrong while the environment is made leaves the map out. Own environments are looked for in
    `root`, the task file's folder.
    """
    import gymnasium

    try:
        import tiloilc.tasks  # noqa: F401  registers the bundled environments

        with importable(root):
            env = gymnasium.make(environment, disable_env_checker=True, **arguments)
    except Exception:  # an environment is anyone's code
        return None
    try:
        scene = getattr(env.unwrapped, "scene", None)
        if scene is None:
            return None
        env.reset(seed=seed)
        return _read(scene())
    except Exception:  # another kind of scene, or a reset that fails
        return None
    finally:
        env.close()


def cropped(drawn: Map, points: npt.NDArray[np.floating] | None) -> Map:
    """The part of the map where there is something: its shapes, and `points` [n, 2]."""
    corners = [] if points is None else [points[np.isfinite(points).all(axis=1)]]
    for shape in drawn.shapes:
        reach = shape.radius
        corners.append(np.array([[v - reach for v in shape.low], [v + reach for v in shape.high]]))
    every = np.concatenate([*corners, np.empty((0, 2))])
    if not len(every) or not np.ptp(every, axis=0).all():
        return drawn
    margin = 0.05 * float(np.ptp(every, axis=0).max())
    low, high = every.min(axis=0) - margin, every.max(axis=0) + margin
    return replace(drawn, bounds=(float(low[0]), float(low[1]), float(high[0]), float(high[1])))


def _read(scene: object) -> Map:
    """A scene of any class that has the attributes of `tiloilc.tasks.scene.Scene`."""
    x_min, y_min, x_max, y_max = (float(edge) for edge in getattr(scene, "bounds"))  # noqa: B009
    shapes = []
    for shape in getattr(scene, "shapes"):  # noqa: B009
        ring = hasattr(shape, "outer")
        round_ = ring or hasattr(shape, "radius")
        low = shape.center if round_ else shape.low
        high = low if round_ else shape.high
        radius = shape.outer if ring else shape.radius if round_ else 0.0
        shapes.append(
            Shape(
                str(shape.name),
                str(shape.color),
                (float(low[0]), float(low[1])),
                (float(high[0]), float(high[1])),
                float(radius),
                float(shape.inner) if ring else 0.0,
            )
        )
    across, up = getattr(scene, "position", (0, 1))
    return Map((x_min, y_min, x_max, y_max), tuple(shapes), (int(across), int(up)))
