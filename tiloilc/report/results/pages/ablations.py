"""TiLoIL with one part changed: figure 4 (segments, stages), tables 1 (β) and 2 (discriminator)."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence

from tiloilc.report.results import paper
from tiloilc.report.results.book import Book, Family
from tiloilc.report.results.drawing import Panel, picture
from tiloilc.report.results.markdown import (
    MADE,
    cell,
    listed,
    optimum,
    pictures,
    table,
)  # fmt: skip
from tiloilc.report.results.measures import gap, line
from tiloilc.report.results.methods import Ink, method_name
from tiloilc.report.results.pages.learning import command, level
from tiloilc.report.results.rows import Changes, Row
from tiloilc.report.results.tasks import title
from tiloilc.spec.presets import PRESETS

FIGURE_4 = (
    "carlo", "cheetah_flip", "doggo_avoid", "doggo_navigate", "fetch_avoid", "fetch_align",
)  # fmt: skip
"""The tasks that the paper's text names with the figure."""

TABLE_1 = (
    "grid_circular_hard", "flatworld_stabilization", "flatworld_cycle", "doggo_avoid",
    "doggo_navigate", "fetch_avoid", "fetch_align", "carlo", "cheetah_flip",
)  # fmt: skip

TABLE_2 = (
    "doggo_avoid", "doggo_navigate", "fetch_avoid", "fetch_align", "carlo", "cheetah_flip",
    "flatworld_cycle",
)  # fmt: skip

PARTS = {
    "segment": ("no segments", Ink("#cf4f00", "#ff8a4c", "7 3")),
    "stages": ("no stages", Ink("#00875f", "#3ccb9d", "2 4")),
}
"""Each part, what TiLoIL without it is called, and its curve."""

WHOLE = Ink("#0068b3", "#58aef2", width=2.8)

BETAS = {"0.49": 0.49, "1/3": 1 / 3, "1/4": 0.25, "0": 0.0}
"""The paper's columns, and none."""

ABOUT = """\
A row names what its runs change from the preset beside the part in question, since a part is worth
little where others do its work: demonstrations that are cloned and replayed show every short way
already ([ADR 17](../adr/0017-what-the-default-was-chosen-by.md)). Numbers are accepting visits,
mean ± standard deviation over seeds; they lead to their records, and seeds × steps stand below.

"""


def _figure_4(book: Book, drawn: Mapping[str, Panel]) -> str:
    """TiLoIL without segments, and with one stage for all."""
    text = f"# Figure 4: without segments, without stages\n\n{MADE}\n"
    text += (
        "*No segments* (`segment=false`) does not cut episodes at acceptance; *no stages*\n"
        "(`stages=false`) has one discriminator and one stage for all that is not accepting. The\n"
        "paper shows curves and prints no numbers; it leaves out *no segments* on Doggo and\n"
        f"Fetch, where acceptance is never left.\n\n{ABOUT}"
    )
    if drawn:
        said = {path: f"{panel.title} with parts left out" for path, panel in drawn.items()}
        text += pictures(list(said.items()))
        text += "\nCurves are eventual returns with 95 % bootstrap intervals.\n\n"
    rows = []
    absent = []
    for task in dict.fromkeys((*FIGURE_4, *book.tasks)):
        families = _parted(book, task)
        rows += [_parts(book, family) for family in families]
        if not families and task in FIGURE_4:
            rows.append(_parts(book, Family(task, _alone(book, task))))
            absent.append(task)
    heads = ["task", "settings", "TiLoIL", "no segments", "no stages", "optimum"]
    return text + table(heads, rows) + _not_run(absent, "segment=false")


def files(book: Book) -> dict[str, str]:
    """The page of figure 4 and its drawings, by their paths."""
    drawn = _panels(book)
    pictures = {
        path: picture([panel], 1, f"{panel.title} with parts left out")
        for path, panel in drawn.items()
    }
    return {"figure-4.md": _figure_4(book, drawn), **pictures}


def table_1(book: Book) -> str:
    """What β is worth."""
    text = f"# Table 1: β\n\n{MADE}\n"
    text += (
        "β weighs the discriminators' part of the reward (Eq. 8). The paper's own numbers stand\n"
        "below ours, those of its baselines in the [overview](README.md).\n\n"
    )
    families, absent = _families(book, TABLE_1, "beta", ("segment", "stages", "discriminator"))
    heads = ["task", "settings", *(f"β = {name}" for name in BETAS), "optimum"]
    rows = [_betas(book, family) for family in families]
    return text + ABOUT + table(heads, rows) + _not_run(absent, "beta=0.49")


def table_2(book: Book) -> str:
    """One discriminator for all stages."""
    text = f"# Table 2: one discriminator for all stages\n\n{MADE}\n"
    text += (
        "*Shared* (`discriminator=shared`) is one discriminator that is told the automaton's\n"
        f"state; the paper's numbers, over 5 seeds, stand below ours.\n\n{ABOUT}"
    )
    families, absent = _families(book, TABLE_2, "discriminator", ("segment", "stages"))
    heads = ["task", "settings", "one for each stage", "shared", "difference [95 %]", "optimum"]
    rows = [_shared(book, family) for family in families]
    return text + table(heads, rows) + _not_run(absent, "discriminator=shared")


def _families(
    book: Book, asked: Sequence[str], setting: str, apart: Sequence[str]
) -> tuple[list[Family], list[str]]:
    """The families in which a setting varies, and those of the tasks `asked` in any case; which
    of these tasks it does not vary on.
    """
    shown, absent = [], []
    for task in dict.fromkeys((*asked, *book.tasks)):
        families = book.families(task, setting, apart=apart)
        varied = any(len(family.members) > 1 for family in families)
        if varied or task in asked:
            shown += families
        if not varied and task in asked:
            absent.append(task)
    return shown, absent


def _parted(book: Book, task: str) -> list[Family]:
    """The families of figure 4 with the whole method and one part or the other left out."""
    found = book.families(task, *PARTS, apart=("discriminator",))
    return [one for one in found if one.get() is not None and len(one.members) > 1]


def _alone(book: Book, task: str) -> dict[Changes, Row]:
    row = book.usual(task, "tiloil")
    return {} if row is None else {(): row}


def _parts(book: Book, family: Family) -> list[str]:
    whole = family.get()
    cells = []
    for part in PARTS:
        row = family.get(**{part: "false"})
        cells.append(cell(row, "" if row is None else gap(whole, row)))
    best = optimum(book.optimum(family.task))
    return [title(family.task), family.named(*PARTS), cell(whole), *cells, best]


def _panels(book: Book) -> dict[str, Panel]:
    """A panel for each family with a curve, by its path."""
    drawn = {}
    for task in book.tasks:
        for place, family in enumerate(_parted(book, task)):
            looks: dict[Changes, tuple[str, Ink]] = {(): (method_name("tiloil"), WHOLE)}
            looks |= {((part, "false"),): look for part, look in PARTS.items()}
            lines = [
                found
                for changes, (label, ink) in looks.items()
                if (row := family.members.get(changes)) is not None
                and (found := line(row, label, ink)) is not None
            ]
            if len(lines) > 1:
                name = task if place == 0 else f"{task}-{place + 1}"
                said = "eventual return" + ("" if place == 0 else f", {family.named(*PARTS)}")
                drawn[f"ablations/{name}.svg"] = Panel(title(task), said, lines, level(book, task))
    return drawn


def _betas(book: Book, family: Family) -> list[str]:
    """One row of table 1: each β with the paper's number below it."""
    usual = _beta_of(family)
    cells = []
    for name, value in BETAS.items():
        row = family.get(beta=_shown(value))
        if row is None and usual == value:
            row = family.get()
        printed = paper.numbers().get(("table 1", family.task, f"beta={name}"))
        cells.append(cell(row, "" if printed is None else f"paper {printed.text}"))
    best = optimum(book.optimum(family.task))
    return [title(family.task), family.named("beta"), *cells, best]


def _beta_of(family: Family) -> object:
    """What β is where a row does not change it."""
    row = next(iter(family.members.values()), None)
    return None if row is None else PRESETS[row.preset]["beta"]


def _shown(value: float) -> str:
    return json.dumps(int(value) if float(value).is_integer() else value)


def _shared(book: Book, family: Family) -> list[str]:
    """One row of table 2, with the difference and the paper's numbers."""
    rows = (family.get(), family.get(discriminator='"shared"'))
    cells = []
    for row, column in zip(rows, ("separate", "shared"), strict=True):
        printed = paper.numbers().get(("table 2", family.task, column))
        cells.append(cell(row, "" if printed is None else f"paper {printed.text}"))
    best = optimum(book.optimum(family.task))
    return [title(family.task), family.named("discriminator"), *cells, gap(*rows), best]


def _not_run(tasks: Sequence[str], change: str) -> str:
    """Which tasks lack their rows, and how to make one."""
    if not tasks:
        return ""
    names = listed([title(task) for task in tasks])
    return f"\nNot run, in whole or in part: {names}. `{command(tasks[0], change)}`\n"
