"""A plan in words: what is asked, the stages and what leads on, who is compared with whom."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from tiloilc.automaton import accepted_word, rejected_word
from tiloilc.automaton.language.classes import formula_class
from tiloilc.automaton.language.compare import irrelevant_propositions
from tiloilc.automaton.language.shortest import shortest_word
from tiloilc.automaton.ldba import Ldba
from tiloilc.diag import CompileError
from tiloilc.ltl import parse, to_text
from tiloilc.ltl.ast import Formula, Not
from tiloilc.ltl.words import word_text
from tiloilc.plan.model import Plan, Stages
from tiloilc.plan.sentences import in_a_row, stage_lines

__all__ = ["explain", "explain_automaton", "kind_of", "stage_lines", "word_text"]


def explain(plan: Plan) -> str:
    """Several paragraphs about `plan`, ended by a newline."""
    formula = parse(plan.formula, plan.ldba.propositions).formula if plan.formula else None
    about = f": {plan.description}" if plan.description else ""
    paragraphs = [
        [f"{plan.name}{about}"],
        ["Formula" if plan.formula else "Automaton", *_indented(_goal_lines(plan, formula))],
        ["Propositions", *_indented(_predicate_lines(plan))],
        ["Stages", *_indented(stage_lines(plan.ldba, plan.stages, meant=plan.formula != ""))],
        ["Discriminators", *_indented(_buffer_lines(plan.ldba, plan.stages))],
        ["Words", *_indented(_word_lines(plan.ldba, formula))],
    ]
    return "\n\n".join("\n".join(lines) for lines in paragraphs) + "\n"


def explain_automaton(title: str, ldba: Ldba, stages: Stages | None, *, meant: bool = False) -> str:
    """The same about an automaton that belongs to no task; without stages it accepts nothing.

    `meant` says that `title` is the formula that it was made from.
    """
    formula = parse(title, ldba.propositions).formula if meant else None
    about = stage_lines(ldba, stages, meant=meant) if stages else iter(["nothing is accepted"])
    paragraphs = [
        [title] if formula is None else ["Formula", *_indented(_formula_lines(formula, ldba))],
        ["Propositions", f"  {', '.join(ldba.propositions) or 'none'}"],
        ["Stages", *_indented(about)],
        ["Words", *_indented(_word_lines(ldba, formula))],
    ]
    return "\n\n".join("\n".join(lines) for lines in paragraphs) + "\n"


def kind_of(formula: Formula, ldba: Ldba) -> str:
    """The class of a formula in the safety–progress hierarchy, and whether the agent must guess."""
    found = formula_class(formula, ldba)
    jumps = "; the agent takes ε-jumps" if ldba.jumps else ""
    return f"{found}: {found.words}{jumps}"


def _goal_lines(plan: Plan, formula: Formula | None) -> Iterator[str]:
    if formula is None:
        return iter([f"from the file {plan.goal}"])
    return _formula_lines(formula, plan.ldba)


def _formula_lines(formula: Formula, ldba: Ldba) -> Iterator[str]:
    yield to_text(formula)
    yield f"with all brackets: {to_text(formula, brackets=True)}"
    yield f"class: {kind_of(formula, ldba)}"
    if idle := ", ".join(irrelevant_propositions(formula, ldba.propositions)):
        yield f"never matters: {idle}"


def _predicate_lines(plan: Plan) -> Iterator[str]:
    width = max((len(p.name) for p in plan.predicates), default=0)
    for predicate in plan.predicates:
        text = predicate.text or f"python {predicate.python}"
        yield f"{predicate.name:<{width}}  {text}"


def _buffer_lines(ldba: Ldba, stages: Stages) -> Iterator[str]:
    for b in ldba.states:
        if stages.positive[b] or stages.negative[b]:
            ahead = _buffers(stages.positive[b], ldba, stages)
            behind = _buffers(stages.negative[b], ldba, stages)
            yield f"f_{b}: segments that got to {ahead}, against those that got to {behind}"


def _buffers(row: Sequence[int], ldba: Ldba, stages: Stages) -> str:
    """Stage buffers by the numbers of their states; B_⊥ only where something can be lost."""
    names = [f"{c}" for c in row if c != stages.sink_buffer]
    if stages.sink_buffer in row and ldba.sink is not None:
        names.append("a violation")
    return in_a_row(names)


def _word_lines(ldba: Ldba, formula: Formula | None) -> Iterator[str]:
    """An accepted and a rejected word; shortest ones where there is a formula."""
    names = ldba.propositions
    for kind, ask in (("accepted", accepted_word), ("rejected", rejected_word)):
        try:
            word = ask(ldba)
        except CompileError:
            yield f"{kind}: unknown, the automaton is too large to ask"
            continue
        if word is not None and formula is not None:
            meant = formula if kind == "accepted" else Not(formula)
            word = shortest_word(meant, names, word)
        yield f"{kind}: {'none' if word is None else word_text(word, names)}"


def _indented(lines: Iterator[str]) -> Iterator[str]:
    return (f"  {line}" for line in lines)
