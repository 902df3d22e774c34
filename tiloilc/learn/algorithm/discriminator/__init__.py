"""What tells one kind of states from another: networks, or counts on finite tasks."""

from tiloilc.learn.algorithm.discriminator.counts import CountDiscriminators
from tiloilc.learn.algorithm.discriminator.make import make_discriminators
from tiloilc.learn.algorithm.discriminator.networks import Discriminators, StageBuffers
from tiloilc.learn.algorithm.discriminator.unions import Unions, shown_and_own, stage_unions

__all__ = [
    "CountDiscriminators",
    "Discriminators",
    "StageBuffers",
    "Unions",
    "make_discriminators",
    "shown_and_own",
    "stage_unions",
]
