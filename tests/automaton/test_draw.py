"""DOT and Mermaid: what stands in them."""

from __future__ import annotations

from dataclasses import dataclass

from tests.automaton.formulas import PAPER
from tiloilc.automaton import Ldba, to_dot, to_mermaid, translate
from tiloilc.ltl import parse


@dataclass(frozen=True)
class Stages:
    index: tuple[int, ...]


def automaton(text: str) -> Ldba:
    parsed = parse(text)
    return translate(parsed.formula, parsed.propositions)


def test_dot_shows_acceptance_sink_and_jumps() -> None:
    lines = to_dot(automaton("F G y & G !b"), title="stay").splitlines()
    assert any('label="stay"' in line for line in lines)
    (accepting,) = [line for line in lines if line.startswith("  1 [")]
    assert "peripheries=2" in accepting
    (sink,) = [line for line in lines if line.startswith("  2 [")]
    assert "sink" in sink
    (jump,) = [line for line in lines if "ε" in line]
    assert jump.startswith("  0 -> 1 [style=dashed")
    assert not any(line.startswith("  2 -> 2") for line in lines), "the sink's loop says nothing"


def test_guards_are_short_formulas() -> None:
    dot = to_dot(automaton("G F (a & X F (b & X F c)) & G !z"))
    assert 'label="a & !z"' in dot
    assert 'label="z"' in dot


def test_states_of_one_stage_stand_in_one_column() -> None:
    ldba = automaton(PAPER["tray"].text)
    dot = to_dot(ldba, Stages((0, 1, 1, 2, 2, 3)))
    assert "{ rank=same; 1; 2; }" in dot
    assert "3 · stage 2" in dot


def test_labels_survive_odd_names() -> None:
    parsed = parse('F "a < b"')
    ldba = translate(parsed.formula, parsed.propositions)
    assert '"F \\"a < b\\""' in to_dot(ldba)
    assert "F &quot;a &lt; b&quot;" in to_mermaid(ldba)


def test_mermaid_draws_the_same_states_and_jumps() -> None:
    text = to_mermaid(automaton("F G y & G !b"), title="stay")
    assert text.startswith('---\ntitle: "stay"\n---\nflowchart LR\n')
    assert "s0 -.->|ε| s1" in text
    assert 's1[["1<br/>G y"]]' in text
    assert "class s2 sink" in text


def test_long_names_and_guards_are_cut_and_kept_whole_in_the_tooltip() -> None:
    text = " & ".join(f"F (place{i} & X F goal{i})" for i in range(5))
    dot = to_dot(automaton(text))
    (first,) = [line for line in dot.splitlines() if line.startswith("  0 [")]
    assert "…" in first
    assert f'tooltip="{text}"' in first
