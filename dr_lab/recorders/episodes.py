"""Episodes of a policy in a recording: the machine in 3-D as it moves, reward and actions beside it, and a table."""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from dr_lab.recorders.branch import Branch, entity_path
from dr_lab.recorders.episode import Episode
from dr_lab.recorders.eye import eye_controls, followed_box
from dr_lab.recorders.joint_labels import commanded
from dr_lab.recorders.look import Look
from dr_lab.recorders.scene import (
    body_poses,
    log_bodies,
    log_surroundings,
    moving_corners,
    send_poses,
    send_start,
    thin,
)
from dr_lab.recorders.shape import Paint
from dr_lab.reports.quantity import ABSENT, number, titled
from dr_lab.reports.tables import table
from dr_lab.trajectory import Array

ROOT = "episode"
_FOLLOWED = "followed"
_MOST = 4  # episodes side by side
_TITLED = 2  # parameters in a view's title; the table has all
_CURVES = ("after", "before", "command", "measured", "noise")  # colours of actions, in turn
# The lines tell how fast the machine travels; in the ground itself they would flicker.
_LINES = rr.components.Plane3D.XY.with_distance(0.01)  # m
_LINKED = rrb.TimeAxis(link="LinkToGlobal")
_PLAYED = (
    "To play them, choose **t** in place of **{}** at the lower left. Rewards and actions step by step: episodes.mcap, "
    "and the recording of `dr-lab evaluate`."
)


def log_episodes(root: Branch, episodes: Sequence[Episode], look: Look, counting: str | None = None) -> None:
    """Log below ``<root>/<episode>/{world,reward,action}`` on the timeline ``t``, and the table in ``<root>/table``.

    Args:
        root: where to.
        episodes: each is shown up to `Look.longest`.
        look: colours, line widths, the rate of the poses.
        counting: timeline of what training counts, which shows the machines as the episodes begin; None where nothing
            is counted.
    """
    for episode in _drawn(episodes):
        place, shot = root / episode.name, _shot(episode, look)
        _log_machine(place / "world", episode, shot, look)
        shown = episode.time[:-1] <= look.longest
        _log_steps(place / "reward", episode.time[1:][shown], episode.reward[shown, None], ["reward"], look)
        model = episode.geometry
        actuators = [model.actuator(row).name or f"action {i}" for i, row in enumerate(commanded(model))]
        _log_steps(place / "action", episode.time[:-1][shown], episode.action[shown], actuators, look)
        if counting is not None:
            send_start(place / "world" / "machine", episode.geometry, shot.pose, counting)
    told = f"{_PLAYED.format(counting)}\n\n" if counting is not None and anything_drawn(episodes) else ""
    text = f"{told}{episodes_table(episodes)}"
    (root / "table").static(rr.TextDocument(text, media_type=rr.MediaType.MARKDOWN))


def episodes_table(episodes: Sequence[Episode]) -> str:
    """Return, length, end and context of each episode, as Markdown."""
    parameters = {name: unit for each in episodes for name, (_, unit) in each.context.items()}
    header = ["episode", "return", "time [s]", "ended", *(titled(name, unit) for name, unit in parameters.items())]
    rows = [
        [
            each.name.removeprefix("episode_"),
            number(each.undiscounted),
            number(each.time[-1]),
            each.ended,
            *(number(each.context[name][0]) if name in each.context else ABSENT for name in parameters),
        ]
        for each in episodes
    ]
    return table(header, rows)


def episodes_page(episodes: Sequence[Episode], look: Look, counting: str | None = None) -> rrb.Container:
    """A column an episode of a feasible context, machine above reward and actions, and the table below all.

    Reward and actions have no place on a timeline that counts: there they would be empty.
    """
    shots = [(episode, _shot(episode, look)) for episode in _drawn(episodes)]
    if counting is not None:
        shots = [(episode, shot) for episode, shot in shots if len(shot.points)]
    draw = _column if counting is None else _scene
    shown, columns = [episode for episode, _ in shots], [draw(episode, shot, look) for episode, shot in shots]
    text = rrb.TextDocumentView(origin=entity_path(ROOT, "table"), name="Episodes of the trained policy")
    rows = [_side_by_side(shown, columns), text] if columns else [text]
    return rrb.Vertical(*rows, row_shares=[4, 1][-len(rows) :], name="Episodes (timeline t)" if columns else "Episodes")


def anything_drawn(episodes: Sequence[Episode]) -> bool:
    """Whether an episode moves on the timeline ``t``."""
    return bool(_drawn(episodes))


def _side_by_side(episodes: Sequence[Episode], columns: Sequence[rrb.Container | rrb.View]) -> rrb.Container:
    """All columns, or as many a tab as can be looked at, each named after its first and last episode."""
    if len(columns) <= _MOST:
        return rrb.Horizontal(*columns)
    tabs = []
    for start in range(0, len(columns), _MOST):
        first, last = (_spoken(each) for each in (episodes[start], episodes[: start + _MOST][-1]))
        name = first if first == last else f"{first} … {last}"
        tabs.append(rrb.Horizontal(*columns[start : start + _MOST], name=name))
    return rrb.Tabs(*tabs)


def _spoken(episode: Episode) -> str:
    return episode.name.replace("_", " ")


def _column(episode: Episode, shot: "_Shot", look: Look) -> rrb.Container:
    """A machine of which nothing is to be seen, such as bodies of inertia alone, leaves its place to the plots."""
    scene = [_scene(episode, shot, look)] if len(shot.points) else []
    plots = [_plot(episode, "reward", "reward of each step"), _plot(episode, "action", "action")]
    return rrb.Vertical(*scene, *plots, row_shares=[*[4] * len(scene), 1, 1])


def _drawn(episodes: Sequence[Episode]) -> list[Episode]:
    """Those in which something can happen."""
    return [episode for episode in episodes if episode.ended != "infeasible"]


def _log_machine(world: Branch, episode: Episode, shot: "_Shot", look: Look) -> None:
    model = episode.geometry
    world.static(rr.ViewCoordinates.RIGHT_HAND_Z_UP)
    log_surroundings(world / "fixed", model, look.colour("ground"), look.colour("fixed"))
    log_bodies(world / "machine", model, Paint(look.colour("after")))
    send_poses(world / "machine", model, shot.time, shot.pose)
    if shot.way.any():
        # What is not seen goes along, level where the machine bounces, for the eye to follow.
        (world / _FOLLOWED).static(followed_box(shot.points, look))
        (world / _FOLLOWED).over_time(shot.time, rr.Transform3D.columns(translation=shot.way))


def _log_steps(place: Branch, time: Array, value: Array, names: Sequence[str], look: Look) -> None:
    colours = itertools.islice(itertools.cycle(_CURVES), len(names))
    style = rr.SeriesLines(
        colors=[look.colour(colour) for colour in colours],
        names=list(names),
        widths=[look.line_width] * len(names),
        interpolation_mode="StepAfter",
    )
    place.static(style)
    place.over_time(time, rr.Scalars.columns(scalars=value))


@dataclass(frozen=True)
class _Shot:
    """What the eye sees of an episode.

    Attributes:
        time: s, shape (n,).
        pose: of the bodies, world positions in m, shape (n, nbody, 3), and orientations wxyz, shape (n, nbody, 4).
        way: by which the eye goes along, m, shape (n, 3); 0 for a machine that stays where it is.
        points: corners of the moving shapes as seen on the way, m, shape (k, 3); none where none is visible.
    """

    time: Array
    pose: tuple[Array, Array]
    way: Array
    points: Array


def _shot(episode: Episode, look: Look) -> _Shot:
    """The shown poses; the eye goes along with the base of a machine that travels farther than it is large."""
    model, kept = episode.geometry, thin(episode.time, look.pose_rate)
    kept = kept[episode.time[kept] <= look.longest]
    position, orientation = body_poses(model, episode.qpos[kept])
    base = int(np.flatnonzero(model.body_weldid)[0])
    way = (position[:, base] - position[0, base]) * [1.0, 1.0, 0.0]
    corners = moving_corners(model, position[:1], orientation[:1])
    size = np.linalg.norm(np.ptp(corners, axis=0)) if len(corners) else np.inf  # there is nothing to be lost from sight
    way *= np.linalg.norm(way, axis=1).max() > size
    points = moving_corners(model, position - way[:, None], orientation)
    return _Shot(episode.time[kept], (position, orientation), way, points)


def _scene(episode: Episode, shot: _Shot, look: Look) -> rrb.Spatial3DView:
    """The machine, framed in all of its poses."""
    world = [ROOT, episode.name, "world"]
    followed = entity_path(*world, _FOLLOWED) if shot.way.any() else None
    return rrb.Spatial3DView(
        origin=entity_path(*world),
        name=_title(episode),
        eye_controls=eye_controls(shot.points, look, followed),
        line_grid=rrb.LineGrid3D(visible=followed is not None, plane=_LINES),
    )


def _title(episode: Episode) -> str:
    words = [f"return {number(episode.undiscounted)}"]
    words += [f"{name} {number(value)} {unit}".removesuffix(" 1") for name, (value, unit) in episode.context.items()]
    return f"{_spoken(episode)}: {', '.join(words[: 1 + _TITLED])}"


def _plot(episode: Episode, entity: str, title: str) -> rrb.TimeSeriesView:
    return rrb.TimeSeriesView(
        origin=entity_path(ROOT, episode.name, entity),
        name=title,
        axis_x=_LINKED,
        plot_legend=rrb.PlotLegend(visible=False),
    )
