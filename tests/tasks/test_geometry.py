"""Facts of the worlds as the paper and its relatives state them."""

import gymnasium as gym
import numpy as np
import pytest

from tiloilc.tasks import Circle, Ring, Scene
from tiloilc.tasks.flatworld import BLUE, GREEN, RED, YELLOW
from tiloilc.tasks.grids import MOVES
from tiloilc.tasks.rooms import crosses
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


def test_carlo_starts_on_the_centre_line_at_an_eighth_of_a_round() -> None:
    seen, _ = gym.make("tiloilc/Carlo-v0").reset(seed=0)
    np.testing.assert_allclose(seen[:2] * 60, [45.02602, 45.02602], atol=1e-4)
    np.testing.assert_array_equal(seen[2:4], [0, 0])
    np.testing.assert_allclose(seen[4:], [-0.70710678, 0.70710678], atol=1e-6)
    other, _ = gym.make("tiloilc/Carlo-v0", start=2, heading="angle").reset(seed=0)
    np.testing.assert_allclose(other[:2] * 60, [14.97398, 14.97398], atol=1e-4)
    assert other[4] == pytest.approx(7 / 8)


def test_carlos_first_step_is_at_three_metres_a_second() -> None:
    env = gym.make("tiloilc/Carlo-v0")
    env.reset(seed=0)
    seen = env.step(np.array([0.0, 1.0]))[0]
    # 0.15 m to the north-west
    np.testing.assert_allclose(seen[:2] * 60, [44.91996, 45.13209], atol=1e-4)
    np.testing.assert_allclose(seen[2:4] * 30, [-2.12132, 2.12132], atol=1e-4)


@pytest.mark.parametrize("heading", ["sincos", "angle"])
def test_a_step_of_carlo_is_the_one_computed_by_hand(heading: str) -> None:
    vector = gym.make_vec("tiloilc/Carlo-v0", num_envs=1, heading=heading)
    vector.reset(seed=0)
    looks = [0.0, 1.0] if heading == "sincos" else [0.25]
    vector.set_state(np.array([[50 / 60, 30 / 60, 0, 10 / 30, *looks]], np.float32))
    seen = vector.step(np.array([[0.5, 1.0]]))[0][0]
    # slip atan(tan(0.5) / 2) = 0.266645; 1.0047 m; the heading turns by 0.132367
    np.testing.assert_allclose(seen[:2] * 60, [49.671746, 30.949564], atol=1e-4)
    assert np.hypot(*seen[2:4]) * 30 == pytest.approx(10.094, abs=1e-4)
    angle = np.arctan2(seen[5], seen[4]) if heading == "sincos" else seen[4] * 2 * np.pi
    assert angle == pytest.approx(np.pi / 2 + 0.132367, abs=1e-5)


def test_carlos_speed_stays_between_three_and_thirty() -> None:
    vector = gym.make_vec("tiloilc/Carlo-v0", num_envs=2)
    vector.reset(seed=0)
    speeds = []
    for _ in range(400):
        seen, *_ = vector.step(np.array([[1.0, 1.0], [1.0, -1.0]]))
        speeds.append(np.hypot(seen[:, 2], seen[:, 3]) * 30)
    fast, slow = np.array(speeds).T
    assert fast.max() == pytest.approx(30, abs=1e-4)
    assert np.abs(slow - 3).max() < 1e-4
    assert np.argmax(fast > 29.9) == pytest.approx((29.9 - 3) / 0.094, abs=2)


def test_cars_stop_at_the_edge_of_the_map() -> None:
    env = gym.make("tiloilc/Carlo-v0")
    env.reset(seed=0)
    for _ in range(300):
        seen = env.step(np.array([0.0, 1.0]))[0]
    assert seen[:2].max() == 1.0
    assert env.observation_space.contains(seen)


def test_carlos_random_starts_lie_on_the_centre_line_all_round() -> None:
    vector = gym.make_vec("tiloilc/Carlo-v0", num_envs=400, random_start=True)
    seen, _ = vector.reset(seed=0)
    x, y = (seen[:, :2].T * 60).astype(float) - 30
    np.testing.assert_allclose(np.hypot(x, y), 21.25, atol=1e-4)
    np.testing.assert_allclose(seen[:, 4] * x + seen[:, 5] * y, 0, atol=1e-4)
    assert (seen[:, 5] * x - seen[:, 4] * y > 21).all(), "counter-clockwise"
    count, _ = np.histogram(np.arctan2(y, x), bins=4, range=(-np.pi, np.pi))
    assert count.min() > 60


def stroll(start: tuple[float, float], *moves: tuple[float, float]) -> list[list[float]]:
    """Where one comes in SixteenRooms, and whether one hit a wall."""
    vector = gym.make_vec("tiloilc/SixteenRooms-v0", num_envs=1)
    vector.reset(seed=0)
    vector.set_state(np.array([[*start, 0]], np.float32))
    return [vector.step(np.array([move]))[0][0].tolist() for move in moves]


def test_one_walks_through_a_door_into_the_next_room() -> None:
    path = stroll((7.5, 3.0), *[(1, 0)] * 3)
    assert path == [[8.5, 3, 0], [9.5, 3, 0], [10.5, 3, 0]]
    path = stroll((4.0, 7.5), *[(0.25, 2)] * 3)
    assert path == [[4.25, 8.5, 0], [4.5, 9.5, 0], [4.75, 10.5, 0]]


def test_a_move_into_a_wall_is_not_made_and_is_seen_until_the_next_move() -> None:
    path = stroll((7.5, 6.0), (0.5, 0), (0.5, 0), (0.5, 0), (0, -1), (0.5, -0.5))
    assert path == [[8, 6, 0], [8, 6, 1], [8, 6, 1], [8, 5, 0], [8.5, 4.5, 0]]


def test_nobody_leaves_the_rooms() -> None:
    assert stroll((0.5, 4.0), (-1, 0)) == [[0.5, 4, 1]]
    assert stroll((37.5, 34.0), (1, 0), (0.5, 0)) == [[37.5, 34, 1], [38, 34, 0]]


def test_corners_of_walls_cannot_be_cut_but_touched() -> None:
    assert stroll((7.75, 2.5), (1, 1)) == [[7.75, 2.5, 1]]
    assert stroll((7.5, 2.5), (1, 1)) == [[8.5, 3.5, 0]]
    assert stroll((8.0, 6.0), (0, 1)) == [[8, 7, 0]], "along a wall's face"


def test_a_line_crosses_a_wall_where_one_of_its_points_is_inside() -> None:
    def inside(points: np.ndarray) -> np.ndarray:
        x, y = points[..., 0] % 10, points[..., 1] % 10
        upright = (x > 8) & ((y < 3) | (y > 5))
        flat = (y > 8) & ((x < 3) | (x > 5))
        return upright | flat

    generator = np.random.default_rng(0)
    here = generator.uniform(0, 38, (15_000, 2))
    here = here[~inside(here)][:10_000]
    assert len(here) == 10_000
    there = here + generator.uniform(-1, 1, here.shape)
    within = ((there >= 0) & (there <= 38)).all(axis=1)
    share = np.linspace(0, 1, 201)[:, None, None]
    seen = inside(here + share * (there - here)).any(axis=0)
    told = crosses(here, there)
    assert told[within & seen].all()
    assert (told & ~seen)[within].sum() <= 20, "but for corners that lie between two points"
    assert (told & within).sum() > 500


def test_walks_through_rooms_start_near_the_middle_of_the_first() -> None:
    vector = gym.make_vec("tiloilc/SixteenRooms-v0", num_envs=1000)
    seen, _ = vector.reset(seed=0)
    np.testing.assert_allclose(seen[:, :2].mean(axis=0), [4, 4], atol=0.05)
    np.testing.assert_allclose(seen[:, :2].std(axis=0), [0.5, 0.5], atol=0.03)
    assert not seen[:, 2].any()
    exact, _ = gym.make("tiloilc/SixteenRooms-v0", noise=0.0).reset(seed=1)
    assert exact.tolist() == [4, 4, 0]


def test_a_scene_is_drawn_with_its_colours_in_its_places() -> None:
    scene = Scene((0.0, 0.0, 2.0, 1.0), (Circle("c", "#ff0000", (1.5, 0.5), 0.3),))
    frame = rasterise(scene, (0.25, 0.75), trace=np.array([[0.5, 0.25]]), height=40)
    assert frame.shape == (40, 80, 3)
    assert frame[20, 60].tolist() == [255, 0, 0]
    assert frame[10, 10].max() < 60, "the agent is dark"
    assert frame[30, 20].tolist() != frame[0, 0].tolist(), "the trace is dotted in"


def test_a_ring_is_drawn_with_a_hole() -> None:
    scene = Scene((0.0, 0.0, 1.0, 1.0), (Ring("r", "#ff0000", (0.5, 0.5), 0.3, 0.4),))
    frame = rasterise(scene, (0.1, 0.9), height=100)
    red = (frame == [255, 0, 0]).all(axis=-1)
    assert red[50, 15]
    assert red[85, 50]
    assert not red[50, 50]
    assert not red[50, 5]
    assert red.sum() / 100**2 == pytest.approx(np.pi * (0.4**2 - 0.3**2), rel=0.02)


@pytest.mark.parametrize(
    ("name", "zone"),
    [
        ("FlatWorld", "y"),
        ("GridAvoid", "a"),
        ("GridSequential", "a"),
        ("GridCircular", "a"),
        ("Carlo", "wp0"),
        ("SixteenRooms", "r43"),
    ],
)
def test_scenes_name_what_they_show(name: str, zone: str) -> None:
    scene = gym.make(f"tiloilc/{name}-v0").unwrapped.scene()
    assert zone in {s.name for s in scene.shapes}
    assert scene.bounds[0] < scene.bounds[2]
    assert all(len(s.color) == 7 and s.color[0] == "#" for s in scene.shapes)
