"""Residual against velocity, a joint: friction shows as a step or a slope, delay as a loop."""

import numpy as np

from dr_lab.recorders.branch import Branch
from dr_lab.recorders.chart import Canvas, Chart, linear_axis
from dr_lab.recorders.look import Look
from dr_lab.recorders.overlay import SIMULATED, Overlay
from dr_lab.trajectory import Array

CANVAS = Canvas(width=130.0, height=95.0, left=16.0, right=6.0, top=12.0, bottom=16.0)
# Range of the axes: this share of the points lies inside, so that one outlier does not flatten the rest.
_INSIDE = 99.5


def log_scatter(root: Branch, overlay: Overlay, joint: str, unit: str, look: Look) -> None:
    """Draw one joint's residuals against its velocity: dots, and their mean over equally filled velocity ranges.

    Args:
        root: where to.
        overlay: holds the joint's velocity and residuals.
        joint: its name.
        unit: of the velocity.
        look: colours and number of dots and means.
    """
    velocity, residuals = overlay.residual_velocity[joint]
    shown = [(role, residuals[role]) for role in SIMULATED if role in residuals]
    reach = _range(np.concatenate([residual for _, residual in shown]))
    speed = _range(velocity)
    x = linear_axis(f"velocity of {joint} [{unit}]", -speed, speed, count=8)
    chart = Chart(root, CANVAS, x, linear_axis(overlay.residual_name(joint), -reach, reach))
    chart.frame(look.colour("axis"), look.colour("text"))
    chart.line("zero", [-speed, speed], [0.0, 0.0], look.colour("axis"), 0.5)
    chart.line("still", [0.0, 0.0], [-reach, reach], look.colour("axis"), 0.5)
    for place, (role, residual) in enumerate(shown):
        picked = _spread(velocity, residual, look.scatter_points)
        # Few dots are drawn large enough to be seen, many small enough to be told apart.
        radius = float(np.clip(50.0 / np.sqrt(max(len(picked), 1)), 1.5, 4.0))
        chart.dots(role, velocity[picked], residual[picked], look.colour(role, 160), radius)
        chart.line(f"{role}_mean", *bin_means(velocity, residual, look.scatter_bins), look.colour(role), 1.5)
        corner = np.array([CANVAS.width - 14.0 * (len(shown) - place), -7.0])
        chart.words(f"{role}_name", [(corner, overlay.label(role))], look.colour(role), lift=0.0)


def _range(value: Array) -> float:
    finite = np.abs(value[np.isfinite(value)])
    return float(np.percentile(finite, _INSIDE)) * 1.05 if len(finite) and finite.max() > 0 else 1.0


def _spread(velocity: Array, residual: Array, count: int) -> np.ndarray:
    """At most `count` indices of finite pairs, evenly spaced."""
    finite = np.flatnonzero(np.isfinite(velocity) & np.isfinite(residual))
    return finite[:: max(1, -(-len(finite) // count))]


def bin_means(velocity: Array, residual: Array, bins: int) -> tuple[Array, Array]:
    """Mean velocity and mean residual of equally filled velocity ranges, each shape (k,).

    k = min(bins, √n): with the square-root choice, ranges and samples a range grow alike, and few samples make no comb.
    """
    finite = np.isfinite(velocity) & np.isfinite(residual)
    order = np.argsort(velocity[finite])
    count = min(bins, int(np.sqrt(len(order))))
    parts = np.array_split(order, count) if count else []
    x, y = velocity[finite], residual[finite]
    return np.array([x[part].mean() for part in parts]), np.array([y[part].mean() for part in parts])
