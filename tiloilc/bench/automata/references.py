"""Published sizes to compare with: `reference_sizes.csv`, one row for each formula.

For each formula of four sets from the literature and its negation, the reachable states of four
published variants of LDBA, with edge-based acceptance, without a sink, and with ε-jumps expanded or
not counted as states.
"""

from __future__ import annotations

import csv
from dataclasses import dataclass
from pathlib import Path

FILE = "reference_sizes.csv"

VARIANTS = ("asymmetric", "asymmetric_portfolio", "symmetric", "symmetric_portfolio")

COLUMNS = ("set", "formula", *VARIANTS, "best")


class BadReferences(ValueError):
    """The file is not there, or is not such a table."""


@dataclass(frozen=True, slots=True)
class Reference:
    """A formula of the set `origin`; `sizes` are those of VARIANTS, `best` is the least of them."""

    origin: str
    formula: str
    sizes: tuple[int, ...]
    best: int


def read_references(folder: Path) -> tuple[Reference, ...]:
    """All rows of the table in `folder`, in its order. Raises BadReferences."""
    path = folder / FILE
    try:
        with path.open(encoding="utf-8", newline="") as file:
            rows = list(csv.DictReader(file))
        return tuple(
            Reference(
                row["set"],
                row["formula"],
                tuple(int(row[variant]) for variant in VARIANTS),
                int(row["best"]),
            )
            for row in rows
        )
    except OSError as error:
        raise BadReferences(f"cannot read `{path.as_posix()}`: {error.strerror}") from None
    except (KeyError, TypeError, ValueError):
        raise BadReferences(
            f"`{path.as_posix()}` is not a table with the columns {', '.join(COLUMNS)}"
        ) from None
