"""HOA v1 in: any Büchi or generalised Büchi automaton that is deterministic once it accepts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from tiloilc.automaton.bdd import TRUE, Diagrams
from tiloilc.automaton.draft import Draft
from tiloilc.automaton.finish import edge_based, state_based
from tiloilc.automaton.hoa.body import Body, check_claims
from tiloilc.automaton.hoa.general import Limited, limited
from tiloilc.automaton.hoa.header import read_header
from tiloilc.automaton.hoa.jumps import with_jumps
from tiloilc.automaton.hoa.rows import BEGIN
from tiloilc.automaton.hoa.subsets import with_subsets
from tiloilc.automaton.hoa.tokens import Tokens
from tiloilc.automaton.ldba import Ldba
from tiloilc.automaton.limits import MAX_STATES, TIMEOUT, Budget
from tiloilc.automaton.reduction.reduce import reduce
from tiloilc.automaton.translate import Acceptance
from tiloilc.diag import CompileError, Diagnostic, Span
from tiloilc.diag.text import one_line


@dataclass(frozen=True)
class Imported:
    """An automaton from a file, and the `name:` it has there ("" if none)."""

    ldba: Ldba
    name: str


def from_hoa(
    text: str,
    propositions: Sequence[str] | None = None,
    *,
    file: str = "<hoa>",
    acceptance: Acceptance = "state",
    max_states: int = MAX_STATES,
    timeout: float = TIMEOUT,
) -> Ldba:
    """The automaton of HOA v1 text; bit i of a letter is `propositions[i]`. See `read_hoa`."""
    return read_hoa(
        text,
        propositions,
        file=file,
        acceptance=acceptance,
        max_states=max_states,
        timeout=timeout,
    ).ldba


def read_hoa(
    text: str,
    propositions: Sequence[str] | None = None,
    *,
    file: str = "<hoa>",
    acceptance: Acceptance = "state",
    max_states: int = MAX_STATES,
    timeout: float = TIMEOUT,
) -> Imported:
    """The automaton of HOA v1 text, with its name; bit i of a letter is `propositions[i]`.

    Without `propositions` the letters are over those of the file. States keep their order and
    names, where edges can be read as jumps; else states that wait become sets of states. `file`
    names the text in messages.

    Raises CompileError AUT302 (no HOA v1), AUT303 (other acceptance), AUT304 (not limit-
    deterministic), AUT305 (too large), AUT306 (alternating), AUT307 (unknown proposition).
    """
    diagrams = Diagrams(Budget(max_states, timeout))
    tokens = Tokens(text, file, diagrams.budget)
    header = read_header(tokens, diagrams, propositions)
    body = Body(tokens, header, diagrams)
    check_claims(body)
    name = one_line(header.name)
    finish = state_based if acceptance == "state" else edge_based
    automaton = limited(body)
    if automaton is None:
        nothing = Draft(({(0, False): TRUE},), ((),), 0, (str,))
        return Imported(finish(nothing, header.propositions, diagrams), name)
    names = _names(automaton, body)
    draft = with_jumps(automaton, diagrams)
    if draft is not None:
        ldba = finish(draft, header.propositions, diagrams)
        return Imported(_in_the_files_order(ldba, automaton, names), name)
    draft = reduce(with_subsets(automaton, names, diagrams), diagrams)
    return Imported(finish(draft, header.propositions, diagrams), name)


def load_hoa(
    path: Path, propositions: Sequence[str] | None = None, *, span: Span | None = None
) -> Imported:
    """The automaton in the file `path`, as `read_hoa` reads it.

    Raises CompileError SPEC105, at `span`, if there is no file to read.
    """
    try:
        text = path.read_bytes().decode()
    except (OSError, UnicodeDecodeError) as error:
        problem = "not UTF-8 text" if isinstance(error, ValueError) else str(error.strerror)
        about = {"path": path.as_posix(), "problem": problem[:1].lower() + problem[1:]}
        raise CompileError(Diagnostic.of("SPEC105", span, **about)) from None
    return read_hoa(text, propositions, file=path.as_posix())


def _names(automaton: Limited, body: Body) -> tuple[str, ...]:
    """What the states are called: as in the file, else by their number there."""
    return tuple(
        "start" if n == BEGIN else one_line(body.states[n].name) or f"state {n}"
        for n in automaton.origin
    )


def _in_the_files_order(ldba: Ldba, automaton: Limited, names: tuple[str, ...]) -> Ldba:
    """`ldba`, whose names are the numbers of states in `automaton`, numbered as the file does.

    First the initial state, then the file's order, then states made for jumps, the sink last.
    """
    live = [b for b in ldba.states if b != ldba.sink]
    if not live:
        return ldba
    source = {b: int(ldba.names[b]) for b in live}
    origin = dict(enumerate(automaton.origin))
    made = len(automaton.origin)

    def place(b: int) -> tuple[bool, bool, int, int, int]:
        q = source[b]
        return b != ldba.initial, q >= made, origin.get(q, 0), q, b

    order = sorted(live, key=place) + ([] if ldba.sink is None else [ldba.sink])
    new = {b: i for i, b in enumerate(order)}
    edges = sorted(
        (replace(e, source=new[e.source], target=new[e.target]), i in ldba.accepting_edges)
        for i, e in enumerate(ldba.edges)
    )
    jumps = sorted((new[b], new[t]) for b, t in ldba.jumps)
    called = {b: names[q] if q < made else f"jump {q - made}" for b, q in source.items()}
    return Ldba(
        propositions=ldba.propositions,
        names=tuple(called.get(b, "false") for b in order),
        accepting=frozenset(new[b] for b in ldba.accepting),
        sink=None if ldba.sink is None else new[ldba.sink],
        edges=tuple(edge for edge, _ in edges),
        jumps=tuple(jumps),
        accepting_edges=frozenset(i for i, (_, mark) in enumerate(edges) if mark),
    )
