"""Storm as an oracle: its probability of a formula is that of our automaton, in any model.

Storm translates formulas with a translator that shares no code with ours, so that this checks at
once that an automaton has the language of its formula and that an agent that resolves the jumps as
it goes loses nothing. Storm computes with fractions.

    python -m tests.properties.storm --pairs 2000 --seed 1
"""

from __future__ import annotations

import argparse
import random
import sys
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from itertools import count

import numpy as np

from tests.properties.models import Mdp, best_probability, random_mdp
from tests.properties.variants import Translation, variants
from tests.strategies import random_formula
from tiloilc.automaton import from_hoa, to_hoa, translate
from tiloilc.evaluate.verify.storm import (
    Process,
    Unanswered,
    letter_labels,
    probabilities,
    storm_text,
)
from tiloilc.ltl import parse, to_text
from tiloilc.ltl.ast import Formula

ABC = ("a", "b", "c")
MAX_SIZE = 10
TOLERANCE = 1e-6

PATTERNS = (
    "F G ({0}) | G F ({1})",
    "F (({0}) & G (({1}) | X {2}))",
    "G (({0}) | F G ({1}))",
    "F (({0}) & (({1}) W ({2})))",
    "(G F ({0}) -> G F ({1})) & ({2})",
    "F G (({0}) -> X ({1})) & G F ({2})",
    "F (a & (({0}) R (!({0}) R (({0}) R ({1})))))",
    "G (a | (!b & c) U (b | ({0}) | (G c | !c W ({1}))))",
)
"""Shapes that need jumps: few random formulas do."""

TRANSLATIONS: dict[str, Translation] = {
    **variants(),
    "written and read": lambda formula, names: from_hoa(to_hoa(translate(formula, names)), names),
}
"""Every way to an automaton that is compared with Storm."""


@dataclass(frozen=True, slots=True)
class Pair:
    """A formula and a model; `number` and the seed make it again."""

    number: int
    formula: Formula
    mdp: Mdp


@dataclass(frozen=True, slots=True)
class Verdict:
    """What Storm says of a pair, and what each of TRANSLATIONS makes of it."""

    pair: Pair
    storm: float
    ours: dict[str, float]
    jumps: int

    @property
    def difference(self) -> float:
        """How far the worst one is from Storm."""
        return max(abs(value - self.storm) for value in self.ours.values())

    @property
    def text(self) -> str:
        """All that there is to know of a disagreement."""
        lines = [f"pair {self.pair.number}: {to_text(self.pair.formula)}"]
        lines.append(f"  Storm {self.storm:.9f}")
        lines += [f"  {name} {value:.9f}" for name, value in self.ours.items()]
        for state, (label, actions) in enumerate(
            zip(self.pair.mdp.labels, self.pair.mdp.actions, strict=True)
        ):
            true = "".join(name for bit, name in enumerate(ABC) if label >> bit & 1) or "-"
            told = "; ".join(
                " + ".join(f"{p}: {t}" for t, p in outcome.items()) for outcome in actions
            )
            lines.append(f"  state {state} [{true}] {told}")
        return "\n".join(lines) + "\n"


def random_pair(seed: int, number: int, patterns: bool) -> Pair:
    """The pair `number` of a series; with `patterns` one whose formula is likely to need jumps."""
    generator = random.Random(f"{seed}:{number}:{patterns}")
    if patterns:
        parts = [to_text(random_formula(generator, ABC, 4)) for _ in range(3)]
        formula = parse(generator.choice(PATTERNS).format(*parts), ABC).formula
    else:
        formula = random_formula(generator, ABC, MAX_SIZE)
    return Pair(number, formula, random_mdp(generator, len(ABC)))


def compared(pair: Pair, translations: Mapping[str, Translation] = TRANSLATIONS) -> Verdict | None:
    """Ask both sides about `pair`; None where Storm has no answer."""
    storm = storm_probability(pair.mdp, pair.formula)
    if storm is None:
        return None
    automata = {name: run(pair.formula, ABC) for name, run in translations.items()}
    return Verdict(
        pair,
        storm,
        {name: best_probability(pair.mdp, ldba) for name, ldba in automata.items()},
        max(len(ldba.jumps) for ldba in automata.values()),
    )


def storm_probability(mdp: Mdp, formula: Formula) -> float | None:
    """`Pmax` of `formula` from state 0, computed by Storm from the formula alone.

    None where Storm cannot read what its own translator has written, which happens.
    """
    process = Process(mdp.actions, letter_labels(np.array(mdp.labels), len(ABC)))
    try:
        return float(probabilities(process, storm_text(formula, ABC), [0])[0])
    except Unanswered:
        return None


@dataclass(slots=True)
class Series:
    """What a series of pairs has shown so far."""

    pairs: int = 0
    silent: int = 0
    jumping: int = 0
    between: int = 0
    worst: float = 0.0
    wrong: list[Verdict] = field(default_factory=list)

    @property
    def text(self) -> str:
        """The numbers in one line."""
        return (
            f"{self.pairs} pairs compared, {self.jumping} with jumps, {self.between} with a"
            f" probability between 0 and 1; worst difference {self.worst:.1e},"
            f" {len(self.wrong)} disagreements (no answer from Storm for {self.silent} more)"
        )


def compare(
    pairs: int,
    seed: int,
    patterns: bool,
    translations: Mapping[str, Translation] = TRANSLATIONS,
    on_wrong: Callable[[Verdict], None] = lambda verdict: None,
) -> Series:
    """Compare so many pairs of the series that `seed` begins; `on_wrong` hears of disagreements."""
    series = Series()
    for number in count():
        if series.pairs == pairs:
            return series
        verdict = compared(random_pair(seed, number, patterns), translations)
        if verdict is None:
            series.silent += 1
            continue
        series.pairs += 1
        series.jumping += bool(verdict.jumps)
        series.between += 0 < verdict.storm < 1
        series.worst = max(series.worst, verdict.difference)
        if verdict.difference > TOLERANCE:
            series.wrong.append(verdict)
            on_wrong(verdict)
    raise AssertionError("there is always another pair")


def main() -> int:
    """Run two series, random formulas and patterns; 1 if Storm and we disagree anywhere."""
    parser = argparse.ArgumentParser(description="Compare our automata with Storm.")
    parser.add_argument("--pairs", type=int, default=2000, help="of each kind of formulas")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", type=int, help="just the pairs of this number")
    given = parser.parse_args()
    wrong = False
    for kind, patterns in (("random formulas", False), ("formulas that jump", True)):
        if given.only is not None:
            verdict = compared(random_pair(given.seed, given.only, patterns))
            sys.stdout.write(verdict.text if verdict else "no answer from Storm\n")
            continue
        began = time.perf_counter()
        series = compare(given.pairs, given.seed, patterns, on_wrong=lambda v: _write(v.text))
        _write(f"{kind}: {series.text}; {time.perf_counter() - began:.0f} s\n")
        wrong = wrong or bool(series.wrong)
    return int(wrong)


def _write(text: str) -> None:
    sys.stdout.write(text)
    sys.stdout.flush()


if __name__ == "__main__":
    sys.exit(main())
