"""The joints' positions where inverse dynamics cannot test them: what the names alone say."""

import math
from collections.abc import Sequence

import mujoco
import numpy as np

from dr_lab.diagnosis.windows.closed_loops import coupled
from dr_lab.diagnosis.windows.start import untold_joints
from dr_lab.errors import DataError
from dr_lab.proposal.drives import drives_of
from dr_lab.proposal.grid import wrapped
from dr_lab.proposal.output import Output, Positions
from dr_lab.proposal.per_control import per_control
from dr_lab.proposal.shared_out import shared_out
from dr_lab.proposal.survey import Series, Survey

_COUPLED = "an equality constraint couples joints, and no encoder shows its force, which inverse dynamics needs"
_SMALLER = {"rad": {"deg": math.pi / 180}, "m": {"cm": 1e-2, "mm": 1e-3}}  # units of larger numbers, the largest first
_HINGE = int(mujoco.mjtJoint.mjJNT_HINGE)


def positions_by_name(
    model: mujoco.MjModel, logs: Survey, candidates: Sequence[Series], asked: Sequence[Series], *, sensed: bool
) -> Positions:
    """What the names alone say; with nothing `sensed` either, the logs are not those of the robot."""
    names = [model.joint(i).name for i in range(model.njnt) if model.jnt_type[i] >= int(mujoco.mjtJoint.mjJNT_SLIDE)]
    places, open_places = shared_out(model, names, candidates)
    velocities = [s for s in logs.named("velocity") if s.moves]
    rates, open_rates = shared_out(model, names, velocities)
    outputs = []
    lacking = []
    for name in names:
        hinge = model.jnt_type[model.joint(name).id] == _HINGE
        if name in places:
            outputs.append(
                _named(f"{name}.position", candidates[places[name]], "rad" if hinge else "m", _reach(model, name))
            )
        elif name in rates:
            outputs.append(_named(f"{name}.velocity", velocities[rates[name]], "rad/s" if hinge else "m/s", math.inf))
        else:
            lacking.append(name)
    if not (outputs or sensed):
        raise DataError(_nothing_fits(model, names, logs))
    what = "of joints and commands " if sensed else ""
    doubts = [f"Signs and units {what}are by name alone: {_why_untested(model, lacking)}.", *open_places]
    doubts += [doubt for doubt in open_rates if any(o.channel.endswith(".velocity") for o in outputs)]
    untold = untold_joints(model, [output.channel for output in outputs])
    if lacking := [name for name in lacking if name in untold]:
        doubts.append(f"No series is said to be {', '.join(lacking)}: not measured, or called differently.")
    force, _ = per_control(model)
    return Positions(tuple(outputs), None, None, tuple(asked), drives_of(model, force), tuple(doubts))


def _nothing_fits(model: mujoco.MjModel, joints: Sequence[str], logs: Survey) -> str:
    seen = [str(each.place) for each in logs.series]
    listed = f"The logs hold {', '.join(seen[:20])}{' …' if len(seen) > 20 else ''}."
    listed = " ".join([listed if seen else "The logs hold no numbers that change.", *logs.spoilt])
    if not joints:
        return (
            f"No series of the logs is a position (x, y, z), an orientation (qw, qx, qy, qz), an angular rate (gx, gy, "
            f"gz) or an acceleration (ax, ay, az) of the robot's free body. {listed} Name columns or topics so, or "
            "write the measurements by hand."
        )
    if coupled(model):
        return (
            f"Which series are the joints {', '.join(joints)} has to be told by name: {_COUPLED}. {listed} Name "
            f"columns or topics after the joints, with their units ({joints[0]}_position_mm), or write the "
            "measurements by hand."
        )
    return (
        f"No series of the logs fits a joint of the robot. Joints: {', '.join(joints)}. {listed} Are these logs of "
        "this robot? If so, name columns or topics after the joints (elbow_position), or write the "
        "measurements by hand."
    )


def _reach(model: mujoco.MjModel, joint: str) -> float:
    """Largest angle of a joint in the model; two turns where it has no range."""
    row = model.joint(joint).id
    return float(np.abs(model.jnt_range[row]).max()) if model.jnt_limited[row] else 4 * math.pi


def _named(channel: str, series: Series, usual: str, reach: float) -> Output:
    wrap = any(wrapped(signal.value) > 0 for signal in series.signals)
    unit = series.words.unit or _by_range(series, usual, reach)
    why = "" if unit == (series.words.unit or usual) else f"; in {usual} it would leave the joint's range"
    return Output(channel, (series,), unit, 1, 0.0, wrap, f"by its name{why}")


def _by_range(series: Series, usual: str, reach: float) -> str:
    """Degrees, centimetres or millimetres where the numbers are too large for radians or metres."""
    largest = max(float(np.abs(signal.value).max()) for signal in series.signals)
    smaller = _SMALLER.get(usual, {})
    if largest <= 2 * reach or not smaller:
        return usual
    fitting = (name for name, factor in smaller.items() if factor * largest <= 2 * reach)
    return next(fitting, [*smaller][-1])


def _why_untested(model: mujoco.MjModel, lacking: Sequence[str]) -> str:
    if coupled(model):
        return _COUPLED
    if lacking:
        return "not every joint is measured, which inverse dynamics needs"
    return (
        "a body is free, or a joint is neither a hinge nor a slide"
        if model.nv != model.njnt
        else "the names leave too much open"
    )
