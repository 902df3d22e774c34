"""HOA v1 out: the format that tools for ω-automata exchange (Babiak et al., CAV 2015)."""

from __future__ import annotations

from dataclasses import dataclass, replace

from tiloilc.automaton.bdd import FALSE, TRUE, Diagrams, Node
from tiloilc.automaton.draft import components, reachable
from tiloilc.automaton.finish import cubes, with_edge_acceptance
from tiloilc.automaton.guards import as_diagram
from tiloilc.automaton.ldba import Ldba
from tiloilc.automaton.limits import Budget
from tiloilc.automaton.translate import Acceptance


def to_hoa(
    ldba: Ldba,
    *,
    name: str = "",
    complete: bool = True,
    acceptance: Acceptance | None = None,
    state_names: bool = True,
) -> str:
    """`ldba` as HOA v1 text, ε-jumps expanded: a state has its jump targets' edges too.

    `name` is the automaton's `name:`. `complete=False` leaves the sink out. `acceptance` is that
    of `ldba` unless given; state-based acceptance can be written on edges (which merges the
    states that then agree), the other way round is for `translate`.
    """
    wanted = acceptance or ("edge" if ldba.accepting_edges else "state")
    assert wanted == "edge" or not ldba.accepting_edges, "translate with acceptance='state'"
    if wanted == "edge":
        ldba = with_edge_acceptance(ldba)
    return _Writer(ldba, edges=wanted == "edge", complete=complete).text(name, state_names)


@dataclass(frozen=True, slots=True)
class _Line:
    """One edge of the text."""

    guard: Node
    target: int
    mark: bool


class _Writer:
    """One automaton on its way to text."""

    def __init__(self, ldba: Ldba, *, edges: bool, complete: bool) -> None:
        self.edges = edges
        self.diagrams = Diagrams(Budget())
        kept = [q for q in ldba.states if complete or q != ldba.sink or q == ldba.initial]
        self.ldba = ldba if len(kept) == len(ldba.names) else _without_sink(ldba)
        graph = [
            [e.target for e in row] + list(targets)
            for row, targets in zip(self.ldba.outgoing, self.ldba.jump_targets, strict=True)
        ]
        self.component = components(graph)
        self.rows = [self._row(q) for q in self.ldba.states]
        sink = self.ldba.sink
        if sink and not any(line.target == sink for row in self.rows[:sink] for line in row):
            self.ldba, self.rows = _without_sink(self.ldba), self.rows[:sink]

    def _row(self, state: int) -> list[_Line]:
        """The edges of `state` with those of its jumps, one line for each target and mark."""
        together: dict[tuple[int, bool], Node] = {}
        sources = (state, *self.ldba.jump_targets[state])
        for source in sources:
            for index in self.ldba.outgoing_indices[source]:
                edge = self.ldba.edges[index]
                if source != state and edge.target == self.ldba.sink:
                    continue
                inside = self.component[state] == self.component[edge.target]
                key = (edge.target, inside and index in self.ldba.accepting_edges)
                guard = as_diagram(self.diagrams, edge.guard)
                together[key] = self.diagrams.disj(together.get(key, FALSE), guard)
        if len(sources) > 1 and self.ldba.sink is not None:
            self._shrink_sink(together)
        first = self.diagrams.first_letter
        lines = [_Line(guard, target, mark) for (target, mark), guard in together.items()]
        return sorted(lines, key=lambda line: (first(line.guard), line.target, line.mark))

    def _shrink_sink(self, together: dict[tuple[int, bool], Node]) -> None:
        """Only letters on which nothing else is possible lead to the sink."""
        assert self.ldba.sink is not None
        left = together.pop((self.ldba.sink, False), FALSE)
        for guard in together.values():
            left = self.diagrams.minus(left, guard)
        if left != FALSE:
            together[self.ldba.sink, False] = left

    def text(self, name: str, state_names: bool) -> str:
        ldba = self.ldba
        lines = ["HOA: v1"]
        if name:
            lines.append(f"name: {_quoted(name)}")
        lines += [
            'tool: "tiloilc"',
            f"States: {len(ldba.names)}",
            f"Start: {ldba.initial}",
            " ".join(["AP:", str(len(ldba.propositions)), *map(_quoted, ldba.propositions)]),
            "acc-name: Buchi",
            "Acceptance: 1 Inf(0)",
            f"properties: {' '.join(self.properties())}",
            "--BODY--",
        ]
        for state in ldba.states:
            label = f" {_quoted(ldba.names[state])}" if state_names else ""
            mark = " {0}" if state in ldba.accepting else ""
            lines.append(f"State: {state}{label}{mark}")
            for line in self.rows[state]:
                mark = " {0}" if line.mark else ""
                lines.append(f"[{self._label(line.guard)}] {line.target}{mark}")
        return "\n".join([*lines, "--END--", ""])

    def properties(self) -> list[str]:
        """What is true of the automaton as written, in the words of the format."""
        deterministic = [self._deterministic(row) for row in self.rows]
        graph = [[line.target for line in row] for row in self.rows]
        after_acceptance = reachable(graph, self._accepting_states())
        found = ["trans-labels", "explicit-labels", "trans-acc" if self.edges else "state-acc"]
        if all(self._complete(row) for row in self.rows):
            found.append("complete")
        if all(deterministic):
            found += ["deterministic", "unambiguous"]
        if all(deterministic[q] for q in after_acceptance):
            found.append("semi-deterministic")
        if self._weak(graph):
            found.append("weak")
        return found

    def _accepting_states(self) -> list[int]:
        marked = {q for q, row in enumerate(self.rows) if any(line.mark for line in row)}
        return sorted(marked | self.ldba.accepting)

    def _deterministic(self, row: list[_Line]) -> bool:
        seen = FALSE
        for line in row:
            if self.diagrams.conj(seen, line.guard) != FALSE:
                return False
            seen = self.diagrams.disj(seen, line.guard)
        return True

    def _complete(self, row: list[_Line]) -> bool:
        seen = FALSE
        for line in row:
            seen = self.diagrams.disj(seen, line.guard)
        return seen == TRUE

    def _weak(self, graph: list[list[int]]) -> bool:
        """Whether all edges inside a component carry the same marks."""
        component = components(graph)
        marks: dict[int, set[bool]] = {}
        for q, row in enumerate(self.rows):
            for line in row:
                if component[q] == component[line.target]:
                    mark = line.mark if self.edges else q in self.ldba.accepting
                    marks.setdefault(component[q], set()).add(mark)
        return all(len(kinds) == 1 for kinds in marks.values())

    def _label(self, guard: Node) -> str:
        if guard == TRUE:
            return "t"
        parts = []
        for cube in cubes(self.diagrams, guard):
            bits = [v for v in range(cube.mask.bit_length()) if cube.mask >> v & 1]
            parts.append("&".join(f"{'' if cube.value >> v & 1 else '!'}{v}" for v in bits))
        return " | ".join(parts)


def _without_sink(ldba: Ldba) -> Ldba:
    """`ldba` with the sink, its last state, and the edges to it left out."""
    sink = ldba.sink
    assert sink == len(ldba.names) - 1
    places = [i for i, e in enumerate(ldba.edges) if e.target != sink]
    return replace(
        ldba,
        names=ldba.names[:-1],
        sink=None,
        edges=tuple(ldba.edges[i] for i in places),
        accepting_edges=frozenset(n for n, i in enumerate(places) if i in ldba.accepting_edges),
    )


def _quoted(text: str) -> str:
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"') + '"'
