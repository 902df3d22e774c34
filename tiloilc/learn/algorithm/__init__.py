"""What transitions are worth: TiLoIL, and others, behind one protocol."""

from tiloilc.learn.algorithm.arrivals import Arrivals
from tiloilc.learn.algorithm.method import Episode, Method, Plain, Setup

__all__ = ["Arrivals", "Episode", "Method", "Plain", "Setup"]
