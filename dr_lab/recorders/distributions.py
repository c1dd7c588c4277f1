"""Learned distributions of contexts: histograms over iterations, and ellipses of two parameters."""

from collections.abc import Mapping

import numpy as np
import rerun as rr
from scipy.stats import chi2

from dr_lab.recorders.branch import Branch
from dr_lab.recorders.chart import DOTS, Canvas, Chart, linear_axis
from dr_lab.recorders.look import Look
from dr_lab.recorders.moving_lines import log_moving_lines
from dr_lab.recorders.shape import Colour
from dr_lab.recorders.training import Marginal, Pair
from dr_lab.reports.quantity import percent, titled
from dr_lab.trajectory import Array

CANVAS = Canvas(width=130.0, height=80.0, left=18.0, right=6.0, top=12.0, bottom=16.0)
# Content of the ellipses: one, two and three standard deviations of one dimension, as is usual, and by a round name.
CONTENTS = (0.68, 0.95, 0.99)
_CORNERS = 90  # of the polygon that stands for an ellipse


def log_marginal(root: Branch, marginal: Marginal, look: Look) -> None:
    """Draw one parameter's probability density: that at the beginning always, a learned one by iteration.

    Args:
        root: where to.
        marginal: the histograms.
        look: colours and line widths.
    """
    density, initial = (_density(p, marginal.edges) for p in (marginal.probability, marginal.initial))
    top = 1.05 * max(float(density.max(initial=0.0)), float(initial.max(initial=0.0)))
    x = linear_axis(marginal.title, float(marginal.edges[0]), float(marginal.edges[-1]), 8)
    chart = Chart(root, CANVAS, x, linear_axis("probability density", 0.0, top))
    chart.frame(look.colour("axis"), look.colour("text"))
    if not marginal.learned:
        chart.line("initial", *_stairs(marginal.edges, initial), look.colour("after"), look.measured_width / 2)
        return
    chart.line("initial", *_stairs(marginal.edges, initial), look.colour("noise"), look.line_width)
    outlines = [[chart.place(*_stairs(marginal.edges, each))] for each in density]
    log_moving_lines(root / "learned", marginal.iteration, outlines, look.colour("after"), look.measured_width)
    legend = {"initial": look.colour("noise"), "learned": look.colour("after")}
    chart.legend(legend)


def log_pair(root: Branch, pair: Pair, look: Look) -> None:
    """Draw the mean of two parameters and the ellipses that hold 68, 95 and 99 %, by iteration, and the mean's way."""
    axes = [
        linear_axis(titled(name, unit), float(low), float(high))
        for name, unit, low, high in zip(pair.names, pair.units, pair.low, pair.high, strict=True)
    ]
    chart = Chart(root, CANVAS, axes[0], axes[1])
    chart.frame(look.colour("axis"), look.colour("text"))
    chart.line("way", pair.mean[:, 0], pair.mean[:, 1], look.colour("noise"), look.line_width / 2)
    strengths = np.linspace(255, 90, len(CONTENTS)).astype(int).tolist()
    colours = [look.colour("after", strength) for strength in strengths]
    for index, (content, colour) in enumerate(zip(CONTENTS, colours, strict=True)):
        outlines = [
            chart.within(*ellipse(mean, covariance, content))
            for mean, covariance in zip(pair.mean, pair.covariance, strict=True)
        ]
        log_moving_lines(root / "ellipses" / str(index), pair.iteration, outlines, colour, look.measured_width)
    middle = rr.Points2D.columns(positions=chart.place(pair.mean[:, 0], pair.mean[:, 1]))
    style = rr.Points2D.from_fields(
        colors=[look.colour("after")], radii=rr.Radius.ui_points(look.measured_width), draw_order=DOTS
    )
    (root / "mean").static(style)
    (root / "mean").over_iterations(pair.iteration, middle)
    chart.legend({percent(content): colour for content, colour in zip(CONTENTS, colours, strict=True)})


def ellipse(mean: Array, covariance: Array, content: float) -> tuple[Array, Array]:
    """Outline of the ellipse that holds a share of a Gaussian, (z − μ)ᵀ Σ⁻¹ (z − μ) = χ²₂(content).

    Args:
        mean: μ, shape (2,).
        covariance: Σ, shape (2, 2).
        content: share of the probability inside.

    Returns:
        Both coordinates of a closed line, shape (k,) each.
    """
    values, vectors = np.linalg.eigh(covariance)
    angle = np.linspace(0.0, 2 * np.pi, _CORNERS + 1)
    circle = np.sqrt(chi2.ppf(content, df=2)) * np.stack([np.cos(angle), np.sin(angle)])
    x, y = mean[:, None] + vectors @ (np.sqrt(np.maximum(values, 0.0))[:, None] * circle)
    return x, y


def log_marginals(root: Branch, learned: Mapping[str, Marginal], colours: Mapping[str, Colour], look: Look) -> None:
    """Draw what several runs learnt of one parameter, as it was at their end, over what the first one began with.

    Args:
        root: where to.
        learned: the histograms by what the legend calls them, one at least.
        colours: of each of them.
        look: all other colours, and line widths.
    """
    first = next(iter(learned.values()))
    density = {label: _density(each.probability[-1], each.edges) for label, each in learned.items()}
    initial = _density(first.initial, first.edges)
    top = 1.05 * max(float(each.max(initial=0.0)) for each in (initial, *density.values()))
    low, high = (float(f(each.edges[end] for each in learned.values())) for f, end in ((min, 0), (max, -1)))
    x = linear_axis(first.title, low, high, 8)
    chart = Chart(root, CANVAS, x, linear_axis("probability density", 0.0, top))
    chart.frame(look.colour("axis"), look.colour("text"))
    chart.line("initial", *_stairs(first.edges, initial), look.colour("noise"), look.line_width)
    same = [label for label, each in learned.items() if _began_with(each, first)]
    legend = {", ".join(["initial", *same]): look.colour("noise")}
    for index, (label, each) in enumerate(learned.items()):
        if label in same:  # its line would lie on that of the beginning, and hide it or be hidden
            continue
        legend[label] = colours[label]
        chart.line(f"learned_{index}", *_stairs(each.edges, density[label]), legend[label], look.measured_width / 2)
    chart.legend(legend)


def _began_with(each: Marginal, first: Marginal) -> bool:
    """Whether what was learnt in the end is what another run began with."""
    alike = each.edges.shape == first.edges.shape and np.allclose(each.edges, first.edges)
    return alike and np.allclose(each.probability[-1], first.initial)


def _density(probability: Array, edges: Array) -> Array:
    return probability / np.diff(edges)


def _stairs(edges: Array, height: Array) -> tuple[Array, Array]:
    """Outline of a histogram, from the axis and back to it, shape (2 b + 2,) each."""
    return np.repeat(edges, 2), np.concatenate([[0.0], np.repeat(height, 2), [0.0]])
