"""The product of environment and automaton, many copies at once: labels, steps, segments."""

from tiloilc.product.environment import Copies, Floats, bounds, is_finite, single
from tiloilc.product.product import Product
from tiloilc.product.segments import Segment, Segmenter
from tiloilc.product.walk import Int, Walk, walk_tables

__all__ = [
    "Copies",
    "Floats",
    "Int",
    "Product",
    "Segment",
    "Segmenter",
    "Walk",
    "bounds",
    "is_finite",
    "single",
    "walk_tables",
]
