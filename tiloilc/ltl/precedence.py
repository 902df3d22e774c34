"""LTL214: places where the reading of a formula is probably not the writer's.

Only readings that reliably surprise: the everyday idioms (`!a U b`, `G !b & F a`, `GFa -> GFb`,
`a & b | c`, `a -> b -> c`) are left alone.
"""

from __future__ import annotations

from collections.abc import Iterator

from tiloilc.diag import Diagnostic, SourceText
from tiloilc.ltl.syntax import Syntax

TEMPORAL_PREFIXES = frozenset({"next", "eventually", "always", "bounded"})
UNTIL_LIKE = frozenset({"until", "weak", "release", "strong"})
ARROWS = frozenset({"implies", "iff"})
LONGEST_SHOWN = 60


def surprises(text: SourceText, tree: Syntax) -> Iterator[Diagnostic]:
    """A warning for each place of `tree` whose reading surprises, outermost first."""
    waiting = [tree]
    while waiting:
        node = waiting.pop()
        waiting.extend(reversed(node.parts))
        for place, part in enumerate(node.parts):
            if not part.bracketed and _surprises(node, place):
                yield _warning(text, node, place)
                break


def _surprises(node: Syntax, place: int) -> bool:
    """Whether it surprises that part `place`, without brackets, is an operand of `node`."""
    part = node.parts[place]
    if node.rule == "implies":
        # `G a -> F b`: most often G (a -> F b) was meant. `GFa -> GFb` is an idiom.
        swallowed = place == 0 and part.rule == "always" and not _is_temporal(part.parts[0])
        return swallowed or part.rule == "iff"
    if node.rule == "iff":
        return part.rule == "implies"
    if node.rule in UNTIL_LIKE:
        # `F a U b` is (F a) U b; `a U b R c` is a U (b R c).
        prefix = place == 0 and part.rule in TEMPORAL_PREFIXES
        return prefix or (part.rule in UNTIL_LIKE and part.rule != node.rule)
    if node.rule in ("both", "either") and part.rule in UNTIL_LIKE:
        # `a & b U c` is a & (b U c); beside temporal operands (`a U b & G !c`) nobody errs.
        beside = node.parts[max(0, place - 1) : place + 2]
        return any(not _is_temporal(other) for other in beside if other is not part)
    return False


def _is_temporal(part: Syntax) -> bool:
    """Whether `part` has a temporal operator."""
    waiting = [part]
    while waiting:
        node = waiting.pop()
        if node.rule in UNTIL_LIKE or node.rule in TEMPORAL_PREFIXES:
            return True
        waiting.extend(node.parts)
    return False


def _warning(text: SourceText, node: Syntax, place: int) -> Diagnostic:
    part = node.parts[place]
    start, end = node.parts[0].start, node.parts[-1].end
    reading = _with_brackets(text, start, part.start, part.end, end)
    choices = [reading, *_other_readings(text, node, place)]
    return Diagnostic.of(
        "LTL214",
        text.span(part.start, part.end),
        text=_short(text.value[start:end]),
        reading=reading,
        label="taken together",
        help="say it with brackets: " + " or ".join(f"`{choice}`" for choice in choices),
    )


def _other_readings(text: SourceText, node: Syntax, place: int) -> list[str]:
    """What else the writer may have meant: the operators of `node` and its part change places."""
    part = node.parts[place]
    start, end = node.parts[0].start, node.parts[-1].end
    if len(node.parts) != 2 or len(part.parts) > 2:
        return []
    if place == 0:
        return [_with_brackets(text, start, part.parts[-1].start, end, end)]
    return [_with_brackets(text, start, start, part.parts[0].end, end)]


def _with_brackets(text: SourceText, start: int, opened: int, closed: int, end: int) -> str:
    """`text[start:end]` on one line, with brackets around `[opened:closed]`."""
    value = text.value
    return _short(f"{value[start:opened]}({value[opened:closed]}){value[closed:end]}")


def _short(text: str) -> str:
    line = " ".join(text.split())
    return line if len(line) <= LONGEST_SHOWN else line[: LONGEST_SHOWN - 1] + "…"
