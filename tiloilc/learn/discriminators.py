"""Stage buffers and the discriminators they feed (paper, section 3.2; Algorithm 1, lines 15-19)."""

from __future__ import annotations

import torch
from torch import Tensor

from tiloilc.learn.networks import StackedMLP, adam
from tiloilc.learn.state import State, adam_state, load_adam
from tiloilc.learn.unions import stage_unions
from tiloilc.plan import Stages
from tiloilc.product import Floats
from tiloilc.spec.settings import Settings


class StageBuffers:
    """Rings of states, one for each seed and stage: [seed, buffer, capacity, d]."""

    def __init__(self, seeds: int, buffers: int, capacity: int, d: int) -> None:
        self.states = torch.zeros(seeds, buffers, capacity, d)
        self._view = self.states.numpy()
        self.written = torch.zeros(seeds, buffers, dtype=torch.long)

    @property
    def counts(self) -> Tensor:
        """States held, [seed, buffer]."""
        return self.written.clamp(max=self.states.shape[2])

    def add(self, seed: int, buffer: int, observations: Floats) -> None:
        """Store states [m, d], over the oldest ones when full."""
        capacity = self.states.shape[2]
        kept = observations[-capacity:]
        start = int(self.written[seed, buffer]) % capacity
        first = min(len(kept), capacity - start)
        self._view[seed, buffer, start : start + first] = kept[:first]
        self._view[seed, buffer, : len(kept) - first] = kept[first:]
        self.written[seed, buffer] += len(kept)

    def sample(self, unions: Tensor, count: int, generator: torch.Generator) -> Tensor:
        """Uniformly from unions of buffers: `unions` [stage, buffer] to [seed, stage, count, d].

        An empty union yields arbitrary states; see `available`.
        """
        seeds, buffers, capacity, d = self.states.shape
        ends = (self.counts[:, None] * unions).cumsum(-1)
        total = ends[..., -1:]
        drawn = (torch.rand(*total.shape[:2], count, generator=generator) * total).long()
        drawn = drawn.minimum((total - 1).clamp(min=0))
        buffer = torch.searchsorted(ends, drawn, right=True).clamp(max=buffers - 1)
        before = (ends - self.counts[:, None] * unions).gather(-1, buffer)
        row = (torch.arange(seeds)[:, None, None] * buffers + buffer) * capacity + drawn - before
        return self.states.view(-1, d).index_select(0, row.view(-1)).view(*row.shape, d)

    def state(self) -> State:
        """The rings as far as they are filled."""
        filled = int(self.counts.max())
        return {"states": self.states[:, :, :filled], "written": self.written}

    def load(self, state: State) -> None:
        """Take what `state` gave."""
        self.states[:, :, : state["states"].shape[2]] = state["states"]
        self.written.copy_(state["written"])

    def available(self, unions: Tensor) -> Tensor:
        """Which unions hold any state, [seed, stage]."""
        return (self.counts[:, None] * unions).sum(-1) > 0


class RunningNorm:
    """Mean and variance of all states seen so far, for each seed; [seed, 1, d]."""

    def __init__(self, seeds: int, d: int) -> None:
        self.mean = torch.zeros(seeds, 1, d, dtype=torch.float64)
        self.square = torch.ones(seeds, 1, d, dtype=torch.float64)
        self.count = torch.zeros(1, dtype=torch.float64)

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
        return (x - self.mean.float()) / deviation.float()


class Discriminators:
    """f_b for every stage b: separate networks, or one that is told the stage (appendix F.2).

    A union matrix [stage, buffer] names each stage's positive and negative buffers; a stage with an
    empty row has no discriminator. Until a stage has been trained its f is 0.
    """

    def __init__(
        self,
        stages: Stages,
        buffers: StageBuffers,
        demonstrations: Tensor,
        settings: Settings,
        generator: torch.Generator,
    ) -> None:
        seeds, _, _, d = buffers.states.shape
        self.settings, self.generator, self.buffers = settings, generator, buffers
        self.positive, self.negative = stage_unions(stages, settings.stages)
        self.stages = len(self.positive)
        self.shared = settings.discriminator == "shared"
        inputs = d + self.stages if self.shared else d
        stack = seeds if self.shared else seeds * self.stages
        sizes = [inputs, *settings.discriminator_hidden, 1]
        self.nets = StackedMLP(stack, sizes, generator)
        self.adam = adam(self.nets.parameters, settings.discriminator_rate)
        self.norm = RunningNorm(seeds, d)
        self.demonstrations = demonstrations
        self.trained = torch.zeros(seeds, self.stages, dtype=torch.bool)

    def logits(self, x: Tensor) -> Tensor:
        """f_b(s) of every stage b for states [seed, stage, n, d]: [seed, stage, n]."""
        seeds, stages, n, d = x.shape
        x = self.norm(x.view(seeds, -1, d)).view(seeds, stages, n, d)
        if self.shared:
            told = torch.eye(stages)[None, :, None].expand(seeds, stages, n, stages)
            x = torch.cat([x, told], dim=-1).view(seeds, stages * n, -1)
        else:
            x = x.view(seeds * stages, n, d)
        return self.nets(x).view(seeds, stages, n)

    @torch.no_grad()
    def bonus(self, observation: Tensor, state: Tensor) -> Tensor:
        """tanh f_b(s) for s [seed, n, d] and b [seed, n]; 0 where b has no trained f."""
        every = observation[:, None].expand(-1, self.stages, -1, -1).contiguous()
        stage = state if self.settings.stages else torch.zeros_like(state)
        values = torch.tanh(self.logits(every)) * self.trained[:, :, None]
        return values.gather(1, stage[:, None]).squeeze(1)

    def update(self) -> Tensor:
        """One step of binary cross-entropy on every stage; the loss of each seed."""
        n = self.settings.discriminator_batch
        positive = self._positive(n)
        negative = self.buffers.sample(self.negative, n, self.generator)
        ready = self.buffers.available(self.negative) & self._has_positive()
        logits = self.logits(torch.cat([positive, negative], dim=2))
        wanted = torch.cat([torch.ones(n), torch.zeros(n)]).expand_as(logits)
        entropy = torch.nn.functional.binary_cross_entropy_with_logits(
            logits, wanted, reduction="none"
        )
        loss = (entropy.mean(2) * ready).sum(1)
        self.adam.zero_grad()
        loss.sum().backward()
        self.adam.step()
        self.trained |= ready
        return loss.detach()

    def state(self) -> State:
        """Everything but the stage buffers."""
        return {
            **self.nets.state("nets"),
            **adam_state(self.adam, "adam"),
            "norm.mean": self.norm.mean,
            "norm.square": self.norm.square,
            "norm.count": self.norm.count,
            "trained": self.trained,
        }

    def load(self, state: State) -> None:
        """Take what `state` gave."""
        self.nets.load(state, "nets")
        load_adam(self.adam, state, "adam")
        self.norm.mean.copy_(state["norm.mean"])
        self.norm.square.copy_(state["norm.square"])
        self.norm.count.copy_(state["norm.count"])
        self.trained.copy_(state["trained"])

    def _has_positive(self) -> Tensor:
        own = self.buffers.available(self.positive)
        wanted = self.positive.any(1)
        return wanted if len(self.demonstrations) else own & wanted

    def _positive(self, n: int) -> Tensor:
        """Positive states, `demo_fraction` of them (all, without own ones) from demonstrations."""
        own = self.buffers.sample(self.positive, n, self.generator)
        if len(self.demonstrations) == 0:
            return own
        seeds, stages, _, d = own.shape
        drawn = torch.randint(
            len(self.demonstrations), (seeds * stages * n,), generator=self.generator
        )
        shown = self.demonstrations.index_select(0, drawn).view(seeds, stages, n, d)
        few = round(n * self.settings.demo_fraction)
        from_demo = torch.arange(n) < few
        from_demo = from_demo | ~self.buffers.available(self.positive)[..., None]
        return torch.where(from_demo[..., None], shown, own)
