"""Parts of a formula that do not matter (Beer, Ben-David, Eisner, Rodeh, FMSD 2001: vacuity)."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence

from tiloilc.automaton.language.questions import implies, small_budget
from tiloilc.automaton.limits import Budget
from tiloilc.diag import CompileError
from tiloilc.ltl import Syntax
from tiloilc.ltl.ast import FALSE, TRUE, Constant, Formula

MAX_PARTS = 40
"""Of more parts nobody asks."""

DOWN, BOTH, UP = -1, 0, 1
"""Polarity: the formula gets weaker with a part (UP), stronger (DOWN), or nothing is known."""


def irrelevant_parts(syntax: Syntax, propositions: Sequence[str]) -> list[tuple[Syntax, Formula]]:
    """The parts of a formula as written that do not matter, with constants that may replace them.

    All may be replaced at once, for the same meaning. Each place is looked at on its own, the
    largest first, later ones before earlier ones: of two that say the same, the second is named.
    The formula itself is left out: it is unsatisfiable or always true, which says more. Ends early
    where the comparison would take too long. In the order of the text.
    """
    places = list(_places(syntax))
    found: dict[int, tuple[Syntax, Formula]] = {}
    budget = small_budget()
    while len(places) <= MAX_PARTS:
        before = set(found)
        for place, polarity in places:
            if isinstance(place.formula, Constant) or _within(place, found.values()):
                continue
            try:
                value = _replacement(syntax, place, polarity, found, propositions, budget)
            except CompileError:
                return _in_order(found)
            if value is not None:
                found = {key: kept for key, kept in found.items() if not _holds(place, kept[0])}
                found[id(place)] = place, value
        if before == set(found):
            break
    return _in_order(found)


def _places(syntax: Syntax) -> Iterator[tuple[Syntax, int]]:
    """Every part but the whole, with its polarity: outer before inner, later before earlier."""
    waiting = [(syntax, UP)]
    while waiting:
        node, polarity = waiting.pop(0)
        if node is not syntax:
            yield node, polarity
        for index, part in reversed(list(enumerate(node.parts))):
            waiting.append((part, polarity * _sign(node.rule, index)))


def _sign(rule: str, index: int) -> int:
    """Whether an operator gets weaker (UP) or stronger (DOWN) with its operand `index`."""
    if rule in ("iff", "xor"):
        return BOTH
    return DOWN if rule == "negate" or (rule == "implies" and index == 0) else UP


def _over(node: Syntax, replaced: Mapping[int, Formula]) -> Formula:
    """The formula of `node` with other formulas for some parts, given by their ids."""
    if id(node) in replaced:
        return replaced[id(node)]
    operands = [_over(part, replaced) for part in node.parts]
    if all(new is part.formula for new, part in zip(operands, node.parts, strict=True)):
        return node.formula
    return node.over(operands)


def _replacement(
    syntax: Syntax,
    place: Syntax,
    polarity: int,
    found: dict[int, tuple[Syntax, Formula]],
    names: Sequence[str],
    budget: Budget,
) -> Constant | None:
    """What may stand at `place`, beside what was `found`. Raises CompileError AUT305."""
    replaced = {key: value for key, (_, value) in found.items()}
    current = _over(syntax, replaced)
    for value in (FALSE, TRUE):
        changed = _over(syntax, {**replaced, id(place): value})
        if _same(current, changed, polarity, value, names, budget):
            return value
    return None


def _same(
    formula: Formula,
    changed: Formula,
    polarity: int,
    value: Constant,
    names: Sequence[str],
    budget: Budget,
) -> bool:
    """Whether `changed`, with `value` for a part of `polarity`, still means the same.

    One direction is known from the polarity. Raises CompileError AUT305.
    """
    pairs = [(formula, changed), (changed, formula)]
    if polarity != BOTH:
        weaker = (polarity == UP) == value.value
        pairs = [(changed, formula)] if weaker else [(formula, changed)]
    return all(implies(left, right, names, budget) for left, right in pairs)


def _holds(outer: Syntax, inner: Syntax) -> bool:
    return outer.start <= inner.start and inner.end <= outer.end


def _within(place: Syntax, found: Iterable[tuple[Syntax, Formula]]) -> bool:
    return any(_holds(part, place) for part, _ in found)


def _in_order(found: dict[int, tuple[Syntax, Formula]]) -> list[tuple[Syntax, Formula]]:
    return sorted(found.values(), key=lambda each: each[0].start)
