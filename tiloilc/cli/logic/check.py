"""`tiloilc check`: what a formula means, and how two formulas differ."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from tiloilc.cli.logic.formulas import Propositions, Written, read, show, split_names
from tiloilc.diag import CompileError

if TYPE_CHECKING:
    from tiloilc.ltl import Parsed
    from tiloilc.ltl.ast import Formula


def command(
    formula: Annotated[str, typer.Argument(metavar="F", help="In LTL.")],
    other: Annotated[str | None, typer.Argument(metavar="G", help="To compare it with.")] = None,
    propositions: Propositions = None,
) -> None:
    """Say what a formula means, or how two formulas differ.

    Of F alone: whether it is satisfiable and valid, with shortest words that say so, its class in
    the safety–progress hierarchy, and propositions that never matter. Of F and G: equivalent,
    implied, or a shortest word that tells them apart.

    Exit with 1 if F is unsatisfiable, or if F and G are not equivalent.
    """
    texts = [Written(formula)] if other is None else [Written(formula), Written(other)]
    parsed = [_parsed(text, propositions) for text in texts]
    appearing = [name for p in parsed for name in p.propositions]
    names = split_names(propositions) or tuple(dict.fromkeys(appearing))
    try:
        if other is None:
            fine = _alone(parsed[0].formula, names)
        else:
            fine = _together(parsed[0].formula, parsed[1].formula, names)
    except CompileError as error:
        show(error.diagnostics, texts[0])
        raise typer.Exit(1) from None
    if not fine:
        raise typer.Exit(1)


def _parsed(text: Written, propositions: str | None) -> Parsed:
    try:
        return read(text, propositions)
    except CompileError as error:
        show(error.diagnostics, text)
        raise typer.Exit(1) from None


def _alone(formula: Formula, names: tuple[str, ...]) -> bool:
    from tiloilc.automaton import translate
    from tiloilc.automaton.language.classes import formula_class
    from tiloilc.automaton.language.compare import irrelevant_propositions
    from tiloilc.ltl.ast import Not

    model, counter = _word(formula, names), _word(Not(formula), names)
    print("satisfiable: " + ("no" if model is None else f"yes, by {model}"))
    print("valid: " + ("yes" if counter is None else f"no, by {counter}"))
    found = formula_class(formula, translate(formula, names))
    print(f"class: {found} ({found.words})")
    if idle := list(irrelevant_propositions(formula, names)):
        print(f"never matters: {', '.join(idle)}")
    return model is not None


def _together(first: Formula, second: Formula, names: tuple[str, ...]) -> bool:
    from tiloilc.ltl.ast import Not, conjunction

    only_first = _word(conjunction((first, Not(second))), names)
    only_second = _word(conjunction((second, Not(first))), names)
    if only_first is None and only_second is None:
        print("equivalent")
        return True
    if only_first is None:
        print("the first implies the second, not the other way round")
    elif only_second is None:
        print("the second implies the first, not the other way round")
    else:
        print("neither implies the other")
    for word, who in ((only_first, "first"), (only_second, "second")):
        if word is not None:
            print(f"accepted by the {who} only: {word}")
    return False


def _word(formula: Formula, names: tuple[str, ...]) -> str | None:
    """A shortest word of `formula`, None if there is none. Raises CompileError AUT305."""
    from tiloilc.automaton import satisfying_word
    from tiloilc.automaton.language.shortest import shortest_word
    from tiloilc.ltl.words import word_text

    known = satisfying_word(formula, names)
    return None if known is None else word_text(shortest_word(formula, names, known), names)
