"""Storm's side: answers questions of `storm.py`, one JSON text a line, on standard input.

It runs as a program of its own and imports nothing of this project: Storm cannot be interrupted
while it computes, so whoever asks ends this program instead.
"""

from __future__ import annotations

import json
import signal
import sys
from typing import TYPE_CHECKING, TypedDict

if TYPE_CHECKING:
    from stormpy.models import SparseDtmc, SparseMdp, StateLabeling


class Question(TypedDict):
    """A process, and a path property in Storm's syntax from each of the `starts`.

    `actions[s][a]` are the outcomes (state, probability as a fraction) of each action of each
    state, `labels` the states of each label. Without a `choice` it is a chain.
    """

    actions: list[list[list[tuple[int, str]]]]
    labels: dict[str, list[int]]
    choice: bool
    property: str
    starts: list[int]


def answer(question: Question) -> list[str] | None:
    """The (greatest) probability from each start, as fractions; None where Storm has none.

    That is where it cannot read what its own translator of formulas has written.
    """
    import stormpy

    operator = "Pmax" if question["choice"] else "P"
    (query,) = stormpy.parse_properties(f"{operator}=? [ {question['property']} ]")
    model = _model(question)
    try:
        result = stormpy.model_checking(model, query, only_initial_states=True)
    except RuntimeError as error:
        if "acc-name headers do not match" not in str(error):
            raise
        return None
    return [str(result.get_value(start)) for start in question["starts"]]


def _model(question: Question) -> SparseMdp | SparseDtmc:
    from stormpy import Rational
    from stormpy.datastructures import SparseMatrixBuilder
    from stormpy.models import SparseDtmc, SparseMdp, SparseModelComponents

    choice, states = question["choice"], len(question["actions"])
    rows = [outcome for choices in question["actions"] for outcome in choices]
    builder = SparseMatrixBuilder[Rational](
        rows=len(rows),
        columns=states,
        entries=sum(map(len, rows)),
        has_custom_row_grouping=choice,
        row_groups=states if choice else 0,
    )
    row = 0
    known: dict[str, Rational] = {}
    for choices in question["actions"]:
        if choice:
            builder.new_row_group(row)
        for outcome in choices:
            for target, chance in outcome:
                if chance not in known:
                    known[chance] = Rational(chance)
                builder.add_next_value(row, target, known[chance])
            row += 1
    parts = SparseModelComponents[Rational](
        transition_matrix=builder.build(), state_labeling=_labeling(question)
    )
    return SparseMdp[Rational](parts) if choice else SparseDtmc[Rational](parts)


def _labeling(question: Question) -> StateLabeling:
    from stormpy.models import StateLabeling

    labels = StateLabeling(len(question["actions"]))
    for name, states in question["labels"].items():
        labels.add_label(name)
        for state in states:
            labels.add_label_to_state(name, state)
    return labels


def main() -> None:
    """Answer until nobody asks any more."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # whoever asks says when it is enough
    for line in sys.stdin:
        sys.stdout.write(json.dumps(answer(json.loads(line))) + "\n")
        sys.stdout.flush()


if __name__ == "__main__":
    main()
