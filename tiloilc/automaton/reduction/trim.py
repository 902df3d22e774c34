"""Drop what cannot be reached and what cannot accept."""

from __future__ import annotations

from dataclasses import replace

from tiloilc.automaton.bdd import FALSE, Diagrams
from tiloilc.automaton.draft import Draft, Row, components, keep, reachable, reversed_graph


def trim(draft: Draft, diagrams: Diagrams) -> Draft:
    """Drop what cannot be reached and what cannot accept, and accepting marks on no cycle."""
    graph = [draft.targets(q) for q in range(len(draft.rows))]
    component = components(graph)
    rows: list[Row] = []
    accepting = set()
    for q, row in enumerate(draft.rows):
        new: Row = {}
        for (target, mark), guard in row.items():
            key = (target, mark and component[q] == component[target])
            new[key] = diagrams.disj(new.get(key, FALSE), guard)
            if key[1]:
                accepting.add(q)
        rows.append(new)
    live = reachable(reversed_graph(graph), accepting)
    kept = (live & reachable(graph, [draft.initial])) | {draft.initial}
    trimmed = keep(replace(draft, rows=tuple(rows)), kept)
    if len(kept) < len(draft.rows):
        return trim(trimmed, diagrams)
    return trimmed
