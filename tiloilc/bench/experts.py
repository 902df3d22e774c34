"""How well the scripted experts do their tasks: `python -m tiloilc.bench.experts PAGE [TASK…]`.

Plays EPISODES episodes of each bundled task (or of those named) with the expert that made its
demonstrations, with its own noise and without any, and writes a row for each into the page; rows of
other tasks stay as they are.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Sequence
from importlib.resources import files
from math import prod
from pathlib import Path

import numpy as np

from tiloilc.bench.markdown import table
from tiloilc.demos import DemoSet, bundled, play, replay_all
from tiloilc.driver import Analysis, analyse
from tiloilc.evaluate.optimum import task_optimum

EPISODES = 50

HEAD = f"""\
# Tasks

The paper's tasks as they are here: a row for each file in `specs/`, written by `make experts`, not
by hand. The *optimum* counts accepting visits in an episode: with ≥ it is a lower bound, reached by
real actions; `tiloilc explain TASK` says how it is known. *Accepted* is the share of {EPISODES}
episodes in which the scripted expert that made the demonstrations reaches acceptance and never
violates the formula, without noise and with its own. Its *first visit* is a median over the latter,
in steps.

"""

COLUMNS = (
    "task",
    "formula",
    "steps",
    "observation",
    "action",
    "optimum",
    "expert",
    "accepted without noise",
    "accepted with noise",
    "first visit",
)


def rows_of(page: str) -> dict[str, str]:
    """The rows of a page that has been written before, by task."""
    return {m[1]: m[0] for m in re.finditer(r"^\| `(\w+)` \|.*\n", page, re.MULTILINE)}


def page_of(rows: dict[str, str]) -> str:
    """The page with these rows."""
    return HEAD + table(COLUMNS, []) + "".join(rows[name] for name in sorted(rows))


def row(task: Path) -> str:
    """The row of one task file; nothing is claimed of an expert where none made demonstrations."""
    about = analyse(task, DemoSet(()))
    spec, ldba, asked = about.spec, about.ldba, about.asked
    assert spec is not None, f"{task} has errors"
    assert ldba is not None
    assert asked is not None
    assert about.labels is not None
    made = spec.environment
    best = task_optimum(made.id, made.kwargs, about.labels, ldba, made.horizon, spec.train.epsilon)
    optimum = "–" if best is None else f"{'' if best.exact else '≥ '}{best.accepting_visits:g}"
    shape = asked.action_space.shape
    action = f"{prod(shape)}" if shape else f"one of {getattr(asked.action_space, 'n', '?')}"
    formula = f"`{spec.formula}`".replace("|", "\\|")
    told = [f"`{spec.name}`", formula, made.horizon, asked.dimensions, action, optimum]
    shipped = bundled(spec.name)
    if shipped is None:
        return table([], [[*told, *["–"] * 4]]).splitlines(keepends=True)[-1]
    expert = str(shipped.meta["expert"])
    without, _ = _accepted(about, expert, 0.0)
    share, first = _accepted(about, expert, None)
    told += [f"`{expert}`", f"{without:.0%}", f"{share:.0%}", f"{first:g}"]
    return table([], [told]).splitlines(keepends=True)[-1]


def _accepted(about: Analysis, expert: str, noise: float | None) -> tuple[float, float]:
    """The share of episodes that are accepted, and the median step of their first visits."""
    spec, ldba = about.spec, about.ldba
    assert spec is not None
    assert ldba is not None
    assert about.labels is not None
    made, seeds = spec.environment, range(EPISODES)
    episodes = play(
        made.id, made.kwargs, horizon=made.horizon, expert=expert, seeds=seeds, noise=noise
    )
    firsts = []
    for run in replay_all(DemoSet(episodes), about.labels, ldba)[1]:
        if run.visits and run.violates_at is None:
            accepting = np.isin(run.states[1:], sorted(ldba.accepting))
            firsts.append(1 + int(accepting.argmax()))
    return len(firsts) / EPISODES, float(np.median(firsts)) if firsts else float("nan")


def main(arguments: Sequence[str]) -> None:
    """Write the page; `arguments` are its path and the tasks that are played."""
    page, named = Path(arguments[0]), arguments[1:]
    bundle = sorted(Path(str(files("tiloilc.specs"))).glob("*.yaml"))
    rows = rows_of(page.read_text(encoding="utf-8")) if page.is_file() else {}
    rows = {name: rows[name] for name in rows if name in {task.stem for task in bundle}}
    for task in bundle:
        if not named or task.stem in named:
            rows[task.stem] = row(task)
            sys.stderr.write(rows[task.stem])
            page.write_text(page_of(rows), encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1:])
