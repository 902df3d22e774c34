"""How Doggo's expert walks: a trot by the clock, found by search, that steers with the front hips.

Motors follow sines; nothing is fed back but the heading. The 19 numbers of the gait are in
`assets/trot.json`; `python -m tiloilc.tasks.robots.trot_search` finds them.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from importlib.resources import files

import numpy as np
import numpy.typing as npt

from tiloilc.tasks.experts import Observation, Progress, Waypoint, advance

Doubles = npt.NDArray[np.float64]

SWINGS = tuple(
    f"{end} {joint}" for joint in ("hip_z", "hip_y", "ankle") for end in ("front", "rear")
)
"""What swings alike but for half a period: the joints of two legs, front left and rear right before
front right and rear left."""

REAR = np.array([0, 1, 1, 0])
LEFT = np.array([1.0, 1.0, -1.0, -1.0])
HALF = np.array([0.0, np.pi, 0.0, np.pi])
"""Of the four legs in the order of the motors: front left, rear left, rear right, front right."""

GAIN = 1.0
"""Torque of the front hips, a share of all they have, for one radian off the way."""

SHARPEST = 0.7
"""The most of it: with more the front legs no longer step."""

AHEAD = 1.0
"""Metres along the way that the expert looks ahead."""


@dataclass(frozen=True, slots=True)
class Swing:
    """`offset + amplitude · sin(2π · frequency · t + phase)`, in shares of the motor's torque."""

    amplitude: float
    offset: float
    phase: float


@dataclass(frozen=True, slots=True)
class Trot:
    """A gait: `frequency` in Hz and one swing for each of SWINGS."""

    frequency: float
    swings: tuple[Swing, ...]

    @staticmethod
    def of(numbers: Sequence[float] | Doubles) -> Trot:
        """From 19 numbers: the frequency, and amplitude, offset and phase of each swing."""
        frequency, *rest = (float(number) for number in numbers)
        assert len(rest) == 3 * len(SWINGS)
        return Trot(frequency, tuple(Swing(*rest[i : i + 3]) for i in range(0, len(rest), 3)))

    def torques(self, seconds: float, turn: float, vigour: float = 1.0) -> Doubles:
        """What the twelve motors do at a time, in [-1, 1]; a positive `turn` leads to the left.

        `vigour` is a share of the amplitudes: 0 stands still.
        """
        wave = np.array([[s.amplitude, s.offset, s.phase] for s in self.swings]).reshape(3, 2, 3)
        amplitude, offset, phase = np.moveaxis(wave[:, REAR], -1, 0)  # each [3, 4]
        angle = 2 * np.pi * self.frequency * seconds + HALF + phase
        torque = offset + vigour * amplitude * np.sin(angle)
        torque[0] += turn * LEFT * (1 - REAR)
        return np.asarray(np.clip(torque.reshape(-1), -1.0, 1.0), np.float64)


def shipped_trot() -> Trot:
    """The gait in `assets/trot.json`."""
    text = (files("tiloilc.tasks.robots") / "assets" / "trot.json").read_text("utf-8")
    found = json.loads(text)
    return Trot(float(found["frequency"]), tuple(Swing(**found["swings"][name]) for name in SWINGS))


def written(trot: Trot, **about: float) -> str:
    """A gait as the text of `assets/trot.json`; `about` says where it comes from."""
    swings = {name: asdict(s) for name, s in zip(SWINGS, trot.swings, strict=True)}
    return json.dumps({"frequency": trot.frequency, "swings": swings, **about}, indent=1) + "\n"


@dataclass(frozen=True, eq=False)
class TrotExpert:
    """Trots along the straight lines through its waypoints, then stands still.

    position, orientation  where the observation has x and y, and the trunk's quaternion
    seconds  that pass in one step
    noise    each motor is disturbed by up to this share of its torque, at every step
    pace     the share of the gait's amplitudes in an episode is drawn from here
    """

    name: str
    trot: Trot
    route: tuple[Waypoint, ...]
    position: slice
    orientation: slice
    seconds: float
    laps: int = 1
    dwell: int | None = 0
    pace: tuple[float, float] = (0.9, 1.0)
    noise: float = 0.2

    def begin(self, observation: Observation, generator: np.random.Generator) -> Progress:
        """Draw a pace."""
        return Progress(pace=float(generator.uniform(*self.pace)) if self.noise else 1.0)

    def act(
        self, observation: Observation, progress: Progress, generator: np.random.Generator
    ) -> tuple[npt.NDArray[np.float32], Progress]:
        """The motors' torques at this time of the gait, float32 [12]."""
        here = observation[self.position].astype(np.float64)
        arrived = bool(
            np.hypot(*(here - self.route[progress.leg].aim)) < self.route[progress.leg].within
        )
        progress = advance(progress, arrived, len(self.route), self.laps, self.dwell)
        start = self.route[progress.leg - 1].aim if progress.leg else (0.0, 0.0)
        ahead = _ahead(here, np.array(start), np.array(self.route[progress.leg].aim)) - here
        off = np.arctan2(ahead[1], ahead[0]) - heading(observation[self.orientation])
        turn = float(np.clip(GAIN * ((off + np.pi) % (2 * np.pi) - np.pi), -SHARPEST, SHARPEST))
        moving = progress.laps < self.laps
        torque = self.trot.torques(
            progress.steps * self.seconds, turn if moving else 0.0, progress.pace if moving else 0.0
        )
        torque += generator.uniform(-self.noise, self.noise, torque.shape)
        action = np.clip(torque, -1.0, 1.0).astype(np.float32)
        return action, replace(progress, steps=progress.steps + 1)


def heading(quaternion: npt.NDArray[np.floating]) -> float:
    """The angle from the x axis to where a body (w, x, y, z) faces, rad."""
    w, x, y, z = (float(q) for q in quaternion)
    return float(np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)))


def _ahead(here: Doubles, start: Doubles, end: Doubles) -> Doubles:
    """The point of the line from `start` to `end` that lies AHEAD of what is nearest to `here`."""
    line = end - start
    length = max(float(np.hypot(*line)), 1e-9)
    along = float((here - start) @ line) / length + AHEAD
    return np.asarray(start + line * min(along, length) / length)
