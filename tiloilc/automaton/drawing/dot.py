"""Automata as Graphviz DOT, for those who want to lay them out or style them themselves.

Stages go from left to right, accepting states have two lines, the sink is grey, ε-jumps are dashed,
guards are short formulas; what is cut is whole in the tooltip.
"""

from __future__ import annotations

from collections.abc import Iterator

from tiloilc.automaton.drawing.picture.pieces import (
    GUARD_LINES,
    GUARD_WIDTH,
    NAME_LINES,
    NAME_WIDTH,
    HasIndex,
)
from tiloilc.automaton.drawing.text import own_parts, wrapped
from tiloilc.automaton.guards import guard_text
from tiloilc.automaton.ldba import Ldba, StateId

GREY = "#666d75"


def to_dot(ldba: Ldba, stages: HasIndex | None = None, title: str | None = None) -> str:
    """`ldba` as DOT text; with `stages`, states of one stage stand in one column."""
    lines = [
        "digraph ldba {",
        '  rankdir=LR; nodesep=0.45; ranksep=0.6; pad=0.2; bgcolor="white";',
        '  fontname="Helvetica"; fontsize=14; labelloc=t;',
        '  node [fontname="Helvetica", fontsize=12, shape=box, style="rounded,filled",',
        '        fillcolor="#f4f7fb", color="#24425f", margin="0.12,0.08", height=0.45];',
        '  edge [fontname="Helvetica", fontsize=11, arrowsize=0.7, color="#24425f"];',
    ]
    if title is not None:
        lines.append(f"  label={_quoted(title)};")
    lines.append('  start [shape=point, width=0.08, label="", fillcolor="#24425f"];')
    labels = labels_of(ldba, stages, title)
    lines.extend(_state(ldba, state, labels[state]) for state in ldba.states)
    if stages is not None:
        lines.extend(_columns(ldba, stages))
    lines.append(f"  start -> {ldba.initial};")
    lines.extend(_edges(ldba))
    for source, target in ldba.jumps:
        look = 'style=dashed, label="ε", fontsize=13, color="#b3541e", fontcolor="#b3541e"'
        lines.append(f"  {source} -> {target} [{look}];")
    return "\n".join([*lines, "}", ""])


def _state(ldba: Ldba, state: StateId, label: list[str]) -> str:
    look = [
        f"label={_quoted(chr(10).join(label))}",
        f"tooltip={_quoted(ldba.names[state])}",
    ]
    if state in ldba.accepting:
        look += ["peripheries=2", 'fillcolor="#e3f4e3"']
    if state == ldba.sink:
        look += ['fillcolor="#ececec"', f'color="{GREY}"', f'fontcolor="{GREY}"']
    return f"  {state} [{', '.join(look)}];"


def labels_of(ldba: Ldba, stages: HasIndex | None, title: str | None) -> list[list[str]]:
    """The lines in each state: its number and stage, then what sets it apart."""
    labels = []
    for state, own in enumerate(own_parts(ldba, title)):
        head = f"{state}" if stages is None else f"{state} · stage {stages.index[state]}"
        text = wrapped(own, NAME_WIDTH, NAME_LINES) if own else []
        labels.append([f"{state} · sink"] if state == ldba.sink else [head, *text])
    return labels


def _columns(ldba: Ldba, stages: HasIndex) -> Iterator[str]:
    """States of one stage in one column; the sink stands wherever there is room."""
    columns: dict[int, list[StateId]] = {}
    for state in ldba.states:
        if state != ldba.sink and state not in ldba.accepting:
            columns.setdefault(stages.index[state], []).append(state)
    for _, states in sorted(columns.items()):
        if len(states) > 1:
            yield f"  {{ rank=same; {' '.join(f'{state};' for state in states)} }}"


def _edges(ldba: Ldba) -> Iterator[str]:
    for index, edge in enumerate(ldba.edges):
        if edge.source == ldba.sink:
            continue
        guard = guard_text(edge.guard, ldba.propositions)
        marked = f"● {guard}" if index in ldba.accepting_edges else guard
        text = "\n".join(wrapped(marked, GUARD_WIDTH, GUARD_LINES))
        look = [f"label={_quoted(text)}", f"tooltip={_quoted(guard)}"]
        if edge.target == ldba.sink:
            look += [f'color="{GREY}"', f'fontcolor="{GREY}"', "weight=0"]
        elif edge.source == edge.target:
            look += ["arrowsize=0.5", "penwidth=0.8", "fontsize=10"]
        yield f"  {edge.source} -> {edge.target} [{', '.join(look)}];"


def _quoted(text: str) -> str:
    escaped = text.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n")
    return f'"{escaped}"'
