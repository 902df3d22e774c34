"""Binary decision diagrams: Boolean functions as canonical integers (Bryant, 1986).

Small and of our own on purpose: the variable order is part of the construction (propositions on
top, so that a diagram's upper part is the list of its letter sets), nodes are plain integers to
walk, and an empty manager costs nothing. `dd` gives the same functions and is the oracle in the
tests; it takes four times as long and 0.15 s to import (CUDD: 10 ms for each manager).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import NewType

from tiloilc.automaton.limits import Budget

Node = NewType("Node", int)
"""A Boolean function, as a place in its manager's table. Equal functions are equal numbers."""

FALSE = Node(0)
TRUE = Node(1)

Literals = tuple[tuple[int, bool], ...]
"""A conjunction of literals: (variable, its sign), variables ascending."""

_LEAF = 1 << 60
"""The variable of the constants: below all others."""

_NODES_PER_CHECK = 1024


class Diagrams:
    """A manager: every function here is over variables 0, 1, 2, … with 0 on top."""

    def __init__(self, budget: Budget) -> None:
        self.budget = budget
        self._table: list[tuple[int, Node, Node]] = [(_LEAF, FALSE, FALSE), (_LEAF, TRUE, TRUE)]
        self._unique: dict[tuple[int, Node, Node], Node] = {}
        self._and: dict[tuple[Node, Node], Node] = {}
        self._or: dict[tuple[Node, Node], Node] = {}
        self._not: dict[Node, Node] = {FALSE: TRUE, TRUE: FALSE}
        self._support: dict[Node, int] = {FALSE: 0, TRUE: 0}
        self._first: dict[Node, int] = {TRUE: 0}
        self._tables: dict[tuple[int, ...], dict[Node, int]] = {}
        self._covers: dict[tuple[Node, Node], tuple[Node, list[Literals]]] = {}

    def node(self, variable: int, low: Node, high: Node) -> Node:
        """`high` where `variable` is true, `low` where not; both must be below `variable`."""
        if low == high:
            return low
        key = (variable, low, high)
        found = self._unique.get(key)
        if found is None:
            found = self._unique[key] = Node(len(self._table))
            self._table.append(key)
            if found % _NODES_PER_CHECK == 0:
                self.budget.nodes(found)
        return found

    def parts(self, f: Node) -> tuple[int, Node, Node]:
        """The top variable of `f`, and `f` where it is false and where it is true."""
        return self._table[f]

    def literal(self, variable: int, sign: bool = True) -> Node:
        """One variable, or its negation."""
        return self.node(variable, FALSE, TRUE) if sign else self.node(variable, TRUE, FALSE)

    def conj(self, f: Node, g: Node) -> Node:
        """f ∧ g."""
        if f == g or g == TRUE:
            return f
        if f == TRUE:
            return g
        if f == FALSE or g == FALSE:
            return FALSE
        return self._junction(f, g, self.conj, self._and)

    def disj(self, f: Node, g: Node) -> Node:
        """f ∨ g."""
        if f == g or g == FALSE:
            return f
        if f == FALSE:
            return g
        if f == TRUE or g == TRUE:
            return TRUE
        return self._junction(f, g, self.disj, self._or)

    def _junction(
        self,
        f: Node,
        g: Node,
        operation: Callable[[Node, Node], Node],
        memo: dict[tuple[Node, Node], Node],
    ) -> Node:
        key = (f, g) if f < g else (g, f)
        result = memo.get(key)
        if result is None:
            v, f_low, f_high = self._table[f]
            w, g_low, g_high = self._table[g]
            if v == w:
                result = self.node(v, operation(f_low, g_low), operation(f_high, g_high))
            elif v < w:
                result = self.node(v, operation(f_low, g), operation(f_high, g))
            else:
                result = self.node(w, operation(f, g_low), operation(f, g_high))
            memo[key] = result
            if len(memo) % _NODES_PER_CHECK == 0:
                self.budget.look()
        return result

    def negate(self, f: Node) -> Node:
        """¬f."""
        result = self._not.get(f)
        if result is None:
            v, low, high = self._table[f]
            result = self._not[f] = self.node(v, self.negate(low), self.negate(high))
            self._not[result] = f
        return result

    def minus(self, f: Node, g: Node) -> Node:
        """f ∧ ¬g."""
        return self.conj(f, self.negate(g))

    def implies(self, f: Node, g: Node) -> bool:
        """Whether f ⟹ g everywhere."""
        return self.conj(f, g) == f

    def support(self, f: Node) -> frozenset[int]:
        """The variables that `f` depends on."""
        bits = self._support_bits(f)
        found = []
        while bits:
            lowest = bits & -bits
            found.append(lowest.bit_length() - 1)
            bits ^= lowest
        return frozenset(found)

    def _support_bits(self, f: Node) -> int:
        """The support as bits: a set for each of a million nodes would fill the memory."""
        result = self._support.get(f)
        if result is None:
            v, low, high = self._table[f]
            result = self._support_bits(low) | self._support_bits(high) | 1 << v
            self._support[f] = result
        return result

    def assign(self, f: Node, values: Mapping[int, bool]) -> Node:
        """`f` with some variables fixed."""
        memo: dict[Node, Node] = {FALSE: FALSE, TRUE: TRUE}

        def walk(g: Node) -> Node:
            result = memo.get(g)
            if result is None:
                v, low, high = self._table[g]
                if v in values:
                    result = walk(high if values[v] else low)
                else:
                    result = self.node(v, walk(low), walk(high))
                memo[g] = result
            return result

        return walk(f)

    def substitute(self, f: Node, value: Callable[[int], Node], memo: dict[Node, Node]) -> Node:
        """`f` with every variable v replaced by `value(v)`; `f` must be monotone in all of them.

        `memo` belongs to `value` and may be kept between calls.
        """
        if f <= TRUE:
            return f
        result = memo.get(f)
        if result is None:
            v, low, high = self._table[f]
            high_part = self.conj(value(v), self.substitute(high, value, memo))
            result = memo[f] = self.disj(high_part, self.substitute(low, value, memo))
        return result

    def table(self, f: Node, variables: tuple[int, ...]) -> int:
        """The truth table of `f`, which depends on `variables` only: a bit for each assignment.

        Conjunction of tables is `&`, which for a dozen variables is ten times as fast as `conj`.
        """
        memo = self._tables.setdefault(variables, {FALSE: 0, TRUE: 1})
        place = {v: i for i, v in enumerate(variables)}
        place[_LEAF] = count = len(variables)

        def own(g: Node) -> int:
            """The table over the variables from that of `g` on."""
            result = memo.get(g)
            if result is None:
                variable, low, high = self._table[g]
                under = place[variable] + 1
                result = from_on(low, under) | from_on(high, under) << (1 << count - under)
                memo[g] = result
            return result

        def from_on(g: Node, start: int) -> int:
            result = own(g)
            for i in reversed(range(start, place[self._table[g][0]])):
                result |= result << (1 << count - 1 - i)
            return result

        return from_on(f, 0)

    def some(self, f: Node, below: int) -> Node:
        """∃ of all variables under `below`."""
        v, low, high = self._table[f]
        return f if v >= below else self.disj(self.some(low, below), self.some(high, below))

    def first_letter(self, f: Node) -> int:
        """The least letter (bit i is variable i) of `f`, which is not false."""
        result = self._first.get(f)
        if result is None:
            v, low, high = self._table[f]
            with_v = self.first_letter(high) | 1 << v if high != FALSE else -1
            without = self.first_letter(low) if low != FALSE else -1
            result = max(with_v, without) if min(with_v, without) < 0 else min(with_v, without)
            self._first[f] = result
        return result

    def cover(self, f: Node, most: Node | None = None) -> list[Literals]:
        """An irredundant cover of `f` by prime implicants (Minato, 1993), in a fixed order.

        With `most`, which `f` implies, of some function between the two: what is in `most` only
        does not matter.
        """
        memo = self._covers

        def between(low: Node, up: Node) -> tuple[Node, list[Literals]]:
            """A function between `low` and `up`, and its cover."""
            if low == FALSE:
                return FALSE, []
            if up == TRUE:
                return TRUE, [()]
            key = (low, up)
            if key in memo:
                return memo[key]
            self.budget.tick()
            v = min(self._table[low][0], self._table[up][0])
            low0, low1 = self._cofactors(low, v)
            up0, up1 = self._cofactors(up, v)
            f0, cubes0 = between(self.minus(low0, up1), up0)
            f1, cubes1 = between(self.minus(low1, up0), up1)
            rest = self.disj(self.minus(low0, f0), self.minus(low1, f1))
            both, cubes = between(rest, self.conj(up0, up1))
            result = self.node(v, self.disj(f0, both), self.disj(f1, both))
            memo[key] = (
                result,
                [
                    *cubes,
                    *(((v, False), *cube) for cube in cubes0),
                    *(((v, True), *cube) for cube in cubes1),
                ],
            )
            return memo[key]

        return list(between(f, f if most is None else most)[1])

    def _cofactors(self, f: Node, variable: int) -> tuple[Node, Node]:
        v, low, high = self._table[f]
        return (low, high) if v == variable else (f, f)

    def split(
        self, functions: tuple[Node, ...], below: int, memo: dict[tuple[Node, ...], Split]
    ) -> Split:
        """What `functions` become under each assignment of the variables under `below`.

        Each different outcome with the set of assignments that lead to it. Outcomes in which
        the first function is false are left out. `memo` may be kept between calls.
        """
        found = memo.get(functions)
        if found is not None:
            return found
        self.budget.tick()
        if functions[0] == FALSE:
            return {}
        top = min(self._table[f][0] for f in functions)
        if top >= below:
            result = {functions: TRUE}
        else:
            pairs = [self._cofactors(f, top) for f in functions]
            result = {}
            for sign, branch in ((False, 0), (True, 1)):
                edge = self.literal(top, sign)
                part = self.split(tuple(pair[branch] for pair in pairs), below, memo)
                for outcome, guard in part.items():
                    full = self.conj(edge, guard)
                    result[outcome] = self.disj(result.get(outcome, FALSE), full)
        memo[functions] = result
        return result


Split = dict[tuple[Node, ...], Node]
"""Outcomes with the set of assignments of each."""
