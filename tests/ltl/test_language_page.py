"""The tables of docs/ltl.md are true: every spelling, every precedence."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from tiloilc.ltl import parse, to_text
from tiloilc.ltl.ast import FALSE, TRUE, Formula
from tiloilc.ltl.lexer import SYMBOLS, WORDS

PAGE = (Path(__file__).resolve().parents[2] / "docs" / "ltl.md").read_text(encoding="utf-8")
CANONICAL = {
    "negation": "!",
    "next": "X",
    "eventually": "F",
    "always": "G",
    "until": "U",
    "weak until": "W",
    "release": "R",
    "strong release": "M",
    "conjunction": "&",
    "exclusive disjunction": "^",
    "disjunction": "|",
    "implication": "->",
    "equivalence": "<->",
}


def tables(title: str) -> list[list[list[str]]]:
    """The tables under a heading: rows of cells, without the head."""
    section = PAGE.split(f"\n## {title}", 1)[1].split("\n## ", 1)[0]
    found: list[list[list[str]]] = []
    for block in re.findall(r"(?:^\|.*\n)+", section, re.MULTILINE):
        rows = [re.split(r"(?<!\\)\|", line.strip())[1:-1] for line in block.splitlines()[2:]]
        found.append([[cell.strip().replace("\\|", "|") for cell in row] for row in rows])
    return found


def code(cell: str) -> list[str]:
    """What stands between backquotes."""
    return re.findall(r"`([^`]+)`", cell)


OPERATORS = [(row[0], code(row[1]), row[2]) for row in tables("Operators")[0]]
PAIRS = [
    (code(written)[0], code(read)[0])
    for title, place in (("Operators", 1), ("Bounds", 0), ("Propositions", 0))
    for written, read in tables(title)[place]
]


def formula(text: str) -> Formula:
    return parse(text).formula


def test_the_page_lists_every_operator_and_every_spelling() -> None:
    assert [name for name, _, _ in OPERATORS] == list(CANONICAL)
    listed = {s for _, spellings, _ in OPERATORS for s in spellings}
    listed |= {s for row in tables("Constants")[0] for s in code(row[1])}
    structure = {"OPEN", "CLOSE", "IS_TRUE", "IS_FALSE"}
    known = {s for kind, group in SYMBOLS.items() if kind not in structure for s in group}
    known |= {s for group in WORDS.values() for s in group if s not in ("True", "TRUE")}
    assert known - {"False", "FALSE"} <= listed
    assert listed - known == {"X[!]", "weak until", "strong release", "NOT", "AND", "OR", "XOR"}


@pytest.mark.parametrize(("name", "spellings", "binds"), OPERATORS)
def test_all_spellings_of_an_operator_mean_the_same(
    name: str, spellings: list[str], binds: str
) -> None:
    sign = CANONICAL[name]
    for spelling in spellings:
        if binds == "prefix":
            assert formula(f"{spelling} a") == formula(f"{sign} a"), spelling
        else:
            assert formula(f"a {spelling} b") == formula(f"a {sign} b"), spelling


LEVELS = [
    ["until", "weak until", "release", "strong release"],
    ["conjunction"],
    ["exclusive disjunction"],
    ["disjunction"],
    ["implication", "equivalence"],
]


def test_each_operator_binds_tighter_than_those_below() -> None:
    order = [name for name, _, binds in OPERATORS if binds != "prefix"]
    assert [name for level in LEVELS for name in level] == order
    for tighter, above in enumerate(LEVELS):
        for below in LEVELS[tighter + 1 :]:
            for one in above:
                for other in below:
                    t, loose = CANONICAL[one], CANONICAL[other]
                    assert formula(f"a {loose} b {t} c") == formula(f"a {loose} (b {t} c)")
                    assert formula(f"a {t} b {loose} c") == formula(f"(a {t} b) {loose} c")
    for name, _, binds in OPERATORS:
        for prefix in ("!", "X", "F", "G"):
            if binds != "prefix":
                sign = CANONICAL[name]
                assert formula(f"{prefix} a {sign} b") == formula(f"({prefix} a) {sign} b")


@pytest.mark.parametrize(("name", "spellings", "binds"), OPERATORS)
def test_operators_associate_as_the_page_says(name: str, spellings: list[str], binds: str) -> None:
    if binds == "prefix":
        return
    level = next(level for level in LEVELS if name in level)
    for other in level:
        one, two = CANONICAL[name], CANONICAL[other]
        both = formula(f"a {one} b {two} c")
        if binds == "right":
            assert both == formula(f"a {one} (b {two} c)")
        elif binds == "left":
            assert both == formula(f"(a {one} b) {two} c")
        else:
            assert to_text(both) == f"a {one} b {two} c"


@pytest.mark.parametrize(("written", "read"), PAIRS)
def test_what_the_page_says_is_read_so_is(written: str, read: str) -> None:
    assert formula(written) == formula(read)


def test_constants_have_the_spellings_of_the_page() -> None:
    for name, cell in tables("Constants")[0]:
        for spelling in code(cell):
            assert formula(spelling) == (TRUE if name == "true" else FALSE)
