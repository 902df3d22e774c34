"""Merge states of one component that accept the same words, wherever a trial shows it is safe."""

from __future__ import annotations

from collections.abc import Sequence

from tiloilc.automaton.bdd import Diagrams
from tiloilc.automaton.draft import Draft, components, on_cycles
from tiloilc.automaton.reduction.inclusion import Inclusion
from tiloilc.automaton.reduction.jumps import waiting_states
from tiloilc.automaton.reduction.letters import moves
from tiloilc.automaton.reduction.quotient import redirect

MAX_STATES = 100
"""Deterministic states to try: beyond, trials cost more than they save."""


MAX_TRIALS = 6
"""Trials for each state: those it is most like come first, and later ones hardly ever succeed."""


def merge_by_trial(draft: Draft, diagrams: Diagrams) -> Draft:
    """Lead what enters a deterministic state to another one of its component, if all agree.

    Two states of one language are no reason to merge: a run may go round between them and miss
    the marks. So the merged automaton is compared with the old one, from every state: no common
    run may be marked for ever in one and not in the other.
    """
    component, _ = on_cycles(draft)
    waiting = waiting_states(draft)
    fixed = [q for q in range(len(draft.rows)) if q not in waiting]
    if len(fixed) > MAX_STATES:
        return draft
    step = draft.steps or (None,) * len(draft.rows)
    pairs = [
        (p, q)
        for p in fixed
        for q in fixed
        if p != q and component[p] == component[q] and step[p] == step[q]
    ]
    if not pairs:
        return draft
    inclusion = Inclusion(draft, diagrams, pairs)
    same = [(p, q) for p, q in pairs if inclusion.holds(p, q) and inclusion.holds(q, p)]
    trial = _Trial(draft, diagrams)
    lead = list(range(len(draft.rows)))
    tried = [0] * len(lead)
    for p, q in sorted(same, key=lambda pair: (-_likeness(draft, *pair), pair)):
        if lead[p] == p and lead[q] == q and tried[q] < MAX_TRIALS:
            tried[q] += 1
            led = [p if t == q else t for t in lead]
            if trial.agrees(led):
                lead = led
    if lead == list(range(len(lead))):
        return draft
    return redirect(draft, lead, diagrams)


def _likeness(draft: Draft, p: int, q: int) -> int:
    """How many edges p and q have in common."""
    return len(draft.rows[p].items() & draft.rows[q].items())


Step = tuple[int, int, bool, bool]
"""Where a pair of states leads on some letters: both targets, and whether each edge accepts."""


class _Trial:
    """Compares the deterministic part of a draft with itself after states have been merged."""

    def __init__(self, draft: Draft, diagrams: Diagrams) -> None:
        self._moves = moves(draft, diagrams) or []
        self._budget = diagrams.budget
        self._steps: dict[tuple[int, int], list[Step]] = {}

    def agrees(self, lead: Sequence[int]) -> bool:
        """Whether every state keeps its language if `lead[q]` is entered in place of q.

        Runs differ only from there on, so these pairs are where the comparison starts.
        """
        work = [(p, q) for q, p in enumerate(lead) if p != q]
        index = {pair: i for i, pair in enumerate(work)}
        graph: list[list[tuple[int, bool, bool]]] = []
        for pair in work:
            edges = []
            for new, old, new_mark, old_mark in self._common(*pair):
                target = (lead[new], old)
                if target not in index:
                    index[target] = len(work)
                    work.append(target)
                edges.append((index[target], new_mark, old_mark))
            graph.append(edges)
        return not (_one_sided(graph, 1) or _one_sided(graph, 2))

    def _common(self, new: int, old: int) -> list[Step]:
        found = self._steps.get((new, old))
        if found is None:
            self._budget.tick()
            found = [
                (s, t, s_mark, t_mark)
                for s, s_mark, letters in self._moves[new]
                for t, t_mark, others in self._moves[old]
                if letters & others
            ]
            self._steps[new, old] = found
        return found


def _one_sided(graph: Sequence[Sequence[tuple[int, bool, bool]]], side: int) -> bool:
    """Whether some cycle has marks of the other side and none of `side`."""
    alone = [
        (q, e[0]) for q, edges in enumerate(graph) for e in edges if e[3 - side] and not e[side]
    ]
    if not alone:
        return False
    quiet = components([[e[0] for e in edges if not e[side]] for edges in graph])
    return any(quiet[q] == quiet[target] for q, target in alone)
