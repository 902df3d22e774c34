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
    ROAD,
    ROOMS,
    ROOMS_PROSE,
    YELLOW,
    bits,
    circular,
    corridor,
    sequential,
)
from tiloilc.demos.recording import published_fields
from tiloilc.label import Labeller, compile_predicates
from tiloilc.spec import Spec, read_spec

HAND: dict[str, Callable[[np.ndarray], np.ndarray]] = {
    "carlo": ROAD,
    "flatworld_cycle": bits(RED, GREEN, YELLOW, BLUE),
    "flatworld_disjunction": bits(RED, GREEN, YELLOW, BLUE),
    "flatworld_stabilization": bits(YELLOW, BLUE),
    "sixteen_rooms": ROOMS,
    "sixteen_rooms_prose": ROOMS_PROSE,
}
for _i, _level in enumerate(("easy", "medium", "hard")):
    HAND[f"grid_avoid_{_level}"] = corridor((7, 9, 11)[_i])
    HAND[f"grid_sequential_{_level}"] = sequential(_i + 3)
    HAND[f"grid_circular_{_level}"] = circular(_i + 2)


def test_every_task_file_is_checked_here(root: Path) -> None:
    assert {path.stem for path in (root / "specs").glob("*.yaml")} >= set(HAND)


NOT_PLACES = {"wall"}
"""Propositions that are not about where one is."""


def compiled(root: Path, name: str) -> tuple[Spec, gym.Env, Labeller]:
    """A task file, its environment and its predicates."""
    spec = read_spec(root / "specs" / f"{name}.yaml").spec
    fields = published_fields(spec.environment.id, spec.environment.kwargs)
    labels = compile_predicates({n: str(p) for n, p in spec.propositions.items()}, fields)
    return spec, gym.make(spec.environment.id, **spec.environment.kwargs).unwrapped, labels


def states(name: str, env: gym.Env) -> np.ndarray:
    """Observations from everywhere, [n, d]: all of a grid, else 20,000 at random."""
    generator = np.random.default_rng(0)
    if name.startswith("grid"):
        return env.finite_model().observations.astype(np.float32)
    space = env.observation_space
    points = generator.uniform(space.low, space.high, (20_000, *space.shape)).astype(np.float32)
    if name == "carlo":
        angle = generator.uniform(0, 2 * np.pi, len(points))
        points[:, 4:] = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    if name.startswith("sixteen"):
        points[::2, :2] = points[::2, :2].round()
        points[:, 2] = points[:, 2].round()
    return points


@pytest.mark.parametrize("name", sorted(HAND))
def test_predicates_say_what_the_world_is(name: str, root: Path) -> None:
    spec, env, labels = compiled(root, name)
    assert spec.name == name
    points = states(name, env)
    ours, theirs = HAND[name](points), labels(points)
    np.testing.assert_array_equal(ours, theirs)
    assert all((ours >> i & 1).any() for i in range(len(spec.propositions)))


@pytest.mark.parametrize("name", sorted(HAND))
def test_zones_are_drawn_where_the_predicates_hold(name: str, root: Path) -> None:
    spec, env, labels = compiled(root, name)
    shown = {shape.name for shape in env.scene().shapes}
    for i, proposition in enumerate(spec.propositions):
        assert proposition in shown | NOT_PLACES
        for shape in env.scene().shapes:
            if shape.name == proposition:
                low = getattr(shape, "low", None)
                middle = shape.center if low is None else np.add(low, shape.high) / 2
                seen = np.zeros((1, *env.observation_space.shape), np.float32)
                seen[0, list(env.scene().position)] = np.round(middle, 4)
                assert labels(seen)[0] >> i & 1


def car(x: float, y: float, heading: float) -> np.ndarray:
    """One of Carlo's cars, (x, y) from the middle of the road, as an observation [1, 6]."""
    looks = [np.cos(heading), np.sin(heading)]
    return np.array([[(30 + x) / 60, (30 + y) / 60, 0.0, 0.0, *looks]], np.float32)


@pytest.mark.parametrize("quarter", range(4))
def test_a_car_crashes_when_its_corner_touches_the_disc_or_the_ring(
    quarter: int, root: Path
) -> None:
    labels = compiled(root, "carlo")[2]
    turn = quarter * np.pi / 2
    c, s = round(np.cos(turn)), round(np.sin(turn))

    def letter(x: float, y: float) -> int:
        return int(labels(car(c * x - s * y, s * x + c * y, turn))[0])

    # looking east, its rear right corner is at (9, 12), which is 15 from the middle
    assert letter(11 - 0.01, 13 - 0.01) == 4
    assert letter(11 + 0.01, 13 + 0.01) == 0
    # its front left corner is at (16.5, 22), which is 27.5 from the middle
    assert letter(14.5 + 0.01, 21 + 0.01) == 4
    assert letter(14.5 - 0.01, 21 - 0.01) == 0
    # its right side touches the disc in the middle
    assert letter(0.5, 16 - 0.01) == 4
    assert letter(0.5, 16 + 0.01) == 0


def test_a_car_may_pass_where_its_middle_is_nearer_than_its_corner_could_be(root: Path) -> None:
    labels = compiled(root, "carlo")[2]
    assert labels(car(0, 16.5, 0))[0] == 0, "along the disc"
    assert labels(car(0, 16.5, np.pi / 2))[0] == 4, "with its tail in the disc"


def test_regions_of_the_road_begin_five_metres_from_their_middle(root: Path) -> None:
    labels = compiled(root, "carlo")[2]
    for sign, bit in ((1, 1), (-1, 2)):
        assert labels(car(sign * (21.25 - 4.99), 0, np.pi / 2))[0] & bit
        assert not labels(car(sign * (21.25 - 5.01), 0, np.pi / 2))[0] & bit
