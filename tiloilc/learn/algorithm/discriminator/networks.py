"""Stage buffers and the discriminators they feed (paper, section 3.2; Algorithm 1, lines 15-19)."""

from __future__ import annotations

import torch
from torch import Tensor
from torch.nn.functional import softplus

from tiloilc.learn.algorithm.discriminator.unions import Unions
from tiloilc.learn.engine.networks import Adam, StackedMLP, Tape
from tiloilc.learn.engine.ring import Ring
from tiloilc.learn.engine.state import State, under, with_prefix
from tiloilc.product import Floats
from tiloilc.spec.settings import Settings


class StageBuffers:
    """Rings of states, one for each seed and stage: [seed, buffer, capacity, d]."""

    def __init__(
        self,
        seeds: int,
        buffers: int,
        capacity: int,
        d: int,
        device: torch.device | str = "cpu",
    ) -> None:
        self.states = torch.zeros(seeds, buffers, capacity, d, device=device)
        self.written = torch.zeros(seeds, buffers, dtype=torch.long)

    @property
    def counts(self) -> Tensor:
        """States held, [seed, buffer]."""
        held = self.written.clamp(max=self.states.shape[2])
        return held.to(self.states.device, non_blocking=True)

    def add(self, seed: int, buffer: int, observations: Floats) -> None:
        """Store states [m, d], over the oldest ones when full."""
        capacity = self.states.shape[2]
        kept = observations[-capacity:]
        start = int(self.written[seed, buffer]) % capacity
        first = min(len(kept), capacity - start)
        ring, new = self.states[seed, buffer], torch.from_numpy(kept)
        ring[start : start + first] = new[:first]
        ring[: len(kept) - first] = new[first:]
        self.written[seed, buffer] += len(kept)

    def sample(self, unions: Tensor, uniform: Tensor) -> Tensor:
        """From unions of buffers, `unions` [union, buffer] of 0 and 1: states [seed, union, n, d].

        `uniform` [seed, union, n] are random numbers in [0, 1), one for each state. An empty union
        yields arbitrary states; see `available`.
        """
        seeds, buffers, capacity, d = self.states.shape
        counts = self.counts[:, None] * unions
        ends = counts.cumsum(-1)
        total = ends[..., -1:]
        drawn = (uniform * total).long().minimum((total - 1).clamp(min=0))
        buffer = torch.searchsorted(ends, drawn, right=True).clamp(max=buffers - 1)
        before = (ends - counts).gather(-1, buffer)
        seed = torch.arange(seeds, device=unions.device)[:, None, None]
        row = (seed * buffers + buffer) * capacity + drawn - before
        return self.states.view(-1, d).index_select(0, row.view(-1)).view(*row.shape, d)

    def ring(self) -> Ring:
        """The states, a ring for each seed and buffer."""
        return Ring(self.states.flatten(0, 1), self.written.flatten())

    def state(self) -> State:
        """Everything but the states."""
        return {"written": self.written}

    def load(self, state: State) -> None:
        """Take what `state` gave."""
        self.written.copy_(state["written"])

    def available(self, unions: Tensor) -> Tensor:
        """Which unions hold any state, [seed, stage]."""
        return (self.counts[:, None] * unions).sum(-1) > 0


class RunningNorm:
    """Mean and variance of all states seen so far, for each seed; [seed, 1, d]."""

    def __init__(self, seeds: int, d: int, device: torch.device | str = "cpu") -> None:
        self.mean = torch.zeros(seeds, 1, d, dtype=torch.float64, device=device)
        self.square = torch.ones(seeds, 1, d, dtype=torch.float64, device=device)
        self.count = torch.zeros(1, dtype=torch.float64, device=device)

    def update(self, x: Tensor) -> None:
        """Take in states [seed, n, d]."""
        x = x.double()
        self.count += x.shape[1]
        share = x.shape[1] / self.count
        self.mean.lerp_(x.mean(1, keepdim=True), share)
        self.square.lerp_(x.square().mean(1, keepdim=True), share)

    def __call__(self, x: Tensor) -> Tensor:
        """States [seed, n, d] with zero mean and unit variance."""
        deviation = (self.square - self.mean.square()).clamp(min=1e-6).sqrt()
        return (x - self.mean.to(x.dtype)) / deviation.to(x.dtype)


class Discriminators:
    """f_b for every stage b: separate networks, or one that is told the stage (appendix F.2).

    `unions` names the buffers that feed each. Until a stage has been trained its f is 0.
    """

    def __init__(
        self,
        unions: Unions,
        buffers: StageBuffers,
        demonstrations: Tensor,
        settings: Settings,
        generator: torch.Generator,
    ) -> None:
        device = generator.device
        seeds, _, _, d = buffers.states.shape
        self.settings, self.generator, self.buffers = settings, generator, buffers
        self.unions = torch.cat([unions.positive, unions.negative]).to(device)
        self.stages = unions.stages
        self.slot = unions.slot.to(device)
        self.shared = settings.discriminator == "shared"
        inputs = d + self.stages if self.shared else d
        stack = seeds if self.shared else seeds * self.stages
        sizes = [inputs, *settings.discriminator_hidden, 1]
        self.nets = StackedMLP(stack, sizes, generator)
        self.adam = Adam(self.nets.parameters, settings.discriminator_rate)
        self.norm = RunningNorm(seeds, d, device)
        self.demonstrations = demonstrations
        self.trained = torch.zeros(seeds, self.stages, dtype=torch.bool, device=device)

    def see(self, after: Floats) -> None:
        """Normalise by all states so far; these are [seed, copy, d]."""
        self.norm.update(torch.from_numpy(after).to(self.norm.mean.device))

    def add(self, seed: int, buffer: int, observations: Floats) -> None:
        """Store a segment's states [m, d]."""
        self.buffers.add(seed, buffer, observations)

    def learn(self, chance: State) -> dict[str, Tensor]:
        """One update; its loss for each seed."""
        return {"discriminator": self.update(chance)}

    def logits(self, x: Tensor) -> Tensor:
        """f_b(s) of every stage b for normalised states [seed, stage, n, d]: [seed, stage, n]."""
        return self._forward(x)[0]

    def _forward(self, x: Tensor) -> tuple[Tensor, Tape]:
        seeds, stages, n, _ = x.shape
        if self.shared:
            told = torch.eye(stages, device=x.device)[None, :, None]
            x = torch.cat([x, told.expand(seeds, stages, n, stages)], dim=-1)
        out, tape = self.nets.forward(x.reshape(self.nets.stack, -1, self.nets.sizes[0]))
        return out.view(seeds, stages, n), tape

    def bonus(self, observation: Tensor, state: Tensor) -> Tensor:
        """tanh f_b(s) for s [seed, n, d] and b [seed, n]; 0 where b has no trained f."""
        every = self.norm(observation)[:, None].expand(-1, self.stages, -1, -1)
        values = torch.tanh(self.logits(every)) * self.trained[:, :, None]
        values = torch.cat([values, torch.zeros_like(observation[:, None, :, 0])], dim=1)
        return values.gather(1, self.slot[state][:, None]).squeeze(1)

    def draw(self) -> State:
        """What the next update needs of chance.

        `uniform` [seed, 2 · stage, n] for states of buffers, `shown` [seed, stage, n] for those of
        demonstrations, if there are any.
        """
        seeds, n = len(self.trained), self.settings.discriminator_batch
        random = self.generator
        uniform = torch.rand((seeds, 2 * self.stages, n), generator=random, device=random.device)
        if len(self.demonstrations) == 0:
            return {"uniform": uniform}
        shape = (seeds, self.stages, n)
        count = len(self.demonstrations)
        shown = torch.randint(count, shape, generator=random, device=random.device)
        return {"uniform": uniform, "shown": shown}

    def update(self, draws: State | None = None) -> Tensor:
        """One step of binary cross-entropy on every stage; the loss of each seed."""
        states, ready = self._batch(draws or self.draw())
        seeds, _, n, d = states.shape
        logits, tape = self._forward(self.norm(states.view(seeds, -1, d)).view(states.shape))
        wanted = (torch.arange(n, device=states.device) < n // 2).float()
        to_logits = (torch.sigmoid(logits) - wanted) * (ready[:, :, None] / n)
        self.adam.step(self.nets.backward(tape, to_logits.view(self.nets.stack, -1, 1)))
        self.trained |= ready
        entropy = softplus(logits) - wanted * logits
        return (entropy.mean(2) * ready).sum(1)

    def _batch(self, draws: State) -> tuple[Tensor, Tensor]:
        """As many positive as negative states, in this order: [seed, stage, 2n, d]; and which
        stages have both [seed, stage].

        `demo_fraction` of the positive ones are of demonstrations; all, while there are no others.
        """
        held = self.buffers.available(self.unions).unflatten(1, (2, self.stages))
        drawn = self.buffers.sample(self.unions, draws["uniform"]).unflatten(1, (2, self.stages))
        positive, ready = drawn[:, 0], held.all(1)
        if "shown" in draws:
            shown = self.demonstrations[draws["shown"]]
            n = shown.shape[2]
            few = torch.arange(n, device=shown.device) < round(n * self.settings.demo_fraction)
            positive = torch.where((few | ~held[:, 0, :, None])[..., None], shown, positive)
            ready = held[:, 1]
        return torch.cat([positive, drawn[:, 1]], dim=2), ready

    def policy(self) -> State:
        """What f needs; the first axis of each tensor is a multiple of the seeds."""
        return {
            **self.nets.state("nets"),
            "norm.mean": self.norm.mean,
            "norm.square": self.norm.square,
            "trained": self.trained,
        }

    def load_policy(self, state: State) -> None:
        """Take what `policy` gave."""
        self.nets.load(state, "nets")
        self.norm.mean.copy_(state["norm.mean"])
        self.norm.square.copy_(state["norm.square"])
        self.trained.copy_(state["trained"])

    def rings(self) -> dict[str, Ring]:
        """The stage buffers' states."""
        return {"stages": self.buffers.ring()}

    def state(self) -> State:
        """Everything but the stage buffers' states."""
        count = {"norm.count": self.norm.count}
        filled = with_prefix("stages", self.buffers.state())
        return {**self.policy(), **self.adam.state("adam"), **count, **filled}

    def load(self, state: State) -> None:
        """Take what `state` gave."""
        self.load_policy(state)
        self.adam.load(state, "adam")
        self.norm.count.copy_(state["norm.count"])
        self.buffers.load(under("stages", state))
