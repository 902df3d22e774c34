"""Random automata as HOA text, in all of the format's forms, with what they accept.

The text and the meaning are made side by side from one list of edges, so that the meaning owes
nothing to any reader.
"""

from __future__ import annotations

import random
from collections.abc import Sequence
from dataclasses import dataclass

from tiloilc.ltl import Lasso

Letters = frozenset[int]


@dataclass(frozen=True)
class RandomEdge:
    """An edge on a set of letters, in some acceptance sets."""

    source: int
    target: int
    letters: Letters
    sets: frozenset[int]


@dataclass(frozen=True)
class RandomAutomaton:
    """`edges` with the sets of their states. Accepting: each of `required` visited for ever.

    A requirement (n, outside) is set n, or the edges outside it.
    """

    propositions: tuple[str, ...]
    states: int
    starts: tuple[int, ...]
    edges: tuple[RandomEdge, ...]
    required: tuple[tuple[int, bool], ...]

    def accepts(self, lasso: Lasso) -> bool:
        """Whether some run visits all that is required for ever: by components, all alone."""
        letters, back = lasso.letters, len(lasso.stem)
        moves: dict[tuple[int, int], list[tuple[tuple[int, int], frozenset[int]]]] = {}
        for q in range(self.states):
            for i, letter in enumerate(letters):
                following = i + 1 if i + 1 < len(letters) else back
                moves[q, i] = [
                    ((e.target, following), e.sets)
                    for e in self.edges
                    if e.source == q and letter in e.letters
                ]
        reach = {place: _reach(moves, place) for place in moves}
        for place in {p for q in self.starts for p in {(q, 0), *reach[q, 0]}}:
            together = [p for p in reach[place] if place in reach[p]]
            inside = [s for p in together for t, s in moves[p] if t in together]
            if inside and all(
                any((n in sets) != outside for sets in inside) for n, outside in self.required
            ):
                return True
        return False


def _reach(
    moves: dict[tuple[int, int], list[tuple[tuple[int, int], frozenset[int]]]],
    start: tuple[int, int],
) -> set[tuple[int, int]]:
    """The places after at least one step."""
    found: set[tuple[int, int]] = set()
    work = [start]
    while work:
        for target, _ in moves[work.pop()]:
            if target not in found:
                found.add(target)
                work.append(target)
    return found


def random_automaton(
    generator: random.Random, *, free: int = 3, fixed: int = 4, sets: int = 2
) -> tuple[RandomAutomaton, str]:
    """An automaton that chooses in `free` states at most, and never in `fixed` ones; its text.

    Only fixed states are in acceptance sets, so it is limit-deterministic. States are shuffled.
    """
    propositions = ("a", "b", "c")[: generator.randint(1, 3)]
    every = range(2 ** len(propositions))
    n_free, n_fixed = generator.randint(0, free), generator.randint(1, fixed)
    count, n_sets = n_free + n_fixed, generator.randint(1, sets)
    number = generator.sample(range(count), count)
    on_states = generator.random() < 0.5
    outside = [on_states is False and generator.random() < 0.2 for _ in range(n_sets)]
    marks = [_marks(generator, n_sets) for _ in range(count)]
    edges = []
    for q in range(count):
        for letter in every:
            targets = [n_free + generator.randrange(n_fixed)] if generator.random() < 0.8 else []
            if q < n_free:
                targets = generator.sample(range(count), generator.randint(0, min(3, count)))
            for target in targets:
                own = marks[q] if on_states else _marks(generator, n_sets)
                if q < n_free:
                    own = frozenset(n for n in range(n_sets) if outside[n])
                edges.append(RandomEdge(number[q], number[target], frozenset({letter}), own))
    starts = generator.sample(range(count), generator.choice((1, 1, 1, min(2, count))))
    automaton = RandomAutomaton(
        propositions,
        count,
        tuple(number[q] for q in starts),
        tuple(edges),
        tuple((n, outside[n]) for n in range(n_sets)),
    )
    state_marks = {
        number[q]: marks[q] if on_states and q >= n_free else frozenset() for q in range(count)
    }
    return automaton, _text(generator, automaton, state_marks if on_states else None)


def _marks(generator: random.Random, sets: int) -> frozenset[int]:
    return frozenset(n for n in range(sets) if generator.random() < 0.4)


def _text(
    generator: random.Random,
    automaton: RandomAutomaton,
    state_marks: dict[int, frozenset[int]] | None,
) -> str:
    count = len(automaton.propositions)
    required = " & ".join(f"Inf({'!' if out else ''}{n})" for n, out in automaton.required)
    quoted = " ".join(f'"{name}"' for name in automaton.propositions)
    header = [
        *(f"Start: {q}" for q in automaton.starts),
        f"AP: {count} {quoted}",
        f"Acceptance: {len(automaton.required)} {required}",
        *(["Alias: @x 0", "Alias: @yes t"] if generator.random() < 0.3 else []),
        *([f"States: {automaton.states}"] if generator.random() < 0.7 else []),
        *(['tool: "random" "1"', "remark: 3 x"] if generator.random() < 0.3 else []),
    ]
    generator.shuffle(header)
    aliases = any(line.startswith("Alias: @x") for line in header)
    lines = ["HOA: v1", *header, "--BODY--"]
    for q in generator.sample(range(automaton.states), automaton.states):
        own = [e for e in automaton.edges if e.source == q]
        name = f' "number {q}"' if generator.random() < 0.5 else ""
        marks = state_marks[q] if state_marks is not None else frozenset()
        each = all(sum(x in e.letters for e in own) == 1 for x in range(2**count))
        if each and generator.random() < 0.4:
            ordered = sorted(own, key=lambda e: min(e.letters))
            lines.append(f"State: {q}{name}{_sets(marks)}")
            lines += [f"{e.target}{_sets(e.sets - marks)}" for e in ordered]
            continue
        letters = {frozenset().union(*(e.letters for e in own if e.target == t)) for t in _to(own)}
        same = {e.sets for e in own} <= {marks}
        if own and same and len(letters) == 1 and generator.random() < 0.5:
            label = _label(generator, letters.pop(), count, aliases)
            lines.append(f"State: [{label}] {q}{name}{_sets(marks)} /* for all */")
            lines += [f"{target}" for target in _to(own)]
            continue
        lines.append(f"State: {q}{name}{_sets(marks)}")
        for target, sets in sorted({(e.target, e.sets) for e in own}, key=str):
            guard = frozenset().union(
                *(e.letters for e in own if (e.target, e.sets) == (target, sets))
            )
            label = _label(generator, guard, count, aliases)
            lines.append(f"[{label}] {target}{_sets(sets - marks)}")
    return "\n".join([*lines, "--END--", ""])


def _to(edges: Sequence[RandomEdge]) -> list[int]:
    return sorted({e.target for e in edges})


def _sets(sets: frozenset[int]) -> str:
    return f" {{{' '.join(map(str, sorted(sets)))}}}" if sets else ""


def _label(generator: random.Random, letters: Letters, count: int, aliases: bool) -> str:
    """A formula for a set of letters, sometimes turned round."""
    others = frozenset(range(2**count)) - letters
    if not others:
        return "@yes" if aliases else "t"
    if generator.random() < 0.3:
        return f"!({_sum(others, count, aliases)})" if others else "t"
    return _sum(letters, count, aliases)


def _sum(letters: Letters, count: int, aliases: bool) -> str:
    products = []
    for letter in sorted(letters):
        literals = [f"{'' if letter >> i & 1 else '!'}{i}" for i in range(count)]
        if aliases:
            literals[0] = literals[0].replace("0", "@x")
        products.append("&".join(literals))
    return " | ".join(products) or "f"
