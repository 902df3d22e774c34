"""The discriminators that a backbone wants."""

from __future__ import annotations

from torch import Tensor

from tiloilc.learn.algorithm.discriminator.counts import CountDiscriminators
from tiloilc.learn.algorithm.discriminator.networks import Discriminators, StageBuffers
from tiloilc.learn.algorithm.discriminator.unions import Unions
from tiloilc.learn.algorithm.method import Setup


def make_discriminators(
    setup: Setup, unions: Unions, demonstrations: Tensor
) -> Discriminators | CountDiscriminators:
    """Counts where there are cells, else networks.

    `demonstrations` [k, d] are mixed into every positive batch.
    """
    s = setup.settings
    if setup.cells is not None:
        return CountDiscriminators(unions, setup.cells, demonstrations, s)
    capacity = min(s.stage_buffer_size, setup.capacity)
    shape = (s.seeds, unions.buffers, capacity, setup.dimensions)
    buffers = StageBuffers(*shape, setup.generator.device)
    return Discriminators(unions, buffers, demonstrations, s, setup.generator)
