"""`tiloilc check`: what a formula means, and how two formulas differ."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from tiloilc.cli.formulas import Propositions, Written, read, show, split_names
from tiloilc.diag import CompileError

if TYPE_CHECKING:
    from tiloilc.ltl import Parsed
    from tiloilc.ltl.ast import Formula


def command(
    formula: Annotated[str, typer.Argument(metavar="F", help="In LTL.")],
    other: Annotated[str | None, typer.Argument(metavar="[G]", help="To compare it with.")] = None,
    propositions: Propositions = None,
) -> None:
    """Say what a formula means, or how two formulas differ.

    Of F alone: whether it is satisfiable and valid. Of F and G: equivalent, implied, or a word
    that tells them apart.

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
    from tiloilc.automaton import satisfying_word
    from tiloilc.ltl.ast import Not
    from tiloilc.plan.explain import word_text

    model = satisfying_word(formula, names)
    counter = satisfying_word(Not(formula), names)
    print("satisfiable: " + ("no" if model is None else f"yes, by {word_text(model, names)}"))
    print("valid: " + ("yes" if counter is None else f"no, by {word_text(counter, names)}"))
    return model is not None


def _together(first: Formula, second: Formula, names: tuple[str, ...]) -> bool:
    from tiloilc.automaton import difference_word
    from tiloilc.plan.explain import word_text

    only_first = difference_word(first, second, names)
    only_second = difference_word(second, first, names)
    if only_first is None and only_second is None:
        print("equivalent")
        return True
    if only_first is None:
        print("F implies G, G does not imply F")
    elif only_second is None:
        print("G implies F, F does not imply G")
    else:
        print("neither implies the other")
    for word, who in ((only_first, "F, not G"), (only_second, "G, not F")):
        if word is not None:
            print(f"{who}: {word_text(word, names)}")
    return False
