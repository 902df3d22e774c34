"""The formula that YAML swallows: `formula: !b & F a` is a tag and an anchor, not text."""

from __future__ import annotations

import re
from collections.abc import Sequence

from tiloilc.spec.nodes import shorten

_TOKEN = re.compile(r"[!&*][^\s,\]}]*|\[\]|.")
_READINGS = {
    "!": "a tag",
    "&": "an anchor",
    "*": "an alias",
    "|": "a block of text",
    ">": "a block of text",
    "[": "a list",
    "{": "a mapping",
    "%": "a directive",
    "@": "a reserved sign",
    "`": "a reserved sign",
}
SPECIAL = "".join(_READINGS)
"""Characters with which YAML lets no ordinary text begin."""


def swallowed(path: Sequence[str], first: str) -> bool:
    """Whether text at `path` that begins with `first` was meant as a formula or predicate."""
    formula = tuple(path) == ("formula",) or (len(path) == 2 and path[0] == "propositions")
    return formula and first in SPECIAL


def what_yaml_reads(line: str) -> tuple[str, str]:
    """What YAML takes the beginning of `line` for, and that beginning."""
    token = _TOKEN.match(line)
    assert token is not None, "a swallowed text is not empty"
    return _READINGS.get(token.group()[0], "something else"), token.group()


def quoting_help(key: str | None, line: str) -> str:
    """How to quote the value `line`, spelt out if it is short."""
    value = without_comment(line)
    if key is None or len(value) > 60 or "\\" in value or ('"' in value and "'" in value):
        return "put the whole text in quotes"
    quote = "'" if '"' in value else '"'
    quoted = f"{quote}{shorten(value, 60)}{quote}"
    return f"quote it: {key}: {quoted}"


def without_comment(line: str) -> str:
    """The rest of a line as it was meant, without a comment and space behind it."""
    return re.sub(r"\s+#.*$", "", line).rstrip()
