"""Updates of SAC and of TiLoIL, one seed, with the networks and the batch of the paper's table 5.

31 observations, 5 automaton states as one-hot, 4 actions; with K = 4 discriminators or none.
"""

from __future__ import annotations

from tiloilc.bench.contestants.work import Work
from tiloilc.bench.measurement import Measurement
from tiloilc.bench.turns import Contestant, Tell, compare, take_turns

JUDGED = Work(discriminators=True)

OURS = Contestant("tiloilc", "ours", "updates")
OURS_JUDGED = Contestant("tiloilc, four discriminators", "ours", "updates", JUDGED)
RIVALS = {
    Contestant("Stable-Baselines3", "sb3", "updates"): 3.0,
    Contestant("CleanRL's loop", "cleanrl", "updates"): 3.0,
    Contestant("SBX", "sbx", "updates"): 1.3,
    Contestant("the matrix products alone", "floor", "updates"): 0.6,
}
OPERATOR = Contestant("the operator of compiled updates", "floor", "by_operator")
LIBRARIES = [
    Contestant("torch's library", "floor", "by_torch"),
    Contestant("numpy's library", "floor", "by_numpy"),
]
RIVAL_JUDGED = Contestant("Stable-Baselines3 and four discriminators", "sb3", "updates", JUDGED)


def measure(rounds: int, tell: Tell) -> list[Measurement]:
    """The rows of this benchmark."""
    everyone = [OURS, *RIVALS, OURS_JUDGED, RIVAL_JUDGED]
    ours, *rivals, judged, rival_judged = take_turns(everyone, rounds, tell=tell)
    operator, *libraries = take_turns([OPERATOR, *LIBRARIES], rounds, tell=tell)
    name, unit = "updates of SAC, K = {}", "updates/s"
    return [
        *(
            compare(name.format(0), unit, ours, rival, goal)
            for rival, goal in zip(rivals, RIVALS.values(), strict=True)
        ),
        compare(name.format(4), unit, judged, rival_judged, 4.5),
        *(compare("matrix products of an update", unit, operator, other) for other in libraries),
    ]
