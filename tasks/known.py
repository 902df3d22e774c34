"""What is known to be possible in worlds that have no finite model: the best episodes that are."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt


@dataclass(frozen=True, slots=True, eq=False)
class Known:
    """Episodes of one very good controller, made of real actions.

    observations  [m, T+1, d]  what was seen from m starts, equally likely, the first row included
    how           in words, for the reader of a result: who acted, and what nobody could exceed

    What they achieve is a lower bound of what can be. An environment does not know what counts as
    an achievement: that is asked of the observations.
    """

    observations: npt.NDArray[np.generic]
    how: str


def known_best(env: object, horizon: int) -> tuple[Known, ...]:
    """The best episodes of `horizon` steps that an environment publishes, one entry a controller.

    An environment publishes them by a method `known_best(horizon)` on its unwrapped form; empty if
    it has none. Raises TypeError if what it publishes is something else.
    """
    bare = getattr(env, "unwrapped", env)
    publish = getattr(bare, "known_best", None)
    if publish is None:
        return ()
    found = tuple(publish(horizon))
    for known in found:
        if not isinstance(known, Known):
            raise TypeError(f"{bare!r} publishes {type(known).__name__} as a known best")
    return found
