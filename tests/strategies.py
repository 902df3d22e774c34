"""Random formulas and words: Hypothesis strategies, which shrink, and seeded generators."""

from __future__ import annotations

import random
from collections.abc import Callable, Sequence

from hypothesis import strategies as st

from tiloilc.ltl.ast import (
    FALSE,
    TRUE,
    Always,
    And,
    Eventually,
    Formula,
    Iff,
    Implies,
    Next,
    Not,
    Or,
    Proposition,
    Release,
    StrongRelease,
    Until,
    WeakUntil,
    Xor,
)
from tiloilc.ltl.lasso import Lasso

UNARY: tuple[Callable[[Formula], Formula], ...] = (Not, Next, Eventually, Always)
BINARY: tuple[Callable[[Formula, Formula], Formula], ...] = (
    lambda left, right: And((left, right)),
    lambda left, right: Or((left, right)),
    Until,
    Release,
    WeakUntil,
    StrongRelease,
    Implies,
    Iff,
    Xor,
)


@st.composite
def formulas(draw: st.DrawFn, propositions: Sequence[str], max_size: int = 12) -> Formula:
    """Formulas of at most `max_size` operators, propositions and constants."""
    return _formula(
        draw(st.integers(1, max_size)),
        propositions,
        lambda low, high: draw(st.integers(low, high)),
    )


@st.composite
def lassos(
    draw: st.DrawFn, propositions: Sequence[str], max_stem: int = 4, max_loop: int = 4
) -> Lasso:
    """Words stem · loop^ω; bit i of a letter is `propositions[i]`."""
    letters = st.integers(0, 2 ** len(propositions) - 1)
    stem = draw(st.lists(letters, max_size=max_stem))
    loop = draw(st.lists(letters, min_size=1, max_size=max_loop))
    return Lasso(tuple(stem), tuple(loop))


def random_formula(
    generator: random.Random, propositions: Sequence[str], max_size: int = 12
) -> Formula:
    """As `formulas`, drawn from `generator`: fast, for many examples."""
    return _formula(generator.randint(1, max_size), propositions, generator.randint)


def random_lasso(
    generator: random.Random, propositions: Sequence[str], max_stem: int = 4, max_loop: int = 4
) -> Lasso:
    """As `lassos`, drawn from `generator`."""
    top = 2 ** len(propositions) - 1
    stem = tuple(generator.randint(0, top) for _ in range(generator.randint(0, max_stem)))
    loop = tuple(generator.randint(0, top) for _ in range(generator.randint(1, max_loop)))
    return Lasso(stem, loop)


def _formula(size: int, propositions: Sequence[str], pick: Callable[[int, int], int]) -> Formula:
    """A formula of exactly `size` nodes (three-armed junctions count one more)."""
    if size == 1:
        leaf = pick(0, 8 * len(propositions) + 1)
        if leaf >= 8 * len(propositions):
            return (FALSE, TRUE)[leaf - 8 * len(propositions)]
        return Proposition(propositions[leaf % len(propositions)])
    if size == 2 or pick(0, 2) == 0:
        return UNARY[pick(0, 3)](_formula(size - 1, propositions, pick))
    if size >= 5 and pick(0, 5) == 0:
        first = pick(1, size - 4)
        second = pick(1, size - 3 - first)
        sizes = (first, second, size - 2 - first - second)
        return (And, Or)[pick(0, 1)](tuple(_formula(s, propositions, pick) for s in sizes))
    left = pick(1, size - 2)
    return BINARY[pick(0, len(BINARY) - 1)](
        _formula(left, propositions, pick), _formula(size - 1 - left, propositions, pick)
    )
