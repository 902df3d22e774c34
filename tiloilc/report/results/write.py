"""All pages and figures by their paths, and their writing."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from tiloilc.report.results.book import Book
from tiloilc.report.results.pages import (
    ablations,
    comparison,
    demonstrations,
    disjunction,
    every,
    index,
    learning,
    readme,
    verified,
)

__all__ = ["files", "write"]


def files(book: Book) -> dict[str, str]:
    """Every file of `docs/results/` with its text, by its path there."""
    pages = {
        "README.md": index.index(book),
        "all.md": every.page(book),
        "figure-3.md": learning.figure_3(book),
        "figure-8.md": disjunction.figure_8(book),
        "grids.md": learning.grids(book),
        "robots.md": learning.robots(book),
        "table-1.md": ablations.table_1(book),
        "table-2.md": ablations.table_2(book),
        "table-3.md": demonstrations.table_3(book),
        "table-4.md": demonstrations.table_4(book),
        "verified.md": verified.page(book),
    }
    if overview := readme.figure(book):
        pages["overview.svg"] = overview
    drawn = {**learning.curves(book), **ablations.files(book)}
    return {**pages, **drawn, **comparison.files(book), **demonstrations.files(book)}


def write(made: Mapping[str, str], folder: Path) -> None:
    """Make the folder hold these files and no other page or figure."""
    for path in [*folder.rglob("*.md"), *folder.rglob("*.svg")]:
        if path.relative_to(folder).as_posix() not in made:
            path.unlink()
    for name, text in made.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8", newline="\n")
