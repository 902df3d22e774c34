"""Canvases as pixels, by Pillow, whose own font is the same on every machine."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from io import BytesIO
from math import ceil, floor
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from tiloilc.report.pictures.canvas import (
    PAPER,
    Box,
    Canvas,
    Clip,
    Disc,
    Path,
    Photo,
    Pixels,
    Ring,
    Shape,
    Text,
)

if TYPE_CHECKING:
    from PIL import Image as Images
    from PIL import ImageDraw

Reach: TypeAlias = tuple[float, float, float, float]
"""Left, top, right, bottom."""

SMOOTH = 2
"""Dots are drawn so many times finer on each side than they are shown."""

SPELLED = str.maketrans(
    {
        **{c: str(i) for i, c in enumerate("₀₁₂₃₄₅₆₇₈₉")},
        "–": "-",
        "−": "-",
        "×": "x",
        "ε": "eps",
        "→": ">",
        "↑": "^",
    }
)
"""Pillow's own font has Latin letters only."""


def pixels_of(canvas: Canvas, scale: float = 1.0) -> Pixels:
    """The picture, `scale` dots a pixel, as uint8 [h, w, 3]."""
    return np.asarray(_image(canvas, scale), np.uint8)


def png_of(canvas: Canvas, scale: float = 2.0) -> bytes:
    """The picture as a PNG file."""
    content = BytesIO()
    _image(canvas, scale).save(content, "PNG", optimize=True)
    return content.getvalue()


def _image(canvas: Canvas, scale: float) -> Images.Image:
    from PIL import Image

    fine = scale * SMOOTH
    size = (round(canvas.width * fine), round(canvas.height * fine))
    image = Image.new("RGB", size, PAPER)
    for shape in canvas.shapes:
        _draw(image, shape, fine)
    shown = (max(1, round(canvas.width * scale)), max(1, round(canvas.height * scale)))
    return image.resize(shown, Image.Resampling.BOX)


def _draw(image: Images.Image, shape: Shape, scale: float) -> None:
    from PIL import Image

    match shape:
        case Clip():
            frame, inside = shape.frame, image.copy()
            for inner in shape.shapes:
                _draw(inside, inner, scale)
            left, top = round(frame.x * scale), round(frame.y * scale)
            right, bottom = (frame.x + frame.width) * scale, (frame.y + frame.height) * scale
            image.paste(inside.crop((left, top, round(right), round(bottom))), (left, top))
        case Photo():
            size = (max(1, round(shape.width * scale)), max(1, round(shape.height * scale)))
            photo = Image.fromarray(shape.pixels).resize(size, Image.Resampling.BILINEAR)
            image.paste(photo, (round(shape.x * scale), round(shape.y * scale)))
        case Text():
            _write(image, shape, scale)
        case _:
            look = shape.look
            if look.fill:
                with _mask(image, _reach(shape), look.fill, scale) as mask:
                    _fill(mask, shape, round(255 * look.fill_alpha))
            if look.stroke:
                with _mask(image, _reach(shape), look.stroke, scale) as mask:
                    _stroke(mask, shape, round(255 * look.alpha))


@dataclass(frozen=True)
class _Mask:
    """Where a colour goes: a part of the picture that begins at (left, top), in dots."""

    draw: ImageDraw.ImageDraw
    left: int
    top: int
    scale: float

    def at(self, x: float, y: float) -> tuple[float, float]:
        """Where a point of the canvas is in the mask."""
        return x * self.scale - self.left, y * self.scale - self.top

    def around(self, x: float, y: float, radius: float) -> tuple[float, float, float, float]:
        """The square about a circle."""
        return (*self.at(x - radius, y - radius), *self.at(x + radius, y + radius))

    def corners(self, box: Box) -> tuple[float, float, float, float]:
        """A rectangle; Pillow counts its last row and column in."""
        right, bottom = self.at(box.x + box.width, box.y + box.height)
        return (*self.at(box.x, box.y), right - 1, bottom - 1)


@contextmanager
def _mask(image: Images.Image, reach: Reach, color: str, scale: float) -> Iterator[_Mask]:
    """A mask of what lies in `reach`; at the end `color` is put where it was drawn on."""
    from PIL import Image, ImageDraw

    left, top = max(0, floor(reach[0] * scale)), max(0, floor(reach[1] * scale))
    right, bottom = (
        min(side, ceil(edge * scale))
        for side, edge in zip(image.size, (reach[2], reach[3]), strict=True)
    )
    mask = Image.new("L", (max(1, right - left), max(1, bottom - top)), 0)
    yield _Mask(ImageDraw.Draw(mask), left, top, scale)
    image.paste(color, (left, top, left + mask.width, top + mask.height), mask)


def _reach(shape: Disc | Ring | Box | Path) -> Reach:
    """A rectangle around the shape with its lines."""
    edge = shape.look.width + 1
    match shape:
        case Disc() | Ring():
            far = edge + (shape.radius if isinstance(shape, Disc) else shape.outer)
            return shape.x - far, shape.y - far, shape.x + far, shape.y + far
        case Box():
            right, bottom = shape.x + shape.width, shape.y + shape.height
            return shape.x - edge, shape.y - edge, right + edge, bottom + edge
        case Path():
            x, y = [p[0] for p in shape.points], [p[1] for p in shape.points]
            return min(x) - edge, min(y) - edge, max(x) + edge, max(y) + edge


def _fill(mask: _Mask, shape: Disc | Ring | Box | Path, alpha: int) -> None:
    match shape:
        case Disc():
            mask.draw.ellipse(mask.around(shape.x, shape.y, shape.radius), fill=alpha)
        case Ring():
            mask.draw.ellipse(mask.around(shape.x, shape.y, shape.outer), fill=alpha)
            mask.draw.ellipse(mask.around(shape.x, shape.y, shape.inner), fill=0)
        case Box():
            mask.draw.rectangle(mask.corners(shape), fill=alpha)
        case Path():
            mask.draw.polygon([mask.at(x, y) for x, y in shape.points], fill=alpha)


def _stroke(mask: _Mask, shape: Disc | Ring | Box | Path, alpha: int) -> None:
    half = shape.look.width / 2  # a line lies on both sides of the rim
    wide = max(1, round(shape.look.width * mask.scale))
    match shape:
        case Disc():
            place = mask.around(shape.x, shape.y, shape.radius + half)
            mask.draw.ellipse(place, outline=alpha, width=wide)
        case Ring():
            for radius in (shape.inner, shape.outer):
                place = mask.around(shape.x, shape.y, radius + half)
                mask.draw.ellipse(place, outline=alpha, width=wide)
        case Box():
            mask.draw.rectangle(mask.corners(shape), outline=alpha, width=wide)
        case Path():
            points = [mask.at(x, y) for x, y in shape.points]
            mask.draw.line(points, fill=alpha, width=wide, joint="curve")
            for x, y in (shape.points[0], shape.points[-1]):  # round ends
                mask.draw.ellipse(mask.around(x, y, half), fill=alpha)


def _write(image: Images.Image, text: Text, scale: float) -> None:
    from PIL import ImageFont

    shown = text.text.translate(SPELLED)
    font = ImageFont.load_default(text.size * scale)
    anchor = {"start": "ls", "middle": "ms", "end": "rs"}[text.anchor]
    wide = font.getlength(shown) / scale + text.size
    left = text.x - {"start": 0.5 * text.size, "middle": wide / 2, "end": wide}[text.anchor]
    reach = (left, text.y - 1.5 * text.size, left + wide + text.size, text.y + text.size)
    with _mask(image, reach, text.color, scale) as mask:
        mask.draw.text(
            mask.at(text.x, text.y),
            shown,
            fill=round(255 * text.alpha),
            font=font,
            anchor=anchor,
            stroke_width=0.025 * text.size * scale if text.bold else 0,
        )
