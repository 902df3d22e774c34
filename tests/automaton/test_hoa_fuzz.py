"""Damaged HOA files: findings with a code and a place, and nothing else."""

from __future__ import annotations

import random
import re
from functools import cache

import pytest

from tests.automaton.formulas import PAPER
from tests.automaton.hoa_random import random_automaton
from tests.strategies import random_formula
from tiloilc.automaton import from_hoa, to_hoa, translate
from tiloilc.diag import CompileError, Diagnostic
from tiloilc.ltl import parse

CODES = {"AUT302", "AUT303", "AUT304", "AUT305", "AUT306", "AUT307"}

VOCABULARY = (
    "HOA: v1 States: Start: AP: Alias: Acceptance: acc-name: properties: tool: name: Odd: odd: "
    "--BODY-- --END-- --ABORT-- State: Inf Fin t f & | ! ( ) [ ] { } @a @b 0 1 2 3 7 00 2147483648 "
    '1000000000 99999999999999999999 "a" "b" "" " \\ /* */ Buchi generalized-Buchi Rabin all none '
    "deterministic complete state-acc trans-acc implicit-labels explicit-labels univ-branch "
    "\N{GREEK SMALL LETTER EPSILON} \x00 \x1b $ - --"
)
"""Words of the format, in their places and out of them."""

WORDS = VOCABULARY.split(" ")

PIECES = re.compile(r'"[^"\n]*"|[\w:@-]+|\s+|.', re.DOTALL)


def test_some_hundred_damaged_files_get_findings() -> None:
    attack(random.Random("damaged"), 600)


@pytest.mark.slow
@pytest.mark.parametrize("part", range(4))  # for as many workers
def test_twenty_thousand_damaged_files_get_findings(part: int) -> None:
    attack(random.Random(f"many damaged, {part}"), 5_000)


def attack(generator: random.Random, count: int) -> None:
    """Damage `count` files, a third of which are still read when little was damaged."""
    read = 0
    seen: set[str] = set()
    for _ in range(count):
        text = damaged(generator, whole(generator))
        lines = text.split("\n")
        findings = said(generator, text)
        read += not findings
        for found in findings:
            seen.add(found.code)
            assert found.message.isprintable()
            assert found.help.isprintable()
            if found.span is not None:
                assert 1 <= found.span.line <= len(lines)
                assert 1 <= found.span.column <= len(lines[found.span.line - 1]) + 1
            else:
                assert found.code == "AUT305"
    assert seen <= CODES
    assert seen >= {"AUT302", "AUT304", "AUT307"}
    assert count // 20 < read < count // 2


def said(generator: random.Random, text: str) -> tuple[Diagnostic, ...]:
    """What is said about `text`; nothing if it can be read."""
    names = generator.choice((None, ("a", "b", "c")))
    acceptance = generator.choice(("state", "edge"))
    try:
        from_hoa(text, names, acceptance=acceptance, max_states=200, timeout=5)
    except CompileError as error:
        return error.diagnostics
    return ()


def whole(generator: random.Random) -> str:
    """A file without fault."""
    kind = generator.randrange(3)
    if kind == 0:
        return random_automaton(generator)[1]
    if kind == 1:
        return written(generator.choice(sorted(PAPER.values())).text)
    names = ("a", "b", "c")
    formula = random_formula(generator, names, 8)
    return to_hoa(translate(formula, names, acceptance="edge"), complete=False)


@cache
def written(text: str) -> str:
    """The automaton of a formula of the paper, of which there are few."""
    parsed = parse(text)
    return to_hoa(translate(parsed.formula, parsed.propositions))


def damaged(generator: random.Random, text: str) -> str:
    """`text` after one to six accidents."""
    for _ in range(generator.choice((1, 1, 2, 3, 6))):
        text = accident(generator, text)
    return text


def accident(generator: random.Random, text: str) -> str:
    """A piece, a line or a character lost, doubled, exchanged or put in; or the end cut off."""
    kind = generator.randrange(8)
    if kind == 0:
        return text[: generator.randrange(len(text) + 1)]
    if kind == 1:
        place = generator.randrange(len(text) + 1)
        return text[:place] + chr(generator.choice((0, 9, 34, 47, 92, 200, 0x1F600))) + text[place:]
    parts = text.splitlines(keepends=True) if kind < 4 else PIECES.findall(text)
    if not parts:
        return generator.choice(WORDS)
    place, other = generator.randrange(len(parts)), generator.randrange(len(parts))
    if kind in (2, 4):
        del parts[place]
    elif kind in (3, 5):
        parts.insert(place, parts[other])
    elif kind == 6:
        parts[place] = generator.choice(WORDS)
    else:
        parts[place], parts[other] = parts[other], parts[place]
    return "".join(parts)
