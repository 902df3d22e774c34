"""Random byte strings and mutated formulas through the parser: diagnostics only, and soon.

`python -m tests.fuzz.parser --count 1000000 --seed 1` prints what was seen, and ends with 1 if any
text ended in something else than a formula or findings, or took longer than SLOW seconds.
"""

from __future__ import annotations

import argparse
import random
import sys
import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field

from tests.strategies import random_formula
from tiloilc.diag import CompileError, Diagnostic, SourceText
from tiloilc.ltl import parse, to_text
from tiloilc.ltl.lexer import SYMBOLS, WORDS

SLOW = 1.0
"""Seconds of the processor that no text of these lengths may take: they take a thousandth."""

NAMES = ("a", "b", "GoalReached", "x_1", "F1", "weird name")
CODES = {"LTL201", "LTL202", "LTL203"}

SPELLINGS = [s for group in (*SYMBOLS.values(), *WORDS.values()) for s in group]
PIECES = [
    *SPELLINGS,
    *NAMES[:-1],
    *[
        '"weird name"',
        "'b'",
        "[2:5]",
        "[3]",
        "[..$]",
        "[!]",
        "[",
        "]",
        "{",
        "}",
        ";",
        ",",
        "@",
        "#",
    ],
    *[
        "=",
        "==",
        "!=",
        "<",
        ">",
        "/*",
        "*/",
        '"',
        "'",
        "`",
        "\\",
        "\t",
        "\n",
        "\x00",
        "\x07",
        "é",
        "😀",
    ],
    *[
        "\u0301",
        "\u200b",
        "\ufeff",
        "\ud800",
        "0",
        "1",
        "2",
        "10",
        "007",
        "1e9",
        "GFa",
        "aUb",
        "XXX",
    ],
    *[" "] * 20,
]
"""What is put together, and put into formulas."""


@dataclass
class Seen:
    """How the texts ended, and those that ended badly."""

    formulas: int = 0
    codes: Counter[str] = field(default_factory=Counter)
    slowest: float = 0.0
    faults: list[str] = field(default_factory=list)

    def report(self, count: int, seconds: float) -> str:
        """A few lines."""
        findings = ", ".join(f"{code} {n:,}" for code, n in sorted(self.codes.items()))
        lines = [
            f"{count:,} texts in {seconds:,.0f} s; most processor time {self.slowest:.3f} s",
            f"formulas {self.formulas:,}; findings: {findings}",
            *self.faults[:20],
            f"{len(self.faults)} faults",
        ]
        return "\n".join(lines)


def texts(generator: random.Random) -> Iterator[str]:
    """Texts of several kinds, one after the other, without end."""
    while True:
        yield random_bytes(generator)
        yield "".join(generator.choices(PIECES, k=generator.randint(0, 14)))
        formula = to_text(random_formula(generator, NAMES, 12), brackets=generator.random() < 0.3)
        yield mutated(formula, generator)
        yield respelled(formula, generator)
        if generator.random() < 0.02:
            yield tower(generator)


def tower(generator: random.Random) -> str:
    """Pieces over and over, and perhaps what closes them."""
    pieces = generator.choices(PIECES + ["(", "!", "X", "F", "G"] * 20, k=generator.randint(1, 3))
    closing = ")" * generator.choice([0, 1, pieces.count("(")])
    times = generator.randint(50, 400)
    return " ".join(pieces) * times + "a" + closing * times


def random_bytes(generator: random.Random) -> str:
    """Bytes as text: what of them is no UTF-8 stays as surrogates."""
    data = generator.randbytes(generator.randint(0, 40))
    return (
        data.decode("utf-8", "surrogateescape")
        if generator.random() < 0.5
        else data.decode("latin1")
    )


def mutated(text: str, generator: random.Random) -> str:
    """A text with a few characters or pieces put in, taken out, doubled or exchanged."""
    for _ in range(generator.randint(1, 4)):
        start = generator.randint(0, len(text))
        end = min(len(text), start + generator.randint(0, 3))
        piece = generator.choice(PIECES)
        change = generator.randrange(5)
        if change == 0:
            text = text[:start] + piece + text[start:]
        elif change == 1:
            text = text[:start] + text[end:]
        elif change == 2:
            text = text[:end] + text[start:]
        elif change == 3:
            text = text[:start] + piece + text[end:]
        else:
            other = generator.randint(0, len(text))
            text = text[:start] + text[other : other + 6] + text[start:]
    return text


def respelled(text: str, generator: random.Random) -> str:
    """A formula with other spellings, and without some of its spaces: mostly it can be read."""
    words = []
    for word in text.split(" "):
        kind = next((k for k, group in {**SYMBOLS, **WORDS}.items() if word in group), None)
        if kind is not None and generator.random() < 0.5:
            group = (*SYMBOLS.get(kind, ()), *WORDS.get(kind, ()))
            word = generator.choice(group)
        words.append(word)
    return "".join(word + generator.choice(["", " ", " ", "\n"]) for word in words)


def fuzz(count: int, seed: int) -> Seen:
    """`count` texts through the parser."""
    generator, seen = random.Random(seed), Seen()
    source = texts(generator)
    for _ in range(count):
        text = next(source)
        declared = generator.choice([None, NAMES, NAMES[:2], ()])
        begun = time.process_time()
        fault = _fault(text, declared, seen)
        seen.slowest = max(seen.slowest, time.process_time() - begun)
        if fault is not None:
            seen.faults.append(f"{fault}: {text[:200]!r} over {declared}")
    return seen


def _fault(text: str, declared: tuple[str, ...] | None, seen: Seen) -> str | None:
    """What is wrong with how `text` ended; None if nothing is."""
    try:
        parsed = parse(text, declared)
    except CompileError as error:
        found = error.diagnostics
        seen.codes.update({d.code for d in found})
        return None if found and all(_well_placed(d, text) for d in found) else f"{found}"
    except BaseException as error:
        return f"{type(error).__name__}: {error}"
    seen.formulas += 1
    printed = to_text(parsed.formula)
    try:
        same = parse(printed, declared).formula == parsed.formula
    except BaseException as error:
        return f"printed as {printed}: {type(error).__name__}: {error}"
    return None if same else f"printed as {printed}"


def _well_placed(diagnostic: Diagnostic, text: str) -> bool:
    """Whether a finding is of this package and lies in the text."""
    span = diagnostic.span
    if diagnostic.code not in CODES or span is None:
        return False
    places = SourceText.plain(text).places
    begin, end = (span.line, span.column), (span.end_line, span.end_column)
    last = (places[-1][0], places[-1][1] + 1)
    return (1, 1) <= begin < end <= last or (begin in places and begin < end)


def main() -> int:
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=100_000)
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    begun = time.perf_counter()
    seen = fuzz(given.count, given.seed)
    sys.stdout.write(seen.report(given.count, time.perf_counter() - begun) + "\n")
    return int(bool(seen.faults) or seen.slowest > SLOW)


if __name__ == "__main__":
    sys.exit(main())
