"""The lasso oracle: formula and automaton agree on random words u·v^ω, after every single pass.

What LTL means on such a word is computed directly (`tiloilc.ltl.holds`), and so is, here, what an
automaton makes of it. The passes are those that run: each rule of `simplify` and each reduction is
watched while the package does its work, so that a new one is looked at without being named here.

    python -m tests.properties.lasso --examples 200000 --seed 1
"""

from __future__ import annotations

import argparse
import importlib
import random
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from types import ModuleType
from unittest.mock import patch

from tests.automaton.hoa_reader import Hoa, read_hoa
from tests.properties.variants import Translation, variants
from tests.strategies import random_formula, random_lasso
from tiloilc.automaton import Acceptance, Ldba, accepts, from_hoa, to_hoa
from tiloilc.automaton.bdd import FALSE, TRUE, Diagrams, Node
from tiloilc.automaton.draft import Draft
from tiloilc.automaton.finish import draft_of, with_edge_acceptance
from tiloilc.automaton.limits import Budget
from tiloilc.diag import CompileError
from tiloilc.ltl import Lasso, after, holds, negation, nnf, parse, simplify, to_text, unfold
from tiloilc.ltl.ast import Formula, Not

NAMES = ("a", "b", "c", "d")
MAX_SIZE = 16

translating = importlib.import_module("tiloilc.automaton.translate")
importing = importlib.import_module("tiloilc.automaton.hoa.read")
reducing = importlib.import_module("tiloilc.automaton.reduction.reduce")
rewriting = importlib.import_module("tiloilc.ltl.rewrite.driver")
"""The modules whose functions are watched."""


@dataclass(frozen=True, slots=True)
class Words:
    """Some words, and all that the oracle says of them."""

    lassos: tuple[Lasso, ...]
    names: tuple[str, ...]

    def truth(self, formula: Formula) -> list[bool]:
        """Which words satisfy `formula`."""
        return [holds(formula, lasso, self.names) for lasso in self.lassos]

    @property
    def letters(self) -> list[int]:
        """The letters that appear."""
        return sorted({letter for lasso in self.lassos for letter in lasso.letters})


@dataclass(frozen=True, slots=True)
class Machine:
    """A nondeterministic Büchi automaton; sets of states are bits.

    `steps[letter][q]` are the states that q leads to, and those it leads to over a mark.
    """

    initial: int
    steps: dict[int, list[tuple[int, int]]]

    def accepts(self, lasso: Lasso) -> bool:
        """Whether one can go round the loop for ever, over a mark again and again."""
        now = 1 << self.initial
        for letter in lasso.stem:
            now = self._after(now, letter)
        rounds: dict[int, tuple[int, int]] = {}
        while now:
            q = now.bit_length() - 1
            rounds[q] = self._round(q, lasso.loop)
            now = (now | rounds[q][0]) & ~sum(1 << known for known in rounds)
        reach = {q: plain | 1 << q for q, (plain, _) in rounds.items()}
        for middle in reach:
            for q in reach:
                if reach[q] >> middle & 1:
                    reach[q] |= reach[middle]
        return any(reach[t] >> q & 1 for q, (_, marked) in rounds.items() for t in _bits(marked))

    def _after(self, states: int, letter: int) -> int:
        reached = 0
        for q in _bits(states):
            reached |= self.steps[letter][q][0]
        return reached

    def _round(self, state: int, loop: tuple[int, ...]) -> tuple[int, int]:
        """Where one round leads to from `state`, and where to with a mark on the way."""
        plain, marked = 1 << state, 0
        for letter in loop:
            over_mark = self._after(marked, letter)
            for q in _bits(plain):
                over_mark |= self.steps[letter][q][1]
            plain, marked = self._after(plain, letter), over_mark
        return plain, marked


def _bits(states: int) -> Iterator[int]:
    while states:
        low = states & -states
        yield low.bit_length() - 1
        states ^= low


Pass = Callable[[Draft, Diagrams], Draft]

Edges = list[tuple[int, bool, Callable[[int], bool]]]
"""Target, whether marked, whether a letter is read."""


def machine(
    initial: int, states: Sequence[Edges], jumps: Sequence[Sequence[int]], words: Words
) -> Machine:
    """The machine over the letters of `words`; what a jump's target reads its source reads too."""
    steps = {}
    for letter in words.letters:
        own = []
        for edges in states:
            plain = marked = 0
            for target, mark, reads in edges:
                if reads(letter):
                    plain |= 1 << target
                    marked |= mark << target
            own.append((plain, marked))
        steps[letter] = [
            (
                _union(own[q][0] for q in (state, *jumps[state])),
                _union(own[q][1] for q in (state, *jumps[state])),
            )
            for state in range(len(own))
        ]
    return Machine(initial, steps)


def _union(sets: Iterator[int]) -> int:
    union = 0
    for states in sets:
        union |= states
    return union


def of_draft(draft: Draft, diagrams: Diagrams, words: Words) -> Machine:
    """A draft, its diagrams asked for each letter."""

    def reader(guard: Node) -> Callable[[int], bool]:
        def reads(letter: int) -> bool:
            node = guard
            while node not in (FALSE, TRUE):
                variable, low, high = diagrams.parts(node)
                node = high if letter >> variable & 1 else low
            return node == TRUE

        return reads

    states: list[Edges] = [
        [(target, mark, reader(guard)) for (target, mark), guard in row.items()]
        for row in draft.rows
    ]
    return machine(draft.initial, states, draft.jumps, words)


def of_ldba(ldba: Ldba, words: Words) -> Machine:
    """An LDBA, its cubes asked for each letter; marks of states are put on edges into them."""

    def reader(index: int) -> Callable[[int], bool]:
        return lambda letter: any(letter & c.mask == c.value for c in ldba.edges[index].guard)

    states: list[Edges] = [[] for _ in ldba.names]
    for index, edge in enumerate(ldba.edges):
        mark = index in ldba.accepting_edges or edge.target in ldba.accepting
        states[edge.source].append((edge.target, mark, reader(index)))
    jumps: list[list[int]] = [[] for _ in ldba.names]
    for source, target in ldba.jumps:
        jumps[source].append(target)
    return machine(ldba.initial, states, jumps, words)


def of_hoa(hoa: Hoa, words: Words) -> Machine:
    """What the strict reader has read."""
    states: list[Edges] = [
        [(target, mark, guard.__contains__) for guard, target, mark in hoa.edges[state]]
        for state in sorted(hoa.edges)
    ]
    return machine(hoa.start, states, [()] * len(states), words)


@dataclass(slots=True)
class Check:
    """One formula on its way through all passes; `seen` counts what has been looked at."""

    formula: Formula
    words: Words
    seen: Counter[str] = field(default_factory=Counter)
    wrong: list[str] = field(default_factory=list)
    truth: list[bool] = field(default_factory=list)

    def everything(self) -> list[str]:
        """The passes after which a word is judged differently: none, if all is well."""
        self.truth = self.words.truth(self.formula)
        self._formulas()
        self._rules()
        for name, run in variants().items():
            self._automata(name, run)
        return self.wrong

    def _judge(self, name: str, found: list[bool], expected: list[bool] | None = None) -> None:
        self.seen[name] += len(found)
        if found != (self.truth if expected is None else expected):
            self.wrong.append(name)

    def _formulas(self) -> None:
        formula, words = self.formula, self.words
        normal = nnf(formula)
        for name, other in (
            ("parse(to_text)", parse(to_text(formula), words.names).formula),
            ("parse(to_text with brackets)", parse(to_text(formula, brackets=True)).formula),
            ("nnf", normal),
            ("not negation", Not(negation(formula))),
            ("unfold", unfold(normal)),
        ):
            self._judge(name, words.truth(other))
        found = []
        for lasso in words.lassos:
            first = frozenset(n for bit, n in enumerate(words.names) if lasso.letters[0] >> bit & 1)
            found.append(holds(after(normal, first), lasso.suffix(1), words.names))
        self._judge("after", found)

    def _rules(self) -> None:
        """Every application of every rule, wherever `simplify` makes one."""
        steps: dict[tuple[str, Formula, Formula], None] = {}

        def watched(rule: Callable[[Formula], Formula]) -> Callable[[Formula], Formula]:
            def run(part: Formula) -> Formula:
                changed = rule(part)
                if changed is not part and changed != part:
                    steps.setdefault((rule.__name__, part, changed))
                return changed

            return run

        with patch.object(rewriting, "RULES", tuple(map(watched, rewriting.RULES))):
            simple = simplify(self.formula)
        for name, part, changed in steps:
            expected = self.words.truth(part)
            self._judge(f"rule {name}", self.words.truth(changed), expected)
        self._judge("simplify", self.words.truth(simple))

    def _automata(self, variant: str, run: Translation) -> None:
        """Every draft that is built on the way, the automaton, and what is written of it."""
        words = self.words
        with self._watched(translating, "construction"):
            ldba = run(self.formula, words.names)
        text = to_hoa(ldba)
        diagrams = Diagrams(Budget())
        machines = {
            "automaton": of_ldba(ldba, words),
            "HOA": of_hoa(read_hoa(text), words),
            "HOA without sink": of_hoa(read_hoa(to_hoa(ldba, complete=False)), words),
            "draft again": of_draft(draft_of(ldba, diagrams), diagrams, words),
            "marked edges again": of_ldba(with_edge_acceptance(ldba), words),
        }
        for name, found in machines.items():
            self._judge(f"{name}, {variant}", list(map(found.accepts, words.lassos)))
        self._judge(f"accepts, {variant}", [accepts(ldba, lasso) for lasso in words.lassos])
        acceptance: Acceptance = "edge" if ldba.accepting_edges else "state"
        try:
            with self._watched(importing, "HOA as read"):
                again = from_hoa(text, words.names, acceptance=acceptance)
        except CompileError:
            self.wrong.append(f"HOA in, {variant}")
        else:
            found = of_ldba(again, words)
            self._judge(f"HOA in, {variant}", list(map(found.accepts, words.lassos)))

    @contextmanager
    def _watched(self, module: ModuleType, first: str) -> Iterator[None]:
        """Look at every draft that `module` has reduced: as it comes, and after each pass."""
        last: list[object] = []

        def look(name: str, draft: Draft, diagrams: Diagrams) -> Draft:
            shape = (diagrams, draft.rows, draft.jumps, draft.initial)
            if last != [shape]:
                last[:] = [shape]
                found = of_draft(draft, diagrams, self.words)
                self._judge(name, list(map(found.accepts, self.words.lassos)))
            return draft

        def watched(step: Pass) -> Pass:
            name = f"pass {step.__name__}"
            return lambda draft, diagrams: look(name, step(draft, diagrams), diagrams)

        original: Pass = module.reduce
        with (
            patch.object(reducing, "PASSES", tuple(map(watched, reducing.PASSES))),
            patch.object(module, "reduce", lambda d, dd: original(look(first, d, dd), dd)),
        ):
            yield


def random_check(seed: int, number: int, words: int, max_size: int = MAX_SIZE) -> Check:
    """The check `number` of a series: a formula over 1 to 4 propositions, and so many words."""
    generator = random.Random(f"{seed}:{number}")
    names = NAMES[: generator.choice((1, 2, 3, 3, 4, 4))]
    formula = random_formula(generator, names, max_size)
    lassos = tuple(random_lasso(generator, names) for _ in range(words))
    return Check(formula, Words(lassos, names))


def main() -> int:
    """Check a seeded series of examples, a formula and a word each; 1 if a pass was wrong."""
    parser = argparse.ArgumentParser(description="Compare all passes with LTL on lasso words.")
    parser.add_argument("--examples", type=int, default=200_000)
    parser.add_argument("--words", type=int, default=8, help="examples with the same formula")
    parser.add_argument("--max-size", type=int, default=MAX_SIZE)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", type=int, help="just the formula of this number")
    given = parser.parse_args()
    seen: Counter[str] = Counter()
    began = time.perf_counter()
    failed = true = 0
    numbers = range(-(-given.examples // given.words)) if given.only is None else [given.only]
    for number in numbers:
        check = random_check(given.seed, number, given.words, given.max_size)
        if check.everything():
            failed += 1
            first = f"{check.wrong[0]}, and {len(check.wrong) - 1} after it"
            sys.stdout.write(f"formula {number}: {to_text(check.formula)}: {first}\n")
            sys.stdout.flush()
        seen += check.seen
        true += sum(check.truth)
        if number % 500 == 499:
            took = time.perf_counter() - began
            sys.stderr.write(f"{number + 1} of {len(numbers)} formulas, {took:.0f} s\n")
    for name, count in seen.items():
        sys.stdout.write(f"{count:>9}  {name}\n")
    sys.stdout.write(
        f"{len(numbers) * given.words} examples ({true} true), {len(numbers)} formulas,"
        f" {sum(seen.values())} judgements, {failed} formulas with a wrong pass,"
        f" {time.perf_counter() - began:.0f} s\n"
    )
    return int(failed > 0)


if __name__ == "__main__":
    sys.exit(main())
