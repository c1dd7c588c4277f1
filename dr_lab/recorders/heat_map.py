"""A heat map over two parameters, with its axes and its colour scale."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import rerun as rr

from dr_lab.recorders.branch import Branch
from dr_lab.recorders.chart import Axis, Canvas, Chart, linear_axis
from dr_lab.recorders.look import Look
from dr_lab.recorders.shape import Colour
from dr_lab.recorders.training import ContextAxis
from dr_lab.reports.quantity import number, titled
from dr_lab.trajectory import Array

CANVAS = Canvas(width=130.0, height=90.0, left=18.0, right=24.0, top=12.0, bottom=16.0)
PIXELS = 10  # of the heat map's picture, a canvas unit
_SCALE = (6.0, 8.0)  # distance and width of the colour scale beside the map

DARK_TO_LIGHT = ("fixed", "after", "measured")
"""Stops of values of which more is lighter: grey over blue to white."""

DOUBLE = ("before", "fixed", "after")
"""Stops of values about 0: what is below is orange, what is above blue."""


@dataclass(frozen=True)
class ColourScale:
    """Which colour a value has.

    Attributes:
        low: value of the first colour.
        high: value of the last, ≥ low.
        stops: names of the look's colours from low to high, at equal distances.
    """

    low: float
    high: float
    stops: tuple[str, ...]


def heat_map(value: Array, scale: ColourScale, look: Look) -> np.ndarray:
    """Colours of values; NaN takes the ground's.

    Args:
        value: shape (n, m).
        scale: its colours.
        look: what they are.

    Returns:
        Red, green and blue, shape (n, m, 3), 0 … 255.
    """
    stops = np.array([look.colour(name)[:3] for name in scale.stops], dtype=float)
    share = np.clip((value - scale.low) / max(scale.high - scale.low, np.finfo(float).tiny), 0.0, 1.0)
    at = np.linspace(0.0, 1.0, len(stops))
    colour = np.stack([np.interp(share, at, stops[:, channel]) for channel in range(3)], axis=-1)
    return np.where(np.isfinite(value)[..., None], colour, look.colour("ground")[:3]).astype(np.uint8)


def log_map(root: Branch, axes: Sequence[ContextAxis], value: Array, scale: ColourScale, look: Look) -> Chart:
    """Draw a map.

    Args:
        root: where to.
        axes: across and up.
        value: of each cell, shape (n, m) as the axes; NaN stays empty.
        scale: its colours.
        look: what they are, and line widths.

    Returns:
        The chart that the map is in, to draw more into it.
    """
    chart = Chart(root, CANVAS, *(cell_axis(axis) for axis in axes))
    rows, columns = (np.arange(n) * k // n for n, k in zip(pixels(), value.T.shape, strict=True))
    log_picture(root, value.T[::-1][np.ix_(rows, columns)], scale, look)
    chart.frame(look.colour("axis"), look.colour("text"))
    return chart


def pixels() -> tuple[int, int]:
    """Rows and columns of a picture that fills the canvas."""
    return PIXELS * int(CANVAS.height), PIXELS * int(CANVAS.width)


def log_picture(root: Branch, value: Array, scale: ColourScale, look: Look) -> None:
    """Fill the canvas with the colours of values, and draw their scale beside it.

    Args:
        root: where to.
        value: of every pixel, rows from the top down, of the shape that `pixels` gives.
        scale: its colours.
        look: what they are.
    """
    place = root / "map"
    place.static(rr.Transform3D(scale=1 / PIXELS))
    place.static(rr.Image(heat_map(value, scale, look)))
    _log_scale(root / "scale", scale, look)


def cell_axis(axis: ContextAxis) -> Axis:
    """From half a cell before the first value to half a cell behind the last."""
    room = float(axis.values[-1] - axis.values[0]) / max(len(axis.values) - 1, 1) / 2
    return linear_axis(titled(axis.name, axis.unit), float(axis.values[0]) - room, float(axis.values[-1]) + room)


def _log_scale(root: Branch, scale: ColourScale, look: Look) -> None:
    """The colour scale, at the map's right."""
    distance, width = _SCALE
    ramp = heat_map(np.linspace(scale.high, scale.low, int(CANVAS.height) * PIXELS)[:, None], scale, look)
    place = root / "ramp"
    place.static(rr.Transform3D(scale=1 / PIXELS, translation=[CANVAS.width + distance, 0.0, 0.0]))
    place.static(rr.Image(np.repeat(ramp, int(width) * PIXELS, axis=1)))
    at = CANVAS.width + distance + width / 2
    words: Colour = look.colour("text")
    labels = rr.Points2D(
        [[at, -7.0], [at, CANVAS.height + 1.0]],
        labels=[number(scale.high), number(scale.low)],
        colors=[words],
        radii=0.0,
        show_labels=True,
    )
    (root / "ends").static(labels)
