"""How a policy failed, in words: when each stage was reached, and what went wrong at which step."""

from __future__ import annotations

import re
from dataclasses import dataclass

from tiloilc.automaton.ldba import Cube, Ldba, StateId
from tiloilc.ltl import name_text
from tiloilc.plan import Plan
from tiloilc.plan.telling import Teller
from tiloilc.product import Floats, Int

MOST_LINES = 12
"""Stages of one way that are told; of more the first and the last half."""

PLAIN = re.compile(r'\w+|"[^"]*"')
"""A guard that is one proposition."""


@dataclass(frozen=True, slots=True, eq=False)
class Path:
    """States that followed one another: observations [T+1, d], letters and automaton states [T+1].

    With a `loop` the steps from there on are repeated for ever: after the last one comes that.
    """

    observations: Floats
    letters: Int
    states: Int
    loop: int | None

    def lost(self, ldba: Ldba) -> int | None:
        """The step that led into the sink, None if none did."""
        fell = [t for t, b in enumerate(self.states.tolist()) if b == ldba.sink]
        return fell[0] if fell else None


def way(path: Path, plan: Plan) -> list[str]:
    """Each step that changed the automaton's state, up to what went wrong."""
    ldba, states = plan.ldba, path.states.tolist()
    lost = path.lost(ldba)
    last = len(states) if lost is None else lost
    lines = [f"step 0: {place(plan, states[0])}"] if last else []
    for t in range(1, last):
        if states[t] != states[t - 1]:
            cause = _cause(path, ldba, t)
            lines.append(f"step {t}: {cause}{place(plan, states[t])}")
    if len(lines) > MOST_LINES:
        half = MOST_LINES // 2
        lines[half:-half] = [f"… {len(lines) - 2 * half} more …"]
    return lines


def violation(path: Path, plan: Plan) -> str:
    """What led into the sink: `step 31: b became true in stage 2: …`."""
    lost = path.lost(plan.ldba)
    assert lost is not None, "nothing is lost"
    what = _what_happened(path, plan.ldba, lost)
    where = f" in {place(plan, int(path.states[lost - 1]))}" if lost else " at the start"
    return f"step {lost}: {what}{where}: the formula can no longer be satisfied"


def repetition(path: Path, plan: Plan, nodes: int) -> str:
    """What is wrong with the end of a path whose policy comes back to `nodes` states for ever."""
    assert path.loop is not None, "nothing is repeated"
    length = len(path.states) - path.loop
    if nodes > length:
        what = f"it stays among {nodes} states for ever"
    elif length == 1:
        what = "it stays in one state for ever"
    else:
        what = f"it repeats {length} states for ever"
    inside = sorted(set(path.states[path.loop :].tolist()))
    if len(inside) > 1:
        stages = sorted({plan.stages.index[b] for b in inside})
        where = f"in stage{'s' if stages[1:] else ''} {_in_a_row(stages)}"
        return f"from step {path.loop} on {what}, {where}, and never comes to acceptance"
    missing = _missing(plan, path, path.loop, ("never becomes", "never holds"))
    return f"from step {path.loop} on {what}, in {place(plan, inside[0])}{missing}"


def shortfall(path: Path, plan: Plan, visits: int, wanted: int) -> str:
    """What an episode that violated nothing left to be done."""
    states = path.states.tolist()
    since = next(t for t in range(len(states)) if len(set(states[t:])) == 1)
    made = f"{visits} accepting visit{'' if visits == 1 else 's'}"
    of = f" of {wanted}" if wanted > 1 else ""
    ended = len(states) - 1 < plan.environment.horizon
    after = "the environment ended the episode" if ended else "the horizon was over"
    missing = _missing(plan, path, since + (since > 0), ("did not become", "did not hold"))
    where = f"in {place(plan, states[-1])} since step {since}{missing}"
    return f"step {len(states) - 1}: {after} with {made}{of}, {where}"


def place(plan: Plan, b: StateId) -> str:
    """Where the automaton is: a stage, or acceptance."""
    if b in plan.ldba.accepting:
        return "acceptance"
    return "the sink" if b == plan.ldba.sink else f"stage {plan.stages.index[b]}"


def _missing(plan: Plan, path: Path, first: int, verbs: tuple[str, str]) -> str:
    """What did not happen in the state that a path ends in, short of acceptance, after a comma.

    The letter at step `first` is the first that was read there.
    """
    ldba, b = plan.ldba, int(path.states[-1])
    if b in ldba.accepting or b == ldba.sink:
        return ""
    teller = Teller(ldba, plan.stages)
    needs = teller.needs(b)
    if teller.must_decide(b):
        jumps, read = ldba.jump_targets[b], set(path.letters[first:].tolist())
        if any(ldba.successor(c, letter) != ldba.sink for c in jumps for letter in read):
            bets = " or ".join(f"`{ldba.names[c]}`" for c in jumps)
            return f", without deciding that from here on {bets} holds (ε-jump)"
        needs = " | ".join(guard for way in teller.decisions(b) for guard, _ in way.ways)
    if not needs or needs == "true":
        return ", without coming to acceptance"
    verb = f"{verbs[0]} true" if PLAIN.fullmatch(needs) else verbs[1]
    return f", and `{needs}` {verb}"


def _cause(path: Path, ldba: Ldba, t: int) -> str:
    """Why the automaton's state changed at step `t`, and a comma."""
    before, now, letter = int(path.states[t - 1]), int(path.states[t]), int(path.letters[t])
    if ldba.successor(before, letter) == now:
        return f"{_what_happened(path, ldba, t)}, "
    jumps = ldba.jump_targets[before]
    through = [now] if now in jumps else [c for c in jumps if ldba.successor(c, letter) == now]
    decided = through[0] if through else now  # in a step of its own, after the letter
    return f"decides for state {decided} (ε-jump), "


def _what_happened(path: Path, ldba: Ldba, t: int) -> str:
    """What of the letter at step `t` led on: `b became true`, `a and c are true`."""
    before = ldba.initial if t == 0 else int(path.states[t - 1])
    letter = int(path.letters[t])
    earlier = letter if t == 0 else int(path.letters[t - 1])
    cube = _cube(ldba, before, letter)
    read = [i for i in range(len(ldba.propositions)) if cube.mask >> i & 1]
    true = [i for i in read if cube.value >> i & 1]
    shown, holds = (true, "true") if true else (read, "false")
    if not shown:
        return "any letter"
    fresh = [i for i in shown if (earlier ^ letter) >> i & 1]
    names = [f"`{name_text(ldba.propositions[i])}`" for i in fresh or shown]
    verb = "became" if fresh else "is" if len(names) == 1 else "are"
    return f"{_in_a_row(names)} {verb} {holds}"


def _cube(ldba: Ldba, b: StateId, letter: int) -> Cube:
    """The part of the guard of δ(b, letter) that the letter is in."""
    return next(cube for edge in ldba.outgoing[b] for cube in edge.guard if letter in cube)


def _in_a_row(parts: list[str] | list[int]) -> str:
    texts = [str(part) for part in parts]
    return " and ".join([", ".join(texts[:-1]), texts[-1]] if texts[1:] else texts)
