"""What transitions are worth: TiLoIL, and others, behind one protocol."""

from tiloilc.learn.algorithm.arrivals import Arrivals
from tiloilc.learn.algorithm.method import Backup, Episode, Method, Plain, Setup

__all__ = ["Arrivals", "Backup", "Episode", "Method", "Plain", "Setup"]
