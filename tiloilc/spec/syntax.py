"""What the YAML reader complains about, said in words that help."""

from __future__ import annotations

import re
from dataclasses import dataclass

from ruamel.yaml.error import MarkedYAMLError, YAMLError
from ruamel.yaml.reader import ReaderError

from tiloilc.diag import Diagnostic
from tiloilc.spec.nodes import Source
from tiloilc.spec.swallowed import SPECIAL, quoting_help, what_yaml_reads

_VALUE = re.compile(
    rf"\s*(?:-\s+)?(?P<key>[^\s:#][^:#]*?)\s*:[ \t]+(?P<value>[{re.escape(SPECIAL)}].*)"
)
_QUOTED = re.compile(r"""[^"'#]*?:[ \t]+(?:"(?:[^"\\]|\\.)*"|'[^']*')\s*(?P<rest>[^\s#].*)""")


@dataclass(frozen=True, slots=True)
class _Saying:
    """A complaint by a piece of its text, and ours instead."""

    piece: str
    problem: str
    label: str = ""
    help: str = ""


_SAYINGS = (
    _Saying(
        "mapping values are not allowed",
        "a `:` stands where no key can be",
        help="put the value in quotes if it contains a colon, else check the indentation",
    ),
    _Saying(
        "unexpected end of stream",
        "a quote is never closed",
        "opened here",
        "close the quote",
    ),
    _Saying(
        "unexpected document separator", "a quote is never closed", "opened here", "close the quote"
    ),
    _Saying("'\\t' that cannot start", "a tab cannot indent", "tab", "indent with spaces"),
    _Saying("that cannot start any token", "a value cannot begin with this", "", "quote the value"),
    _Saying("expected ',' or ']'", "a list is not closed", "", "close it with `]`"),
    _Saying("expected ',' or '}'", "a mapping is not closed", "", "close it with `}`"),
    _Saying(
        "expected <block end>, but found '<scalar>'",
        "text follows the end of a value",
        "does not belong to the value before",
        "put the whole value in quotes",
    ),
    _Saying(
        "expected <block end>",
        "this line does not fit the lines above",
        "unexpected here",
        "indent the keys of one mapping alike",
    ),
    _Saying(
        "could not find expected ':'",
        "this line is no `key: value`",
        "no `:` follows",
        "write `key: value`",
    ),
    _Saying(
        "unknown escape character",
        "double quotes know no such escape",
        "",
        "write `\\\\` for a backslash, or use single quotes",
    ),
    _Saying("found duplicate anchor", "an anchor is defined twice"),
    _Saying("expected escape sequence", "an escape is not finished", "", "use single quotes"),
)


def syntax_finding(error: YAMLError, source: Source) -> Diagnostic:
    """One finding for what stopped the YAML reader."""
    if isinstance(error, ReaderError):
        index = min(error.position, max(0, len(source.text) - 1))
        problem = f"a control character (U+{ord(source.text[index]):04X})"
        return Diagnostic.of("SPEC100", source.span(index, index + 1), problem=problem)
    index, context = _marks(error)
    complaint = str(getattr(error, "problem", ""))
    for place in (index, context):
        finding = _swallowed_value(source, place, index)
        if finding is not None:
            return finding
    start = source.text.rfind("\n", 0, index) + 1
    quoted = _QUOTED.match(source.text[start : source.line_end(start)])
    if quoted is not None and start + quoted.start("rest") <= index:
        return Diagnostic.of(
            "SPEC100",
            source.span(start + quoted.start("rest"), start + quoted.end("rest")),
            problem="text follows a closing quote",
            label="not in the quotes",
            help="put the whole value in one pair of quotes",
        )
    for saying in _SAYINGS:
        if saying.piece in complaint:
            unclosed = "\n" in source.text[context:index] and "closed" in saying.problem
            start = min(context if unclosed else index, len(source.text.rstrip()))
            return Diagnostic.of(
                "SPEC100",
                source.span(start, start + 1),
                problem=saying.problem,
                label=saying.label,
                help=saying.help,
            )
    index = min(index, len(source.text.rstrip()))
    problem = "the structure is broken here"
    return Diagnostic.of("SPEC100", source.span(index, index + 1), problem=problem)


def _swallowed_value(source: Source, place: int, index: int) -> Diagnostic | None:
    """The line around `place` has a value that begins with a special sign, before `index`."""
    start = source.text.rfind("\n", 0, place) + 1
    match = _VALUE.fullmatch(source.text[start : source.line_end(start)])
    if match is None or start + match.start("value") > index:
        return None
    value = match["value"]
    if value[0] in "[{" and not _closes(value):
        return None
    reading, token = what_yaml_reads(value)
    begin = start + match.start("value")
    return Diagnostic.of(
        "SPEC104",
        source.span(begin, begin + len(token)),
        problem=f"`{token}` is read as {reading}",
        label=f"{reading} to YAML",
        help=quoting_help(match["key"], value),
    )


def _closes(value: str) -> bool:
    """A collection that ends within the line, with more text behind it."""
    depth = 0
    for position, character in enumerate(value):
        depth += (character in "[{") - (character in "]}")
        if depth == 0:
            return bool(value[position + 1 :].strip())
    return False


def _marks(error: YAMLError) -> tuple[int, int]:
    """Where the reader stopped, and where what it was reading began."""
    if not isinstance(error, MarkedYAMLError) or error.problem_mark is None:
        return 0, 0
    index = error.problem_mark.index
    return index, index if error.context_mark is None else error.context_mark.index
