"""The states and edges of a HOA file."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

from tiloilc.automaton.bdd import FALSE, TRUE, Diagrams, Node
from tiloilc.automaton.hoa.expressions import label_atom, label_node, postfix
from tiloilc.automaton.hoa.header import Header, check_aliases, refuse_conjunction
from tiloilc.automaton.hoa.tokens import Token, Tokens, shown, unquoted


class FileEdge(NamedTuple):
    """One edge as written, with the acceptance sets of its state; `place` is its target."""

    guard: Node
    target: int
    sets: frozenset[int]
    place: Token


@dataclass(frozen=True)
class FileState:
    """One state as written. `place` is its number; `marked`: its edges name acceptance sets."""

    place: Token
    name: str
    sets: frozenset[int]
    edges: tuple[FileEdge, ...]
    labelled: str
    marked: bool


class Body:
    """All states of one automaton, by number. Raises CompileError AUT302, AUT305, AUT306."""

    def __init__(self, tokens: Tokens, header: Header, diagrams: Diagrams) -> None:
        self.tokens = tokens
        self.header = header
        self.diagrams = diagrams
        self.states: dict[int, FileState] = {}
        while tokens.next.text == "State:":
            number, state = self._state()
            self.states[number] = state
            diagrams.budget.states(len(self.states))
        tokens.expect("section", "`State:`, an edge or `--END--`", "--END--")
        if tokens.next.text == "HOA:":
            problem = "a second automaton begins here, and one is read"
            raise tokens.error(tokens.next, problem, help="put each into a file of its own")
        if tokens.next.kind != "end":
            raise tokens.unexpected("the end of the file after `--END--`")
        self._check_numbers()

    def _state(self) -> tuple[int, FileState]:
        tokens = self.tokens
        tokens.take()
        label = self._label()
        number, place = tokens.number("a state's number")
        if number in self.states:
            raise tokens.error(place, f"state {number} is described twice")
        name = unquoted(tokens.take()) if tokens.next.kind == "string" else ""
        sets = self._sets()
        wanted = 1 << len(self.header.bits)
        edges: list[FileEdge] = []
        labels: list[bool] = []
        marked = False
        while tokens.at("[") or tokens.next.kind == "int":
            begin = tokens.next
            guard = self._label()
            labels.append(guard is not None)
            if label is not None and guard is not None:
                raise tokens.error(begin, f"state {number} has a label, so its edges must not")
            if labels[-1] != labels[0]:
                problem = f"either all edges of state {number} have labels, or none"
                raise tokens.error(begin, problem)
            if guard is None:
                guard = label if label is not None else TRUE
            target, at = tokens.number("a state's number")
            refuse_conjunction(tokens, at, "an edge leads to several states at once")
            own = self._sets()
            marked |= bool(own)
            edges.append(FileEdge(guard, target, own | sets, at))
            if label is None and not labels[0] and len(edges) > wanted:
                problem = f"state {number} has no labels, so {wanted} edges, but more are listed"
                raise tokens.error(begin, problem, help="write labels such as `[0 & !1]`")
        labelled = "state" if label is not None else "edge" if any(labels) else "none"
        if labelled == "none" and edges and len(edges) != wanted:
            problem = (
                f"state {number} has no labels, so {wanted} edges, but {len(edges)} are listed"
            )
            raise tokens.error(place, problem, help="list one for each letter, or write labels")
        if labelled == "none":
            edges = self._of_letters(edges)
        return number, FileState(place, name, sets, tuple(edges), labelled, marked)

    def _label(self) -> Node | None:
        tokens = self.tokens
        if not tokens.at("["):
            return None
        tokens.take()
        label = postfix(tokens, label_atom, negation=True)
        check_aliases(label, tokens, self.header.aliases)
        tokens.expect("sign", "`&`, `|` or `]`", "]")
        return label_node(
            label, self.diagrams, lambda t: self.header.letters(t, tokens, self.diagrams)
        )

    def _of_letters(self, edges: list[FileEdge]) -> list[FileEdge]:
        """The edges of a state without labels: the n-th is for the letter n."""
        together: dict[tuple[int, frozenset[int]], list[int]] = {}
        for letter, edge in enumerate(edges):
            together.setdefault((edge.target, edge.sets), []).append(letter)
        order = sorted((bit, number) for number, bit in enumerate(self.header.bits))
        return [
            edges[letters[0]]._replace(guard=self._letters(letters, order))
            for letters in together.values()
        ]

    def _letters(self, letters: list[int], order: list[tuple[int, int]]) -> Node:
        """A set of letters of the file, by the propositions in `order`: (variable, number)."""
        self.diagrams.budget.tick()
        if len(letters) >> len(order):
            return TRUE
        if not letters:
            return FALSE
        (variable, number), *below = order
        parts: tuple[list[int], list[int]] = ([], [])
        for letter in letters:
            parts[letter >> number & 1].append(letter)
        low, high = (self._letters(part, below) for part in parts)
        return self.diagrams.node(variable, low, high)

    def _sets(self) -> frozenset[int]:
        """`{0 2}`, the acceptance sets of a state or an edge; none if there are no braces."""
        tokens = self.tokens
        if not tokens.at("{"):
            return frozenset()
        tokens.take()
        found = set()
        while tokens.next.kind == "int":
            number, token = tokens.number("an acceptance set")
            if number >= self.header.sets:
                declared = self.header.sets
                problem = f"there is no acceptance set {number}: {declared} are declared"
                raise tokens.error(token, problem)
            found.add(number)
        tokens.expect("sign", "the number of an acceptance set, or `}`", "}")
        return frozenset(found)

    def _check_numbers(self) -> None:
        """States are numbered from 0, each is described, and nothing leads elsewhere."""
        count = self.header.states
        for number, state in self.states.items():
            if count is not None and number >= count:
                problem = f"there is no state {number}: `States:` says {count:_}"
                raise self.tokens.error(state.place, problem)
        used = dict(self.header.starts)
        for state in self.states.values():
            for edge in state.edges:
                used.setdefault(edge.target, edge.place)
        for number, place in used.items():
            if number not in self.states:
                raise self.tokens.error(place, f"there is no `State: {number}`")
        if count is not None and len(self.states) != count:
            missing = next(n for n in range(count) if n not in self.states)
            problem = f"`States:` says {count:_}, but there is no `State: {missing}`"
            raise self.tokens.error(self.tokens.next, problem)


def check_claims(body: Body) -> None:
    """Raise CompileError AUT302 for a word behind `properties:` that the automaton contradicts.

    Only what can be seen without asking about the language. Unknown words mean nothing to us.
    """
    states = body.states.values()
    holds: dict[str, Callable[[], bool]] = {
        "state-labels": lambda: all(s.labelled == "state" for s in states),
        "trans-labels": lambda: all(s.labelled != "state" for s in states),
        "implicit-labels": lambda: all(s.labelled == "none" for s in states),
        "explicit-labels": lambda: all(s.labelled != "none" or not s.edges for s in states),
        "state-acc": lambda: not any(s.marked for s in states),
        "trans-acc": lambda: not any(s.sets for s in states),
        "univ-branch": lambda: False,
        "no-univ-branch": lambda: True,
        "deterministic": lambda: (
            len(body.header.starts) <= 1 and all(_deterministic(s, body.diagrams) for s in states)
        ),
        "complete": lambda: bool(states) and all(_complete(s, body.diagrams) for s in states),
    }
    for claim in body.header.claims:
        if claim.text in holds and not holds[claim.text]():
            problem = f"`properties:` says `{shown(claim)}`, which is not so"
            help = f"remove `{shown(claim)}`"
            raise body.tokens.error(claim, problem, label="not so", help=help)


def _deterministic(state: FileState, diagrams: Diagrams) -> bool:
    """Whether no letter leads to two places, or to one in two ways."""
    together: dict[tuple[int, frozenset[int]], Node] = {}
    for edge in state.edges:
        key = (edge.target, edge.sets)
        together[key] = diagrams.disj(together.get(key, FALSE), edge.guard)
    seen = FALSE
    for guard in together.values():
        if diagrams.conj(seen, guard) != FALSE:
            return False
        seen = diagrams.disj(seen, guard)
    return True


def _complete(state: FileState, diagrams: Diagrams) -> bool:
    union = FALSE
    for edge in state.edges:
        union = diagrams.disj(union, edge.guard)
    return union == TRUE
