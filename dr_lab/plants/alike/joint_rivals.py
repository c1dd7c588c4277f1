"""What effects at a joint could give along a course."""

from collections.abc import Iterator, Sequence

import numpy as np

from dr_lab.plants.alike.at_joint import AtJoint
from dr_lab.plants.alike.friction_rivals import friction_rivals
from dr_lab.plants.alike.response import Signature
from dr_lab.plants.alike.rival import Choice, Rival, along, linear, pushing, showing
from dr_lab.trajectory import Array


def joint_rivals(places: Sequence[AtJoint], load: Array) -> Iterator[Rival]:
    """Effects of every joint, its encoder's included.

    Args:
        places: all joints, in order.
        load: |drive − outside| at each joint, N·m or N, shape (K, n).
    """
    for at in places:
        yield from friction_rivals(at, load[:, at.row])
        yield from _forces(at)
        yield from _readings(at)
        if at.row and at.slides == places[at.row - 1].slides:
            yield _coupled(at)


def tachometer_rivals(places: Sequence[AtJoint]) -> Iterator[Rival]:
    """Effects of every joint's tachometer, whose readings q' follow late: q' = w + c w'."""
    for at in places:
        rate = at.course.measured_speed[at.row].rate(at.course.middle)
        smooth = Choice([showing(at.row, at.joints, speed=-rate)], [0.0], [at.grids.velocity_filter])
        yield Rival(f"velocity_low_pass@{at.name}", 1, (smooth,))


def _forces(at: AtJoint) -> Iterator[Rival]:
    q, joint = at.q, at.name
    # What these give is not linear in anything: they have no rivals' shapes, but a number of parameters.
    yield Rival(f"backlash@{joint}", 2)
    yield Rival(f"joint_elasticity@{joint}", 3)
    yield Rival(f"motor_side_elasticity@{joint}", 3)
    if at.controlled:
        yield Rival(f"servo_backlash@{joint}", 2)
        yield Rival(f"servo_elasticity@{joint}", 3)
    yield Rival(f"flexible_mode@{joint}", 3)
    one = np.ones_like(q)
    yield Rival(f"spring@{joint}", 2, at.linear(-q, one))
    yield Rival(f"hardening_spring@{joint}", 2, at.linear(-(q**3)))
    yield Rival(f"constant_offset@{joint}", 1, at.linear(one))
    turns = [n * q for n in (at.grids.pitches if at.slides else at.grids.periods)]
    yield Rival(f"cogging@{joint}", 3, tuple(at.linear(np.sin(turn), np.cos(turn))[0] for turn in turns))
    yield Rival(f"armature@{joint}", 1, at.linear(-at.course.acceleration[:, at.row], positive=True))
    upper, lower, inwards = at.extent.highest[at.row], at.extent.lowest[at.row], at.ways(at.grids.stops)
    above = [at.linear(-np.maximum(q - (upper - far), 0.0), positive=True)[0] for far in inwards]
    below = [at.linear(np.maximum(lower + far - q, 0.0), positive=True)[0] for far in inwards]
    yield Rival(f"end_stop@{joint}", 4, (*above, *below))


def _coupled(at: AtJoint) -> Rival:
    """A spring between a joint and the one before it, its ratio from a grid; its rest position is linear."""
    q, row, count, choices = at.course.position, at.row, at.joints, []
    for ratio in at.grids.ratios:
        stretch, one = q[:, row - 1] - ratio * q[:, row], np.ones(len(q))
        columns = []
        for pull in (-stretch, one):
            first, second = pushing(pull, row - 1, count), pushing(-ratio * pull, row, count)
            columns.append(Signature(first.force + second.force, first.reading))
        choices += linear(*columns, positive=(True, False))
    return Rival(f"joint_coupling@{at.name}", 3, tuple(choices))


def _readings(at: AtJoint) -> Iterator[Rival]:
    """What an encoder reads beyond the position of a model that shows what was measured, y.

    A delay d reads y = q(t − d), so that q = y(t + d); a filter y' = (q − y) / c, so that q = y + c y'.
    The same holds of velocities, which a tachometer shows.
    """
    q, v, grids, now = at.q, at.v, at.grids, at.course.middle
    measured, spun = at.course.measured[at.row], at.course.measured_speed[at.row]

    def shown(position: Array | float = 0.0, speed: Array | float = 0.0) -> Signature:
        return showing(at.row, at.joints, position, speed)

    def read(*shapes: Array) -> tuple[Choice]:
        return linear(*map(shown, shapes))

    yield Rival(f"sensor_bias@{at.name}", 1, read(np.ones_like(q)))
    yield Rival(f"sensor_scale@{at.name}", 1, linear(shown(q, v)))
    most = float(at.ways([grids.drift])[0])
    yield Rival(f"sensor_drift@{at.name}", 1, (Choice([shown(now, 1.0)], [-most], [most]),))
    turns = [n * q for n in (grids.pitches if at.slides else grids.discs)]
    yield Rival(f"encoder_eccentricity@{at.name}", 3, tuple(read(np.sin(turn), np.cos(turn))[0] for turn in turns))
    y, w = measured.at(now), spun.at(now)
    late = [shown(y - measured.at(now + d), w - spun.at(now + d)) for d in grids.offsets]
    yield Rival(f"sensor_time_offset@{at.name}", 1, along(late))
    slow = shown(-measured.rate(now), -spun.rate(now))
    yield Rival(f"sensor_low_pass@{at.name}", 1, (Choice([slow], [0.0], [grids.filter]),))
