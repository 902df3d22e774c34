"""A plan in words: what is asked, the stages and what leads on, who is compared with whom."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from tiloilc.automaton import accepted_word, guard_text, rejected_word
from tiloilc.automaton.ldba import Cube, Ldba, StateId
from tiloilc.ltl import Lasso, is_cosafety, is_safety, nnf, parse, to_text
from tiloilc.ltl.ast import Formula
from tiloilc.plan.model import Plan, Stages
from tiloilc.plan.stages import is_absorbing


def explain(plan: Plan) -> str:
    """Several paragraphs about `plan`, ended by a newline."""
    formula = parse(plan.formula, plan.ldba.propositions).formula
    about = f": {plan.description}" if plan.description else ""
    paragraphs = [
        [f"{plan.name}{about}"],
        ["Formula", *_indented(_formula_lines(formula, plan.ldba))],
        ["Propositions", *_indented(_predicate_lines(plan))],
        ["Stages", *_indented(stage_lines(plan.ldba, plan.stages))],
        ["Discriminators", *_indented(_buffer_lines(plan.ldba, plan.stages))],
        ["Words", *_indented(_word_lines(plan.ldba))],
    ]
    return "\n\n".join("\n".join(lines) for lines in paragraphs) + "\n"


def kind_of(formula: Formula, ldba: Ldba) -> str:
    """The class of a formula, as far as its form and its automaton show it."""
    if is_safety(nnf(formula)):
        return "safety: nothing bad ever happens"
    if is_cosafety(nnf(formula)):
        return "co-safety: something good happens once, after finitely many steps"
    if ldba.jumps:
        return "beyond deterministic Büchi automata: the agent takes ε-jumps"
    return "deterministic Büchi: no ε-jumps"


def stage_lines(ldba: Ldba, stages: Stages) -> Iterator[str]:
    """For each live state what is left to do, its place in the order, and where letters lead."""
    for b in ldba.states:
        if b == ldba.sink:
            continue
        marks = ["start"] if b == ldba.initial else []
        marks += ["accepting"] if b in ldba.accepting else []
        place = f"stage {stages.index[b]} of {stages.length[b]}"
        yield f"{b}: {ldba.names[b]}   ({', '.join([place, *marks])})"
        for target, guard in _leads(ldba, b):
            if target != b:
                where = "violates for ever" if target == ldba.sink else f"leads to {target}"
                yield f"   {guard} {where}"
        for target in ldba.jump_targets[b]:
            for reached, guard in _leads(ldba, target):
                if reached != ldba.sink:
                    yield f"   {guard} may lead to {reached}, by an ε-jump"
    if is_absorbing(ldba):
        yield "acceptance is absorbing: accepting visits count the steps that it lasts"


def _formula_lines(formula: Formula, ldba: Ldba) -> Iterator[str]:
    yield to_text(formula)
    yield f"with all brackets: {to_text(formula, brackets=True)}"
    yield f"class: {kind_of(formula, ldba)}"


def _predicate_lines(plan: Plan) -> Iterator[str]:
    width = max((len(p.name) for p in plan.predicates), default=0)
    for predicate in plan.predicates:
        text = predicate.text or f"python {predicate.python}"
        yield f"{predicate.name:<{width}}  {text}"


def _buffer_lines(ldba: Ldba, stages: Stages) -> Iterator[str]:
    for b in ldba.states:
        if stages.positive[b] or stages.negative[b]:
            ahead, behind = (_buffers(side, stages) for side in (stages.positive, stages.negative))
            yield f"f_{b}: segments that got to {ahead[b]}, against those that got to {behind[b]}"


def _buffers(side: Sequence[Sequence[int]], stages: Stages) -> list[str]:
    names = []
    for row in side:
        texts = [str(c) if c != stages.sink_buffer else "a violation" for c in row]
        names.append(" or ".join([", ".join(texts[:-1]), texts[-1]] if texts[1:] else texts))
    return names


def _word_lines(ldba: Ldba) -> Iterator[str]:
    for kind, word in (("accepted", accepted_word(ldba)), ("rejected", rejected_word(ldba))):
        yield f"{kind}: {'none' if word is None else word_text(word, ldba.propositions)}"


def word_text(word: Lasso, propositions: Sequence[str]) -> str:
    """An ultimately periodic word: `{a} {} then for ever {b, c} {}`."""

    def letters(part: Sequence[int]) -> str:
        sets = (
            ", ".join(name for i, name in enumerate(propositions) if letter >> i & 1)
            for letter in part
        )
        return " ".join(f"{{{names}}}" for names in sets)

    stem = f"{letters(word.stem)} then " if word.stem else ""
    return f"{stem}for ever {letters(word.loop)}"


def _leads(ldba: Ldba, b: StateId) -> Iterator[tuple[StateId, str]]:
    """Where each guard of `b` leads, each target once."""
    guards: dict[StateId, list[Cube]] = {}
    for edge in ldba.outgoing[b]:
        guards.setdefault(edge.target, []).extend(edge.guard)
    for target, cubes in guards.items():
        yield target, guard_text(tuple(sorted(cubes)), ldba.propositions)


def _indented(lines: Iterator[str]) -> Iterator[str]:
    return (f"  {line}" for line in lines)
