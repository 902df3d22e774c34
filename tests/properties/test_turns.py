"""Sources of promises are served in turn, and none is passed over for ever.

Each formula has two sources with promises of their own, and another part that asks for one *or* the
other: while that is open the two are waited for together. The words keep one promise never, and
play the parts so that its turn would always come while it is hidden.
"""

from __future__ import annotations

import random

import pytest

from tiloilc.automaton import accepts, translate
from tiloilc.automaton.translate import ConstructionName
from tiloilc.ltl import Lasso, holds, parse

NAMES = ("p", "b", "q", "c", "s", "d", "r", "z", "e")


def word(stem: str, loop: str) -> Lasso:
    """Letters by the names of their propositions, with blanks between; "-" for none."""
    letters = [
        [sum(1 << NAMES.index(name) for name in letter if name != "-") for letter in text.split()]
        for text in (stem, loop)
    ]
    return Lasso(tuple(letters[0]), tuple(letters[1]))


@pytest.mark.parametrize(
    ("text", "broken"),
    [
        (
            "G (p -> X F b) & G ((q -> X F c) & (s -> X F d)) & ((r -> X (F b | F d)) W z) & G F e",
            word("q p", "br d ep"),
        ),
        (
            "G (p -> X F b) & G ((q -> X F c) & (s -> X F d))"
            " & ((r -> X (F b | F d)) W z) & G (z | X F e)",
            word("q p", "br d ep"),
        ),
        (
            "G (p -> X F b) & G (s -> X F d & (!q | X F c)) & (z R (r -> X (F b | F d))) & G F e",
            word("qs dp", "br d ep"),
        ),
    ],
)
def test_a_promise_never_kept_is_not_passed_over(text: str, broken: Lasso) -> None:
    formula = parse(text, NAMES).formula
    generator = random.Random(text)
    letters = sorted(set(broken.letters))
    words = [broken]
    for _ in range(60):
        stem = [generator.choice(letters) for _ in range(generator.randint(0, 3))]
        loop = [generator.choice(letters) for _ in range(generator.randint(1, 6))]
        words.append(Lasso(tuple(stem), tuple(loop)))
    truth = [holds(formula, word, NAMES) for word in words]
    assert not truth[0]
    assert any(truth)
    ldba = translate(formula, NAMES)
    assert [accepts(ldba, word) for word in words] == truth


@pytest.mark.parametrize("construction", ["asymmetric", "symmetric"])
@pytest.mark.parametrize(
    "text",
    [
        "(z R (p | ((X F d | X c) W z))) & F G (p | F b)",
        "G F e & (z R (!p -> ((X F d | X (c & F e)) W z))) & F G (!p -> F b)",
    ],
)
def test_an_alternative_that_later_letters_never_say_whole_is_kept(
    text: str, construction: ConstructionName
) -> None:
    """Over p for ever nothing else is promised, but another p is asked for by every letter."""
    formula = parse(text, NAMES).formula
    ldba = translate(formula, NAMES, construction=construction)
    for always in (word("", "pqe"), word("d pc", "pe p"), word("-", "pe"), word("c", "pe - c")):
        assert accepts(ldba, always) == holds(formula, always, NAMES)
