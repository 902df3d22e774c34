"""Did you mean: the known name nearest to what was written."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches


def nearest(name: str, known: Iterable[str]) -> str | None:
    """The known name most like `name`, if one is like it at all; the first of equals."""
    names = list(dict.fromkeys(known))
    for candidate in names:
        if candidate.lower() == name.lower():
            return candidate
    return next(iter(get_close_matches(name, names, n=1, cutoff=0.6)), None)


def did_you_mean(name: str, known: Iterable[str], *, listed: str = "known") -> str:
    """A help line: the nearest name, and the known ones when they are few.

    For example ``did you mean `c`? declared: a, b, c`` with `listed="declared"`.
    """
    names = list(dict.fromkeys(known))
    guess = nearest(name, names)
    question = f"did you mean `{guess}`?" if guess else ""
    listing = f"{listed}: {', '.join(names)}" if 0 < len(names) <= 24 else ""
    return " ".join(part for part in (question, listing) if part)
