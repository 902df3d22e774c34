"""Limit-deterministic Büchi automata: from formulas, their words, HOA, pictures."""

from tiloilc.automaton.compare import difference_word, satisfying_word
from tiloilc.automaton.complement import rejected_word
from tiloilc.automaton.draw import to_dot, to_mermaid, to_svg
from tiloilc.automaton.graphviz import rendered
from tiloilc.automaton.guards import guard_text
from tiloilc.automaton.hoa import to_hoa
from tiloilc.automaton.ldba import Cube, Edge, Ldba, Letter, StateId
from tiloilc.automaton.limits import MAX_STATES, TIMEOUT
from tiloilc.automaton.translate import Acceptance, translate
from tiloilc.automaton.words import accepted_word, accepts, is_empty

__all__ = [
    "MAX_STATES",
    "TIMEOUT",
    "Acceptance",
    "Cube",
    "Edge",
    "Ldba",
    "Letter",
    "StateId",
    "accepted_word",
    "accepts",
    "difference_word",
    "guard_text",
    "is_empty",
    "rejected_word",
    "rendered",
    "satisfying_word",
    "to_dot",
    "to_hoa",
    "to_mermaid",
    "to_svg",
    "translate",
]
