"""Ways of a policy in the plane, before and after it was adapted."""

import numpy as np

from dr_lab.recorders.branch import Branch
from dr_lab.recorders.chart import Axis, Canvas, Chart, linear_axis
from dr_lab.recorders.look import Look
from dr_lab.recorders.shape import Colour
from dr_lab.recorders.training import Ways
from dr_lab.trajectory import Array

CANVAS = Canvas(width=130.0, height=110.0, left=18.0, right=6.0, top=12.0, bottom=16.0)
_ROOM = 1.1  # of what is shown over what is drawn
_FARTHEST = 2.0  # distance of what is shown over that of the farthest goal
_GOAL, _END = 6.0, 3.0  # radii of dots, points on the screen


def log_ways(root: Branch, ways: Ways, look: Look) -> None:
    """Draw them in two colours, with a dot where each ends and a larger one at each goal.

    What is farther off than twice the goals are is left out.

    Args:
        root: where to.
        ways: the courses.
        look: colours and line widths.
    """
    starts = [course[:1] for course in (*ways.before, *ways.after)]
    across, up = _axes(np.concatenate([ways.goals, *starts]), np.concatenate([*ways.before, *ways.after]))
    chart = Chart(root, CANVAS, across, up)
    chart.frame(look.colour("axis"), look.colour("text"))
    chart.dots("goals", ways.goals[:, 0], ways.goals[:, 1], look.colour("measured"), _GOAL)
    colours = {name: look.colour(name) for name in ("before", "after")}
    for name, courses in (("before", ways.before), ("after", ways.after)):
        for index, course in enumerate(courses):
            _log_course(Chart(root / f"{name}_{index}", CANVAS, across, up), course, colours[name], look)
    chart.legend({**colours, "goals": look.colour("measured")})


def _axes(wanted: Array, others: Array) -> tuple[Axis, Axis]:
    """Axes of one scale, on which all wanted places (k, 2) are, and others unless they are far off."""
    middle = 0.5 * (wanted.min(axis=0) + wanted.max(axis=0))
    canvas = np.array([CANVAS.width, CANVAS.height])
    near = np.max(np.abs(wanted - middle) / canvas)
    unit = (
        _ROOM * float(np.clip(np.max(np.abs(others - middle) / canvas), near, _FARTHEST * near)) or 1.0 / CANVAS.width
    )
    ends = np.stack([middle - unit * canvas, middle + unit * canvas], axis=1)
    across, up = (linear_axis(f"{name} [m]", *each) for name, each in zip("xy", ends.tolist(), strict=True))
    return across, up


def _log_course(chart: Chart, course: Array, colour: Colour, look: Look) -> None:
    """Up to where it leaves the chart."""
    low, high = np.array([[axis.low, axis.high] for axis in (chart.x, chart.y)]).T
    left = np.flatnonzero((np.clip(course, low, high) != course).any(axis=1))
    shown = course[: left[0] if len(left) else len(course)]
    chart.line("way", shown[:, 0], shown[:, 1], colour, look.line_width / 2)
    if not len(left):
        chart.dots("end", shown[-1:, 0], shown[-1:, 1], colour, _END)
