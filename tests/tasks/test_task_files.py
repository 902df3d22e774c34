"""The task files say in predicates what the worlds are."""

from collections.abc import Callable
from pathlib import Path

import gymnasium as gym
import numpy as np
import pytest

from tests.demos.examples import (
    BLUE,
    GREEN,
    RED,
    YELLOW,
    bits,
    circular,
    corridor,
    sequential,
)
from tiloilc.demos.recording import published_fields
from tiloilc.label import compile_predicates
from tiloilc.spec import read_spec

HAND: dict[str, Callable[[np.ndarray], np.ndarray]] = {
    "flatworld_cycle": bits(RED, GREEN, YELLOW, BLUE),
    "flatworld_disjunction": bits(RED, GREEN, YELLOW, BLUE),
    "flatworld_stabilization": bits(YELLOW, BLUE),
}
for _i, _level in enumerate(("easy", "medium", "hard")):
    HAND[f"grid_avoid_{_level}"] = corridor((7, 9, 11)[_i])
    HAND[f"grid_sequential_{_level}"] = sequential(_i + 3)
    HAND[f"grid_circular_{_level}"] = circular(_i + 2)


def test_every_task_file_is_checked_here(root: Path) -> None:
    assert {path.stem for path in (root / "specs").glob("*.yaml")} >= set(HAND)


@pytest.mark.parametrize("name", sorted(HAND))
def test_predicates_say_what_the_world_is(name: str, root: Path) -> None:
    spec = read_spec(root / "specs" / f"{name}.yaml").spec
    assert spec.name == name
    fields = published_fields(spec.environment.id, spec.environment.kwargs)
    labels = compile_predicates({n: str(p) for n, p in spec.propositions.items()}, fields)
    env = gym.make(spec.environment.id, **spec.environment.kwargs).unwrapped
    if name.startswith("grid"):
        points = env.finite_model().observations.astype(np.float32)
    else:
        points = np.random.default_rng(0).uniform(-2, 2, (20_000, 2)).astype(np.float32)
    ours, theirs = HAND[name](points), labels(points)
    np.testing.assert_array_equal(ours, theirs)
    assert all((ours >> i & 1).any() for i in range(len(spec.propositions)))


@pytest.mark.parametrize("name", sorted(HAND))
def test_zones_are_drawn_where_the_predicates_hold(name: str, root: Path) -> None:
    spec = read_spec(root / "specs" / f"{name}.yaml").spec
    env = gym.make(spec.environment.id, **spec.environment.kwargs).unwrapped
    fields = published_fields(spec.environment.id, spec.environment.kwargs)
    labels = compile_predicates({n: str(p) for n, p in spec.propositions.items()}, fields)
    shown = {shape.name for shape in env.scene().shapes}
    for i, proposition in enumerate(spec.propositions):
        assert proposition in shown
        for shape in env.scene().shapes:
            if shape.name == proposition:
                low = getattr(shape, "low", None)
                middle = shape.center if low is None else np.add(low, shape.high) / 2
                assert labels(np.array([middle], np.float32).round(2))[0] >> i & 1
