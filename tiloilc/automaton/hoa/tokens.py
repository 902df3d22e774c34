"""The words of a HOA file, one after the other, with their places."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Literal, NamedTuple

from tiloilc.automaton.limits import Budget, too_large
from tiloilc.diag import CompileError, Diagnostic, Span
from tiloilc.diag.text import one_line

MAX_CHARACTERS = 16_000_000
"""Of one file: many times what the limit of states can fill, and a minute's reading."""

LARGEST = 2**31 - 1
"""The greatest number that the format allows."""

Kind = Literal["string", "section", "header", "word", "alias", "int", "sign", "end"]

_TOKEN = re.compile(
    r'(?P<string>"(?:[^"\\]++|\\.)*+")'
    r"|(?P<section>--(?:BODY|END|ABORT)--)"
    r"|(?P<header>[a-zA-Z_][0-9a-zA-Z_-]*:)"
    r"|(?P<word>[a-zA-Z_][0-9a-zA-Z_-]*)"
    r"|(?P<alias>@[0-9a-zA-Z_-]+)"
    r"|(?P<int>[0-9]+)"
    r"|(?P<sign>[][{}()&|!])",
    re.DOTALL,
)
_SPACE = re.compile(r"[ \t\n\r]*")
_COMMENT = re.compile(r"/\*|\*/")

_SHOWN = 30
"""Characters of a word that a message repeats."""


class Token(NamedTuple):
    """A word of the file and where it stands: `text[start:end]`. `kind` "end": there is no more."""

    kind: Kind
    text: str
    start: int
    end: int


class Tokens:
    """The words of `text` from left to right; `next` is the one that comes.

    Raises CompileError AUT302 where no word of the format stands, and at `--ABORT--`.
    """

    def __init__(self, text: str, file: str, budget: Budget) -> None:
        self.text = text
        self.file = file
        self.budget = budget
        if len(text) > MAX_CHARACTERS:
            raise too_large(f"the file has more than {MAX_CHARACTERS:_} characters")
        self._words = self._read()
        self.next = next(self._words)

    def take(self) -> Token:
        """The next word, which is then behind us."""
        token = self.next
        if token.kind != "end":
            self.next = next(self._words)
        return token

    def at(self, *signs: str) -> bool:
        """Whether one of `signs` comes next."""
        return self.next.kind == "sign" and self.next.text in signs

    def expect(self, kind: Kind, what: str, text: str | None = None) -> Token:
        """The next word, which must be of `kind`, and `text` if given; `what` says so in words."""
        if self.next.kind != kind or (text is not None and self.next.text != text):
            raise self.unexpected(what)
        return self.take()

    def number(self, what: str) -> tuple[int, Token]:
        """The next word as a number of the format."""
        token = self.expect("int", what)
        if token.text[0] == "0" and token.text != "0":
            raise self.error(token, f"`{shown(token)}` begins with a useless 0")
        if len(token.text) > len(str(LARGEST)) or int(token.text) > LARGEST:
            raise self.error(token, f"`{shown(token)}` is greater than {LARGEST}")
        return int(token.text), token

    def unexpected(self, what: str) -> CompileError:
        """AUT302: `what` was expected where the next word stands."""
        found = "the end of the file" if self.next.kind == "end" else f"`{shown(self.next)}`"
        return self.error(self.next, f"expected {what}, found {found}", label=f"expected {what}")

    def error(
        self,
        place: Token,
        problem: str,
        *,
        label: str = "",
        help: str = "",
    ) -> CompileError:
        """AUT302 at `place`."""
        span = self.span(place.start, place.end)
        return CompileError(Diagnostic.of("AUT302", span, label=label, help=help, problem=problem))

    def span(self, start: int, end: int) -> Span:
        """The stretch `text[start:end]` as lines and columns; an empty one covers one character."""
        end = max(end, start + 1)
        line, column = self._place(start)
        last_line, last_column = self._place(end - 1)
        return Span(self.file, line, column, last_line, last_column + 1)

    def _place(self, index: int) -> tuple[int, int]:
        return self.text.count("\n", 0, index) + 1, index - self.text.rfind("\n", 0, index)

    def _read(self) -> Iterator[Token]:
        position = 1 if self.text.startswith("\N{ZERO WIDTH NO-BREAK SPACE}") else 0
        while True:
            self.budget.tick()
            position = self._after_space(position)
            match = _TOKEN.match(self.text, position)
            if match is None:
                break
            kind: Kind = match.lastgroup  # type: ignore[assignment]  # the names of the groups
            token = Token(kind, match.group(), position, match.end())
            if token.text == "--ABORT--":
                problem = "its writer gave up: `--ABORT--`"
                raise self.error(token, problem, help="write the file again")
            yield token
            position = token.end
        if position < len(self.text):
            raise self._no_word(position)
        end = Token("end", "", len(self.text.rstrip()), len(self.text.rstrip()))
        while True:
            yield end

    def _after_space(self, position: int) -> int:
        """Where the next word begins: after white space and comments, which may be nested."""
        while True:
            match = _SPACE.match(self.text, position)
            assert match is not None, "it may be empty"
            position = match.end()
            if not self.text.startswith("/*", position):
                return position
            begin, depth = position, 0
            while True:
                self.budget.tick()
                mark = _COMMENT.search(self.text, position)
                if mark is None:
                    raise self.error(
                        Token("sign", "/*", begin, begin + 2), "the comment never ends"
                    )
                position = mark.end()
                depth += 1 if mark.group() == "/*" else -1
                if depth == 0:
                    break

    def _no_word(self, position: int) -> CompileError:
        character = self.text[position]
        token = Token("sign", character, position, position + 1)
        if character == '"':
            return self.error(token, "the quoted text never ends", help='put a `"` behind it')
        return self.error(token, f"`{shown(token)}` does not belong to the format")


def shown(token: Token) -> str:
    """The word as a message repeats it."""
    text = token.text
    return one_line(text if len(text) <= _SHOWN else f"{text[: _SHOWN - 1]}…")


def unquoted(token: Token) -> str:
    """The text of a quoted word."""
    return re.sub(r"\\(.)", r"\1", token.text[1:-1], flags=re.DOTALL)
