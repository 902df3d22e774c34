"""The agent on continuous tasks: batches, rewards, inputs, demonstrations, options."""

from typing import Any

import numpy as np
import pytest
import torch

from tests.learn.examples import beyond, cell_is, demos, generator, plan
from tests.plan.automata import chain, flatworld_cycle, fork, stabilization
from tiloilc.demos import Demo, DemoSet
from tiloilc.diag import CompileError
from tiloilc.learn import make_loop
from tiloilc.learn.agent.cloning import clone, infer_actions
from tiloilc.learn.agent.continuous import SacAgent
from tiloilc.learn.agent.shown import _segments, show
from tiloilc.learn.algorithm.method import arrivals_of
from tiloilc.learn.algorithm.tiloil import stage_reward, tiloil_backup
from tiloilc.learn.engine.sac import Imitated
from tiloilc.learn.run.job import _shown
from tiloilc.learn.run.loop import Loop
from tiloilc.plan import Plan, stage_plan
from tiloilc.product import Segmenter, walk_tables

STAY = stabilization()
PATH = [[0.1 * t, 0.0] for t in range(8)]
LABELS = beyond(0.4, 1.5)


def task(actions: str = "inferred", **changes: object) -> Plan:
    return plan(STAY, "TestsDrift-v0", actions=actions, **changes)


def learner(until: int = 80, shown: DemoSet | None = None, **changes: Any) -> tuple[Loop, SacAgent]:
    loop = make_loop(task(**changes), demos(PATH, PATH[:5]) if shown is None else shown, LABELS)
    for _ in loop.run(until):
        pass
    assert isinstance(loop.agent, SacAgent)
    return loop, loop.agent


@pytest.fixture(autouse=True)
def quick_cloning(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tiloilc.learn.agent.cloning.INVERSE_STEPS", 20)
    monkeypatch.setattr("tiloilc.learn.agent.cloning.CLONING_STEPS", 20)


# spaces


@pytest.mark.parametrize(
    ("name", "backbone"),
    [
        ("CartPole-v1", "auto"),
        ("CartPole-v1", "sac"),
        ("CartPole-v1", "tabular"),
        ("Pendulum-v1", "tabular"),
        ("TestsLine-v0", "sac"),
    ],
)
def test_spaces_that_a_backbone_cannot_take_are_a_finding(name: str, backbone: str) -> None:
    made = plan(chain(["p"]), name, backbone=backbone)
    with pytest.raises(CompileError, match="JOB608"):
        make_loop(made, DemoSet(()), cell_is(0))


def test_actions_fill_the_environments_range() -> None:
    _, agent = learner(until=1)
    drawn = agent.explore(np.random.default_rng(0), (2, 1000))
    assert drawn.shape == (2, 1000, 1)
    assert drawn.min() == pytest.approx(-2, abs=0.05)
    assert drawn.max() == pytest.approx(4, abs=0.05)
    assert drawn.mean() == pytest.approx(1, abs=0.2)


def test_stored_actions_are_scaled_to_one() -> None:
    _, agent = learner(until=30)
    actions = agent.layout.unpack(agent.replay.rows[:, :30]).action
    assert actions.abs().max() <= 1
    assert actions.min() < -0.7
    assert actions.max() > 0.7


# inputs


def test_networks_see_scaled_states_and_b_as_one_hot() -> None:
    _, agent = learner(until=1)
    x = agent.encode(torch.zeros(2, 3, 2), torch.tensor([[0, 1, 2]] * 2))
    assert x.shape == (2, 3, 2 + 3)
    assert x[0, :, 2:].tolist() == torch.eye(3).tolist()
    assert torch.equal(x[0, 0, :2], -agent.encode.middle / agent.encode.half)


def test_bounded_observations_are_scaled_by_their_bounds() -> None:
    made = plan(STAY, "tiloilc/FlatWorld-v0")
    agent = make_loop(made, DemoSet(()), beyond(9, 9)).agent
    assert isinstance(agent, SacAgent)
    assert agent.encode.middle.tolist() == pytest.approx([0, 0])
    assert (agent.encode.half > 1).all()


def test_what_acts_in_numpy_is_the_policy_that_learns() -> None:
    _, agent = learner(until=70)
    seen = np.random.default_rng(0).normal(size=(2, 5, 2)).astype(np.float32)
    states = np.array([[0, 1, 2, 0, 1]] * 2)
    x = agent.encode(torch.from_numpy(seen), torch.from_numpy(states))
    assert np.allclose(agent.encode.on_host(seen, states), x.numpy(), atol=1e-6)
    found = agent.act(seen, states, greedy=True)
    assert found.dtype == np.float32
    assert np.allclose(found, 1 + 3 * agent.sac.mean_action(x).numpy(), atol=1e-5)
    noise = torch.randn(2, 5, 1, generator=generator(3))
    drawn = agent.sac.act(x.numpy(), noise.numpy())
    assert np.allclose(drawn, agent.sac.sample(x, noise).action.numpy(), atol=1e-5)
    assert not np.allclose(agent.act(seen, states, greedy=False), found, atol=1e-2)


# targets


def test_rewards_are_those_of_todays_discriminators() -> None:
    _, agent = learner(entropy=0.2)
    batch = agent.layout.unpack(agent.replay.rows[:, :40])

    def targets() -> torch.Tensor:
        options = agent.options[batch.state, batch.letter]
        return agent.method.backup(batch, options).best(torch.zeros(options.shape))

    before = targets()
    agent.method.discriminators.trained[:] = True
    for parameter in agent.method.discriminators.nets.parameters:
        parameter.zero_()
    silent = targets()
    agent.method.discriminators.nets.biases[-1].fill_(20.0)  # tanh f = 1 everywhere
    loud = targets()
    staged = batch.state == 0
    assert torch.allclose((loud - silent)[staged], torch.tensor(agent.settings.beta), atol=1e-4)
    assert not torch.equal(before, loud)


def test_targets_are_equation_4_with_the_soft_value_of_the_next_state(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    _, agent = learner(entropy=0.2)
    chance, n, k = agent._draw(), 16, agent.options.shape[2]
    seen = []

    def critics(x: torch.Tensor, action: torch.Tensor, target: torch.Tensor) -> torch.Tensor:
        batch = agent._batch(chance)
        options = agent.options[batch.state, batch.letter]
        after = agent._encode_options(batch.next_observation, options)
        soft = agent.sac.soft_value(after, agent.sac.sample(after, chance.noise[:, : n * k]))
        bonus = agent.method.discriminators.bonus(batch.observation, batch.state)
        reward = stage_reward(agent.method.table, batch.state, bonus, agent.settings)
        backup = tiloil_backup(agent.method.table, batch, options, reward, agent.settings)
        expected = backup.best(soft.view(2, n, k))
        seen.append(torch.allclose(target, expected, atol=1e-5))
        assert torch.equal(action, batch.action)
        assert torch.equal(x, agent.encode(batch.observation, batch.state))
        return torch.zeros(2)

    monkeypatch.setattr(agent.sac, "update_critics", critics)
    agent._update(chance)
    assert seen == [True]


def test_a_jump_that_takes_a_step_is_worth_its_pay_and_what_follows_a_step_later() -> None:
    """Q((s', 0), jump) = R((s', 0)) + γ V(s', 1), or V(s', 0) of those who do not jump."""
    _, agent = learner(entropy=0.2, epsilon="step", exact_entry=False, end_on_sink=False)
    batch = agent._batch(agent._draw())
    options = agent.options[batch.state, batch.letter]
    waits = (batch.state == 0) & (options[..., 0] == 0)
    assert waits.any()
    assert (options[waits] == torch.tensor([0, 1])).all()
    value = torch.randn(options.shape, generator=torch.Generator().manual_seed(0))
    none = torch.zeros_like(batch.state)
    now, then = (
        stage_reward(
            agent.method.table, none, agent.method.discriminators.bonus(seen, none), agent.settings
        )
        for seen in (batch.observation, batch.next_observation)
    )
    gamma = agent.settings.gamma
    expected = now + gamma * torch.maximum(value[..., 0], then + gamma * value[..., 1])
    found = agent.method.backup(batch, options).best(value)
    assert torch.allclose(found[waits], expected[waits])


@pytest.mark.parametrize(("epsilon", "stays_from"), [("free", 4), ("step", 3)])
def test_demonstrations_are_read_by_the_jumps_that_are_trained_with(
    epsilon: str, stays_from: int
) -> None:
    """Yellow from the fifth state on: the jump reads it, or is a step before it."""
    agent = make_loop(task(epsilon=epsilon), demos(PATH), LABELS).agent
    assert isinstance(agent, SacAgent)
    assert agent.shown.state.tolist() == [int(t >= stays_from) for t in range(7)]


def test_letters_in_the_replay_are_those_of_the_state_arrived_in() -> None:
    _, agent = learner(until=50)
    batch = agent.layout.unpack(agent.replay.rows[:, :50])
    letters = LABELS(batch.next_observation.reshape(-1, 2).numpy()).reshape(2, 50)
    assert np.array_equal(batch.letter.numpy(), letters)


def test_relabelled_steps_are_read_from_every_live_state_and_demonstrations_as_they_went() -> None:
    made = plan(chain(["near", "far"]), "TestsDrift-v0", batch_size=4000, demo_replay=0.25)
    loop = make_loop(made, demos(PATH), LABELS)
    list(loop.run(61))
    agent = loop.agent
    assert isinstance(agent, SacAgent)
    batch, shown = agent._batch(agent._draw()), agent.shown_rows
    assert agent.demo_rows is not None
    went = set(agent.layout.unpack(agent.demo_rows).state.unique().tolist())
    assert set(batch.state[:, :shown].unique().tolist()) <= went
    share = batch.state[:, shown:].flatten().bincount(minlength=3) / (2 * (4000 - shown))
    sink = loop.walk.sink
    live = [b for b in range(loop.walk.states) if b != sink and int(agent.code[b]) == b]
    assert min(share[live]) > 0.4 / len(live)
    letters = LABELS(batch.next_observation.reshape(-1, 2).numpy()).reshape(2, -1)
    assert np.array_equal(batch.letter.numpy(), letters)


def test_without_relabelling_steps_stay_in_the_states_they_were_made_in() -> None:
    _, agent = learner(until=61, relabel=False, demo_replay=0)
    made = {(*row[:2], row[-3]) for seed in agent.replay.rows[:, :61].tolist() for row in seed}
    batch = agent._batch(agent._draw())
    seen = torch.cat([batch.observation, batch.state[..., None]], dim=-1)
    assert {tuple(row) for seed in seen.tolist() for row in seed} <= made


# options


def test_the_greedy_choice_is_the_option_of_greatest_value() -> None:
    _, agent = learner(exact_entry=False, gamma=0.9)
    seen = np.zeros((2, 1, 2), np.float32)
    offered = np.array([[[0, 1]]] * 2)
    x = agent.encode(torch.zeros(2, 2, 2), torch.tensor([[0, 1]] * 2))
    worth = agent.sac.q(agent.sac.critics, x, agent.sac.mean_action(x)).amin(1)
    assert agent.choose(seen, offered, greedy=True)[:, 0].tolist() == worth.argmax(1).tolist()


def test_with_exact_entry_acceptance_is_chosen_at_once() -> None:
    _, agent = learner(until=1, exact_entry=True)
    offered = np.array([[[0, 1], [0, 0], [2, 2]]] * 2)
    chosen = agent.choose(np.zeros((2, 3, 2), np.float32), offered, greedy=True)
    assert chosen.tolist() == [[1, 0, 2]] * 2


def forked(path: list[list[float]] = PATH, **changes: Any) -> SacAgent:
    """The agent of `GF a | GF b` that has just cloned a demonstration of a alone."""
    made = plan(fork(), "TestsDrift-v0", **changes)
    loop = make_loop(made, demos(path), LABELS)
    list(loop.run(made.train.learning_starts))
    assert isinstance(loop.agent, SacAgent)
    return loop.agent


def test_while_cloning_lasts_nobody_jumps_where_no_demonstration_was() -> None:
    """All went through 1 and 3: elsewhere it is worth 1 / (1 − γ) = 10 less, then 5, then 0."""
    agent = forked(gamma=0.9, warm_start_steps=40)
    assert set(agent.shown.state.tolist()) == {1, 3}
    offered = np.tile(np.array([[0, 1, 2]]), (2, 50, 1))
    seen = np.random.default_rng(0).normal(0, 1, (2, 50, 2)).astype(np.float32)
    for progress, less in ((None, 10.0), (20, 5.0), (40, 0.0)):
        if progress is not None:
            agent.learn(progress)
        assert agent.reluctance.tolist() == [[less, 0, less, 0, less]] * 2
        pay = agent.policy()["arrival.pay"] + agent.reluctance
        assert torch.equal(pay, arrivals_of(agent.method, agent.walk, 2, torch.zeros(2))["pay"])
        if less:
            assert (agent.choose(seen, offered, greedy=True) == 1).all()
            assert (agent.choose(seen, offered, greedy=False) != 1).mean() < 0.1
    assert (agent.choose(seen, offered, greedy=True) != 1).any()
    assert (agent.choose(seen, offered, greedy=False) != 1).mean() > 0.1


def test_where_a_demonstration_ends_is_not_strange() -> None:
    """It may end in acceptance, with nothing to show of what to do there."""
    agent = forked(PATH[:5])
    assert agent.shown.state.tolist() == [1, 1, 1, 1]
    assert agent.shown.arrived.tolist() == [1, 1, 1, 3]
    assert not agent.reluctance[:, 3].any()


def test_who_clones_nothing_jumps_as_values_say() -> None:
    assert not forked(warm_start="none").reluctance.any()


def test_a_policy_takes_its_reluctance_along() -> None:
    agent = forked(gamma=0.9, warm_start_steps=40)
    cloned = {name: tensor.clone() for name, tensor in agent.policy().items()}
    agent.learn(40)
    agent.load_policy(cloned)
    assert agent.reluctance[:, 2].tolist() == [10, 10]
    del cloned["reluctance"]  # as in a run of before
    agent.load_policy(cloned)
    assert not agent.reluctance.any()


# demonstrations


def test_demonstrations_have_their_share_in_every_batch() -> None:
    for share, rows in ((0.0, 0), (0.25, 4), (0.5, 8), (1.0, 16)):
        _, agent = learner(until=61, demo_replay=share, warm_start="none")
        batch = agent._batch(agent._draw())
        assert agent.shown_rows == rows
        assert batch.observation.shape == (2, 16, 2)
        path = {round(0.1 * t, 4) for t in range(8)}
        from_demo = [round(v, 4) in path for v in batch.observation[0, :, 0].tolist()]
        assert all(from_demo[:rows])
        assert not any(from_demo[rows:])


def test_demonstrations_go_through_the_automaton_their_first_label_included() -> None:
    _, agent = learner(until=61)
    assert agent.demo_rows is not None
    batch = agent.layout.unpack(agent.demo_rows)
    assert batch.observation.shape == (2, 7 + 4, 2)
    assert not batch.terminal.any()  # a demonstration that stops has not ended
    letters = LABELS(batch.next_observation[0].numpy())
    assert np.array_equal(batch.letter[0].numpy(), letters)


def test_the_first_label_of_a_demonstration_is_read() -> None:
    made = plan(chain(["far", "near"]), "TestsLine-v0", kwargs={"start": 4})
    loop = make_loop(made, demos([4, 3, 2]), cell_is(4, 2))
    loop.product.reset([1, 2], np.array([True, True]))
    shown = _shown(made, demos([4, 3, 2]), cell_is(4, 2), loop.walk, loop.product.copies)
    assert shown.state.tolist() == [1, 1]  # `far` holds in the first state
    assert shown.letter.tolist() == [0, 2]
    assert loop.product.states.tolist() == [1, 1]  # as the agent starts


def replayed(agent: SacAgent, moves: tuple[int, int], jitter: float | None = None) -> None:
    """Have 3,000 steps in the replay, whose action moves which of the two numbers by a tenth.

    With `jitter` the second is 0.5 everywhere, but for so much noise.
    """
    rng, shape = np.random.default_rng(0), (2, 3000, 1)
    before = rng.normal(size=(2, 3000, 2)).astype(np.float32)
    action = rng.uniform(-2, 4, shape).astype(np.float32)
    after = before + 0.1 * action * np.array(moves, np.float32)
    if jitter is not None:
        for states in (before, after):
            states[..., 1] = 0.5 + jitter * rng.normal(size=shape[:2])
    zero = np.zeros(shape[:2], np.int64)
    agent.replay = type(agent.replay)(2, 3000, agent.layout.width)
    agent.record(before, action, after, zero, zero, zero.astype(np.bool_), zero)


def test_actions_are_inferred_from_states(monkeypatch: pytest.MonkeyPatch) -> None:
    """Drift moves by a tenth of the action: the inverse model must find that out."""
    monkeypatch.setattr("tiloilc.learn.agent.cloning.INVERSE_STEPS", 600)
    _, agent = learner(until=1)
    replayed(agent, moves=(1, 1))
    batch = agent.layout.unpack(agent.replay.rows[:, :200])
    states = batch.observation, batch.next_observation
    found = infer_actions(*states, agent.replay, agent.layout, agent.generator)
    assert (found - batch.action).abs().mean() < 0.1


@pytest.mark.parametrize("jitter", [0.0, 1e-5])
def test_what_the_agent_never_moved_says_nothing_of_demonstrated_actions(
    jitter: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A block lies still, but for its jitter, until somebody lifts it: demonstrations do."""
    monkeypatch.setattr("tiloilc.learn.agent.cloning.INVERSE_STEPS", 600)
    _, agent = learner(until=1)
    replayed(agent, moves=(1, 0), jitter=jitter)
    shown, done = torch.zeros(2, 50, 2), 0.6 * torch.linspace(-1.5, 1.5, 50).sin()
    shown[..., 0], shown[..., 1] = torch.linspace(-1, 1, 50), torch.linspace(0.5, 0.6, 50)
    moved = torch.stack([0.1 * (1 + 3 * done), torch.full((50,), 0.002)], dim=-1)
    found = infer_actions(shown, shown + moved, agent.replay, agent.layout, agent.generator)
    assert (found[..., 0] - done).abs().mean() < 0.1


def test_actions_that_lead_beyond_all_that_was_seen_are_those_at_its_edge(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("tiloilc.learn.agent.cloning.INVERSE_STEPS", 20)
    _, agent = learner(until=60)
    seen = agent.layout.unpack(agent.replay.rows[:, :60]).observation
    far = seen.mean(1, keepdim=True) + seen.std(1, keepdim=True) * torch.tensor([[6.0], [9.0]])
    found = infer_actions(far, far, agent.replay, agent.layout, agent.generator)
    assert torch.equal(found[:, 0], found[:, 1])
    assert (found.abs() < 1).all()


def test_the_noise_of_actions_is_not_what_the_networks_were_drawn_from() -> None:
    _, agent = learner(until=1)
    first = torch.Generator().manual_seed(agent.generator.initial_seed())
    noise = torch.Generator().manual_seed(agent.host.initial_seed())
    assert not torch.equal(torch.rand(9, generator=first), torch.rand(9, generator=noise))


def test_seeds_clone_by_steps_of_their_own(monkeypatch: pytest.MonkeyPatch) -> None:
    """Two seeds that begin alike end apart: each draws which steps it is shown."""
    monkeypatch.setattr("tiloilc.learn.agent.cloning.CLONING_STEPS", 1)
    _, agent = learner(until=1)
    for layer in agent.sac.actor.parameters:
        layer[1] = layer[0]
    width = agent.sac.actor.parameters[0].shape[1]
    x, action = torch.randn(300, width).expand(2, -1, -1), torch.rand(300, 1).expand(2, -1, -1)
    clone(agent.sac, x, action, agent.generator)
    assert not torch.equal(agent.sac.actor.parameters[0][0], agent.sac.actor.parameters[0][1])


def test_actions_are_inferred_again_by_what_the_agent_has_done_since(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """What it did at first was wrong about every step; the same demonstrations, better actions."""
    monkeypatch.setattr("tiloilc.learn.agent.cloning.INVERSE_STEPS", 600)
    monkeypatch.setattr("tiloilc.learn.agent.cloning.CLONING_STEPS", 600)
    monkeypatch.setattr("tiloilc.learn.agent.cloning.SCALED_BY", 700)  # of 3,000
    _, agent = learner(until=61)
    assert agent.demo_rows is not None
    before, first = agent.demo_rows.clone(), agent.layout.unpack(agent.demo_rows).action.clone()
    replayed(agent, moves=(1, 0))
    agent.infer(cloning=False)
    batch = agent.layout.unpack(agent.demo_rows)
    moved = (batch.next_observation - batch.observation)[..., :1]
    done = (10 * moved + 2) / 3 - 1  # as Drift moves, between −2 and 4
    assert (batch.action - done).abs().mean() < 0.1 < (first - done).abs().mean()
    same = [i for i in range(before.shape[-1]) if i != 2]
    assert torch.equal(agent.demo_rows[..., same], before[..., same])
    x = agent.encode(batch.observation, batch.state)
    apart = (agent.sac.mean_action(x) - batch.action).abs().mean()
    agent.infer(cloning=True)
    assert (agent.sac.mean_action(x) - batch.action).abs().mean() < 0.1 < apart


def test_actions_that_are_inferred_again_are_not_cloned_without_a_warm_start() -> None:
    _, agent = learner(until=61, warm_start="none", demo_replay=0.5)
    assert agent.demo_rows is not None
    rows, actor = agent.demo_rows.clone(), [p.clone() for p in agent.sac.actor.parameters]
    agent.infer(cloning=True)
    assert not torch.equal(agent.demo_rows, rows)
    assert all(map(torch.equal, agent.sac.actor.parameters, actor))


def test_recorded_actions_are_not_inferred_again() -> None:
    recorded = DemoSet((Demo(np.array(PATH, np.float32), np.full((7, 1), 4, np.float32)),))
    _, agent = learner(until=61, shown=recorded, actions="recorded")
    assert agent.demo_rows is not None
    before = agent.demo_rows.clone()
    agent.infer(cloning=True)
    assert torch.equal(agent.demo_rows, before)


def test_recorded_actions_are_used_as_they_are() -> None:
    recorded = DemoSet((Demo(np.array(PATH, np.float32), np.full((7, 1), 4, np.float32)),))
    _, agent = learner(until=61, shown=recorded, actions="recorded")
    assert agent.demo_rows is not None
    assert agent.layout.unpack(agent.demo_rows).action.unique().tolist() == [1]


def test_without_actions_demonstrations_feed_the_discriminators_only() -> None:
    _, agent = learner(until=70, actions="none")
    assert agent.demo_rows is None
    assert len(agent.method.discriminators.demonstrations) > 0


def test_cloning_brings_the_greedy_action_to_the_demonstrated_one(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("tiloilc.learn.agent.cloning.CLONING_STEPS", 600)
    _, agent = learner(until=1)
    x, action = torch.randn(2, 40, 5, generator=generator(1)), torch.full((2, 40, 1), 0.5)
    clone(agent.sac, x, action, agent.generator)
    assert (agent.sac.mean_action(x) - 0.5).abs().mean() < 0.05


def test_the_cloning_loss_fades_to_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    _, agent = learner(until=61, warm_start_steps=100, demo_replay=0.25, gamma=0.9)
    seen = []

    def actor(x: torch.Tensor, drawn: object, imitated: Imitated) -> torch.Tensor:
        seen.append(float(imitated.weight))  # one tensor, filled anew
        assert imitated.action.shape == (2, 4, 1)
        return torch.zeros(2)

    monkeypatch.setattr(agent.sac, "update_actor", actor)
    for progress in (0, 50, 100, 200):
        agent.learn(progress)
    assert seen == pytest.approx([10, 5, 0, 0])


# which states of demonstrations are positive


@pytest.mark.parametrize(
    ("accepting", "cut", "expected"),
    [
        ("0010010", True, [(0, 3), (3, 6)]),  # what follows the last visit leads nowhere
        ("0000", True, [(0, 4)]),  # appendix F.3: one that never accepts counts whole
        ("00111", True, [(0, 3)]),  # staying is no segment
        ("1001", True, [(0, 1), (1, 4)]),
        ("1", True, [(0, 1)]),
        ("0010010", False, [(0, 7)]),
    ],
)
def test_demonstrations_are_cut_like_episodes(
    accepting: str, cut: bool, expected: list[tuple[int, int]]
) -> None:
    assert _segments([c == "1" for c in accepting], cut) == expected


def test_demonstrations_and_episodes_agree_on_segments() -> None:
    """The segments that reach acceptance are the same for a demonstration and an episode."""
    ldba = flatworld_cycle()
    walk, stages = walk_tables(ldba), stage_plan(ldba)
    rng = np.random.default_rng(0)
    for _ in range(50):
        states, b = [], 0
        for letter in rng.integers(8, size=30):
            b = ldba.successor(b, int(letter))
            states.append(b)
        collector = Segmenter(walk, stages, 1, 30, 1, True)
        found = []
        for t, b in enumerate(states):
            found += collector.arrive(np.array([[t]], np.float32), np.array([b]), np.array([True]))
        mine = [seen.observations[:, 0].astype(int).tolist() for seen in found]
        theirs = [list(range(*s)) for s in _segments(walk.accepting[states].tolist(), True)]
        if mine:
            assert mine == theirs


def test_nothing_is_shown_without_demonstrations() -> None:
    shown = show(DemoSet(()), (), walk_tables(STAY), task().demonstrations, 2, True)
    assert shown.observation.shape == shown.positive.shape == (0, 2)
    _, agent = learner(until=70, shown=DemoSet(()))
    assert agent.demo_rows is None


def test_step_sizes_fall_to_their_final_share_but_not_the_temperatures() -> None:
    _, agent = learner(until=50, steps=200, learning_starts=100, final_rate=0.2, actor_rate=0.5)
    sac = agent.sac
    for step, share in ((0, 1.0), (50, 0.6), (100, 0.2), (163, 0.2)):  # 64 copies end past 200
        agent.learn(step)
        assert sac.actor_adam.rate.item() == pytest.approx(0.5 * share)
        assert sac.critic_adam.rate.item() == pytest.approx(agent.settings.critic_rate * share)
        assert sac.alpha_adam.rate.item() == pytest.approx(agent.settings.critic_rate)


@pytest.mark.parametrize("share", [0.0, 0.25, 1.0])
def test_a_share_of_actions_is_random_while_learning(share: float) -> None:
    """A policy that hardly varies stands apart from uniform actions in [-2, 4]."""
    _, agent = learner(until=1, exploration=share)
    agent.sac.actor.parameters[-1].fill_(0)
    agent.sac.actor.parameters[-1][..., 1:] = -50  # log σ at its least
    for layer in agent.sac.actor.parameters[:-1]:
        layer.fill_(0)
    seen, states = np.zeros((2, 2000, 2), np.float32), np.zeros((2, 2000), np.int64)
    acted = agent.act(seen, states, greedy=False)
    stray = (np.abs(acted - 1) > 0.1).mean()
    assert stray == pytest.approx(share * (1 - 0.2 / 6), abs=0.02)
    assert (np.abs(agent.act(seen, states, greedy=True) - 1) < 1e-3).all()
