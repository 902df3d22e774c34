"""Six baselines against hand numbers, and each on a task that it solves."""

from typing import Any

import numpy as np
import pytest
import torch
from gymnasium.spaces import Discrete

from tests.learn.exact import RING, SIZE, labels_of, learn_all
from tests.learn.exact import task as line
from tests.learn.examples import beyond, cell_is, demos, generator, plan, settings
from tests.plan.automata import automaton, chain, ring, stabilization
from tiloilc.automaton.ldba import Ldba
from tiloilc.demos import Demo, DemoSet
from tiloilc.evaluate.rollout import Arena
from tiloilc.learn import make_loop
from tiloilc.learn.agent.continuous import SacAgent
from tiloilc.learn.agent.steps import Trail, in_each_state
from tiloilc.learn.agent.tabular import TabularAgent
from tiloilc.learn.algorithm import Episode, Setup
from tiloilc.learn.algorithm.cycler import CyclER, accepting_cycles, best_cycle
from tiloilc.learn.algorithm.drl2 import DRL2, chain_values, optimistic_prior
from tiloilc.learn.algorithm.gail import GAIL
from tiloilc.learn.algorithm.method import Method, make_method
from tiloilc.learn.algorithm.pwil import PWIL, coupling_costs
from tiloilc.learn.engine.cells import Cells
from tiloilc.learn.engine.replay import Batch
from tiloilc.plan import Plan, stage_plan
from tiloilc.product import walk_tables
from tiloilc.spec.presets import OF_ALGORITHM
from tiloilc.spec.settings import ALGORITHMS

WALK = walk_tables(RING)
WAITS, HALF, ACCEPTS, SINK = range(4)
NOTHING, RIGHT, LEFT, NEVER = 0, 1, 2, 4
GAMMA, BETWEEN = 0.9, 0.99

BASELINES = tuple(sorted(OF_ALGORITHM))


def setup(ldba: Ldba = RING, shown: Any = (), finite: bool = True, **changes: object) -> Setup:
    given = settings(
        **{"seeds": 1, "gamma": GAMMA, "gamma_between": BETWEEN, "preset": "paper", **changes}
    )
    states = torch.tensor(shown, dtype=torch.float32).reshape(-1, 1)
    cells = Cells.of(Discrete(9)) if finite else None
    walk = walk_tables(ldba, given.epsilon)
    return Setup(given, stage_plan(ldba), walk, states, 100, 4, generator(), cells)


def method(name: str, **changes: Any) -> Method:
    return make_method(setup(algorithm=name, **changes))


def batch(
    *steps: tuple[int, int], terminal: bool = False, kept: Any = (), shown: bool = False
) -> Batch:
    """Steps of one seed, each an automaton state and the letter of where it leads."""
    state, letter = (torch.tensor([column]) for column in zip(*steps, strict=True))
    seen = torch.zeros(1, len(steps), 1)
    over = torch.full(state.shape, terminal)
    notes = torch.tensor(kept, dtype=torch.float32).reshape(1, len(steps), -1)
    return Batch(seen, seen, seen, state, letter, over, notes, torch.full(state.shape, shown))


def read_from(steps: Batch, *states: int) -> Batch:
    """The same steps, each read from each of the states."""
    trail = Trail(steps, steps.state >= 0, steps.state)
    return in_each_state(trail, torch.tensor(states)).batch


def targets(found: Method, steps: Batch, value: float = 5.0) -> list[float]:
    """What each step is worth where every next state is worth `value`."""
    options = torch.from_numpy(WALK.options)[steps.state, steps.letter]
    worth = found.backup(steps, options).best(torch.full(options.shape, value))
    return worth[0].tolist()


# what all have in common


def test_every_baseline_says_what_of_it_is_faithful_and_what_reconstructed() -> None:
    for name in BASELINES:
        text = __import__(f"tiloilc.learn.algorithm.{name}", fromlist=["x"]).__doc__
        assert "Faithful" in text or "Reconstructed" in text


def test_what_an_algorithm_is_goes_before_the_preset_and_the_task_before_both() -> None:
    given = settings(algorithm="sqil", preset="paper")
    assert (given.demo_replay, given.segment) == (0.5, False)
    assert settings(algorithm="sqil", demo_replay=0.25).demo_replay == 0.25
    assert given.overrides().keys() >= {"algorithm"}
    assert "demo_replay" not in given.overrides()
    assert settings().override({"algorithm": "gail"}).segment is False
    assert settings(algorithm="gail").override({"algorithm": "tiloil"}).segment is True


def test_what_a_task_file_says_of_one_method_does_not_make_another() -> None:
    """A first value for TiLoIL would leave LCER without anything to look for (ADR 25)."""
    given = settings(optimistic=True, relabel=False, gamma=0.9)
    assert given.override({"gamma": 0.8}).optimistic is True
    lcer = given.override({"algorithm": "lcer"})
    assert (lcer.optimistic, lcer.relabel, lcer.gamma) == (False, True, 0.9)
    assert given.override({"algorithm": "lcer", "optimistic": True}).optimistic is True
    assert given.override({"algorithm": "cloning"}).optimistic is True
    sqil = settings(algorithm="sqil", demo_replay=0.2, tau=0.1)
    assert sqil.override({"steps": 5}).demo_replay == 0.2
    assert sqil.override({"algorithm": "tiloil"}).demo_replay == 0.1
    assert sqil.override({"algorithm": "tiloil"}).tau == 0.1


# LCER


def test_eventual_discounting_pays_for_arrival_and_discounts_there() -> None:
    steps = batch((HALF, LEFT), (HALF, NOTHING), (ACCEPTS, RIGHT), (HALF, NEVER))
    found = targets(method("lcer"), steps)
    assert found == pytest.approx([1 + GAMMA * 5, BETWEEN * 5, BETWEEN * 5, 0])


def test_nothing_comes_after_an_environments_own_end() -> None:
    steps = batch((HALF, LEFT), (HALF, NOTHING), terminal=True)
    assert targets(method("lcer"), steps) == pytest.approx([1, 0])


def test_a_counterfactual_step_has_the_reward_of_the_state_it_is_read_from() -> None:
    """Trap 27: the agent was waiting for `right`; from the other state the same step accepts."""
    read = read_from(batch((WAITS, LEFT), kept=[[]]), WAITS, HALF)
    assert targets(method("lcer"), read) == pytest.approx([BETWEEN * 5, 1 + GAMMA * 5])


def test_the_discount_between_visits_is_below_one() -> None:
    """Trap 28: with 1 to wait for ever is worth as much as to arrive."""
    for name in ("lcer", "cycler", "drl2"):
        given = settings(algorithm=name)
        assert 0.99 < given.gamma_between < 1
        with pytest.raises(ValueError, match=r"less than or equal to 0\.99999"):
            settings(algorithm=name, gamma_between=1)


def test_lcer_finds_the_values_of_eventual_discounting() -> None:
    """Seven steps and an arrival make a round: V = d⁷ (1 + γ V)."""
    made = line(RING, algorithm="lcer", gamma_between=BETWEEN)
    loop = make_loop(made, DemoSet(()), labels_of(RING))
    agent = loop.agent
    assert isinstance(agent, TabularAgent)
    cells, states, actions = np.meshgrid(range(SIZE), [0, 1], range(3), indexing="ij")
    cell, b, action = (grid.reshape(1, -1) for grid in (cells, states, actions))
    after = np.clip(cell + action - 1, 0, SIZE - 1)
    letter = labels_of(RING)(after.reshape(-1, 1)).reshape(after.shape)
    seen, arrived = (x[..., None].astype(np.float32) for x in (cell, after))
    agent.record(seen, action, arrived, b, letter, np.zeros(b.shape, dtype=np.bool_), b)
    learn_all(agent, 1000)
    away = BETWEEN**7
    assert agent.q[0, 0, WAITS].max().item() == pytest.approx(away / (1 - GAMMA * away), rel=1e-4)


def test_a_jump_that_takes_a_step_is_chosen_by_what_comes_then() -> None:
    """Definition 2.3: staying is worth V of the first option, jumping a step more."""
    stay = stabilization()
    found = make_method(
        setup(stay, algorithm="lcer", epsilon="step", accepting_target="live", finite=False)
    )
    options = torch.tensor([[[0, 1]]])
    worth = found.worth(torch.zeros(1, 1, 1), options).each(torch.tensor([[[3.0, 5.0]]]))
    assert worth[0, 0].tolist() == pytest.approx([3, 1 + GAMMA * 5])
    step = batch((0, 0))
    target = found.backup(step, options).best(torch.tensor([[[3.0, 5.0]]]))
    assert target.item() == pytest.approx(BETWEEN * (1 + GAMMA * 5))


# DRL²


def test_values_of_a_chain_by_hand() -> None:
    """U₁ = 1 + γ U₁ where it accepts; U₀ = ½ d U₀ + ½ (1 + γ U₁)."""
    counts = torch.tensor([[[3.0, 3.0], [0.0, 8.0]]]).double()
    discount = torch.tensor([BETWEEN, GAMMA]).double()
    stays = 1 / (1 - GAMMA)
    expected = [0.5 * stays / (1 - 0.5 * BETWEEN), stays]
    found = chain_values(counts, torch.tensor([False, True]), discount)
    assert found[0].tolist() == pytest.approx(expected)


def test_the_prior_expects_nobody_to_fail_or_to_wait() -> None:
    prior = optimistic_prior(WALK)
    assert prior.tolist() == [[0, 1, 0, 0], [0, 0, 1, 0], [0.5, 0.5, 0, 0], [0, 0, 0, 1]]
    kept = optimistic_prior(walk_tables(stabilization()))
    assert kept.tolist() == [[0, 1, 0], [0, 1, 0], [0, 0, 1]]  # acceptance may be kept


def test_steps_are_counted_and_lower_what_is_hoped_for() -> None:
    found = method("drl2", prior_count=4)
    assert isinstance(found, DRL2)
    hoped = found.potential[0].tolist()
    waiting = np.full((1, 40), WAITS)
    found.see(np.zeros((1, 40, 1), np.float32), waiting, waiting)
    assert found.potential[0].tolist() == hoped  # until the next update
    found.learn(found.draw())
    assert found.counts[0, WAITS].tolist() == [40, 0, 0, 0]
    chain = torch.tensor([[40 / 44, 4 / 44, 0, 0], [0, 0, 1, 0], [0.5, 0.5, 0, 0], [0, 0, 0, 1]])
    discount = torch.tensor([BETWEEN, BETWEEN, GAMMA, BETWEEN])
    paid = torch.tensor([0.0, 0, 1, 0])
    expected = torch.linalg.solve(torch.eye(4) - chain * discount, chain @ paid)
    assert found.potential[0].tolist() == pytest.approx(expected.tolist(), rel=1e-4)
    assert found.potential[0, WAITS] < hoped[WAITS]
    assert found.potential[0, SINK] == 0


def test_progress_pays_the_difference_of_potentials() -> None:
    found = method("drl2")
    assert isinstance(found, DRL2)
    found.potential.copy_(torch.tensor([[2.0, 3.0, 4.0, 0.0]]))
    steps = batch((WAITS, RIGHT), (HALF, LEFT), (HALF, NOTHING), (HALF, NEVER))
    expected = [
        BETWEEN * 3 - 2 + BETWEEN * 5,
        1 + GAMMA * 4 - 3 + GAMMA * 5,
        BETWEEN * 3 - 3 + BETWEEN * 5,
        -3,
    ]
    assert targets(found, steps) == pytest.approx(expected)


def test_states_that_read_alike_have_one_potential_whichever_steps_were_counted() -> None:
    """They share a row of the table: what differed would be paid once more for each round."""
    found = method("drl2", accepting_target="segment")
    assert isinstance(found, DRL2)
    for state, arrived, times in ((WAITS, HALF, 9), (WAITS, WAITS, 70), (ACCEPTS, SINK, 20)):
        steps = np.full((1, times), state)
        found.see(np.zeros((1, times, 1), np.float32), steps, np.full((1, times), arrived))
    found.learn(found.draw())
    assert found.potential[0, ACCEPTS] == found.potential[0, WAITS]
    assert found.potential[0, WAITS] < found.potential[0, HALF]


# CyclER


def test_the_cycle_of_a_ring_begins_where_acceptance_reads_as() -> None:
    assert accepting_cycles(WALK, np.array([0, 1, 0, 3])) == [((0, 1), (1, 2))]
    apart = [((0, 1), (1, 2)), ((2, 1), (1, 2)), ((2, 0), (0, 1), (1, 2))]
    assert accepting_cycles(WALK, np.arange(4)) == apart


def test_parallel_edges_of_a_disjunction_are_one_cycle() -> None:
    """Trap 31: a guard like `y | r` is many letters and one edge."""
    either = automaton(["y", "r"], 2, lambda b, true: int(bool(true)), {1})
    assert accepting_cycles(walk_tables(either), np.zeros(2, int)) == [((0, 1),)]
    assert (WALK.options[WAITS] == HALF).sum() == 2  # `right`, with and without `left`


def test_the_cycle_that_pays_most_is_kept_with_what_was_taken_of_it() -> None:
    """Two of the first cycle's four edges are less than one of the second's one."""
    places = np.array([[0, -1, 1, 1], [-1, 0, -1, 0]])
    best, taken = best_cycle(places, np.array([4, 1]))
    assert (best, taken.tolist()) == (1, [0, 0, 1, 1])
    best, taken = best_cycle(places, np.array([2, 2]))
    assert (best, taken.tolist()) == (0, [0, 1, 1, 3])


def test_each_edge_pays_once_between_two_visits() -> None:
    found = method("cycler")
    assert isinstance(found, CyclER)
    state = np.array([WAITS, WAITS, HALF, HALF, ACCEPTS, HALF])
    arrived = np.array([WAITS, HALF, HALF, ACCEPTS, HALF, HALF])
    kept = found.judge(Episode(np.zeros((6, 1), np.float32), state, arrived))
    letters = (NOTHING, RIGHT, NOTHING, LEFT, RIGHT, NOTHING)
    steps = batch(*zip(state.tolist(), letters, strict=True), kept=kept)
    options = torch.from_numpy(WALK.options)[steps.state, steps.letter]
    assert found.extra(steps, options)[0, :, 0].tolist() == [0, 0.5, 0, 0.5, 0.5, 0]
    assert targets(found, steps)[3] == pytest.approx(0.5 + GAMMA * 5)


def test_a_counterfactual_step_pays_by_its_own_edge() -> None:
    found = method("cycler")
    assert isinstance(found, CyclER)
    steps = batch((WAITS, LEFT), (WAITS, LEFT), kept=[[0, 0], [0, 0b10]])
    read = read_from(steps, WAITS, HALF)
    options = torch.from_numpy(WALK.options)[read.state, read.letter]
    assert found.extra(read, options)[0, :, 0].tolist() == [0, 0.5, 0, 0]  # 1 → 2 was taken


# GAIL


def test_gail_pays_what_was_shown_more_than_what_was_not() -> None:
    found = method("gail", shown=[1, 1, 1, 2])
    assert isinstance(found, GAIL)
    zero = np.zeros((1, 2), np.int64)
    found.see(np.array([[[0], [1]]], np.float32), zero, zero)
    found.learn(found.draw())
    ratio = (3 + 0.5) / (1 * 4 / 2 + 0.5)
    seen = torch.tensor([[[1.0], [2.0], [0.0], [7.0]]])
    paid = found.reward(seen, torch.tensor([[0, 1, 2, 3]]))[0].tolist()
    assert paid[0] == pytest.approx(np.tanh(np.log(ratio)))
    assert paid[1] > 0 > paid[2]
    assert paid[3] == 0


def test_gail_learns_to_tell_states_apart() -> None:
    rng = np.random.default_rng(0)
    found = method(
        "gail", shown=rng.normal(2, 0.1, 50), finite=False, discriminator_rate=0.02, seeds=2
    )
    assert isinstance(found, GAIL)
    zero = np.zeros((2, 50), np.int64)
    found.see(rng.normal(-2, 0.1, (2, 50, 1)).astype(np.float32), zero, zero)
    for _ in range(200):
        losses = found.learn(found.draw())
    assert losses["discriminator"].shape == (2,)
    seen = torch.tensor([[[2.0], [-2.0]]]).expand(2, -1, -1)
    paid = found.reward(seen, torch.zeros(2, 2, dtype=torch.long))
    assert (paid[:, 0] > 0.9).all()
    assert (paid[:, 1] < -0.9).all()


# PWIL


def test_a_coupling_by_hand() -> None:
    """Masses of a quarter move to two atoms of a half: the third one has to go far."""
    states, atoms = np.zeros((3, 1)), np.array([[0.0], [2.0]])
    assert coupling_costs(states, atoms, 4).tolist() == [0, 0, 0.5]
    assert coupling_costs(np.array([[0.5]]), atoms, 1).tolist() == [0.5 * 0.5 + 0.5 * 1.5]
    assert coupling_costs(np.zeros((0, 1)), atoms, 4).tolist() == []


def test_no_more_is_moved_than_there_is_room_for() -> None:
    rng = np.random.default_rng(0)
    states, atoms = rng.normal(size=(20, 3)), rng.normal(size=(7, 3))
    greedy = coupling_costs(states, atoms, 20).sum()
    assert greedy >= _least_cost(states, atoms) - 1e-9


def _least_cost(states: Any, atoms: Any) -> float:
    """The optimal coupling, by linear programming."""
    from scipy.optimize import linprog

    m, n = len(states), len(atoms)
    cost = np.linalg.norm(states[:, None] - atoms, axis=-1).ravel()
    rows = np.kron(np.eye(m), np.ones(n))
    columns = np.kron(np.ones(m), np.eye(n))
    mass = np.concatenate([np.full(m, 1 / m), np.full(n, 1 / n)])
    found = linprog(cost, A_eq=np.concatenate([rows, columns]), b_eq=mass)
    assert found.success
    return float(found.fun)


def test_doing_exactly_what_was_shown_pays_most() -> None:
    found = method("pwil", shown=[0, 1, 2, 3])
    assert isinstance(found, PWIL)
    three = np.zeros(4, np.int64)

    def paid(*cells: float) -> list[float]:
        after = np.array(cells, np.float32)[:, None]
        return found.judge(Episode(after, three, three))[:, 0].tolist()

    assert paid(0, 1, 2, 3) == pytest.approx([5, 5, 5, 5])
    spread = np.std([0, 1, 2, 3])
    expected = 5 * np.exp(-5 * 4 / np.sqrt(1) * 0.25 * 1 / spread)  # room is left one cell away
    assert paid(0, 0, 2, 3) == pytest.approx([5, expected, 5, 5], abs=1e-3)


def test_what_pwil_paid_is_never_computed_again() -> None:
    """Trap 17: it depends on the episode, so it stands beside the step."""
    found = method("pwil", shown=[0, 1, 2, 3])
    step = batch((WAITS, NOTHING), kept=[[2.5]])
    assert targets(found, step) == pytest.approx([2.5 + GAMMA * 5])


# SQIL


def test_sqil_pays_for_what_was_shown() -> None:
    found = method("sqil", shown=[0, 1])
    assert targets(found, batch((WAITS, NOTHING), shown=True)) == pytest.approx([1 + GAMMA * 5])
    assert targets(found, batch((WAITS, NOTHING), kept=[[]])) == pytest.approx([GAMMA * 5])


def test_to_imitators_a_sink_is_a_state_like_others() -> None:
    for name in ("gail", "pwil", "sqil"):
        found = method(name, shown=[0, 1])
        assert targets(found, batch((HALF, NEVER), kept=[[0.0]])) == pytest.approx([GAMMA * 5])


EVERYONE = torch.tensor([True])


def test_a_table_learns_demonstrated_steps_once_it_knows_their_actions() -> None:
    """The way to the right was shown; who has never gone right cannot tell what was done."""
    made = line(RING, algorithm="sqil")
    agent = make_loop(made, demos([0, 1, 2, 3, 4]), labels_of(RING)).agent
    assert isinstance(agent, TabularAgent)
    assert agent.shown is not None
    assert not agent.shown.known(EVERYONE).valid.any()
    one, two = np.array([[[1.0]]], np.float32), np.array([[[2.0]]], np.float32)
    agent.shown.see(one, np.array([[2]]), two)
    assert not agent.shown.known(~EVERYONE).valid.any()  # whose episode has not ended
    known = agent.shown.known(EVERYONE)
    (at,) = known.valid[0].nonzero()[:, 0].tolist()
    assert (known.batch.observation[0, at].item(), known.batch.action[0, at].item()) == (1, 2)
    assert known.age[0, at] == 2  # two steps come after it
    assert known.batch.shown.all()


def test_demonstrations_are_learned_again_by_the_seeds_whose_episode_has_ended() -> None:
    """What a seed learns does not depend on how often others' episodes end beside it."""
    made = plan(RING, "TestsLine-v0", actions="recorded", algorithm="sqil", seeds=2)
    shown = DemoSet((Demo(np.arange(3, dtype=np.float32)[:, None], np.array([[2], [2]])),))
    agent = make_loop(made, shown, labels_of(RING)).agent
    assert isinstance(agent, TabularAgent)
    cells, zero = np.full((2, 1, 1), 4, np.float32), np.zeros((2, 1), np.int64)
    agent.record(cells, zero + agent.first_action, cells, zero, zero, zero > 0, zero)
    agent.finish(np.array([[False], [True]]), zero + 1)
    before = agent.q.clone()
    agent.learn(0)
    moved = (agent.q != before).flatten(2).any(-1)
    assert moved.any(1).tolist() == [False, True]
    assert moved[1, :2].all()


def test_recorded_actions_need_not_be_found_out() -> None:
    made = plan(RING, "TestsLine-v0", actions="recorded", algorithm="sqil", seeds=1)
    shown = DemoSet((Demo(np.arange(3, dtype=np.float32)[:, None], np.array([[2], [2]])),))
    agent = make_loop(made, shown, labels_of(RING)).agent
    assert isinstance(agent, TabularAgent)
    assert agent.shown is not None
    known = agent.shown.known(EVERYONE)
    assert known.batch.action.tolist() == [[2, 2]]
    assert known.valid.all()


# held back until judged


def drifting(name: str, until: int, **changes: object) -> SacAgent:
    deadly = ring(["far"], "deadly")
    made = plan(deadly, "TestsDrift-v0", horizon=7, algorithm=name, **changes)
    path = [[0.1 * t, 0.0] for t in range(6)]
    loop = make_loop(made, demos(path, path), beyond(0.3, 0.7))
    for _ in loop.run(until):
        pass
    assert isinstance(loop.agent, SacAgent)
    return loop.agent


@pytest.mark.parametrize("name", ["cycler", "pwil"])
def test_steps_enter_the_replay_in_order_once_all_seeds_have_judged_them(name: str) -> None:
    agent = drifting(name, until=50)
    waiting = len(agent.held.rows)
    assert agent.replay.written + waiting == 50
    assert 0 <= waiting < 2 * 7
    everything = drifting("lcer", until=50, end_on_sink=agent.settings.end_on_sink)
    there, columns = agent.replay.written, everything.layout.width
    mine = agent.replay.rows[:, :there, :columns]
    assert torch.equal(mine, everything.replay.rows[:, :there])  # steps are random until then


def test_what_is_kept_in_the_replay_is_what_was_judged() -> None:
    agent = drifting("pwil", until=50)
    rows = agent.layout.unpack(agent.replay.rows[:, : agent.replay.written])
    method = agent.method
    assert isinstance(method, PWIL)
    whole = slice(0, 7)  # no sink ends an imitator's episode
    zero = np.zeros(7, np.int64)
    for seed in range(2):
        after = rows.next_observation[seed, whole].numpy()
        expected = method.judge(Episode(after, zero, zero))
        assert rows.kept[seed, whole].tolist() == expected.tolist()


# all of them, on tasks that they solve


def visits(made: Plan, shown: DemoSet, labels: Any) -> float:
    """Accepting visits an episode of greedy actions at the end of training."""
    loop = make_loop(made, shown, labels)
    for _ in loop.run(made.train.steps):
        pass
    played = Arena(made, labels, 5).play(loop.agent, range(5))
    return float(played.accepting[:, :, 1:].sum(-1).mean())


@pytest.mark.parametrize("name", ["lcer", "cycler", "drl2"])
def test_who_knows_the_formula_goes_to_and_fro_on_a_table(name: str) -> None:
    """From the left, right and left again: a round of eight steps, five of them in 40."""
    made = plan(
        RING,
        "TestsLine-v0",
        horizon=40,
        kwargs={"size": SIZE, "start": 0},
        algorithm=name,
        steps=3200,
        learning_starts=400,
    )
    assert visits(made, DemoSet(()), labels_of(RING)) == 5


@pytest.mark.parametrize("name", ["gail", "pwil", "sqil"])
def test_who_imitates_goes_where_was_gone_on_a_table(name: str) -> None:
    """Four steps to the right, and sixteen there."""
    made = plan(
        chain(["right"]),
        "TestsLine-v0",
        horizon=20,
        kwargs={"size": SIZE, "start": 0},
        algorithm=name,
        steps=2000,
        learning_starts=200,
        exploration=0.4,
    )
    shown = demos([0, 1, 2, 3, 4, *[4] * 16])
    assert visits(made, shown, cell_is(4)) == 17


@pytest.mark.slow
@pytest.mark.parametrize("name", BASELINES)
def test_each_drifts_to_a_goal_and_stays_there(name: str) -> None:
    made = plan(
        chain(["a"]),
        "TestsDrift-v0",
        horizon=20,
        algorithm=name,
        steps=1500,
        learning_starts=300,
        batch_size=64,
        actor_hidden=(32,),
        critic_hidden=(32,),
    )
    path = [[min(0.2 * t, 1.5), 0.2 * t] for t in range(21)]
    assert visits(made, demos(path, path, path), beyond(1.0)) > 8


def test_every_algorithm_that_settings_name_can_be_made() -> None:
    for name in ALGORITHMS:
        assert method(name, shown=[0, 1]).columns in (0, 1, 2)
