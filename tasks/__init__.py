"""The paper's environments and their scripted experts: plain Gymnasium, nothing of logic.

Importing this package registers the environments. Each has a single form (`gymnasium.make`). Those
that are arrays [n, …] have a batched one, too (`gymnasium.make_vec`), which never resets itself and
of which the single one is a view; those on MuJoCo import it when one is made. None pays rewards or
ends episodes: how long an episode is and what is to be done in it, the task file says.
"""

import gymnasium

from tiloilc.tasks.experts import Expert, Progress, experts_of
from tiloilc.tasks.finite import FiniteModel, finite_model
from tiloilc.tasks.known import Known, known_best
from tiloilc.tasks.markov import MarkovModel, markov_model
from tiloilc.tasks.scene import Circle, Rectangle, Ring, Scene

__all__ = [
    "IDS",
    "Circle",
    "Expert",
    "FiniteModel",
    "Known",
    "MarkovModel",
    "Progress",
    "Rectangle",
    "Ring",
    "Scene",
    "experts_of",
    "finite_model",
    "known_best",
    "markov_model",
]

_MODULES = {
    "Carlo": "carlo",
    "CheetahFlip": "robots.cheetah",
    "DoggoAvoid": "robots.doggo",
    "DoggoNavigate": "robots.doggo",
    "FetchAlign": "robots.fetch.align",
    "FetchAvoid": "robots.fetch.avoid",
    "FetchPlaceButton": "robots.fetch.button",
    "FetchPlaceTray": "robots.fetch.tray",
    "FlatWorld": "flatworld",
    "GridAvoid": "grids",
    "GridCircular": "grids",
    "GridSequential": "grids",
    "SixteenRooms": "rooms",
}

IDS = tuple(f"tiloilc/{name}-v0" for name in _MODULES)
"""The ids of all registered environments."""

for _name, _module in _MODULES.items():
    if f"tiloilc/{_name}-v0" not in gymnasium.registry:
        gymnasium.register(
            id=f"tiloilc/{_name}-v0",
            entry_point=f"tiloilc.tasks.{_module}:{_name}Env",
            vector_entry_point=(
                None
                if _module.startswith("robots.")
                else f"tiloilc.tasks.{_module}:{_name}VectorEnv"
            ),
        )
