"""Environments that fail while they are used are their author's matter, with the place."""

from typing import Any

import gymnasium as gym
import numpy as np
import pytest

from tests.product.worlds import Line
from tiloilc.diag import CompileError
from tiloilc.product import Copies, is_finite
from tiloilc.spec.model import Environment


class Broken(Line):
    """A line whose third step goes wrong as `how` says."""

    def __init__(self, how: str) -> None:
        if how == "make":
            raise RuntimeError("no licence")
        super().__init__()
        self.how, self.steps = how, 0

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[np.ndarray, dict[str, Any]]:
        if self.how == "reset":
            raise RuntimeError("no start")
        return super().reset(seed=seed, options=options)

    def step(self, action: int) -> tuple[np.ndarray, float, bool, bool, dict[str, Any]]:
        self.steps += 1
        seen, *rest = super().step(action)
        if self.steps < 3:
            return seen, *rest  # type: ignore[return-value]
        if self.how == "raise":
            raise ZeroDivisionError("first line\nsecond line")
        wrong = {
            "shape": np.zeros(2),
            "nan": np.full(1, np.nan),
            "range": np.full(1, 5),
            "tuple": seen,
        }[self.how]
        return (wrong, 0.0) if self.how == "tuple" else (wrong, *rest)  # type: ignore[return-value]


@pytest.fixture(autouse=True)
def registered() -> Any:
    gym.register("TestsBroken-v0", entry_point=Broken)
    yield
    gym.registry.pop("TestsBroken-v0")


def use(how: str) -> None:
    many = Copies(Environment(id="TestsBroken-v0", horizon=9, kwargs={"how": how}), 2)
    many.reset([1, 2], np.ones(2, dtype=np.bool_))
    for _ in range(3):
        many.step(np.zeros(2, np.int64))


@pytest.mark.parametrize(
    ("how", "said"),
    [
        ("make", "it cannot be made: RuntimeError: no licence (test_failing_copies.py, line "),
        ("reset", "reset() fails: RuntimeError: no start (test_failing_copies.py, line "),
        ("raise", "step() fails: ZeroDivisionError: first line (test_failing_copies.py, line "),
        ("tuple", "step() fails: ValueError: not enough values"),
        ("shape", "an observation of 2 numbers, not 1"),
        ("nan", "an observation that is not finite"),
        ("range", "an observation outside the observation space"),
    ],
)
def test_a_failure_of_the_environment_is_said_to_be_its_own(how: str, said: str) -> None:
    with pytest.raises(CompileError) as caught:
        use(how)
    (diagnostic,) = caught.value.diagnostics
    assert diagnostic.code == "RUN707"
    assert said in diagnostic.message


def test_what_is_too_large_for_a_table_is_not_finite() -> None:
    two = gym.spaces.Discrete(2)
    assert is_finite(gym.spaces.Box(0, 99, (3,), np.int64), two)
    assert not is_finite(gym.spaces.Box(0, 255, (8, 8, 3), np.uint8), two)
    assert not is_finite(gym.spaces.MultiDiscrete([10_000] * 4), two)
    assert is_finite(gym.spaces.MultiBinary(10), two)
    assert not is_finite(gym.spaces.MultiBinary([10, 10]), two)
    assert is_finite(gym.spaces.Discrete(5, start=-2), two)
