"""The header of a HOA file: what is declared before the states."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from tiloilc.automaton.bdd import Diagrams, Node
from tiloilc.automaton.hoa.expressions import (
    Atom,
    Clause,
    Condition,
    Postfix,
    Visited,
    clauses,
    condition_atom,
    label_atom,
    label_node,
    postfix,
)
from tiloilc.automaton.hoa.tokens import Token, Tokens, shown, unquoted
from tiloilc.diag import CompileError, Diagnostic, did_you_mean
from tiloilc.diag.text import one_line

MAX_PROPOSITIONS = 62
"""A letter is the set of true propositions, kept as the bits of one 64-bit integer."""

FEW = 30
"""Longer names, and more of them, are not compared to guess what may have been meant."""

_ONCE = ("HOA:", "States:", "AP:", "Acceptance:", "acc-name:", "tool:", "name:")


@dataclass(frozen=True)
class Header:
    """What the header declares.

    `propositions` are those of the letters, `bits[i]` is the place among them of the file's
    proposition i. `states` is the declared number of states, `sets` that of acceptance sets.
    `clauses` must all be visited infinitely often. `claims` are the words behind `properties:`.
    """

    name: str
    states: int | None
    starts: tuple[tuple[int, Token], ...]
    propositions: tuple[str, ...]
    bits: tuple[int, ...]
    sets: int
    clauses: tuple[Clause, ...]
    aliases: Mapping[str, Node]
    claims: tuple[Token, ...]

    def letters(self, token: Token, tokens: Tokens, diagrams: Diagrams) -> Node:
        """The letters of a label's operand: a proposition's number or an alias."""
        if token.kind == "alias":
            return self.aliases[token.text]
        return _literal(token, tokens, self.bits, diagrams)


@dataclass
class _Items:
    """The header's items as they stand, while it is read."""

    name: str = ""
    states: int | None = None
    starts: dict[int, Token] = field(default_factory=dict)
    propositions: list[Token] = field(default_factory=list)
    sets: tuple[int, Token] | None = None
    condition: Postfix[Condition] = field(default_factory=list)
    condition_end: int = 0
    accepting: list[Token] = field(default_factory=list)
    aliases: dict[str, Postfix[str]] = field(default_factory=dict)
    claims: list[Token] = field(default_factory=list)


def read_header(tokens: Tokens, diagrams: Diagrams, propositions: Sequence[str] | None) -> Header:
    """Read up to and with `--BODY--`.

    Raises CompileError AUT302 (syntax), AUT303 (acceptance), AUT306 (alternation), AUT307 (a
    proposition that is not among `propositions`).
    """
    if tokens.next.text != "HOA:":
        help = "other formats: Spot's `autfilt` writes HOA"
        raise tokens.error(tokens.next, "it does not begin with `HOA: v1`", help=help)
    items = _Items()
    seen: set[str] = set()
    while tokens.next.kind == "header":
        name = tokens.take()
        if name.text in seen and name.text in _ONCE:
            raise tokens.error(name, f"`{shown(name)}` stands there twice")
        seen.add(name.text)
        _item(name, tokens, items)
    tokens.expect("section", "a header such as `Start:`, or `--BODY--`", "--BODY--")
    if items.sets is None:
        problem = "there is no `Acceptance:` before `--BODY--`"
        raise tokens.error(tokens.next, problem, help="write `Acceptance: 1 Inf(0)` for Büchi")
    names, bits = _propositions(items, tokens, propositions)
    aliases: dict[str, Node] = {}

    def letters(token: Token) -> Node:
        if token.kind == "alias":
            return aliases[token.text]
        return _literal(token, tokens, bits, diagrams)

    for alias, label in items.aliases.items():
        aliases[alias] = label_node(label, diagrams, letters)
    return Header(
        items.name,
        items.states,
        tuple(items.starts.items()),
        names,
        bits,
        items.sets[0],
        _acceptance(items, tokens),
        aliases,
        tuple(items.claims),
    )


def _item(name: Token, tokens: Tokens, items: _Items) -> None:
    match name.text:
        case "HOA:":
            version = tokens.expect("word", "the version `v1`")
            if version.text != "v1":
                raise tokens.error(version, f"version `{shown(version)}`, only `v1` is read")
        case "States:":
            items.states = tokens.number("the number of states")[0]
        case "Start:":
            state, token = tokens.number("a state's number")
            refuse_conjunction(tokens, token, "it begins in several states at once")
            items.starts.setdefault(state, token)
        case "AP:":
            _read_propositions(tokens, items)
        case "Alias:":
            _read_alias(tokens, items)
        case "Acceptance:":
            items.sets = tokens.number("the number of acceptance sets")
            items.condition = postfix(tokens, condition_atom, negation=False)
            items.condition_end = tokens.next.start
        case "acc-name:":
            items.accepting.append(tokens.expect("word", "the name of an acceptance"))
            while tokens.next.kind in ("word", "int"):
                items.accepting.append(tokens.take())
        case "tool:":
            tokens.expect("string", "the tool's name in quotes")
            if tokens.next.kind == "string":
                tokens.take()
        case "name:":
            items.name = unquoted(tokens.expect("string", "the automaton's name in quotes"))
        case "properties:":
            while tokens.next.kind == "word":
                items.claims.append(tokens.take())
        case _:
            _unknown(name, tokens)


def _unknown(name: Token, tokens: Tokens) -> None:
    """Skip a header that may be skipped: its name begins with a small letter."""
    if name.text[0].isupper():
        known = ("States:", "Start:", "AP:", "Alias:", "Acceptance:")
        help = did_you_mean(name.text, known) if len(name.text) < FEW else ""
        problem = f"header `{shown(name)}` is not known and may change the meaning"
        raise tokens.error(name, problem, help=help)
    while tokens.next.kind in ("int", "string", "word"):
        tokens.take()


def _read_propositions(tokens: Tokens, items: _Items) -> None:
    count, token = tokens.number("the number of propositions")
    if count > MAX_PROPOSITIONS:
        problem = f"{count:_} propositions, at most {MAX_PROPOSITIONS} are possible"
        raise tokens.error(token, problem)
    while tokens.next.kind == "string":
        items.propositions.append(tokens.take())
        name = unquoted(items.propositions[-1])
        if not name or not name.isprintable() or '"' in name or "\\" in name:
            problem = "this cannot name a proposition"
            help = "a name is not empty and has no quotes, backslashes or control characters"
            raise tokens.error(items.propositions[-1], problem, help=help)
        if name in map(unquoted, items.propositions[:-1]):
            raise tokens.error(items.propositions[-1], f"proposition `{name}` stands there twice")
        if len(items.propositions) > count:
            break
    if len(items.propositions) != count:
        listed = len(items.propositions)
        more = "more" if listed > count else f"only {listed}"
        raise tokens.error(token, f"`AP:` says {count} propositions, but {more} are listed")


def _read_alias(tokens: Tokens, items: _Items) -> None:
    name = tokens.expect("alias", "an alias such as `@a`")
    if name.text in items.aliases:
        raise tokens.error(name, f"alias `{shown(name)}` is defined twice")
    label = postfix(tokens, label_atom, negation=True)
    check_aliases(label, tokens, items.aliases)
    items.aliases[name.text] = label


def check_aliases(label: Postfix[str], tokens: Tokens, known: Mapping[str, object]) -> None:
    """Raise CompileError AUT302 for an alias that is not defined before it is used."""
    for item in label:
        if isinstance(item, Atom) and item.token.kind == "alias" and item.token.text not in known:
            problem = f"alias `{shown(item.token)}` is not defined before its use"
            few = [name for name in list(known)[:FEW] if len(name) < FEW]
            help = did_you_mean(item.token.text, few) if len(item.token.text) < FEW else ""
            raise tokens.error(item.token, problem, help=help)


def refuse_conjunction(tokens: Tokens, first: Token, problem: str) -> None:
    """Raise CompileError AUT306 where `&` goes on after a state's number."""
    if tokens.at("&"):
        last = tokens.take()
        if tokens.next.kind == "int":
            last = tokens.next
        span = tokens.span(first.start, last.end)
        help = "other tools remove alternation, for example Spot's `autfilt`"
        raise CompileError(Diagnostic.of("AUT306", span, problem=problem, help=help))


def _propositions(
    items: _Items, tokens: Tokens, wanted: Sequence[str] | None
) -> tuple[tuple[str, ...], tuple[int, ...]]:
    """The propositions of the letters, and where among them the file's own are."""
    own = [unquoted(token) for token in items.propositions]
    if wanted is None:
        return tuple(own), tuple(range(len(own)))
    unknown = [
        Diagnostic.of(
            "AUT307",
            tokens.span(token.start, token.end),
            name=name,
            label="not declared",
            help=did_you_mean(name, wanted, listed="declared") if len(name) < FEW else "",
        )
        for name, token in zip(own, items.propositions, strict=True)
        if name not in wanted
    ]
    if unknown:
        raise CompileError(*unknown)
    return tuple(wanted), tuple(list(wanted).index(name) for name in own)


def _literal(token: Token, tokens: Tokens, bits: Sequence[int], diagrams: Diagrams) -> Node:
    number = int(token.text)
    if number >= len(bits):
        problem = f"there is no proposition {number}: `AP:` lists {len(bits)}"
        raise tokens.error(token, problem)
    return diagrams.literal(bits[number])


def _acceptance(items: _Items, tokens: Tokens) -> tuple[Clause, ...]:
    assert items.sets is not None
    count = items.sets[0]
    atoms = [item for item in items.condition if isinstance(item, Atom)]
    for atom in atoms:
        if atom.value.name in ("Inf", "Fin") and atom.value.visited.number >= count:
            problem = (
                f"there is no acceptance set {atom.value.visited.number}: {count} are declared"
            )
            raise tokens.error(atom.token, problem)
    for atom in atoms:
        if atom.value.name == "Fin":
            raise _unsupported(items, tokens, atom.token)
    found = clauses(items.condition)
    _check_name(items, tokens, found)
    return found


def _unsupported(items: _Items, tokens: Tokens, token: Token) -> CompileError:
    name = " ".join(shown(t) for t in items.accepting)
    help = "convert it, for example with Owl's `ltl2ldba` or Spot's `autfilt --buchi`"
    span = tokens.span(token.start, token.end)
    return CompileError(
        Diagnostic.of(
            "AUT303", span, acceptance=name or "Fin", label="must end at some time", help=help
        )
    )


def _check_name(items: _Items, tokens: Tokens, found: tuple[Clause, ...]) -> None:
    """`acc-name:` must not contradict `Acceptance:`."""
    if not items.accepting:
        return
    assert items.sets is not None
    name, *parameters = (token.text for token in items.accepting)
    count = {"Buchi": "1", "all": "0", "none": "0"}.get(name)
    if name == "generalized-Buchi":
        count = parameters[0] if parameters else None
    if name not in ("Buchi", "generalized-Buchi", "all", "none"):
        return
    each = {(Visited(n, False),) for n in range(len(found))}
    meant = {()} if name == "none" else each if len(found) == items.sets[0] else None
    if count != str(items.sets[0]) or {tuple(clause) for clause in found} != meant:
        first, last = items.accepting[0], items.accepting[-1]
        place = Token("word", "", first.start, last.end)
        said = " ".join(tokens.text[items.sets[1].start : items.condition_end].split())
        problem = f"`acc-name: {name}` contradicts `Acceptance: {one_line(said[:60])}`"
        raise tokens.error(place, problem, help="remove `acc-name:`, or correct it")
