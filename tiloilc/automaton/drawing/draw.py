"""Pictures of automata: Graphviz DOT, SVG and Mermaid.

Stages go from left to right, accepting states have two lines, the sink is grey, ε-jumps are dashed,
guards are short formulas.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from typing import Protocol

from tiloilc.automaton.drawing.graphviz import rendered
from tiloilc.automaton.guards import guard_text
from tiloilc.automaton.ldba import Ldba, StateId

NAME_WIDTH = 24
"""Characters in a line of a state's name."""

NAME_LINES = 3
"""Lines of a state's name; the rest is in the tooltip."""

GUARD_WIDTH = 22
"""Characters in a line of a guard."""

GUARD_LINES = 4
"""Lines of a guard; the rest is in the tooltip."""

GREY = "#8a8a8a"


class HasIndex(Protocol):
    """The stages of an automaton: `index[b]` is how many stages lie before state b."""

    @property
    def index(self) -> Sequence[int]:
        """By state."""


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
    lines.extend(_state(ldba, state, stages) for state in ldba.states)
    if stages is not None:
        lines.extend(_columns(ldba, stages))
    lines.append(f"  start -> {ldba.initial};")
    lines.extend(_edges(ldba))
    for source, target in ldba.jumps:
        look = 'style=dashed, label="ε", fontsize=13, color="#b3541e", fontcolor="#b3541e"'
        lines.append(f"  {source} -> {target} [{look}];")
    return "\n".join([*lines, "}", ""])


def to_svg(ldba: Ldba, stages: HasIndex | None = None, title: str | None = None) -> str:
    """`ldba` as SVG text, laid out by Graphviz; the same text every time."""
    drawn = rendered(to_dot(ldba, stages, title), "svg")
    text = drawn.decode("utf-8").replace("\r\n", "\n")
    text = re.sub(r"<!--.*?-->\n?", "", text, flags=re.DOTALL)
    return text.replace(
        'font-family="Helvetica,sans-Serif"', 'font-family="Helvetica,Arial,sans-serif"'
    )


def to_mermaid(ldba: Ldba, stages: HasIndex | None = None, title: str | None = None) -> str:
    """`ldba` as a Mermaid flowchart, which Markdown renderers draw."""
    lines = ["---", f"title: {title!r}", "---"] if title is not None else []
    lines += ["flowchart LR", f"  start(( )) --> s{ldba.initial}"]
    for state in ldba.states:
        label = "<br/>".join(_escaped(line) for line in _label(ldba, state, stages))
        left, right = ("[[", "]]") if state in ldba.accepting else ("([", "])")
        lines.append(f'  s{state}{left}"{label}"{right}')
    for index, edge in enumerate(ldba.edges):
        if edge.source == ldba.sink:
            continue
        guard = guard_text(edge.guard, ldba.propositions)
        mark = " ●" if index in ldba.accepting_edges else ""
        lines.append(f'  s{edge.source} -->|"{_escaped(guard)}{mark}"| s{edge.target}')
    for source, target in ldba.jumps:
        lines.append(f"  s{source} -.->|ε| s{target}")
    lines.append("  classDef accepting stroke-width:3px")
    lines.append("  classDef sink fill:#eee,stroke:#aaa,color:#888")
    lines += [f"  class s{state} accepting" for state in sorted(ldba.accepting)]
    if ldba.sink is not None:
        lines.append(f"  class s{ldba.sink} sink")
    return "\n".join([*lines, ""])


def _state(ldba: Ldba, state: StateId, stages: HasIndex | None) -> str:
    look = [
        f"label={_quoted(chr(10).join(_label(ldba, state, stages)))}",
        f"tooltip={_quoted(ldba.names[state])}",
    ]
    if state in ldba.accepting:
        look += ["peripheries=2", 'fillcolor="#e3f4e3"']
    if state == ldba.sink:
        look += ['fillcolor="#ececec"', f'color="{GREY}"', f'fontcolor="{GREY}"']
    return f"  {state} [{', '.join(look)}];"


def _label(ldba: Ldba, state: StateId, stages: HasIndex | None) -> list[str]:
    """The lines in a state: its number and stage, then what is left to do."""
    if state == ldba.sink:
        return [f"{state} · sink"]
    head = f"{state}" if stages is None else f"{state} · stage {stages.index[state]}"
    return [head, *_wrapped(ldba.names[state], NAME_WIDTH, NAME_LINES)]


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
        mark = "\n●" if index in ldba.accepting_edges else ""
        text = "\n".join(_wrapped(guard, GUARD_WIDTH, GUARD_LINES)) + mark
        look = [f"label={_quoted(text)}", f"tooltip={_quoted(guard)}"]
        if edge.target == ldba.sink:
            look += [f'color="{GREY}"', f'fontcolor="{GREY}"', "weight=0"]
        elif edge.source == edge.target:
            look += ["arrowsize=0.5", "penwidth=0.8", "fontsize=10"]
        yield f"  {edge.source} -> {edge.target} [{', '.join(look)}];"


def _wrapped(text: str, width: int, limit: int) -> list[str]:
    """`text` in at most `limit` lines, broken before `&` and `|` where that is possible."""
    lines = [""]
    for part in re.split(r" (?=[&|] )", text):
        joined = f"{lines[-1]} {part}".strip()
        if len(joined) <= width or not lines[-1]:
            lines[-1] = joined
        else:
            lines.append(part)
    if len(lines) > limit:
        lines = [*lines[: limit - 1], lines[limit - 1] + " …"]
    return [line if len(line) <= 2 * width else f"{line[: 2 * width - 1]}…" for line in lines]


def _quoted(text: str) -> str:
    escaped = text.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n")
    return f'"{escaped}"'


def _escaped(text: str) -> str:
    return text.replace("&", "&amp;").replace('"', "&quot;").replace("<", "&lt;")
