"""Automata as Mermaid flowcharts, which Markdown renderers draw."""

from __future__ import annotations

import json

from tiloilc.automaton.drawing.dot import labels_of
from tiloilc.automaton.drawing.picture.pieces import GUARD_LINES, GUARD_WIDTH, HasIndex
from tiloilc.automaton.drawing.text import wrapped
from tiloilc.automaton.guards import guard_text
from tiloilc.automaton.ldba import Ldba


def to_mermaid(ldba: Ldba, stages: HasIndex | None = None, title: str | None = None) -> str:
    """`ldba` as a Mermaid flowchart, which Markdown renderers draw."""
    lines = ["---", f"title: {json.dumps(title)}", "---"] if title is not None else []
    labels = labels_of(ldba, stages, title)
    lines += ["flowchart LR", f"  start(( )) --> s{ldba.initial}"]
    for state in ldba.states:
        label = "<br/>".join(_escaped(line) for line in labels[state])
        left, right = ("[[", "]]") if state in ldba.accepting else ("([", "])")
        lines.append(f'  s{state}{left}"{label}"{right}')
    for index, edge in enumerate(ldba.edges):
        if edge.source == ldba.sink:
            continue
        guard = guard_text(edge.guard, ldba.propositions)
        text = f"● {guard}" if index in ldba.accepting_edges else guard
        label = "<br/>".join(map(_escaped, wrapped(text, GUARD_WIDTH, GUARD_LINES)))
        lines.append(f'  s{edge.source} -->|"{label}"| s{edge.target}')
    for source, target in ldba.jumps:
        lines.append(f"  s{source} -.->|ε| s{target}")
    lines.append("  classDef accepting stroke-width:3px")
    lines.append("  classDef sink fill:#eee,stroke:#888,color:#555")
    lines += [f"  class s{state} accepting" for state in sorted(ldba.accepting)]
    if ldba.sink is not None:
        lines.append(f"  class s{ldba.sink} sink")
    return "\n".join([*lines, ""])


def _escaped(text: str) -> str:
    escaped = text.replace("#", "#35;").replace("&", "&amp;").replace('"', "&quot;")
    return escaped.replace("<", "&lt;").replace(">", "&gt;")
