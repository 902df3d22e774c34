"""Carlo: a car on a ring road (paper, appendix H.1.2), as in the CARLO simulator."""

from __future__ import annotations

from typing import Any, Literal

import numpy as np
import numpy.typing as npt
from gymnasium.spaces import Box

from tiloilc.tasks.batched import Array, BatchedEnv, SingleEnv
from tiloilc.tasks.carlo.driver import LINES, CarelessDriver, Driver, racing
from tiloilc.tasks.carlo.road import (
    AXLE,
    CENTER_LINE,
    DISC,
    FRICTION,
    MAX_SPEED,
    MIDDLE,
    MIN_SPEED,
    REGION,
    REGIONS,
    RING,
    SIZE,
    farthest,
)
from tiloilc.tasks.experts import Expert
from tiloilc.tasks.known import Known
from tiloilc.tasks.scene import Circle, Ring, Scene

DT = 0.1
"""Seconds that a step takes."""

Heading = Literal["sincos", "angle"]
"""How the observation tells where the car looks."""


class CarloVectorEnv(BatchedEnv):
    """n cars, each 4 m long and 2 m wide, on a ring road between a disc and a ring.

    A state is a position (x, y) in [0, 60]² m, a speed v in [0, 30] m/s and a heading ψ. An action
    is a steering angle δ in rad and a throttle u in m/s², both in [-1, 1]. A kinematic bicycle:

        β  = atan(½ tan δ)
        v' = clip(v + (u - 0.06) dt, 3, 30)
        ψ' = ψ + (v + v')/2 · sin β · dt / AXLE
        (x, y)' = (x, y) + (v + v')/2 · dt · (cos, sin)((ψ + ψ')/2 + β)

    Nothing stops a car but the edge of the map. It crashes where its rectangle touches the disc or
    the ring: a question about the observation, which the task file asks.

    The observation is float32, and all there is to know of the state:

    pos      (x, y) / 60 m
    vel      v (cos ψ, sin ψ) / 30 m/s
    heading  (cos ψ, sin ψ); with heading="angle" ψ / 2π in [0, 1], as in the paper: one number
             less, but it jumps once a round, which networks cannot follow

    dt            seconds that a step takes
    start         i of the paper: on the centre line at an angle of (1 + 2i)π/4, counter-clockwise
    random_start  begin at any angle instead
    """

    def __init__(
        self,
        num_envs: int = 1,
        *,
        heading: Heading = "sincos",
        dt: float = DT,
        start: int = 0,
        random_start: bool = False,
        render_mode: str | None = None,
    ) -> None:
        if heading not in ("sincos", "angle"):
            raise ValueError(f"heading must be 'sincos' or 'angle', not {heading!r}")
        if not dt > 0:
            raise ValueError(f"dt must be positive, not {dt}")
        if start not in (0, 1, 2, 3):
            raise ValueError(f"start must be 0, 1, 2 or 3, not {start}")
        size = 6 if heading == "sincos" else 5
        low = np.array([0.0, 0.0, -1.0, -1.0, -1.0, -1.0] if size == 6 else [0, 0, -1, -1, 0])
        super().__init__(
            num_envs,
            Box(low.astype(np.float32), np.ones(size, np.float32), dtype=np.float32),
            Box(-1.0, 1.0, (2,), np.float32),
            render_mode,
        )
        self.heading, self.dt = heading, float(dt)
        self.start, self.random_start = start, random_start
        self.observation_fields = {
            "pos": slice(0, 2),
            "vel": slice(2, 4),
            "heading": slice(4, 6) if size == 6 else 4,
        }

    def scene(self) -> Scene:
        """The disc and the ring that one crashes into, and the two regions, in units of `pos`."""
        middle = (MIDDLE / SIZE, MIDDLE / SIZE)
        regions = (
            Circle(f"wp{i}", "#5b8fd6", (x / SIZE, y / SIZE), REGION / SIZE)
            for i, (x, y) in enumerate(REGIONS)
        )
        return Scene(
            (0.0, 0.0, 1.0, 1.0),
            (
                *regions,
                Circle("crash", "#6b7280", middle, DISC / SIZE),
                Ring("", "#6b7280", middle, RING / SIZE, 0.5),
            ),
        )

    def experts(self) -> tuple[Expert, ...]:
        """A driver who goes round twice, and one who crashes or stops on the way."""
        angle = self.heading == "angle"
        return Driver("carlo", angle=angle), CarelessDriver("unsafe", angle=angle)

    def known_best(self, horizon: int) -> tuple[Known, ...]:
        """Drives on inner lines, against the direction of the road and with it; from one start."""
        if self.random_start:
            return ()
        turn, rounds = farthest(horizon, self.dt)
        how = (
            "a car at full throttle on the inner line: a lower bound, reached by real actions; in "
            f"{horizon} steps none can get more than {turn:.1f} rad about the middle, which is "
            f"{rounds} times to the one region and then to the other"
        )
        return tuple(
            Known(self._drive(horizon, line, sense)[None], how)
            for line in LINES
            for sense in (-1, 1)
        )

    def _drive(self, horizon: int, line: tuple[float, float], sense: int) -> Array:
        """What a car in a hurry sees in this world, [T+1, d]."""
        car = CarloVectorEnv(dt=self.dt, heading=self.heading, start=self.start)
        angle = self.heading == "angle"
        seen = [car.reset()[0][0]]
        for step in range(horizon):
            action = racing(step * self.dt, seen[-1], angle=angle, line=line, sense=sense)
            seen.append(car.step(action[None])[0][0])
        return np.array(seen)

    def _start(self, copies: npt.NDArray[np.int64]) -> Array:
        angle = np.full(len(copies), (1 + 2 * self.start) * np.pi / 4)
        if self.random_start:
            for row, copy in enumerate(copies):
                angle[row] = self.generator(int(copy)).uniform(0.0, 2 * np.pi)
        x, y = (MIDDLE + CENTER_LINE * part for part in (np.cos(angle), np.sin(angle)))
        return self._shown(x, y, np.zeros(len(copies)), angle + np.pi / 2)

    def _move(self, state: Array, actions: Array) -> Array:
        if actions.shape != (len(state), 2):
            raise ValueError(f"actions must have shape {(len(state), 2)}, not {actions.shape}")
        # rows that lie in one piece: what a sine gives must not depend on how many cars there are
        steer, throttle = np.ascontiguousarray(np.clip(actions.T.astype(np.float64), -1.0, 1.0))
        x, y, vx, vy, *heading = np.ascontiguousarray(state.T.astype(np.float64))
        angle = 2 * np.pi * heading[0] if len(heading) == 1 else np.arctan2(heading[1], heading[0])
        speed = MAX_SPEED * np.hypot(vx, vy)
        slip = np.arctan(np.tan(steer) / 2)
        faster = np.clip(speed + (throttle - FRICTION) * self.dt, MIN_SPEED, MAX_SPEED)
        way = (speed + faster) / 2 * self.dt
        turned = angle + way * np.sin(slip) / AXLE
        course = (angle + turned) / 2 + slip
        return self._shown(
            np.clip(SIZE * x + way * np.cos(course), 0.0, SIZE),
            np.clip(SIZE * y + way * np.sin(course), 0.0, SIZE),
            faster,
            turned,
        )

    def _shown(self, x: Array, y: Array, speed: Array, angle: Array) -> Array:
        """What a state looks like, [n, d]."""
        along, up = np.cos(angle), np.sin(angle)
        sees = [along, up] if self.heading == "sincos" else [np.mod(angle, 2 * np.pi) / (2 * np.pi)]
        vel = [speed * along / MAX_SPEED, speed * up / MAX_SPEED]
        return np.stack([x / SIZE, y / SIZE, *vel, *sees], axis=1).astype(np.float32)

    def _observe(self, state: Array) -> Array:
        return state.copy()

    def _recover(self, observations: Array) -> Array:
        return observations.astype(np.float32)


class CarloEnv(SingleEnv):
    """One car; see CarloVectorEnv."""

    def __init__(self, render_mode: str | None = None, **kwargs: Any) -> None:
        super().__init__(CarloVectorEnv(1, render_mode=render_mode, **kwargs))
