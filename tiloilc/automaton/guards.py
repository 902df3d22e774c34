"""Guards as people read them: short formulas instead of lists of letters."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from tiloilc.automaton.bdd import FALSE, TRUE, Diagrams, Node
from tiloilc.automaton.ldba import Cube
from tiloilc.automaton.limits import Budget
from tiloilc.ltl import name_text


def guard_text(guard: Sequence[Cube], propositions: Sequence[str]) -> str:
    """The letter set `guard` as a formula over `propositions`: `a & !z`, `true`, `a | b`.

    A disjunction of conjunctions, or the other way round where that is shorter.
    """
    diagrams = Diagrams(Budget())
    node = as_diagram(diagrams, guard)
    return text_between(diagrams, node, node, propositions)


def text_between(diagrams: Diagrams, low: Node, high: Node, propositions: Sequence[str]) -> str:
    """A short formula that holds of all letters in `low`, and of none outside `high`.

    What is in `high` only does not matter; `low` implies `high`.
    """
    names = [name_text(name) for name in propositions]
    if low == FALSE or high == TRUE:
        return "false" if low == FALSE else "true"
    products = sorted(diagrams.cover(low, high))
    sums = sorted(diagrams.cover(diagrams.negate(high), diagrams.negate(low)))
    if sum(map(len, sums)) < sum(map(len, products)):
        turned = [[(v, not sign) for v, sign in literals] for literals in sums]
        return _junctions(turned, names, " & ", " | ")
    return _junctions(products, names, " | ", " & ")


def as_diagram(diagrams: Diagrams, guard: Iterable[Cube]) -> Node:
    """The letter set `guard` as a diagram over the numbers of the propositions."""
    union = FALSE
    for cube in guard:
        product = TRUE
        for v in reversed(range(cube.mask.bit_length())):
            if cube.mask >> v & 1:
                literal = diagrams.literal(v, bool(cube.value >> v & 1))
                product = diagrams.conj(literal, product)
        union = diagrams.disj(union, product)
    return union


def _junctions(
    parts: Sequence[Sequence[tuple[int, bool]]], names: Sequence[str], outer: str, inner: str
) -> str:
    """The literals of each part joined by `inner`, the parts by `outer`."""
    texts = []
    for literals in parts:
        text = inner.join(f"{'' if sign else '!'}{names[v]}" for v, sign in literals)
        bracketed = len(parts) > 1 and len(literals) > 1 and inner == " | "
        texts.append(f"({text})" if bracketed else text)
    return outer.join(texts)
