"""Mean of a learned distribution over the whole of training, with bands that hold 68 and 95 % of it."""

import numpy as np
import rerun as rr

from dr_lab.recorders.branch import Branch
from dr_lab.recorders.chart import Chart, linear_axis
from dr_lab.recorders.heat_map import CANVAS, PIXELS, pixels
from dr_lab.recorders.look import Look
from dr_lab.recorders.training import Spread
from dr_lab.reports.quantity import percent, titled

_BANDS = {0.68: 1.0, 0.95: 2.0}  # share of a Gaussian: standard deviations to either side
_SHADES = (0.55, 0.3)  # of the mean's colour over the ground, one a band


def log_spread(root: Branch, spread: Spread, look: Look) -> None:
    """Draw mean and bands over iterations, and the mean that training began with.

    Args:
        root: where to.
        spread: two iterations at least.
        look: colours and line widths.
    """
    first, last = (float(spread.iteration[end]) for end in (0, -1))
    reach = max(_BANDS.values()) * spread.std
    low, high = float((spread.mean - reach).min()), float((spread.mean + reach).max())
    room = 0.03 * (high - low)
    value = linear_axis(titled(spread.name, spread.unit), low - room, high + room)
    chart = Chart(root, CANVAS, linear_axis("iteration", first, last), value)
    rows, columns = pixels()
    level = bands(spread, (value.low, value.high), rows, columns)
    shades = [_over(look.colour("after"), look.colour("ground"), share) for share in (0.0, *_SHADES[::-1])]
    place = root / "bands"
    place.static(rr.Transform3D(scale=1 / PIXELS))
    place.static(rr.Image(np.array(shades, np.uint8)[level]))
    chart.frame(look.colour("axis"), look.colour("text"))
    chart.line("start", [first, last], spread.mean[[0, 0]], look.colour("noise"), look.line_width / 2)
    chart.line("mean", spread.iteration, spread.mean, look.colour("after"), look.line_width / 2)
    legend = {"start": look.colour("noise"), "mean": look.colour("after")}
    chart.legend(legend | {percent(share): (*shade, 255) for share, shade in zip(_BANDS, shades[:0:-1], strict=True)})


def bands(spread: Spread, ends: tuple[float, float], rows: int, columns: int) -> np.ndarray:
    """How many bands every pixel is in, rows from the largest value down, columns from the first iteration on.

    Between two iterations mean and standard deviation change evenly.

    Args:
        spread: mean and standard deviation.
        ends: least and largest value shown.
        rows: of pixels.
        columns: of pixels.

    Returns:
        Shape (rows, columns).
    """
    value = ends[1] - (np.arange(rows) + 0.5) / rows * (ends[1] - ends[0])
    first, last = spread.iteration[[0, -1]]
    at = first + (np.arange(columns) + 0.5) / columns * (last - first)
    mean, std = (np.interp(at, spread.iteration, each) for each in (spread.mean, spread.std))
    away = np.abs(value[:, None] - mean)
    return np.sum([away <= many * std for many in _BANDS.values()], axis=0)


def _over(colour: tuple[int, ...], ground: tuple[int, ...], share: float) -> tuple[int, int, int]:
    red, green, blue = np.rint(share * np.array(colour[:3]) + (1.0 - share) * np.array(ground[:3])).astype(int).tolist()
    return red, green, blue
