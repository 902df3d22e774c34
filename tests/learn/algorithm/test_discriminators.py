"""Stage buffers and discriminators: what is drawn, what is learned, what stays silent."""

from collections.abc import Sequence

import numpy as np
import pytest
import torch
from gymnasium.spaces import Discrete

from tests.learn.examples import generator, settings
from tests.plan.automata import flatworld_cycle, response
from tiloilc.learn.algorithm.discriminator.counts import CountDiscriminators
from tiloilc.learn.algorithm.discriminator.networks import Discriminators, RunningNorm, StageBuffers
from tiloilc.learn.algorithm.discriminator.unions import stage_unions
from tiloilc.learn.engine.cells import Cells
from tiloilc.plan import stage_plan

STAGES = stage_plan(flatworld_cycle())  # stages 0, 1, 2; 3 accepts, 4 is the sink, B_⊥ is 5


def states(*values: float) -> np.ndarray:
    return np.array(values, np.float32)[:, None]


def held(buffers: StageBuffers, seed: int, buffer: int) -> list[float]:
    count = int(buffers.counts[seed, buffer])
    return sorted(buffers.states[seed, buffer, :count, 0].tolist())


def discriminators(
    buffers: StageBuffers, shown: Sequence[float] = (), **changes: object
) -> Discriminators:
    given = settings(seeds=len(buffers.states), discriminator_rate=0.02, **changes)
    demonstrations = torch.tensor(shown, dtype=torch.float32)[:, None]
    unions = stage_unions(STAGES, given.stages)
    return Discriminators(unions, buffers, demonstrations, given, generator())


def uniform(*shape: int) -> torch.Tensor:
    return torch.rand(shape, generator=generator())


# buffers


def test_a_full_buffer_forgets_the_oldest_states() -> None:
    buffers = StageBuffers(2, 3, capacity=4, d=1)
    buffers.add(1, 2, states(0, 1, 2))
    buffers.add(1, 2, states(3, 4, 5))
    assert held(buffers, 1, 2) == [2, 3, 4, 5]
    assert buffers.counts.tolist() == [[0, 0, 0], [0, 0, 4]]


def test_of_a_segment_longer_than_the_buffer_the_end_is_kept() -> None:
    buffers = StageBuffers(1, 1, capacity=4, d=1)
    buffers.add(0, 0, states(9, 9))
    buffers.add(0, 0, states(*range(7)))
    assert held(buffers, 0, 0) == [3, 4, 5, 6]


def test_states_of_a_union_are_drawn_uniformly_not_buffers_nor_segments() -> None:
    buffers = StageBuffers(2, 4, capacity=100, d=1)
    buffers.add(0, 0, states(*range(10)))  # ten states in one segment
    for k in range(30):
        buffers.add(0, 2, states(100 + k))  # thirty segments of one state
    buffers.add(0, 3, states(*[-1.0] * 90))  # not in the union
    unions = torch.tensor([[1, 1, 1, 0], [0, 0, 0, 1]])
    drawn = buffers.sample(unions, uniform(2, 2, 40_000))
    assert drawn.shape == (2, 2, 40_000, 1)
    values, counts = np.unique(drawn[0, 0].numpy(), return_counts=True)
    assert values.tolist() == [*range(10), *range(100, 130)]
    assert (abs(counts - 1000) < 180).all()
    assert drawn[0, 1].unique().tolist() == [-1]


def test_seeds_draw_from_their_own_buffers() -> None:
    buffers = StageBuffers(2, 2, capacity=5, d=1)
    buffers.add(0, 0, states(1, 2))
    buffers.add(1, 1, states(3, 4))
    unions = torch.tensor([[1, 1]])
    drawn = buffers.sample(unions, uniform(2, 1, 100))
    assert drawn[0].unique().tolist() == [1, 2]
    assert drawn[1].unique().tolist() == [3, 4]
    assert buffers.available(torch.tensor([[1, 0], [0, 1]])).tolist() == [
        [True, False],
        [False, True],
    ]


def test_buffers_go_on_from_their_state() -> None:
    first, second = (StageBuffers(1, 2, capacity=4, d=1) for _ in range(2))
    first.add(0, 1, states(*range(6)))
    first.add(0, 0, states(7))
    second.load({name: tensor.clone() for name, tensor in first.state().items()})
    nothing = torch.zeros(2, dtype=torch.long)
    second.ring().restore(first.ring().since(nothing), nothing, first.ring().written)
    for buffers in (first, second):
        buffers.add(0, 1, states(8, 9))
    assert torch.equal(first.written, second.written)
    assert held(first, 0, 1) == held(second, 0, 1) == [4, 5, 8, 9]
    assert held(second, 0, 0) == [7]


# unions


def test_the_sink_buffer_is_among_the_negatives_of_every_stage() -> None:
    unions = stage_unions(STAGES, separate=True)
    assert unions.negative.tolist() == [[1, 0, 0, 0, 0, 1], [1, 1, 0, 0, 0, 1], [1, 1, 1, 0, 0, 1]]
    assert unions.positive.tolist() == [[0, 1, 1, 1, 0, 0], [0, 0, 1, 1, 0, 0], [0, 0, 0, 1, 0, 0]]
    one = stage_unions(STAGES, separate=False)
    assert one.negative[0, STAGES.sink_buffer] == 1


def test_acceptance_and_the_sink_have_no_discriminator() -> None:
    unions = stage_unions(STAGES, separate=True)
    assert unions.slot.tolist() == [0, 1, 2, 3, 3]
    assert unions.stages == 3
    assert stage_unions(STAGES, separate=False).slot.tolist() == [0] * 5


def test_one_discriminator_for_all_tells_acceptance_from_everything_else() -> None:
    unions = stage_unions(STAGES, separate=False)
    assert unions.positive.tolist() == [[0, 0, 0, 1, 0, 0]]
    assert unions.negative.tolist() == [[1, 1, 1, 0, 1, 1]]


def test_no_buffer_is_positive_and_negative_at_once() -> None:
    for ldba in (flatworld_cycle(), response()):
        for separate in (True, False):
            unions = stage_unions(stage_plan(ldba), separate)
            assert not (unions.positive & unions.negative).any()


# normalisation


def test_the_running_norm_is_that_of_everything_seen() -> None:
    rng = np.random.default_rng(0)
    data = torch.from_numpy(rng.normal([3, -50], [0.1, 20], size=(2, 400, 2))).float()
    norm = RunningNorm(2, 2)
    for start in range(0, 400, 8):
        norm.update(data[:, start : start + 8])
    expected = (data - data.mean(1, keepdim=True)) / data.std(1, keepdim=True, correction=0)
    assert torch.allclose(norm(data), expected, atol=1e-3)


def test_a_constant_component_is_normalised_to_zero() -> None:
    norm = RunningNorm(1, 1)
    for _ in range(5):
        norm.update(torch.full((1, 3, 1), 7.0))
    assert norm(torch.full((1, 1, 1), 7.0)).item() == pytest.approx(0, abs=1e-3)


def test_discriminators_see_normalised_states_and_nothing_else() -> None:
    """f(s) must be the same for (s, norm) and for (10 s + 3, norm of that)."""
    buffers = StageBuffers(1, 6, capacity=10, d=1)
    first, second = discriminators(buffers), discriminators(buffers)
    assert first.nets.sizes[0] == 1  # the MDP state: no b, no time
    x = torch.linspace(-1, 1, 9)[None, :, None]
    first.norm.update(x)
    second.norm.update(10 * x + 3)
    b = torch.zeros(1, 9, dtype=torch.long)
    for found in (first, second):
        found.trained[:] = True
    assert first.bonus(x, b).abs().min() > 0
    assert torch.allclose(first.bonus(x, b), second.bonus(10 * x + 3, b), atol=1e-5)


# learning


def filled(seeds: int = 1) -> StageBuffers:
    """Accepting segments are around 1, those of stage 0 around -1; nothing else happened."""
    buffers = StageBuffers(seeds, 6, capacity=200, d=1)
    rng = np.random.default_rng(0)
    for seed in range(seeds):
        buffers.add(seed, 3, states(*rng.normal(1, 0.3, 100)))
        buffers.add(seed, 0, states(*rng.normal(-1, 0.3, 100)))
    return buffers


@pytest.mark.parametrize("kind", ["separate", "shared"])
def test_discriminators_learn_to_tell_success_from_failure(kind: str) -> None:
    found = discriminators(filled(2), discriminator=kind)
    for _ in range(300):
        loss = found.update()
    assert loss.shape == (2,)
    seen = torch.tensor([[[1.0], [-1.0]]] * 2)
    for b in range(3):
        bonus = found.bonus(seen, torch.full((2, 2), b))
        assert (bonus[:, 0] > 0.8).all()
        assert (bonus[:, 1] < -0.8).all()


@pytest.mark.parametrize("kind", ["separate", "shared"])
def test_an_untrained_discriminator_adds_nothing(kind: str) -> None:
    found = discriminators(StageBuffers(1, 6, capacity=10, d=1), discriminator=kind)
    seen, b = torch.randn(1, 50, 1, generator=generator()), torch.arange(50)[None] % 5
    assert found.bonus(seen, b).tolist() == [[0.0] * 50]
    before = [p.clone() for p in found.nets.parameters]
    found.update()  # no positives, no negatives
    assert found.bonus(seen, b).tolist() == [[0.0] * 50]
    assert all(torch.equal(p, q) for p, q in zip(before, found.nets.parameters, strict=True))


@pytest.mark.parametrize("side", [3, 0])
def test_one_side_alone_teaches_nothing(side: int) -> None:
    buffers = StageBuffers(1, 6, capacity=10, d=1)
    buffers.add(0, side, states(1, 2, 3))
    found = discriminators(buffers)
    assert found.update().tolist() == [0.0]
    assert not found.trained.any()


def test_acceptance_and_sink_have_no_discriminator() -> None:
    found = discriminators(filled())
    for _ in range(20):
        found.update()
    assert found.trained.tolist() == [[True, True, True]]
    assert found.bonus(torch.ones(1, 2, 1), torch.tensor([[3, 4]])).tolist() == [[0.0, 0.0]]


def test_a_seed_that_has_seen_nothing_learns_nothing_from_the_others() -> None:
    buffers = filled(2)
    buffers.written[1] = 0
    found = discriminators(buffers)
    for _ in range(5):
        loss = found.update()
    assert loss[0] > 0
    assert loss[1] == 0
    assert found.trained[0, :3].all()
    assert not found.trained[1].any()


def test_the_share_of_demonstrations_in_a_positive_batch_is_as_told() -> None:
    buffers = StageBuffers(1, 6, capacity=1000, d=1)
    buffers.add(0, 3, states(*[1.0] * 990))  # many own ones do not swamp five demonstrations
    for share in (0.0, 0.25, 0.5, 1.0):
        found = discriminators(buffers, shown=[7.0] * 5, demo_fraction=share)
        drawn = found._batch(found.draw())[0][0, 0, :16, 0]
        assert (drawn == 7).float().mean().item() == share


def test_without_own_successes_all_positives_are_demonstrations() -> None:
    buffers = StageBuffers(1, 6, capacity=10, d=1)
    buffers.add(0, 0, states(0, 0))
    found = discriminators(buffers, shown=[7.0, 8.0], demo_fraction=0.25)
    drawn = found._batch(found.draw())[0][0, :, :16]
    assert drawn.unique().tolist() == [7, 8]
    found.update()
    assert found.trained.tolist() == [[True, True, True]]


def test_the_discriminator_loss_is_binary_cross_entropy_summed_over_stages() -> None:
    buffers = StageBuffers(1, 6, capacity=10, d=1)
    buffers.add(0, 3, states(2.0))
    buffers.add(0, 0, states(-2.0))
    found = discriminators(buffers)
    every = torch.tensor([[[[2.0]], [[-2.0]]]])  # both states for one stage at a time
    logits = found.logits(found.norm(every.view(1, 2, 1)).repeat(1, 3, 1).view(1, 3, 2, 1))[0]
    expected = 0.5 * (
        torch.nn.functional.softplus(-logits[:, 0]) + torch.nn.functional.softplus(logits[:, 1])
    )
    assert found.update().item() == pytest.approx(expected.sum().item(), rel=1e-5)


def test_discriminators_go_on_from_their_state() -> None:
    def run(found: Discriminators, updates: int) -> torch.Tensor:
        for _ in range(updates):
            found.update()
        return found.bonus(torch.linspace(-1, 1, 9)[None, :, None], torch.ones(1, 9).long())

    first = discriminators(filled())
    first.norm.update(torch.randn(1, 100, 1, generator=generator(1)))
    run(first, 5)
    second = discriminators(filled())
    second.load({name: tensor.clone() for name, tensor in first.state().items()})
    second.generator.set_state(first.generator.get_state())
    assert torch.equal(run(first, 5), run(second, 5))


# counts


def counted(shown: Sequence[int] = (), **changes: object) -> CountDiscriminators:
    states = torch.tensor(shown, dtype=torch.float32)[:, None]
    given = settings(seeds=1, **changes)
    unions = stage_unions(STAGES, given.stages)
    found = CountDiscriminators(unions, Cells.of(Discrete(4)), states, given)
    found.counts[0, 3] = torch.tensor([0.0, 2.0, 0.0, 6.0])
    found.counts[0, 0] = torch.tensor([3.0, 1.0, 0.0, 0.0])
    return found


def of(found: CountDiscriminators, b: int) -> list[float]:
    return found.bonus(torch.arange(4)[None, :, None], torch.full((1, 4), b))[0].tolist()


def test_counts_give_the_log_ratio_of_the_frequencies() -> None:
    found = counted()
    found.learn({})
    positive = np.array([0.0, 2, 0, 6])
    negative = np.array([3.0, 1, 0, 0]) * 8 / 4  # as if both sides were equally many
    expected = np.tanh(np.log((positive + 0.5) / (negative + 0.5)))
    assert of(found, 0) == pytest.approx(expected.tolist())
    assert of(found, 0)[2] == 0  # nobody was ever there


def test_counts_of_one_side_alone_say_nothing() -> None:
    found = counted()
    found.counts[0, 0] = 0
    found.learn({})
    assert of(found, 0) == [0, 0, 0, 0]
    assert of(counted(), 0) == [0, 0, 0, 0]  # not before they are learned


def test_counts_of_sinks_are_negative_for_every_stage() -> None:
    found = counted()
    found.counts[0, 0] = 0
    found.counts[0, STAGES.sink_buffer] = torch.tensor([0.0, 0, 9, 0])
    found.learn({})
    for b in range(3):
        assert of(found, b)[2] < -0.9
    assert of(found, 3) == of(found, 4) == [0, 0, 0, 0]


def test_counts_take_their_share_of_demonstrations() -> None:
    found = counted(shown=[1, 1, 2, 2], demo_fraction=0.5)
    found.learn({})
    positive = 0.5 * np.array([0.0, 2, 0, 6]) + 0.5 * 8 * np.array([0, 2, 2, 0]) / 4
    negative = np.array([3.0, 1, 0, 0]) * 8 / 4
    expected = np.tanh(np.log((positive + 0.5) / (negative + 0.5)))
    assert of(found, 0) == pytest.approx(expected.tolist())
