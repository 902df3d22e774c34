"""The stages of an automaton in sentences a newcomer understands."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence

from tiloilc.automaton.ldba import Ldba, StateId
from tiloilc.plan.model import Stages
from tiloilc.plan.stages import is_absorbing
from tiloilc.plan.telling import Case, Teller

LEADS = {
    "lost": "is lost for ever",
    "stays": "stays",
    "on": "leads on to",
    "aside": "leads aside to",
    "back": "leads back to",
    "to": "leads to",
}


def stage_lines(ldba: Ldba, stages: Stages, meant: bool = True) -> Iterator[str]:
    """Each live state in the order of the stages: what it means in words, and where letters lead.

    Of the rows the first counts whose guard holds. `meant` says that a state's name is the formula
    of what is left to do, as that of a translated automaton is.
    """
    teller = Teller(ldba, stages)
    live = [b for b in ldba.states if b != ldba.sink]
    for b in sorted(live, key=lambda b: (stages.index[b], b)):
        marks = ["start"] if b == ldba.initial else []
        marks += ["accepting"] if b in ldba.accepting else []
        place = f"stage {stages.index[b]} of {stages.length[b]}"
        yield f"{place}: {', '.join([f'state {b}', *marks])}"
        yield f"  {sentence(teller, b)}"
        name = "nothing" if ldba.names[b] == "true" else ldba.names[b]
        yield f"  left to do: {name}" if meant else f"  named: {ldba.names[b]}"
        rows = case_lines(teller, b)
        width = max(len(guard) for guard, _ in rows)
        yield from (f"    {guard:<{width}}  {where}" for guard, where in rows)
        yield from (f"    {line}" for line in decision_lines(teller, b, meant))
    if is_absorbing(ldba):
        yield "acceptance is absorbing: accepting visits count the steps that it lasts"


def sentence(teller: Teller, b: StateId) -> str:
    """What is to know of `b`: `the agent has seen r and must now reach g; touching b loses …`."""
    parts = [
        _history_and_duty(teller, b),
        _of_accepting(teller, b),
        "" if teller.must_decide(b) else _decisions(teller, b),
        _losses(teller, b),
    ]
    return "; ".join(part for part in parts if part) or "the agent goes on with any letter"


def case_lines(teller: Teller, b: StateId) -> list[tuple[str, str]]:
    """The rows of `b`: a guard, and where it leads. The first counts whose guard holds."""
    cases = teller.cases(b)
    if len(cases) == 1:
        return [("any letter", _where(teller, cases[0]))]
    lines = []
    for i, case in enumerate(cases):
        after_loss = cases[0].way == "lost" and 0 < i < len(cases) - 1
        guard = f"else {case.guard}" if after_loss else case.guard
        lines.append((guard, _where(teller, case)))
    return lines


def decision_lines(teller: Teller, b: StateId, meant: bool = True) -> Iterator[str]:
    """Each ε-jump of `b` in words; `meant` as in `stage_lines`."""
    for decision in teller.decisions(b):
        ways = "; ".join(f"{guard} leads to {_named(teller, t)}" for guard, t in decision.ways)
        name = teller.ldba.names[decision.jump]
        bet = f", that from here on {name}" if meant else ""
        yield f"or decide for state {decision.jump}{bet} (ε-jump): {ways}"


def in_a_row(names: Sequence[str]) -> str:
    """Names in a row: `0, 1 or 2`."""
    return " or ".join([", ".join(names[:-1]), names[-1]] if names[1:] else names)


def _history_and_duty(teller: Teller, b: StateId) -> str:
    parts = []
    if decided := teller.decided(b):
        parts.append(f"has decided for state {' and '.join(map(str, decided))}")
    if seen := teller.seen(b):
        verb = "has seen" if not decided else "seen"
        parts.append(f"{verb} {', then '.join(map(_clause, seen))}")
    needs = teller.needs(b)
    now = "must now" if parts else "must"
    if teller.must_decide(b):
        jumps = in_a_row([f"state {c}" for c in teller.ldba.jump_targets[b]])
        parts.append(f"must at some time decide for {jumps}")
    elif needs == "true":
        parts.append("goes on with any letter" + (" that does not lose" if teller.loses(b) else ""))
    elif needs:
        parts.append(f"{now} reach {_clause(needs)}")
    return f"the agent {' and '.join(parts)}" if parts else ""


def _of_accepting(teller: Teller, b: StateId) -> str:
    if b not in teller.ldba.accepting:
        return ""
    if not teller.accepts_while_not_lost(b):
        return "this is accepting, and a new round begins"
    if teller.cannot_be_lost(b):
        return "all is done: whatever comes is accepted"
    return "this is accepting for as long as nothing is lost"


def _decisions(teller: Teller, b: StateId) -> str:
    jumps = teller.ldba.jump_targets[b]
    return f"it may decide for {in_a_row([f'state {c}' for c in jumps])}" if jumps else ""


def _losses(teller: Teller, b: StateId) -> str:
    loses = teller.loses(b)
    if not loses:
        return ""
    plain = not re.search(r"[!&|]", loses) and loses != "true"
    touched = f"touching {loses}" if plain else "any letter" if loses == "true" else loses
    return f"{touched} loses for ever"


def _clause(guard: str) -> str:
    """A guard inside a sentence; of a plain choice the words."""
    if "(" in guard and not guard.startswith("("):
        return guard
    if " & " not in guard:
        return guard.strip("()").replace(" | ", " or ")
    return guard


def _where(teller: Teller, case: Case) -> str:
    if case.way in ("lost", "stays"):
        return LEADS[case.way]
    return f"{LEADS[case.way]} {_named(teller, case.target)}"


def _named(teller: Teller, b: StateId) -> str:
    accepting = ", accepting" if b in teller.ldba.accepting else ""
    return f"state {b} (stage {teller.stages.index[b]}{accepting})"
