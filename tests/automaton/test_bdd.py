"""Diagrams: the same functions as truth tables and as the `dd` package."""

from __future__ import annotations

import random
from itertools import product

import dd.autoref as dd
import pytest

from tiloilc.automaton.bdd import FALSE, TRUE, Diagrams, Node
from tiloilc.automaton.limits import Budget
from tiloilc.diag import CompileError

SIZE = 5
LETTERS = [tuple(bits) for bits in product((False, True), repeat=SIZE)]


def random_function(generator: random.Random, diagrams: Diagrams, depth: int = 5) -> Node:
    if depth == 0:
        return diagrams.literal(generator.randrange(SIZE), generator.random() < 0.5)
    left = random_function(generator, diagrams, depth - 1)
    right = random_function(generator, diagrams, depth - 1)
    return generator.choice((diagrams.conj, diagrams.disj, diagrams.minus))(left, right)


def table(diagrams: Diagrams, node: Node) -> list[bool]:
    values = []
    for letter in LETTERS:
        here = node
        while here > TRUE:
            variable, low, high = diagrams.parts(here)
            here = high if letter[variable] else low
        values.append(here == TRUE)
    return values


def test_operations_agree_with_truth_tables() -> None:
    generator = random.Random("tables")
    diagrams = Diagrams(Budget())
    for _ in range(200):
        f, g = (random_function(generator, diagrams) for _ in range(2))
        ft, gt = table(diagrams, f), table(diagrams, g)
        pairs = list(zip(ft, gt, strict=True))
        assert table(diagrams, diagrams.conj(f, g)) == [a and b for a, b in pairs]
        assert table(diagrams, diagrams.disj(f, g)) == [a or b for a, b in pairs]
        assert table(diagrams, diagrams.negate(f)) == [not a for a in ft]
        assert diagrams.implies(f, g) == all(b or not a for a, b in pairs)
        assert (f == g) == (ft == gt), "equal functions are equal numbers"


def test_assigning_fixes_variables() -> None:
    generator = random.Random("assign")
    diagrams = Diagrams(Budget())
    for _ in range(100):
        f = random_function(generator, diagrams)
        values = {v: generator.random() < 0.5 for v in generator.sample(range(SIZE), 2)}
        fixed = table(diagrams, diagrams.assign(f, values))
        for letter, value in zip(LETTERS, fixed, strict=True):
            changed = tuple(values.get(v, bit) for v, bit in enumerate(letter))
            assert value == table(diagrams, f)[LETTERS.index(changed)]


def test_a_cover_is_the_function_and_no_cube_can_go_or_grow() -> None:
    generator = random.Random("cover")
    diagrams = Diagrams(Budget())

    def union(cubes: list[tuple[tuple[int, bool], ...]]) -> Node:
        result = FALSE
        for cube in cubes:
            product_ = TRUE
            for variable, sign in cube:
                product_ = diagrams.conj(product_, diagrams.literal(variable, sign))
            result = diagrams.disj(result, product_)
        return result

    for _ in range(100):
        f = random_function(generator, diagrams)
        cubes = diagrams.cover(f)
        assert union(cubes) == f
        for i, cube in enumerate(cubes):
            assert union(cubes[:i] + cubes[i + 1 :]) != f
            for j in range(len(cube)):
                assert not diagrams.implies(union([cube[:j] + cube[j + 1 :]]), f)


def test_the_first_letter_is_the_least_one() -> None:
    generator = random.Random("first")
    diagrams = Diagrams(Budget())
    for _ in range(100):
        f = random_function(generator, diagrams)
        true = [letter for letter, value in zip(LETTERS, table(diagrams, f), strict=True) if value]
        if true:
            numbers = [sum(bit << v for v, bit in enumerate(letter)) for letter in true]
            assert diagrams.first_letter(f) == min(numbers)


def test_splitting_lists_every_outcome_with_its_letters() -> None:
    generator = random.Random("split")
    diagrams = Diagrams(Budget())
    for _ in range(100):
        functions = tuple(random_function(generator, diagrams) for _ in range(2))
        outcomes = diagrams.split(functions, 3, {})
        for bits in product((False, True), repeat=3):
            values = dict(enumerate(bits))
            fixed = tuple(diagrams.assign(f, values) for f in functions)
            found = [o for o, guard in outcomes.items() if diagrams.assign(guard, values) == TRUE]
            assert found == ([] if fixed[0] == FALSE else [fixed])


def test_the_dd_package_gives_the_same_functions() -> None:
    generator = random.Random("dd")
    for _ in range(40):
        state = generator.getstate()
        diagrams = Diagrams(Budget())
        ours = random_function(generator, diagrams, 4)
        generator.setstate(state)
        other = dd.BDD()
        other.declare(*(f"v{i}" for i in range(SIZE)))
        theirs = _same_in_dd(generator, other, 4)
        values = [
            other.let({f"v{v}": bit for v, bit in enumerate(letter)}, theirs) == other.true
            for letter in LETTERS
        ]
        assert table(diagrams, ours) == values


def _same_in_dd(generator: random.Random, manager, depth: int):  # type: ignore[no-untyped-def]
    if depth == 0:
        literal = manager.var(f"v{generator.randrange(SIZE)}")
        return literal if generator.random() < 0.5 else ~literal
    left = _same_in_dd(generator, manager, depth - 1)
    right = _same_in_dd(generator, manager, depth - 1)
    choice = generator.choice(range(3))
    return (left & right, left | right, left & ~right)[choice]


def test_too_many_nodes_are_an_error() -> None:
    diagrams = Diagrams(Budget(max_states=1))
    generator = random.Random("nodes")

    def fill() -> None:
        for _ in range(10_000):
            f = TRUE
            for variable in generator.sample(range(60), 30):
                f = diagrams.conj(f, diagrams.literal(variable, generator.random() < 0.5))

    with pytest.raises(CompileError, match="memory"):
        fill()


def test_a_single_long_operation_looks_at_the_clock() -> None:
    """Nodes, and pairs that are met again, are counted between two rounds of a loop."""
    diagrams = Diagrams(Budget(timeout=0.0))

    def crossed(pairs: int) -> Node:
        result = FALSE
        for v in range(pairs):
            both = diagrams.conj(diagrams.literal(v), diagrams.literal(v + pairs))
            result = diagrams.disj(result, both)
        return result

    with pytest.raises(CompileError, match="not done after"):
        crossed(14)
    assert diagrams.budget.ticks <= 2, "sixteen thousand nodes would be sixteen ticks"
