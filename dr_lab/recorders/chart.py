"""An x–y chart drawn in a 2-D view, because Rerun plots only against time."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import rerun as rr
import rerun.blueprint as rrb
from numpy.typing import ArrayLike

from dr_lab.recorders.branch import Branch, entity_path
from dr_lab.recorders.shape import Colour
from dr_lab.reports.quantity import number
from dr_lab.trajectory import Array

# Layers of the drawing, back to front.
GRID, DOTS, LINES, TEXT = 0.0, 10.0, 20.0, 30.0
_ALIKE = 1e-9  # relative difference of values that only rounding tells apart
# Rerun writes a label below its point; this many canvas units lift it to the point's height.
_LIFT = 3.2
_SMALL = 2.0  # by how much a letter is wider in the canvas units of a small view
_HATCH = 4.0  # canvas units between slanting lines
_LETTER, _NARROWEST, _ROW = 1.6, 16.0, 6.0  # room in a legend for a letter and a label, and between its rows


@dataclass(frozen=True)
class Axis:
    """One axis: what it shows and the positions of its ticks.

    Attributes:
        title: quantity and unit.
        low: least value shown.
        high: largest value shown, > low.
        ticks: value and label of each tick.
    """

    title: str
    low: float
    high: float
    ticks: Sequence[tuple[float, str]]

    def fraction(self, value: ArrayLike) -> Array:
        """Place along the axis: 0 at low, 1 at high, clipped to the chart."""
        return np.clip((np.asarray(value, dtype=float) - self.low) / (self.high - self.low), 0.0, 1.0)


def linear_axis(title: str, low: float, high: float, count: int = 5) -> Axis:
    """An axis from `low` to `high` with about `count` round ticks (1, 2 or 5 times a power of ten apart).

    Where only rounding tells the two apart, it reaches beyond them. Labels have the digits that tell ticks apart.
    """
    if not high - low > _ALIKE * max(abs(low), abs(high)):
        room = max(1.0, 1e-3 * abs(low))
        low, high = low - room, low + room
    raw = (high - low) / count
    power = 10.0 ** np.floor(np.log10(raw))
    step = power * min((1.0, 2.0, 5.0, 10.0), key=lambda multiple: abs(multiple * power - raw))
    values = step * np.arange(np.ceil(low / step), np.floor(high / step) + 1)
    digits = max(4, 1 + int(np.floor(np.log10(max(abs(low), abs(high)))) - np.floor(np.log10(step))))
    # Adding zero turns -0.0 into 0.0, which would be labelled "-0".
    labels = [number(round(value / step) * step + 0.0, digits) for value in values.tolist()]
    return Axis(title, low, high, list(zip(values.tolist(), labels, strict=True)))


def decade_axis(title: str, low: float, high: float) -> Axis:
    """An axis of log10 values whose ticks are labelled with the values themselves.

    Args:
        title: quantity and unit.
        low: least value shown, > 0 (not its logarithm).
        high: largest value shown, > 0.
    """
    first, last = np.log10(low), np.log10(high)
    few = last - first < 2.0
    multiples = (1, 2, 5) if few else (1,)
    decades = range(int(np.floor(first)), int(np.ceil(last)) + 1)
    values = [multiple * 10.0**decade for decade in decades for multiple in multiples]
    ticks = [(float(np.log10(value)), number(value)) for value in values if low <= value <= high]
    return Axis(title, float(first), float(last), ticks)


@dataclass(frozen=True)
class Canvas:
    """Measures of a chart in canvas units: the axes' box, and the room for labels beside it.

    The origin is the box's upper left corner and y points downwards, as in Rerun's 2-D views.
    """

    width: float
    height: float
    left: float
    right: float
    top: float
    bottom: float

    def view(self, parts: Sequence[str], name: str) -> rrb.Spatial2DView:
        """The view that shows a chart of these measures, logged below the entity `parts`."""
        across, down = [-self.left, self.width + self.right], [-self.top, self.height + self.bottom]
        bounds = rrb.VisualBounds2D(x_range=across, y_range=down)
        return rrb.Spatial2DView(origin=entity_path(*parts), name=name, visual_bounds=bounds)


@dataclass(frozen=True)
class Chart:
    """Data points drawn between two axes.

    Attributes:
        root: where the chart is drawn.
        canvas: its measures.
        x: horizontal axis.
        y: vertical axis, larger values up.
    """

    root: Branch
    canvas: Canvas
    x: Axis
    y: Axis

    def place(self, x: ArrayLike, y: ArrayLike) -> Array:
        """Canvas positions of data points, shape (n, 2)."""
        across, up = np.broadcast_arrays(self.x.fraction(x), self.y.fraction(y))
        return np.stack([self.canvas.width * across.ravel(), self.canvas.height * (1.0 - up.ravel())], axis=-1)

    def within(self, x: Array, y: Array) -> list[Array]:
        """Canvas positions of a line as far as it is inside the box: a piece each, shape (m, 2), m ≥ 2; maybe none."""
        inside = (self.x.low <= x) & (x <= self.x.high) & (self.y.low <= y) & (y <= self.y.high)
        change = np.flatnonzero(np.diff(np.concatenate([[False], inside, [False]]).astype(int)))
        pieces = [slice(first, last) for first, last in change.reshape(-1, 2) if last - first > 1]
        return [self.place(x[piece], y[piece]) for piece in pieces]

    def frame(self, axis: Colour, text: Colour) -> None:
        """Draw the box, the grid, the labels of the ticks and the titles of the axes."""
        width, height = self.canvas.width, self.canvas.height
        box = [[0, 0], [width, 0], [width, height], [0, height], [0, 0]]
        grid = [self.place([value, value], [self.y.low, self.y.high]) for value, _ in self.x.ticks]
        grid += [self.place([self.x.low, self.x.high], [value, value]) for value, _ in self.y.ticks]
        self._strips("grid", [*grid, box], (*axis[:3], 90), 0.5, GRID)
        across = [(self.place(value, self.y.low)[0], label) for value, label in self._readable()]
        beside = [(self.place(self.x.low, value)[0] - (5.0, 0.0), label) for value, label in self.y.ticks]
        self.words("ticks_x", across, text, lift=0.0)
        self.words("ticks_y", beside, text)
        title_x = (np.array([width / 2, height + 7.0]), self.x.title)
        wide = _SMALL * _LETTER * len(self.y.title) / 2  # half of the title, where the view is small
        title_y = (np.array([max(wide - self.canvas.left, 0.0), -7.0]), self.y.title)
        self.words("titles", [entry for entry in (title_x, title_y) if entry[1]], text, lift=0.0)

    def _readable(self) -> Sequence[tuple[float, str]]:
        """The ticks of the horizontal axis that are labelled: every second, third … where all have no room."""
        ticks, step = self.x.ticks, 1
        while sum(_SMALL * _LETTER * (len(label) + 1) for _, label in ticks[::step]) > self.canvas.width:
            step += 1
        return ticks[::step]

    def words(self, name: str, entries: Sequence[tuple[Array, str]], colour: Colour, lift: float = _LIFT) -> None:
        """Write texts, each centred on its canvas position."""
        if entries:
            at = np.array([position for position, _ in entries]) - (0.0, lift)
            labels = [label for _, label in entries]
            points = rr.Points2D(at, labels=labels, colors=[colour], radii=0.0, show_labels=True, draw_order=TEXT)
            (self.root / name).static(points)

    def dots(self, name: str, x: ArrayLike, y: ArrayLike, colour: Colour, radius: float) -> None:
        """Draw dots of `radius` points on the screen at data points."""
        radii = rr.Radius.ui_points(radius)
        points = rr.Points2D(self.place(x, y), colors=[colour], radii=radii, draw_order=DOTS)
        (self.root / name).static(points)

    def line(self, name: str, x: ArrayLike, y: ArrayLike, colour: Colour, radius: float, layer: float = LINES) -> None:
        """Draw a line of half-width `radius` points on the screen through data points, above those of lower layers."""
        self._strips(name, [self.place(x, y)], colour, radius, layer)

    def hatch(self, name: str, spans: Sequence[tuple[float, float]], colour: Colour) -> None:
        """Draw slanting lines across the whole height, between the ends of each span of the horizontal axis."""
        height, strips = self.canvas.height, []
        for low, high in spans:
            left, right = self.place([low, high], self.y.low)[:, 0]
            for start in np.arange(left - height, right, _HATCH):
                ends = np.clip([start, start + height], left, right)
                strips.append(np.stack([ends, height - (ends - start)], axis=1))
        if strips:
            self._strips(name, strips, (*colour[:3], 60), 0.5, GRID)

    def legend(self, colours: Mapping[str, Colour]) -> None:
        """Write what the lines are, side by side above the box, or below one another in it where they do not fit."""
        rooms = np.array([max(_SMALL * _LETTER * (len(label) + 1), _NARROWEST) for label in colours])
        title = _SMALL * _LETTER * len(self.y.title) - self.canvas.left  # what it takes of the box's width
        if rooms.sum() <= self.canvas.width - max(title, 0.0):
            across, down = self.canvas.width - rooms.sum() + np.cumsum(rooms), np.full(len(rooms), -7.0)
        else:
            across, down = np.full(len(rooms), self.canvas.width), _ROW * np.arange(1, len(rooms) + 1)
        for index, (label, colour) in enumerate(colours.items()):
            at = np.array([across[index] - rooms[index] / 2, down[index]])
            self.words(f"legend_{index}", [(at, label)], colour, lift=0.0)

    def _strips(self, name: str, strips: Sequence[ArrayLike], colour: Colour, radius: float, layer: float) -> None:
        shape = rr.LineStrips2D(strips, colors=[colour], radii=rr.Radius.ui_points(radius), draw_order=layer)
        (self.root / name).static(shape)
