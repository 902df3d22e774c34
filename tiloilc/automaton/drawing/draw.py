"""Automata as SVG and PNG: the same picture of the same automaton on every machine."""

from __future__ import annotations

from collections.abc import Mapping

from tiloilc.automaton.drawing.picture.compose import picture
from tiloilc.automaton.drawing.picture.pieces import HasIndex
from tiloilc.automaton.drawing.picture.png import png_bytes
from tiloilc.automaton.drawing.picture.svg import svg_text
from tiloilc.automaton.ldba import Ldba


def to_svg(
    ldba: Ldba,
    stages: HasIndex | None = None,
    title: str | None = None,
    notes: Mapping[str, str] | None = None,
) -> str:
    """`ldba` as SVG text. An automaton that is too large has a picture that says so.

    `notes` are short texts under what they are of: `state 2`, `edge 5`, `loop 2` for what stays in
    state 2, `lost 2` for what leads from there into the sink.
    """
    return svg_text(picture(ldba, stages, title, notes))


def to_png(ldba: Ldba, stages: HasIndex | None = None, title: str | None = None) -> bytes:
    """`ldba` as PNG; the letters are drawn in the machine's monospaced font."""
    return png_bytes(picture(ldba, stages, title))
