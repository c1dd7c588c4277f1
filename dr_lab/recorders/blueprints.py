"""The layout of `review.rrd`: which views there are, on which page, and from where the robot is seen."""

from collections.abc import Mapping, Sequence

import mujoco
import numpy as np
import rerun.blueprint as rrb

from dr_lab.channel_names import POSITION, quantity
from dr_lab.recorders import heat_map
from dr_lab.recorders.bars import ladder_canvas, ranking_canvas
from dr_lab.recorders.branch import TIMELINE, entity_path
from dr_lab.recorders.eye import eye_controls
from dr_lab.recorders.look import Look
from dr_lab.recorders.overlay import AFTER, BEFORE, MEASURED, SIMULATED, Overlay
from dr_lab.recorders.scatter import CANVAS
from dr_lab.recorders.scene import moving_corners, thin
from dr_lab.recorders.signal_views import channel_views, signals_page
from dr_lab.reports.gap import GapReport
from dr_lab.reports.ladder import scored, steps
from dr_lab.trajectory import Array

_RANKING = "Ranking on {} (blue: named, orange: equivalent, white line: interval)"


def review_blueprint(
    report: GapReport, overlays: Sequence[Overlay], geometry: mujoco.MjModel, look: Look
) -> rrb.Blueprint:
    """Pages: overview, signals, residual against velocity, ranking, report; a page has one tab a log.

    Args:
        report: decides which pages there are.
        overlays: decide which views there are; without any, only the tables are shown.
        geometry: what the eye has to see.
        look: the eye, and how many channels the overview has.
    """
    with_joints = [overlay for overlay in overlays if overlay.joints()]
    pages: list[rrb.Container | rrb.View | None] = [
        _page("Overview", {overlay.log: _overview(report, overlay, geometry, look) for overlay in overlays}),
        _page("Signals", {overlay.log: signals_page(overlay) for overlay in overlays}),
        _page("Residual and velocity", {overlay.log: _scatters(overlay) for overlay in with_joints}),
        _ranking(report) if report.judged.ranking else None,
        rrb.TextDocumentView(origin="report", name="Report"),
    ]
    return rrb.Blueprint(
        rrb.Tabs(*(page for page in pages if page is not None), name="Review"),
        rrb.BlueprintPanel(state="hidden"),
        rrb.SelectionPanel(state="hidden"),
        rrb.TimePanel(state="collapsed", timeline=TIMELINE, play_state="playing", loop_mode="all"),
    )


def worst_channels(overlay: Overlay, count: int) -> list[str]:
    """The `count` channels that the first simulated role fits worst, positions before others, in the log's order."""

    def misfit(channel: str) -> tuple[bool, float]:
        is_position = quantity(channel) == POSITION
        role = next((role for role in SIMULATED if channel in overlay.simulated.get(role, {})), None)
        if role is None:
            return is_position, 0.0
        value = overlay.measured[channel].value
        squared = (value - overlay.simulated[role][channel]) ** 2
        error = float(np.mean(squared[np.isfinite(squared)])) if np.isfinite(squared).any() else 0.0
        return is_position, error / max(float(np.var(value)), np.finfo(float).tiny)

    worst = sorted(overlay.measured, key=misfit, reverse=True)[:count]
    return [channel for channel in overlay.measured if channel in worst]


def _page(name: str, logs: Mapping[str, rrb.Container]) -> rrb.Container | None:
    """One page: the log's name in its title, or one tab a log where there are several."""
    if not logs:
        return None
    if len(logs) == 1:
        ((log, content),) = logs.items()
        return rrb.Vertical(content, name=f"{name}: {log}")
    return rrb.Tabs(*(rrb.Vertical(content, name=log) for log, content in logs.items()), name=name)


def _overview(report: GapReport, overlay: Overlay, geometry: mujoco.MjModel, look: Look) -> rrb.Container:
    text = rrb.TextDocumentView(origin="verdict", name="Verdict")
    below = rrb.Horizontal(text, _ladder(report), column_shares=[5, 4]) if len(steps(report)) > 1 else text
    robots = _robots(overlay, geometry, look)
    left = rrb.Vertical(rrb.Horizontal(*robots), below, row_shares=[3, 2]) if robots else rrb.Vertical(below)
    channels = worst_channels(overlay, look.overview_channels)
    return rrb.Horizontal(left, rrb.Vertical(*channel_views(overlay, channels)), column_shares=[6, 5])


def _robots(overlay: Overlay, geometry: mujoco.MjModel, look: Look) -> list[rrb.Spatial3DView]:
    """Measured and simulated robot in one view a model; the measured alone where nothing was simulated.

    None of a machine of which nothing is to be seen, such as bodies of inertia alone: its place is left to the plots.
    """
    moving = _moving(overlay, geometry, look)
    if not len(moving):
        return []
    roles = [role for role in SIMULATED if role in overlay.poses]
    scenes = {_robot_title(overlay, role): ["fixed", "real", f"sim_{role}"] for role in roles}
    eye = eye_controls(moving, look)
    return [
        rrb.Spatial3DView(
            origin=entity_path(overlay.log, "world"),
            contents=[f"$origin/{part}/**" for part in parts],
            name=title,
            eye_controls=eye,
            line_grid=False,
        )
        for title, parts in (scenes or {MEASURED: ["fixed", "real"]}).items()
    ]


def _robot_title(overlay: Overlay, role: str) -> str:
    colour = {BEFORE: "orange", AFTER: "blue"}[role]
    label = overlay.label(role)
    return f"measured (white), {label if label != role else f'model {role}'} ({colour})"


def _moving(overlay: Overlay, geometry: mujoco.MjModel, look: Look) -> Array:
    """All that the eye must see: the moving shapes of every robot, m, shape (k, 3)."""
    kept = thin(overlay.time, look.pose_rate)
    corners = [moving_corners(geometry, position[kept], turn[kept]) for position, turn in overlay.poses.values()]
    return np.concatenate([np.empty((0, 3)), *corners])


def _scatters(overlay: Overlay) -> rrb.Container:
    views = [
        CANVAS.view([overlay.log, "scatter", joint], f"{joint}: {overlay.residual_name(joint)} against velocity")
        for joint in overlay.joints()
    ]
    views += [
        heat_map.CANVAS.view([overlay.log, "force", joint], f"{joint}: learned force [{each.unit}], dots: the log")
        for joint, each in overlay.force_maps.items()
    ]
    return rrb.Grid(*views)


def _ladder(report: GapReport) -> rrb.Spatial2DView:
    return ladder_canvas(steps(report)).view(
        ["diagnosis", "ladder"], f"Ladder: error of each model on {scored(report)}"
    )


def _ranking(report: GapReport) -> rrb.Container:
    chart = ranking_canvas(report.judged.ranking).view(["diagnosis", "ranking"], _RANKING.format(scored(report)))
    table = rrb.TextDocumentView(origin="diagnosis/ranking_table", name="Candidates")
    return rrb.Horizontal(chart, table, column_shares=[5, 6], name="Ranking")
