"""`python -m tiloilc.report.results [row ANCHOR]`, in the root of a checkout.

Without arguments: write `docs/results/`, and the part of `README.md` that is between its markers,
from `results/` and `specs/`. With `row` and the end of a link to a row: print the records that it
is made of.
"""

from __future__ import annotations

import sys
from pathlib import Path

from tiloilc.evaluate import Record
from tiloilc.report.results.book import open_book
from tiloilc.report.results.pages import readme
from tiloilc.report.results.write import files, write


def main(arguments: list[str]) -> None:
    """Do what the arguments say; raises SystemExit for others."""
    book = open_book(Path("results"), Path("specs"))
    match arguments:
        case []:
            write(files(book), Path("docs/results"))
            page = Path("README.md")
            page.write_text(readme.fill(page.read_text(encoding="utf-8"), book), encoding="utf-8")
        case ["row", anchor]:
            row = next((row for row in book.rows if row.anchor == anchor), None)
            if row is None:
                raise SystemExit(f"no row `{anchor}`")
            for run in row.runs:
                sys.stdout.write(f"{Record.of(run).text}\n")  # type: ignore[arg-type]
        case _:
            raise SystemExit("usage: python -m tiloilc.report.results [row ANCHOR]")


if __name__ == "__main__":
    main(sys.argv[1:])
