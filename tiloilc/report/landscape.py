"""The reward over the plane, one picture a stage: pixels, and the map's zones over them."""

from __future__ import annotations

import base64
import struct
import zlib
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from tiloilc.plan import Plan
from tiloilc.report.maps import Map
from tiloilc.report.markup import Markup, concat, number, tag
from tiloilc.report.runs.reading import Floats, Rewards
from tiloilc.report.scene import SIZE, outlines
from tiloilc.report.states import State

__all__ = ["key", "pictures"]

RAMP = ((38, 84, 158), (124, 165, 212), (242, 239, 230), (236, 158, 92), (178, 62, 12))
"""From what a discriminator avoids to what it seeks, told apart by colour-blind readers too."""


def pictures(rewards: Rewards, drawn: Map, states: Sequence[State], plan: Plan) -> Markup | None:
    """A picture of each stage on the way to acceptance, in their order; None if there is none.

    Every stage has its own range, (SIDX − β) / N to (SIDX + β) / N: one colour is one opinion of
    its discriminator.
    """
    live = sorted((s for s in states if s.kind == "live"), key=lambda s: (s.stage, s.number))
    drawn_states = []
    for state in live:
        middle, reach = _range(plan, state.number)
        opinion = (rewards.mean[state.number] - middle) / reach
        if not np.abs(opinion).max() > 1e-6:
            continue  # it has no discriminator
        low, high = f"{middle - reach:.2f}", f"{middle + reach:.2f}"
        said = f"reward {low} to {high}".replace("-", "−")
        picture = _picture(opinion, rewards, drawn, f"{state.label}: {said}")
        caption = tag("figcaption", tag("b", state.label), " ", tag("span", said))
        drawn_states.append(tag("figure", picture, caption))
    return tag("div", drawn_states, class_="panels landscape") if drawn_states else None


def key() -> Markup:
    """The colours, from −1 to 1."""
    stops = ", ".join(f"rgb({r} {g} {b})" for r, g, b in RAMP)
    bar = tag("i", class_="ramp", style=f"background: linear-gradient(to right, {stops})")
    return tag("p", "avoided ", bar, " sought", class_="quiet")


def _range(plan: Plan, state: int) -> tuple[float, float]:
    """The reward of a discriminator without an opinion, and how far it can move it (Eq. 8)."""
    if not plan.train.stages:
        return 0.0, 1.0
    length = max(plan.stages.length[state], 1)
    return plan.stages.index[state] / length, plan.train.beta / length


def _picture(opinion: Floats, rewards: Rewards, drawn: Map, title: str) -> Markup:
    across, up = drawn.position
    assert {across, up} == {0, 1}
    x, y = (rewards.x, rewards.y) if across == 0 else (rewards.y, rewards.x)
    values = opinion if across == 0 else opinion.T
    half = [(axis[-1] - axis[0]) / (len(axis) - 1) / 2 for axis in (x, y)]
    x_min, y_min = x[0] - half[0], y[0] - half[1]
    x_max, y_max = x[-1] + half[0], y[-1] + half[1]
    scale = SIZE / max(y_max - y_min, (x_max - x_min) / 3)
    width, height = (x_max - x_min) * scale, (y_max - y_min) * scale
    cells = all((np.diff(axis) == 1).all() for axis in (x, y))  # a table has nothing between them
    href = "data:image/png;base64," + base64.b64encode(png(coloured(values[::-1]))).decode()
    body = [
        tag(
            "image",
            href=href,
            width=width,
            height=height,
            preserveAspectRatio="none",
            image_rendering="pixelated" if cells else "auto",
        ),
        concat(outlines(drawn, x_min, y_max, scale)),
    ]
    return tag("svg", tag("title", title), body, class_="scene", role="img", aria_label=title,
               viewBox=f"0 0 {number(width)} {number(height)}")  # fmt: skip


def coloured(values: Floats) -> npt.NDArray[np.uint8]:
    """Values in [−1, 1] as colours of the ramp, [h, w, 3]."""
    places = np.linspace(-1, 1, len(RAMP))
    channels = [np.interp(values, places, [color[c] for color in RAMP]) for c in range(3)]
    return np.stack(channels, axis=-1).round().astype(np.uint8)


def png(pixels: npt.NDArray[np.uint8]) -> bytes:
    """Pixels [h, w, 3] as a PNG file."""

    def chunk(kind: bytes, data: bytes) -> bytes:
        return (
            struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
        )

    height, width, _ = pixels.shape
    rows = b"".join(b"\0" + row.tobytes() for row in pixels)
    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    parts = chunk(b"IHDR", header), chunk(b"IDAT", zlib.compress(rows, 9)), chunk(b"IEND", b"")
    return b"\x89PNG\r\n\x1a\n" + b"".join(parts)
