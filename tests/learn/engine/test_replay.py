"""The replay: rows go in and come out as they were, rings wrap, sampling is uniform."""

import numpy as np
import torch

from tests.learn.examples import generator
from tiloilc.learn.engine.replay import Layout, Replay


def rows(*values: float, seeds: int = 2) -> np.ndarray:
    """One row [seed, k, 1] for each value; seed s holds value + 1000 s."""
    row = np.array(values, np.float32)[None, :, None]
    return row + 1000 * np.arange(seeds, dtype=np.float32)[:, None, None]


def held(replay: Replay) -> list[list[float]]:
    return [sorted(seed[: len(replay), 0].tolist()) for seed in replay.rows]


def test_what_is_packed_is_unpacked() -> None:
    rng = np.random.default_rng(0)
    layout = Layout(observation=3, action=2)
    seen, after = rng.normal(size=(2, 5, 6, 3)).astype(np.float32)
    action = rng.normal(size=(5, 6, 2)).astype(np.float32)
    state, letter = rng.integers(9, size=(2, 5, 6))
    terminal = rng.random((5, 6)) < 0.5
    packed = layout.pack(seen, action, after, state, letter, terminal)
    assert packed.shape == (5, 6, layout.width)
    batch = layout.unpack(torch.from_numpy(packed))
    for name, expected in {
        "observation": seen,
        "action": action,
        "next_observation": after,
        "state": state,
        "letter": letter,
        "terminal": terminal,
    }.items():
        assert np.array_equal(getattr(batch, name).numpy(), expected), name


def test_a_full_ring_forgets_the_oldest_rows() -> None:
    replay = Replay(seeds=2, capacity=5, width=1)
    for k in range(7):
        replay.add(rows(k))
        assert len(replay) == min(k + 1, 5)
    assert held(replay) == [[2, 3, 4, 5, 6], [1002, 1003, 1004, 1005, 1006]]


def test_rows_of_many_copies_wrap_around_the_end() -> None:
    replay = Replay(seeds=2, capacity=5, width=1)
    replay.add(rows(0, 1, 2))
    replay.add(rows(3, 4, 5))
    assert held(replay) == [[1, 2, 3, 4, 5], [1001, 1002, 1003, 1004, 1005]]


def test_each_seed_is_sampled_from_its_own_rows_uniformly() -> None:
    replay = Replay(seeds=2, capacity=50, width=1)
    replay.add(rows(*range(10)))
    drawn = replay.sample(20_000, generator())[..., 0]
    assert drawn.shape == (2, 20_000)
    for seed in range(2):
        values, counts = np.unique(drawn[seed].numpy(), return_counts=True)
        assert values.tolist() == [1000 * seed + k for k in range(10)]  # none that is not written
        assert (abs(counts - 2000) < 250).all()
    assert not torch.equal(drawn[0], drawn[1] - 1000)  # not the same rows for every seed


def test_a_replay_goes_on_from_its_state() -> None:
    first, second = (Replay(seeds=2, capacity=5, width=1) for _ in range(2))
    for k in range(7):
        first.add(rows(k))
    second.load({name: tensor.clone() for name, tensor in first.state().items()})
    nothing = torch.zeros(2, dtype=torch.long)
    second.ring().restore(first.ring().since(nothing), nothing, first.ring().written)
    for replay in (first, second):
        replay.add(rows(7, 8))
    assert torch.equal(first.rows, second.rows)
    assert torch.equal(first.sample(9, generator()), second.sample(9, generator()))
