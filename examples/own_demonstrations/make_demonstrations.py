"""Writes demonstrations by hand: where a point should go in FlatWorld, as waypoints.

Demonstrations need no actions: the positions that the agent should pass through are enough.
"""

from pathlib import Path

import numpy as np

STEP = 0.4
"""FlatWorld moves at most this far along each axis in a step."""

ROUTES = [
    [(-1.0, -1.0), (-1.2, 0.0), (-0.85, 0.15)],
    [(-1.0, -1.0), (-1.5, -0.5), (-1.1, 0.2), (-0.85, 0.2)],
    [(-1.0, -1.0), (-1.0, -0.4), (-1.0, 0.1)],
]
"""From the start to the yellow disc at (-0.85, 0.15), round the blue one in the middle."""

REST = 15
"""Steps for which a demonstration stays where it has arrived."""


def positions(route: list[tuple[float, float]]) -> np.ndarray:
    """The positions [T+1, 2] of a walk along `route`, no step too long for FlatWorld."""
    rows = [np.array(route[0])]
    for goal in route[1:]:
        while (left := np.abs(goal - rows[-1]).max()) > 1e-9:
            rows.append(rows[-1] + (goal - rows[-1]) * min(1.0, STEP / left))
    rows += [rows[-1]] * REST
    return np.array(rows, dtype=np.float32)


def main() -> None:
    arrays = {f"observations_{i}": positions(route) for i, route in enumerate(ROUTES)}
    path = Path(__file__).with_name("routes.npz")
    np.savez(path, **arrays)
    for name, rows in arrays.items():
        print(f"{path.name}: {name} {rows.shape}")


if __name__ == "__main__":
    main()
