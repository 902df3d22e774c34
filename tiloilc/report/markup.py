"""HTML and SVG elements that escape what they are given: text becomes markup only by `tag`."""

from __future__ import annotations

from collections.abc import Iterable
from html import escape

__all__ = ["Markup", "concat", "number", "tag", "text"]

VOID = frozenset({"br", "img", "link", "meta"})
"""HTML elements without an end tag."""


class Markup(str):
    """Text that is already HTML. Only this module and trusted files make it from plain text."""

    __slots__ = ()


def tag(
    name: str, /, *children: str | Iterable[str], **attributes: str | float | bool | None
) -> Markup:
    """One element. Children that are not Markup are escaped; so are all attribute values.

    `class_` is `class`, other underscores become hyphens. None and False leave an attribute out,
    True gives it no value; numbers are rounded to two places, enough for SVG units.
    """
    parts = [f"<{name}"]
    for key, value in attributes.items():
        if value is None or value is False:
            continue
        label = key.rstrip("_").replace("_", "-")
        if value is True:
            parts.append(f" {label}")
        else:
            shown = value if isinstance(value, str) else number(value)
            parts.append(f' {label}="{escape(shown)}"')
    parts.append(">")
    if name not in VOID:
        parts.append(concat(*children))
        parts.append(f"</{name}>")
    return Markup("".join(parts))


def concat(*children: str | Iterable[str]) -> Markup:
    """Children one after the other, each escaped unless it is Markup."""
    return Markup(
        "".join(
            text(child) if isinstance(child, str) else concat(*child)  # a child or a list of them
            for child in children
        )
    )


def text(value: str) -> Markup:
    """Plain text as Markup; Markup stays as it is."""
    return value if isinstance(value, Markup) else Markup(escape(value, quote=False))


def number(value: float) -> str:
    """At most two places, no trailing zeros, no negative zero: one text for one place on screen."""
    shown = f"{value:.2f}".rstrip("0").rstrip(".")
    return "0" if shown == "-0" else shown
