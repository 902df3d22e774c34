"""Formula text to tokens: symbols, quoted propositions, and words that may hide operators.

Spot's spelling, with words for operators besides. A word is read from the left, like this:

- where a formula may begin, a declared proposition first; then an operator or a constant; then F,
  G or X followed by the rest of the word (`GFa`); a letter before a digit is no operator (`F1`);
- of these only what fits: a unary operator if a formula follows, else something that ends one (so
  that with G declared `G a` is still the operator, and `a & G` the proposition);
- X, F and G may have bounds: `X[3]`, `F[2:5]`, `G[2..]`;
- after a formula, a binary operator, alone (`U`) or followed by the rest of the word (`Ub`).
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass, field
from difflib import SequenceMatcher

SYMBOLS = {
    "NOT": ("!", "~", "¬"),
    "AND": ("&", "&&", "/\\", "∧", "∩", "*"),
    "OR": ("|", "||", "\\/", "∨", "∪", "+"),
    "XOR": ("^", "⊕"),
    "IMPLIES": ("->", "-->", "=>", "→", "⟶", "⇒", "⟹"),
    "IFF": ("<->", "<-->", "<=>", "↔", "⟷", "⇔", "⟺"),
    "NEXT": ("()", "○", "◯", "Ⓧ"),
    "EVENTUALLY": ("<>", "◇", "⋄", "♢"),
    "ALWAYS": ("[]", "□", "⬜", "◻"),
    "TRUE": ("⊤",),
    "FALSE": ("⊥",),
    "OPEN": ("(",),
    "CLOSE": (")",),
    "IS_TRUE": ("=1",),
    "IS_FALSE": ("=0", "\N{COMBINING OVERLINE}", "\N{COMBINING MACRON}"),
}
"""Spellings that need no space around them."""

WORDS = {
    "NOT": ("not",),
    "AND": ("and",),
    "OR": ("or",),
    "XOR": ("xor",),
    "IMPLIES": ("implies", "IMP"),
    "IFF": ("iff", "BIIMP"),
    "NEXT": ("X", "next"),
    "EVENTUALLY": ("F", "eventually", "finally"),
    "ALWAYS": ("G", "always", "globally"),
    "UNTIL": ("U", "until"),
    "WEAK": ("W", "weak", "weak_until"),
    "RELEASE": ("R", "V", "release", "releases"),
    "STRONG": ("M", "strong_release"),
    "TRUE": ("1", "true", "True", "TRUE", "tt"),
    "FALSE": ("0", "false", "False", "FALSE", "ff"),
}
"""Spellings that are words."""

SYMBOL_KINDS = {spelling: kind for kind, spellings in SYMBOLS.items() for spelling in spellings}
WORD_KINDS = {spelling: kind for kind, spellings in WORDS.items() for spelling in spellings}
PREFIXES = {"F": "EVENTUALLY", "G": "ALWAYS", "X": "NEXT"}
INFIXES = {"U": "UNTIL", "W": "WEAK", "R": "RELEASE", "V": "RELEASE", "M": "STRONG"}
UNARY_KINDS = frozenset({"NOT", "NEXT", "EVENTUALLY", "ALWAYS"})
CONSTANT_KINDS = frozenset({"TRUE", "FALSE"})
OPERAND_ENDS = frozenset({"NAME", "CLOSE", "IS_TRUE", "IS_FALSE"}) | CONSTANT_KINDS
BINARY_KINDS = frozenset(
    {"AND", "OR", "XOR", "IMPLIES", "IFF", "UNTIL", "WEAK", "RELEASE", "STRONG"}
)


_SPACE = re.compile(r"(?:\s+|/\*.*?\*/)+", re.DOTALL)
_WORD = re.compile(r"[\w.]+")
QUOTED = re.compile(r'"((?:[^"\\]|\\.)*)"', re.DOTALL)
SINGLE_QUOTED = re.compile(r"'((?:[^'\\]|\\.)*)'", re.DOTALL)
_TWO_WORDS = re.compile(r"(weak)\s+until\b|(strong)\s+release\b")
_SYMBOL = re.compile("|".join(re.escape(s) for s in sorted(SYMBOL_KINDS, key=len, reverse=True)))
_BOUNDS = re.compile(
    r"\s*\[\s*(?P<first>\d+)?\s*"
    r"(?:(?P<to>:|\.\.|,|to)\s*(?P<last>\d+|\$|inf)?\s*)?(?P<strong>!)?\s*\]"
)
_DIGITS = 9
"""A bound of more digits is one as large as these allow: the parser refuses far smaller ones."""
_FOREIGN = re.compile(r"!=|=(?![01>])=*|=>=|<=(?!>)|>=|<-(?![>-])|:=")
"""Operators of other languages that would be cut into ours."""
_STRANGE = re.compile(r"\[[^\[\]]{0,40}\]|(.)\1*", re.DOTALL)
_PREFIX_RUN = re.compile(r"[FGX]*")
_PLAIN_NAME = re.compile(r"[a-zA-EH-WYZ_.][a-zA-Z0-9_.]*|[FGX][0-9][a-zA-Z0-9_.]*")
_ALIKE = 0.6
"""How similar (difflib) a name must be to a declared one to be taken for a slip of it."""


@dataclass(frozen=True, slots=True)
class Token:
    """A stretch `[start, end)` of the text and what it is; `name` is set for propositions."""

    kind: str
    start: int
    end: int
    name: str = ""


@dataclass(frozen=True, slots=True)
class Ambiguity:
    """The proposition `name` at `[start, end)` could have been read `otherwise`."""

    start: int
    end: int
    name: str
    otherwise: str


@dataclass(frozen=True, slots=True)
class Lexed:
    """The tokens of a text, the stretches that are no token, the words read one of two ways."""

    tokens: list[Token] = field(default_factory=list)
    strange: list[tuple[int, int]] = field(default_factory=list)
    ambiguous: list[Ambiguity] = field(default_factory=list)


def tokenize(text: str, declared: Iterable[str] | None) -> Lexed:
    """The tokens of `text`. With `declared` None every identifier is a proposition."""
    words = _Words(None if declared is None else frozenset(declared))
    lexed = Lexed()
    at = 0
    while at < len(text):
        if space := _SPACE.match(text, at):
            at = space.end()
        elif pair := _TWO_WORDS.match(text, at):
            lexed.tokens.append(Token("WEAK" if pair[1] else "STRONG", at, pair.end()))
            at = pair.end()
        elif word := _WORD.match(text, at):
            words.read(word.group(), at, lexed, _formula_follows(text, word.end()))
            at = _with_bounds(text, word.end(), lexed.tokens)
        elif quoted := QUOTED.match(text, at) or _single_quoted(text, at, lexed.tokens):
            name = re.sub(r"\\(.)", r"\1", quoted[1], flags=re.DOTALL)
            if name and name.isprintable():
                lexed.tokens.append(Token("NAME", at, quoted.end(), name))
            else:
                lexed.strange.append((at, quoted.end()))
            at = quoted.end()
        elif text.startswith("/*", at) or text[at] == '"':
            lexed.strange.append((at, len(text)))
            at = len(text)
        elif foreign := _FOREIGN.match(text, at):
            lexed.strange.append((at, foreign.end()))
            at = foreign.end()
        elif symbol := _SYMBOL.match(text, at):
            lexed.tokens.append(Token(SYMBOL_KINDS[symbol.group()], at, symbol.end()))
            at = _with_bounds(text, symbol.end(), lexed.tokens)
        else:
            run = _STRANGE.match(text, at)
            assert run is not None
            lexed.strange.append((at, run.end()))
            at = run.end()
    return lexed


def _with_bounds(text: str, at: int, tokens: list[Token]) -> int:
    """Make `F` into `F[2:5]`, if bounds follow: a token whose name is `EVENTUALLY 2 5`.

    X takes one number or none (`X[!]`: on infinite words the strong next is the next), F and G two;
    without the first they begin now, without the second they are open (`F[2:]`, `F[2..$]`).
    Returns where the text goes on.
    """
    bounds = _BOUNDS.match(text, at)
    if bounds is None or not tokens or tokens[-1].kind not in UNARY_KINDS - {"NOT"}:
        return at
    kind, first, to, last = tokens[-1].kind, bounds["first"], bounds["to"], bounds["last"]
    if (to is None) != (kind == "NEXT") or (first is None and to is None and not bounds["strong"]):
        return at
    until = _bound(last) if last and last.isdigit() else None
    since = _bound(first) if first else int(to is None)
    if until is not None and until < since:
        return at
    name = f"{kind} {since}" + ("" if until is None else f" {until}")
    tokens[-1] = Token("BOUNDED", tokens[-1].start, bounds.end(), name)
    return bounds.end()


def _bound(digits: str) -> int:
    """The number that is written, or the largest that a bound can be."""
    significant = digits.lstrip("0") or "0"
    return int(significant) if len(significant) <= _DIGITS else 10**_DIGITS


def _single_quoted(text: str, at: int, tokens: list[Token]) -> re.Match[str] | None:
    """A proposition in single quotes, as Owl reads it; not where `a'` is meant."""
    ends = tokens and tokens[-1].kind in OPERAND_ENDS and tokens[-1].end == at
    return None if ends else SINGLE_QUOTED.match(text, at)


def keyword(word: str) -> str | None:
    """The kind of an operator or constant that is a word; longer words in any case."""
    return WORD_KINDS.get(word) or (_LONG_WORDS.get(word.lower()) if len(word) > 1 else None)


_LONG_WORDS = {word: kind for word, kind in WORD_KINDS.items() if len(word) > 2 or word == "or"}


def is_plain_name(name: str) -> bool:
    """Whether `name` needs no quotes: Spot and we read it as a proposition, declared or not."""
    return bool(_PLAIN_NAME.fullmatch(name)) and not keyword(name) and name != "first_match"


def _formula_follows(text: str, at: int) -> bool:
    """Whether a formula begins at `at`, rather than that something goes on or ends there."""
    if space := _SPACE.match(text, at):
        at = space.end()
    if word := _WORD.match(text, at):
        kind = keyword(word.group())
        return kind not in BINARY_KINDS and (kind is not None or word.group()[0] not in INFIXES)
    if _BOUNDS.match(text, at):
        return True
    if symbol := _SYMBOL.match(text, at):
        return SYMBOL_KINDS[symbol.group()] in UNARY_KINDS | CONSTANT_KINDS | {"OPEN"}
    return text[at : at + 1] == '"'


class _Words:
    """Reads words, given the declared propositions (None: any)."""

    def __init__(self, declared: frozenset[str] | None) -> None:
        self.declared = declared
        longest = max(map(len, WORD_KINDS))
        self.longest = max(longest, *map(len, declared)) if declared else longest

    def read(self, word: str, at: int, lexed: Lexed, formula_follows: bool) -> None:
        """Append the tokens of `word`, which begins at `at`."""
        tokens, end = lexed.tokens, at + len(word)
        if tokens and tokens[-1].kind in OPERAND_ENDS:
            kind = keyword(word)
            if kind in BINARY_KINDS:
                tokens.append(Token(kind, at, end))
                return
            if kind is None and word[0] in INFIXES and self._readings(word[1:]):
                tokens.append(Token(INFIXES[word[0]], at, at + 1))
                word, at = word[1:], at + 1
        readings = self._readings(word)
        fitting = [r for r in readings if (r[1] in UNARY_KINDS) == formula_follows] or readings
        if not fitting and word[0].isdigit():
            lexed.strange.append((at, end))
            return
        cut, kind = fitting[0] if fitting else (self._unknown_from(word), "NAME")
        for i, letter in enumerate(word[:cut]):
            tokens.append(Token(PREFIXES[letter], at + i, at + i + 1))
        tokens.append(Token(kind, at + cut, end, word[cut:] if kind == "NAME" else ""))
        if kind == "NAME" and len(fitting) > 1:
            other, _ = fitting[1]
            otherwise = " ".join((*word[cut:other], word[other:]))
            lexed.ambiguous.append(Ambiguity(at + cut, end, word[cut:], otherwise))

    def _readings(self, word: str) -> list[tuple[int, str]]:
        """The ways to read `word`: how many letters are operators, and what the rest is.

        Only ways that make sense where a formula may begin, the preferred one first.
        """
        if self.declared is None:
            return self._undeclared_readings(word)
        found: list[tuple[int, str]] = []
        for cut in self._cuts(word):
            if len(word) - cut > self.longest:
                continue
            rest = word[cut:]
            if rest in self.declared:
                found.append((cut, "NAME"))
            if kind := keyword(rest):
                found.append((cut, kind))
        return found

    def _undeclared_readings(self, word: str) -> list[tuple[int, str]]:
        """As Spot reads it: operators and constants first, then F, G and X, then a name."""
        for cut in self._cuts(word):
            if len(word) - cut <= self.longest and (kind := keyword(word[cut:])):
                return [(cut, kind)]
        return [(self._cuts(word)[-1], "NAME")] if word and not word[0].isdigit() else []

    def _cuts(self, word: str) -> range:
        """After how many letters of `word`, read as F, G and X, another reading may begin."""
        run = _PREFIX_RUN.match(word)
        assert run is not None
        length = run.end()
        if length == len(word):
            return range(max(1, length))
        return range(length if word[length].isdigit() and length else length + 1)

    def _unknown_from(self, word: str) -> int:
        """Where the unknown name in `word` begins: where it looks most like a declared one."""
        cuts = self._cuts(word)
        if len(word) > 80 or not self.declared:
            return cuts[-1]

        def likeness(cut: int) -> float:
            rest = word[cut:].casefold()
            best = max(
                SequenceMatcher(None, rest, name.casefold()).ratio() for name in self.declared or ()
            )
            return best if best >= _ALIKE else 0.0

        return max(reversed(cuts), key=likeness)
