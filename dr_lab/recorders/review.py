"""`review.rrd`: the recording that a person opens to see where a model fails and what the effect changes."""

from collections.abc import Sequence
from pathlib import Path

import mujoco
import rerun as rr

from dr_lab.recorders.bars import log_ladder, log_ranking
from dr_lab.recorders.blueprints import review_blueprint
from dr_lab.recorders.branch import Branch
from dr_lab.recorders.force_map import log_force_map
from dr_lab.recorders.look import Look
from dr_lab.recorders.overlay import MEASURED, Overlay
from dr_lab.recorders.recording import recording_file
from dr_lab.recorders.scatter import log_scatter
from dr_lab.recorders.scene import log_bodies, log_surroundings, send_poses, thin
from dr_lab.recorders.shape import Paint
from dr_lab.recorders.signals import log_commands, log_residuals, log_signals
from dr_lab.reports.gap import GapReport
from dr_lab.reports.ladder import before_after, steps
from dr_lab.reports.rankings import by_gain
from dr_lab.reports.tables import error_table, ranking_table
from dr_lab.reports.verdict import verdict_markdown

# Rerun keeps one layout an application: every recording of a gap shares this one.
APPLICATION = "dr_lab_gap"


def write_review(
    path: Path,
    report: GapReport,
    report_md: str,
    overlays: Sequence[Overlay],
    geometry: mujoco.MjModel,
    look: Look,
) -> None:
    """Write the recording with its layout, atomically.

    Entities: ``/<log>/world/{real,sim_before,sim_after}/<body>/<geom>``, ``/<log>/{signal,residual}/<channel>/…``,
    ``/<log>/command/<actuator>``, ``/<log>/{scatter,force}/<joint>``, ``/diagnosis/{ranking,ladder}``, ``/verdict``,
    ``/report``; timeline ``t``, a duration on the log's clock.

    Args:
        path: the file, by custom ``review.rrd``.
        report: what was found.
        report_md: the page made from it.
        overlays: the scored logs; the first is shown on opening, the others have tabs.
        geometry: the model whose bodies the poses belong to.
        look: colours, rates and the eye.

    Raises:
        DrLabError: the folder cannot be written to.
    """
    with recording_file(path, APPLICATION, _name(report), review_blueprint(report, overlays, geometry, look)) as root:
        _log_report(root, report, report_md, look)
        for overlay in overlays:
            _log_overlay(root, overlay, geometry, look)


def _name(report: GapReport) -> str:
    return " · ".join(name for name in (report.model, report.verb, report.verdict) if name)


def _log_report(root: Branch, report: GapReport, report_md: str, look: Look) -> None:
    verdict = f"#### {verdict_markdown(report)}\n\n{error_table(report)}\n"
    _log_text(root / "verdict", verdict)
    _log_text(root / "report", report_md)
    diagnosis = root / "diagnosis"
    ladder = steps(report)
    if len(ladder) > 1:
        log_ladder(diagnosis / "ladder", ladder, before_after(report), look)
    if ranking := report.judged.ranking:
        log_ranking(diagnosis / "ranking", ranking, report.verdict, look)
        table = ranking_table(by_gain(ranking), report.verdict, report.judged.confidence)
        _log_text(diagnosis / "ranking_table", table)


def _log_text(place: Branch, text: str) -> None:
    place.static(rr.TextDocument(text, media_type=rr.MediaType.MARKDOWN))


def _log_overlay(root: Branch, overlay: Overlay, geometry: mujoco.MjModel, look: Look) -> None:
    log = root / overlay.log
    _log_robots(log / "world", overlay, geometry, look)
    log_signals(log, overlay, look)
    log_residuals(log, overlay, look)
    log_commands(log, overlay, look)
    for joint in overlay.joints():
        log_scatter(log / "scatter" / joint, overlay, joint, _velocity_unit(geometry, joint), look)
    for joint, shown in overlay.force_maps.items():
        log_force_map(log / "force" / joint, shown, look)


def _log_robots(world: Branch, overlay: Overlay, geometry: mujoco.MjModel, look: Look) -> None:
    world.static(rr.ViewCoordinates.RIGHT_HAND_Z_UP)
    log_surroundings(world / "fixed", geometry, look.colour("ground"), look.colour("fixed"))
    kept = thin(overlay.time, look.pose_rate)
    for role, (position, quaternion) in overlay.poses.items():
        robot = world / ("real" if role == MEASURED else f"sim_{role}")
        ghost = Paint(look.colour(role, look.ghost_alpha), look.ghost_swell)
        log_bodies(robot, geometry, Paint(look.colour(role)) if role == MEASURED else ghost)
        send_poses(robot, geometry, overlay.time[kept], (position[kept], quaternion[kept]))


def _velocity_unit(geometry: mujoco.MjModel, joint: str) -> str:
    index = mujoco.mj_name2id(geometry, mujoco.mjtObj.mjOBJ_JOINT, joint)
    slides = index >= 0 and geometry.jnt_type[index] == mujoco.mjtJoint.mjJNT_SLIDE
    return "m/s" if slides else "rad/s"
