"""How Cheetah's expert turns over: it plans, by model predictive path integral control.

Williams, Aldrich, Theodorou, *Model Predictive Path Integral Control: From Theory to Parallel
Computation*, 2017: action sequences are drawn around the last plan, tried on the model, and
averaged with weights that grow exponentially with what each brings.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import mujoco
import numpy as np
import numpy.typing as npt
from mujoco import rollout

from tiloilc.tasks.experts import Observation, Progress, advance

Doubles = npt.NDArray[np.float64]

STANDS = ((0.0, 1.0), (0.0, -1.0))
"""(cos, sin) of the pitch on front and on back legs, in the order of a flip."""

WITHIN = float(np.cos(0.5))
"""A pitch is a stand if the cosine of what it is off is greater."""


@dataclass(frozen=True, eq=False)
class FlipExpert:
    """Turns forwards as far as it can see how to; what it sees is all it needs to set its model.

    model, substeps  HalfCheetah, and its steps of physics in one step
    laps         flips: from the front legs to the back legs
    pace         radians a step beyond which turning faster is worth nothing to it; an episode's
                 is drawn from here, without noise there is none
    samples, horizon     action sequences that it tries at a time, and their steps
    spread, correlation  of the noise that a sequence is drawn with: its deviation, and how much
                         of a step's is that of the step before
    temperature  radians of rotation that make a sequence e times as heavy
    noise        each motor is disturbed by up to this share of its torque, at every step
    """

    name: str
    model: Any
    substeps: int
    laps: int = 2
    dwell: int | None = 0
    pace: tuple[float, float] = (0.2, 0.4)
    samples: int = 32
    horizon: int = 12
    spread: float = 1.0
    correlation: float = 0.5
    temperature: float = 0.05
    noise: float = 0.2
    data: Any = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "data", mujoco.MjData(self.model))  # scratch of the trials

    def begin(self, observation: Observation, generator: np.random.Generator) -> Progress:
        """No plan yet; draw a pace."""
        pace = generator.uniform(*self.pace) if self.noise else np.inf
        return Progress(pace=float(pace), plan=np.zeros((self.horizon, self.model.nu)))

    def act(
        self, observation: Observation, progress: Progress, generator: np.random.Generator
    ) -> tuple[npt.NDArray[np.float32], Progress]:
        """The first action of a better plan, float32 [6]."""
        last = progress.plan
        assert last is not None, "begin() gives one"
        arrived = bool(np.dot(observation[1:3], STANDS[progress.leg]) > WITHIN)
        progress = advance(progress, arrived, len(STANDS), self.laps, self.dwell)
        tried = self._drawn(last, generator)
        gain = np.minimum(self._turned(observation, tried), progress.pace).sum(axis=1)
        weight = np.exp((gain - gain.max()) / self.temperature)
        plan = np.tensordot(weight / weight.sum(), tried, axes=1)
        action = plan[0] + generator.uniform(-self.noise, self.noise, plan.shape[1])
        later = np.concatenate((plan[1:], plan[-1:]))
        return (
            np.clip(action, -1.0, 1.0).astype(np.float32),
            replace(progress, steps=progress.steps + 1, plan=later),
        )

    def _drawn(self, plan: Doubles, generator: np.random.Generator) -> Doubles:
        """Action sequences around a plan, the plan itself first, [samples, horizon, actions]."""
        fresh = generator.standard_normal((self.samples, *plan.shape))
        share = np.sqrt(1 - self.correlation**2)
        for t in range(1, len(plan)):
            fresh[:, t] = self.correlation * fresh[:, t - 1] + share * fresh[:, t]
        fresh[0] = 0.0
        return np.clip(plan + self.spread * fresh, -1.0, 1.0)

    def _turned(self, observation: Observation, actions: Doubles) -> Doubles:
        """Radians that each step of action sequences turns the trunk forwards, [samples, horizon].

        The place along the floor, which is not seen, makes no difference.
        """
        height, cosine, sine, *rest = (float(number) for number in observation)
        pitch = np.arctan2(sine, cosine)
        start = np.array([0.0, 0.0, height, pitch, *rest])  # time, positions, velocities
        control = np.repeat(actions, self.substeps, axis=1)
        states, _ = rollout.rollout(
            self.model, self.data, np.tile(start, (len(actions), 1)), control
        )
        after = states[:, self.substeps - 1 :: self.substeps, 3]
        before = np.full((len(actions), 1), pitch)
        return np.diff(after, axis=1, prepend=before)
