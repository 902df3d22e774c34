"""Carlo: a car on a ring road (paper, appendix H.1.2)."""

from tiloilc.tasks.carlo.driver import CarelessDriver, Driver
from tiloilc.tasks.carlo.world import CarloEnv, CarloVectorEnv

__all__ = ["CarelessDriver", "CarloEnv", "CarloVectorEnv", "Driver"]
