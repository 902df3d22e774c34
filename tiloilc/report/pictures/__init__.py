"""Pictures and films of environments: drawn once, written as SVG, PNG, GIF or MP4."""

from tiloilc.report.pictures.canvas import Canvas
from tiloilc.report.pictures.raster import pixels_of, png_of
from tiloilc.report.pictures.svg import svg_of

__all__ = ["Canvas", "pixels_of", "png_of", "svg_of"]
