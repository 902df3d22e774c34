"""TiLoIL (paper, Algorithm 1): what a transition is worth, for batches of stacked seeds."""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import Tensor

from tiloilc.learn.algorithm.discriminator import make_discriminators, stage_unions
from tiloilc.learn.algorithm.method import Backup, Plain, Setup
from tiloilc.learn.engine.replay import Batch
from tiloilc.learn.engine.ring import Ring
from tiloilc.learn.engine.state import State, under, with_prefix
from tiloilc.plan import Stages
from tiloilc.product import Floats, Int, Walk
from tiloilc.spec.settings import Settings


class TiLoIL(Plain):
    """Lines 13 to 23 of Algorithm 1: stage buffers, their discriminators, Eq. 8 and Eq. 4."""

    def __init__(self, setup: Setup) -> None:
        super().__init__(setup)
        s = setup.settings
        self.table = StageTable.of(setup.stages, setup.walk, s).to(setup.generator.device)
        unions = stage_unions(setup.stages, s.stages)
        self.discriminators = make_discriminators(setup, unions, setup.demonstrations)
        self.judges = (s.beta > 0 or not s.stages) and self.discriminators.stages > 0

    def see(self, after: Floats, state: Int, arrived: Int) -> None:
        """Normalise by all states so far."""
        self.discriminators.see(after)

    def segment(self, seed: int, buffer: int, observations: Floats) -> None:
        """Store a segment in its stage buffer (lines 9 to 14)."""
        self.discriminators.add(seed, buffer, observations)

    def draw(self) -> State:
        """Which states the discriminators compare."""
        return self.discriminators.draw() if self.judges else {}

    def learn(self, chance: State) -> dict[str, Tensor]:
        """A step of all discriminators (lines 15 to 19)."""
        return self.discriminators.learn(chance) if self.judges else {}

    def backup(self, batch: Batch, options: Tensor) -> Backup:
        """Eq. 4 with the rewards of today's discriminators."""
        reward = self.reward(batch.observation, batch.state)
        wait = self._wait(batch.next_observation, options)
        return tiloil_backup(self.table, batch, options, reward, self.settings, wait)

    def least(self, batch: Batch, options: Tensor) -> Backup:
        """Eq. 4 with the least reward that any discriminators could give."""
        never = torch.tensor(-1.0)
        reward = stage_reward(self.table, batch.state, never, self.settings)
        wait = None
        if self.walk.costly:
            wait = stage_reward(self.table, options[..., 0], never, self.settings)
        return tiloil_backup(self.table, batch, options, reward, self.settings, wait)

    def worth(self, observation: Tensor, options: Tensor) -> Backup:
        """The same values as in Eq. 4."""
        wait = self._wait(observation, options)
        return option_values(self.table, options, self.settings, wait)

    def reward(self, observation: Tensor, state: Tensor) -> Tensor:
        """Eq. 8 of (s, b) with today's discriminators, [seed, n]."""
        bonus = torch.zeros((), device=observation.device)
        if self.judges:
            bonus = self.discriminators.bonus(observation, self.table.code[state])
        return stage_reward(self.table, state, bonus, self.settings)

    def _wait(self, observation: Tensor, options: Tensor) -> Tensor | None:
        """What is paid for a jump that takes a step; None where jumps do not."""
        return self.reward(observation, options[..., 0]) if self.walk.costly else None

    def policy(self) -> State:
        """The discriminators, where they pay for jumps that take a step."""
        return self.discriminators.policy() if self.walk.costly and self.judges else {}

    def load_policy(self, state: State) -> None:
        """Take what `policy` gave."""
        if state:
            self.discriminators.load_policy(state)

    def rings(self) -> dict[str, Ring]:
        """The stage buffers' states."""
        return self.discriminators.rings()

    def state(self) -> State:
        """The discriminators, and how full the buffers are."""
        return with_prefix("discriminators", self.discriminators.state())

    def load(self, state: State) -> None:
        """Take what `state` gave."""
        self.discriminators.load(under("discriminators", state))


@dataclass(frozen=True)
class StageTable:
    """What the targets need to know of each automaton state, as tensors [states].

    `code[b]` is the state that stands for b in the networks' input, see `input_states`.
    """

    index: Tensor
    length: Tensor
    accepting: Tensor
    sink: Tensor
    code: Tensor

    @classmethod
    def of(cls, stages: Stages, walk: Walk, settings: Settings) -> StageTable:
        """The table of one plan."""
        sink = torch.zeros(walk.states, dtype=torch.bool)
        if walk.sink >= 0:
            sink[walk.sink] = True
        return cls(
            torch.tensor(stages.index, dtype=torch.float32),
            torch.tensor(stages.length, dtype=torch.float32).clamp(min=1),
            torch.from_numpy(walk.accepting),
            sink,
            input_states(walk, settings),
        )

    def to(self, device: torch.device) -> StageTable:
        """The same on a device."""
        return StageTable(
            self.index.to(device),
            self.length.to(device),
            self.accepting.to(device),
            self.sink.to(device),
            self.code.to(device),
        )


def input_states(walk: Walk, settings: Settings) -> Tensor:
    """The state that stands for each automaton state b in the networks' input, [states].

    That is b itself, or, with `accepting_target: segment`, the state that reads every letter as the
    accepting state b does, since the next segment begins there.
    """
    states = list(range(walk.states))
    if settings.segment and settings.accepting_target == "segment":
        states = [_reads_as(walk, b) for b in states]
    return torch.tensor(states)


def _reads_as(walk: Walk, state: int) -> int:
    """The first non-accepting state with the same options as accepting `state`, or itself."""
    if not walk.accepting[state]:
        return state
    alike = (walk.options == walk.options[state]).all(axis=(1, 2)) & ~walk.accepting
    return int(alike.argmax()) if alike.any() else state


def stage_reward(table: StageTable, state: Tensor, bonus: Tensor, settings: Settings) -> Tensor:
    """Eq. 8 of the current (s, b), `bonus` being tanh f_b(s); all [seed, n].

    A sink pays its own reward: its stage index would be higher than what it deserves.
    """
    state = table.code[state]
    if settings.stages:
        reward = (table.index[state] + settings.beta * bonus) / table.length[state]
    else:
        reward = bonus
    return torch.where(table.sink[state], settings.sink_reward, reward)


def option_values(
    table: StageTable, options: Tensor, settings: Settings, wait: Tensor | None = None
) -> Backup:
    """What each option [seed, n, K] is worth, given V(s', b').

    Entering acceptance and sinks has exact values (`exact_entry`): rows of acceptance are rare,
    their Q is untrained for long. `wait` [seed, n] is R((s', b')) of the first option where jumps
    take a step: a jump is an action whose whole effect is known, so its Q needs no network. It is
    paid that reward now, and the state that it leads to comes a step later (definition 2.3). It has
    read no letter, so acceptance by a jump alone has no exact value: it must prove its worth.
    """
    pay = torch.zeros(options.shape, device=options.device)
    discount = torch.ones_like(pay)
    if settings.exact_entry:
        most = 1 / (1 - settings.gamma)
        accepted = table.accepting[options] & settings.segment
        lost = table.sink[options]
        pay = pay.masked_fill(accepted, most).masked_fill(lost, settings.sink_reward * most)
        discount = discount.masked_fill(accepted | lost, 0.0)
    if wait is None:
        return Backup(pay, discount)
    jumps = options != options[..., :1]
    return Backup(
        torch.where(jumps, wait[..., None], pay), discount.masked_fill(jumps, settings.gamma)
    )


def tiloil_backup(
    table: StageTable,
    batch: Batch,
    options: Tensor,
    reward: Tensor,
    settings: Settings,
    wait: Tensor | None = None,
) -> Backup:
    """Eq. 4 with the best of the options [seed, n, K] as next state.

    `batch.state` is b *before* the step: acceptance of b, not of b', counts. `reward` [seed, n] is
    R((s, b)), `wait` is as in `option_values`. An environment that has ended (`terminal`) stays
    where it is: accepted for ever, or never again.
    """
    gamma, state = settings.gamma, batch.state
    most = 1 / (1 - gamma)
    lost = settings.sink_reward * most
    arrived = options if wait is None else options[..., :1]  # to jump is a matter of the next step
    ended, accepted = batch.terminal[..., None], table.accepting[arrived]
    over, done = ended & ~accepted, ended & accepted
    value = option_values(table, options, settings, wait)
    value = Backup(
        value.pay.masked_fill(over, lost).masked_fill(done, most),
        value.discount.masked_fill(ended, 0.0),
    )
    pay, discount = reward[..., None] + gamma * value.pay, gamma * value.discount
    accepts = table.accepting[state][..., None]
    if not settings.segment:
        return Backup(pay, discount)
    if settings.accepting_target == "constant":
        return Backup(pay.masked_fill(accepts, most), discount.masked_fill(accepts, 0.0))
    stays = accepts & (table.code[state] == state)[..., None]
    kept = (table.accepting[options] & ~ended).float()  # V says what it is worth
    after = torch.full_like(kept, most).masked_fill(table.sink[options] | over, lost)
    after = after.masked_fill(kept > 0, 0.0)
    if wait is not None:
        after = after.masked_fill(options != options[..., :1], -torch.inf)
    return Backup(
        torch.where(stays, 1 + gamma * after, pay), torch.where(stays, gamma * kept, discount)
    )
