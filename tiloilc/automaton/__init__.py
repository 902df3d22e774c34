"""Limit-deterministic Büchi automata: from formulas, their words, HOA, pictures."""

from tiloilc.automaton.drawing.dot import to_dot
from tiloilc.automaton.drawing.draw import to_png, to_svg
from tiloilc.automaton.drawing.graphviz import rendered
from tiloilc.automaton.drawing.mermaid import to_mermaid
from tiloilc.automaton.drawing.page import to_html
from tiloilc.automaton.guards import guard_text
from tiloilc.automaton.hoa.read import from_hoa, load_hoa, read_hoa
from tiloilc.automaton.hoa.write import to_hoa
from tiloilc.automaton.language.compare import difference_word, satisfying_word
from tiloilc.automaton.language.complement import rejected_word
from tiloilc.automaton.language.words import accepted_word, accepts, is_empty
from tiloilc.automaton.ldba import Cube, Edge, Ldba, Letter, StateId
from tiloilc.automaton.limits import MAX_STATES, TIMEOUT
from tiloilc.automaton.translate import Acceptance, translate

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
    "from_hoa",
    "guard_text",
    "is_empty",
    "load_hoa",
    "read_hoa",
    "rejected_word",
    "rendered",
    "satisfying_word",
    "to_dot",
    "to_hoa",
    "to_html",
    "to_mermaid",
    "to_png",
    "to_svg",
    "translate",
]
