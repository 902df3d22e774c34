"""Letters and words as people write them, printed and read.

A letter is a set of propositions, the ones that hold: `{a, b}`, or without braces `a b`, `a, b`,
`a & b & !c`. What is not named does not hold. Letters without braces are parted by `;`. An
infinite word ends in what is repeated: `{a} then for ever {b} {}`, or `a; cycle{b; !b}`.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

from tiloilc.diag import CompileError, Diagnostic, SourceText, did_you_mean
from tiloilc.ltl.lasso import Lasso, Letter
from tiloilc.ltl.printer import name_text

_TOKEN = re.compile(
    r"""\s*(?: (?P<loop>then\s+for\s+ever\b | for\s+ever\b | cycle\s*\{)
             | (?P<quoted>"(?:[^"\\]|\\.)*")
             | (?P<sign>[{}();,|] | && | & | ! | ¬ | ~)
             | (?P<name>[^\s{}();,|&!¬~"]+)
             | (?P<odd>\S) )""",
    re.VERBOSE,
)

NOTHING = ("true", "1")
"""Words for a letter of which nothing is said."""


@dataclass(frozen=True, slots=True)
class Word:
    """Letters one after the other, then `loop` for ever if there is one."""

    letters: tuple[Letter, ...]
    loop: tuple[Letter, ...] = ()

    @property
    def lasso(self) -> Lasso | None:
        """The infinite word; None if nothing is said of what comes after the letters."""
        return Lasso(self.letters, self.loop) if self.loop else None


def letter_text(letter: Letter, propositions: Sequence[str]) -> str:
    """A letter as the set of what holds: `{a, b}`."""
    names = (name_text(name) for i, name in enumerate(propositions) if letter >> i & 1)
    return f"{{{', '.join(names)}}}"


def word_text(word: Lasso, propositions: Sequence[str]) -> str:
    """An ultimately periodic word: `{a} {} then for ever {b, c} {}`."""
    stem, loop = (
        " ".join(letter_text(letter, propositions) for letter in part)
        for part in (word.stem, word.loop)
    )
    return f"{stem} then for ever {loop}" if stem else f"for ever {loop}"


def parse_word(text: SourceText | str, propositions: Sequence[str]) -> Word:
    """The word that `text` writes; bit i of a letter is `propositions[i]`.

    An empty text is no letter at all, an empty letter is `{}`. Raises CompileError LTL206 for what
    cannot be read, LTL203 for an unknown proposition.
    """
    source = SourceText.plain(text, "<word>") if isinstance(text, str) else text
    return _Reader(source, propositions).word()


@dataclass(frozen=True, slots=True)
class _Token:
    kind: str
    text: str
    start: int
    end: int


class _Reader:
    """Reads one word, from left to right."""

    def __init__(self, source: SourceText, propositions: Sequence[str]) -> None:
        self.source = source
        self.places = {name: i for i, name in enumerate(propositions)}
        self.tokens = [
            _Token(m.lastgroup, m[m.lastgroup], m.start(m.lastgroup), m.end())
            for m in _TOKEN.finditer(source.value)
            if m.lastgroup is not None
        ]
        self.at = 0

    def word(self) -> Word:
        letters = self.letters(until="")
        loop: tuple[Letter, ...] = ()
        opened = self.taken("loop")
        if opened is not None:
            braced = opened.text.endswith("{")
            loop = self.letters(until="}" if braced else "")
            if not loop:
                raise self.error("nothing is repeated", opened, "write at least one letter, as {}")
            if braced and self.taken("sign", "}") is None:
                raise self.error("`cycle{` is never closed", opened, "add `}` at the end")
        if (rest := self.token) is not None:
            after = "after what is repeated" if loop else "here"
            raise self.error(f"`{rest.text}` cannot stand {after}", rest)
        return Word(letters, loop)

    @property
    def token(self) -> _Token | None:
        return self.tokens[self.at] if self.at < len(self.tokens) else None

    def taken(self, kind: str, text: str | None = None) -> _Token | None:
        """The next token, passed, if it is such a one."""
        token = self.token
        if token is None or token.kind != kind or text not in (None, token.text):
            return None
        self.at += 1
        return token

    def letters(self, until: str) -> tuple[Letter, ...]:
        """Letters up to the sign `until`, to what is repeated, or to the end."""
        found: list[Letter] = []
        parted = True  # whether a letter without braces may begin here
        while (token := self.token) is not None and token.kind != "loop":
            if token.text == until and token.kind == "sign":
                break
            if self.taken("sign", ";"):
                if parted:
                    found.append(0)
                parted = True
            elif opened := self.taken("sign", "{"):
                found.append(self.letter(opened))
                parted = self.taken("sign", ";") is not None
            elif parted:
                found.append(self.letter(None))
                parted = self.taken("sign", ";") is not None
            else:
                raise self.error(
                    f"`{token.text}` cannot stand here", token, "part letters with `;`"
                )
        return tuple(found)

    def letter(self, opened: _Token | None) -> Letter:
        """A letter up to its closing brace, or up to what parts it from the next."""
        signs: dict[str, bool] = {}
        while (token := self.token) is not None and token.kind != "loop":
            if token.kind == "sign" and token.text in "{};":
                break
            if token.kind == "sign" and token.text in (",", "&", "&&"):
                self.at += 1
                continue
            sign = True
            while self.token is not None and self.token.text in ("!", "¬", "~"):
                sign = not sign
                self.at += 1
            self.literal(signs, sign)
        if opened is not None and self.taken("sign", "}") is None:
            raise self.error("`{` is never closed", opened, "add `}`")
        return sum(1 << self.places[name] for name, sign in signs.items() if sign)

    def literal(self, signs: dict[str, bool], sign: bool) -> None:
        """One proposition of a letter, into `signs`."""
        token = self.token
        if token is None or token.kind not in ("name", "quoted"):
            where = token or self.tokens[-1]
            shown = f"`{where.text}` is no proposition" if token else "a proposition is missing"
            if where.kind == "odd":
                raise self.error("a quote is never closed", where, 'add `"`')
            help = "a letter says which propositions hold: `a, b` or `a & !b`"
            raise self.error(shown, where, help)
        self.at += 1
        name = token.text
        if token.kind == "quoted":
            name = re.sub(r"\\(.)", r"\1", name[1:-1])
        elif name in NOTHING and name not in self.places and sign:
            return
        if name not in self.places:
            help = did_you_mean(name, list(self.places), listed="declared")
            span = self.source.span(token.start, token.end)
            found = Diagnostic.of("LTL203", span, name=name, label="not declared", help=help)
            raise CompileError(found)
        if signs.setdefault(name, sign) != sign:
            raise self.error(f"`{name}` cannot hold and not hold in one letter", token)

    def error(self, problem: str, token: _Token, help: str = "") -> CompileError:
        span = self.source.span(token.start, token.end)
        return CompileError(Diagnostic.of("LTL206", span, problem=problem, help=help))
