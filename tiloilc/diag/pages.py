"""The page of each code, in `docs/diagnostics`: what it means, and an example to the letter."""

from __future__ import annotations

import re
from importlib.resources import files

_HIDDEN = re.compile(r"^<!--.*?^-->\n\n?", re.MULTILINE | re.DOTALL)
_FENCED = re.compile(r"^```[^\n`]*\n(.*?)^```$", re.MULTILINE | re.DOTALL)


def page(code: str) -> str:
    """The page of a registered code, in Markdown."""
    return files("tiloilc.diagnostics").joinpath(f"{code}.md").read_text(encoding="utf-8")


def meaning(code: str) -> str:
    """The first paragraph of the page, on one line: what the code means."""
    return " ".join(page(code).split("\n\n")[1].split())


def shown(markdown: str) -> str:
    """A page without what only its test reads."""
    return _HIDDEN.sub("", markdown)


def readable(markdown: str) -> str:
    """A page for the terminal: without marks, what stood in fences indented."""

    def indented(fence: re.Match[str]) -> str:
        return "\n".join(f"    {line}".rstrip() for line in fence[1].splitlines())

    text = _FENCED.sub(indented, shown(markdown))
    return re.sub(r"^#+ ", "", text, flags=re.MULTILINE)
