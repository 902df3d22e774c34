"""Facts of the worlds as the paper and its relatives state them."""

import gymnasium as gym
import numpy as np
import pytest

from tiloilc.tasks import Circle, Scene
from tiloilc.tasks.flatworld import BLUE, GREEN, RED, YELLOW
from tiloilc.tasks.grids import MOVES
from tiloilc.tasks.scene import rasterise

EAST, NORTH, WEST, SOUTH, STAY = range(5)


def walk(name: str, actions: list[int], **kwargs: object) -> list[tuple[int, int]]:
    env = gym.make(f"tiloilc/Grid{name}-v0", **kwargs)
    start, _ = env.reset(seed=0)
    return [tuple(start.tolist())] + [tuple(env.step(a)[0].tolist()) for a in actions]


def test_flatworld_starts_at_minus_one_and_moves_by_dt() -> None:
    env = gym.make("tiloilc/FlatWorld-v0")
    start, _ = env.reset(seed=0)
    np.testing.assert_array_equal(start, np.array([-1, -1], np.float32), strict=True)
    moved = env.step(np.array([1.0, -0.5]))[0]
    np.testing.assert_allclose(moved, [-0.6, -1.2], atol=1e-6)


def test_flatworld_clips_actions_and_positions() -> None:
    env = gym.make("tiloilc/FlatWorld-v0")
    env.reset(seed=0)
    np.testing.assert_allclose(env.step(np.array([9.0, 0.0]))[0], [-0.6, -1.0], atol=1e-6)
    for _ in range(20):
        seen = env.step(np.array([1.0, -1.0]))[0]
    np.testing.assert_array_equal(seen, [2, -2])


def test_flatworlds_discs_are_those_of_the_task() -> None:
    assert (RED.center, RED.radius) == ((0.45, -0.75), 0.3)
    assert (GREEN.center, GREEN.radius) == ((0.45, 1.0), 0.3)
    assert (YELLOW.center, YELLOW.radius) == ((-0.85, 0.15), 0.3)
    assert (BLUE.center, BLUE.radius) == ((0.0, 0.0), 0.8)


def test_flatworlds_blue_reaches_well_into_red_and_yellow_and_hardly_into_green() -> None:
    depth = {d.name: BLUE.radius + d.radius - np.hypot(*d.center) for d in (RED, YELLOW, GREEN)}
    assert depth["r"] > 0.2
    assert depth["y"] > 0.2
    assert 0 < depth["g"] < 0.005


def test_flatworlds_random_starts_lie_in_the_free_space_and_differ() -> None:
    vector = gym.make_vec("tiloilc/FlatWorld-v0", num_envs=500, random_start=True)
    starts, _ = vector.reset(seed=0)
    for disc in (RED, GREEN, YELLOW, BLUE):
        assert np.linalg.norm(starts - np.array(disc.center), axis=1).min() >= disc.radius
    assert len(np.unique(starts, axis=0)) == 500
    assert np.abs(starts).max() > 1.9


def test_actions_move_east_north_west_south_or_not() -> None:
    assert MOVES == ((1, 0), (0, 1), (-1, 0), (0, -1), (0, 0))
    path = walk("Sequential", [EAST, NORTH, WEST, SOUTH, STAY])
    assert path == [(3, 3), (4, 3), (4, 4), (3, 4), (3, 3), (3, 3)]


def test_the_corridor_ends_ten_cells_behind_the_goal() -> None:
    path = walk("Avoid", [WEST] + [EAST] * 20, distance=7)
    assert path[0] == path[1] == (0, 0)
    assert path[-1] == (17, 0)


def test_beside_the_corridor_one_can_walk_three_cells_out() -> None:
    assert walk("Avoid", [NORTH] * 5)[-1] == (0, 3)
    assert walk("Avoid", [SOUTH] * 5)[-1] == (0, -3)


def test_squares_of_the_row_touch_each_other() -> None:
    path = walk("Sequential", [EAST] * 40, zones=3)
    assert path[-1] == (27, 3)


def test_the_middle_of_the_cross_cannot_be_entered() -> None:
    env = gym.make("tiloilc/GridCircular-v0", zones=4).unwrapped
    model = env.finite_model()
    inside = ((model.observations >= 7) & (model.observations <= 13)).all(axis=1)
    assert inside.sum() == 49
    assert not inside[model.successor[~inside]].any()


def test_zones_of_the_cross_go_round_counter_clockwise_from_the_east() -> None:
    scene = gym.make("tiloilc/GridCircular-v0", zones=4).unwrapped.scene()
    zones = {s.name: s for s in scene.shapes if s.name in "abcd"}
    middles = {n: (z.low[0] + z.high[0] - 20, z.low[1] + z.high[1] - 20) for n, z in zones.items()}
    angles = [np.arctan2(middles[n][1], middles[n][0]) for n in "abcd"]
    np.testing.assert_allclose(np.unwrap(angles), [0, np.pi / 2, np.pi, 3 * np.pi / 2])
    assert all(z.high[0] - z.low[0] == z.high[1] - z.low[1] == 5 for z in zones.values())


def test_without_open_corners_the_cross_is_still_one_piece() -> None:
    model = gym.make("tiloilc/GridCircular-v0", corners=False).unwrapped.finite_model()
    found = {int(model.initial[0])}
    for _ in range(200):
        found |= set(model.successor[sorted(found)].ravel().tolist())
    assert len(found) == 4 * 49 + 49 - 25


def test_a_scene_is_drawn_with_its_colours_in_its_places() -> None:
    scene = Scene((0.0, 0.0, 2.0, 1.0), (Circle("c", "#ff0000", (1.5, 0.5), 0.3),))
    frame = rasterise(scene, (0.25, 0.75), trace=np.array([[0.5, 0.25]]), height=40)
    assert frame.shape == (40, 80, 3)
    assert frame[20, 60].tolist() == [255, 0, 0]
    assert frame[10, 10].max() < 60, "the agent is dark"
    assert frame[30, 20].tolist() != frame[0, 0].tolist(), "the trace is dotted in"


@pytest.mark.parametrize("name", ["FlatWorld", "GridAvoid", "GridSequential", "GridCircular"])
def test_scenes_name_what_they_show(name: str) -> None:
    scene = gym.make(f"tiloilc/{name}-v0").unwrapped.scene()
    assert {s.name for s in scene.shapes} >= {"a" if name != "FlatWorld" else "y"}
    assert scene.bounds[0] < scene.bounds[2]
    assert all(len(s.color) == 7 and s.color[0] == "#" for s in scene.shapes)
