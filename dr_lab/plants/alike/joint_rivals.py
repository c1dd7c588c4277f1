"""What effects at a joint could give along a course."""

import itertools
from collections.abc import Iterator

import mujoco
import numpy as np

from dr_lab.plants.alike.course import Course
from dr_lab.plants.alike.grids import Grids
from dr_lab.plants.alike.response import Signature
from dr_lab.plants.alike.rival import Choice, Rival, along, linear, mixed, pushing, showing
from dr_lab.trajectory import Array


def joint_rivals(course: Course, grids: Grids, load: Array) -> Iterator[Rival]:
    """Effects of every joint, its encoder's included.

    Args:
        course: where the machine moves.
        grids: shapes that are tried.
        load: |drive − outside| at each joint, N·m or N, shape (K, n).
    """
    for row, joint in enumerate(course.machine.joints):
        yield from _frictions(course, grids, load[:, row], row, joint)
        yield from _fading(course, grids, row, joint)
        yield from _creeping(course, grids, row, joint)
        yield _soft(course, grids, row, joint)
        yield _falling(course, grids, row, joint)
        yield from _forces(course, grids, row, joint)
        yield from _readings(course, grids, row, joint)
        if row and _slides(course, joint) == _slides(course, course.machine.joints[row - 1]):
            yield _coupled(course, grids, row, joint)


def _frictions(course: Course, grids: Grids, load: Array, row: int, joint: str) -> Iterator[Rival]:
    q, v, count = course.position[:, row], course.velocity[:, row], course.position.shape[1]
    # A held joint is braked by what it needs, which every dry friction that is large enough gives.
    sign = np.where(course.held[:, row], 0.0, course.direction[:, row])

    def of(shape: Array) -> Choice:
        return linear(pushing(shape, row, count), positive=True)[0]

    def several(*shapes: Array, positive: tuple[bool, ...]) -> tuple[Choice, ...]:
        return linear(*(pushing(shape, row, count) for shape in shapes), positive=positive)

    yield Rival(f"coulomb_friction@{joint}", 1, (of(-sign),))
    yield Rival(f"asymmetric_friction@{joint}", 2, several(-sign, -(sign**2), positive=(True, False)))
    speeds = np.abs(v).max() * np.asarray(grids.stribeck)
    drops = [several(-sign, -sign * np.exp(-((v / s) ** 2)), positive=(True, True)) for s in speeds]
    yield Rival(f"stribeck_friction@{joint}", 3, tuple(choice for drop in drops for choice in drop))
    turned = several(-sign, -sign * np.sin(q), -sign * np.cos(q), positive=(True, False, False))
    yield Rival(f"position_dependent_friction@{joint}", 3, turned)
    yield Rival(f"load_dependent_friction@{joint}", 1, (of(-sign * load),))
    yields = np.ptp(q) * np.asarray(grids.displacements)
    yield Rival(f"hysteresis@{joint}", 2, tuple(of(-bent(v, course.step, y) / y) for y in yields))
    yield Rival(f"viscous_friction@{joint}", 1, (of(-v),))
    yield Rival(f"quadratic_drag@{joint}", 1, (of(-np.abs(v) * v),))


def _creeping(course: Course, grids: Grids, row: int, joint: str) -> Iterator[Rival]:
    """Friction that creeps, and gives way before it slides or not; damping of its bristles is left out."""
    q, v, count = course.position[:, row], course.velocity[:, row], course.position.shape[1]
    slow = np.abs(v).max() * np.asarray(grids.creeps)

    def giving(way: float) -> tuple[Choice, ...]:
        bends = [gripped(v, course.step, way, np.tanh(v / creep), creep) for creep in slow]
        return tuple(mixed([pushing(-bend, row, count) for bend in bends]))

    yield Rival(f"smooth_friction@{joint}", 2, giving(0.0))
    ways = np.ptp(q) * np.asarray(grids.ways)
    yield Rival(f"presliding_friction@{joint}", 4, tuple(choice for way in ways for choice in giving(float(way))))


def _soft(course: Course, grids: Grids, row: int, joint: str) -> Rival:
    """Friction that grows with the speed up to its size, or is hard."""
    v, count = course.velocity[:, row], course.position.shape[1]
    slow = np.abs(v).max() * np.asarray(grids.creeps)
    shapes = [-np.clip(v / creep, -1.0, 1.0) for creep in slow]
    hard = -np.where(course.held[:, row], 0.0, course.direction[:, row])
    choices = [linear(pushing(shape, row, count), positive=True)[0] for shape in (hard, *shapes)]
    return Rival(f"soft_friction@{joint}", 2, tuple(choices))


def _falling(course: Course, grids: Grids, row: int, joint: str) -> Rival:
    """Friction that gives way before it slides and falls with the speed; damping of its bristles is left out."""
    q, v, count = course.position[:, row], course.velocity[:, row], course.position.shape[1]
    choices = []
    for way, speed in itertools.product(np.asarray(grids.ways[1:]), np.asarray(grids.stribeck)):
        fall = 1 - np.exp(-((v / (speed * np.abs(v).max())) ** 2))
        steady = [np.sign(v) * (1 - drop * fall) for drop in grids.drops]
        choices += mixed([pushing(-gripped(v, course.step, way * np.ptp(q), end), row, count) for end in steady])
    return Rival(f"lugre_friction@{joint}", 5, tuple(choices))


def _fading(course: Course, grids: Grids, row: int, joint: str) -> Iterator[Rival]:
    """Dry and viscous friction that fade with the time since the log began."""
    v, count, choices = course.velocity[:, row], course.position.shape[1], []
    sign = np.where(course.held[:, row], 0.0, course.direction[:, row])
    for rate in grids.rates:
        left = np.exp(-rate * course.middle)
        shapes = (pushing(-left * sign, row, count), pushing(-left * v, row, count))
        choices += linear(*shapes, positive=True)
    yield Rival(f"friction_drift@{joint}", 3, tuple(choices))


def _forces(course: Course, grids: Grids, row: int, joint: str) -> Iterator[Rival]:
    q, a, count = course.position[:, row], course.acceleration[:, row], course.position.shape[1]

    def forced(*shapes: Array, positive: bool = False) -> tuple[Choice]:
        return linear(*(pushing(shape, row, count) for shape in shapes), positive=positive)

    # What these give is not linear in anything: they have no rivals' shapes, but a number of parameters.
    yield Rival(f"backlash@{joint}", 2)
    yield Rival(f"joint_elasticity@{joint}", 3)
    yield Rival(f"motor_side_elasticity@{joint}", 3)
    one = np.ones_like(q)
    yield Rival(f"spring@{joint}", 2, forced(-q, one))
    yield Rival(f"hardening_spring@{joint}", 2, forced(-(q**3)))
    yield Rival(f"constant_offset@{joint}", 1, forced(one))
    turns = [n * q for n in (grids.pitches if _slides(course, joint) else grids.periods)]
    yield Rival(f"cogging@{joint}", 3, tuple(forced(np.sin(turn), np.cos(turn))[0] for turn in turns))
    yield Rival(f"armature@{joint}", 1, forced(-a, positive=True))
    inwards = np.ptp(q) * np.asarray(grids.stops)
    above = [forced(-np.maximum(q - (q.max() - far), 0.0), positive=True)[0] for far in inwards]
    below = [forced(np.maximum(q.min() + far - q, 0.0), positive=True)[0] for far in inwards]
    yield Rival(f"end_stop@{joint}", 2, (*above, *below))


def _coupled(course: Course, grids: Grids, row: int, joint: str) -> Rival:
    """A spring between a joint and the one before it, its ratio from a grid; its rest position is linear."""
    q, count, choices = course.position, course.position.shape[1], []
    for ratio in grids.ratios:
        stretch, one = q[:, row - 1] - ratio * q[:, row], np.ones(len(q))
        columns = []
        for pull in (-stretch, one):
            first, second = pushing(pull, row - 1, count), pushing(-ratio * pull, row, count)
            columns.append(Signature(first.force + second.force, first.reading))
        choices += linear(*columns, positive=(True, False))
    return Rival(f"joint_coupling@{joint}", 3, tuple(choices))


def _readings(course: Course, grids: Grids, row: int, joint: str) -> Iterator[Rival]:
    """What an encoder reads beyond the position of a model that shows what was measured, y.

    A delay d reads y = q(t − d), so that q = y(t + d); a filter y' = (q − y) / c, so that q = y + c y'.
    The same holds of velocities, which a tachometer shows.
    """
    q, count, measured = course.position[:, row], course.position.shape[1], course.measured[row]
    v, spun, now = course.velocity[:, row], course.measured_speed[row], course.middle

    def read(*shapes: Array) -> tuple[Choice]:
        return linear(*(showing(row, count, shape) for shape in shapes))

    yield Rival(f"sensor_bias@{joint}", 1, read(np.ones_like(q)))
    yield Rival(f"sensor_scale@{joint}", 1, linear(showing(row, count, q, v)))
    most = grids.drift * float(np.ptp(q))
    yield Rival(f"sensor_drift@{joint}", 1, (Choice([showing(row, count, now, 1.0)], [-most], [most]),))
    turns = [n * q for n in (grids.pitches if _slides(course, joint) else grids.discs)]
    yield Rival(f"encoder_eccentricity@{joint}", 3, tuple(read(np.sin(turn), np.cos(turn))[0] for turn in turns))
    y, w = measured.at(now), spun.at(now)
    late = [showing(row, count, y - measured.at(now + d), w - spun.at(now + d)) for d in grids.offsets]
    yield Rival(f"sensor_time_offset@{joint}", 1, along(late))
    slow = showing(row, count, -measured.rate(now), -spun.rate(now))
    yield Rival(f"sensor_low_pass@{joint}", 1, (Choice([slow], [0.0], [grids.filter]),))
    smooth = showing(row, count, speed=-spun.rate(now))
    yield Rival(f"velocity_low_pass@{joint}", 1, (Choice([smooth], [0.0], [grids.velocity_filter]),))


def _slides(course: Course, joint: str) -> bool:
    return int(course.machine.model.joint(joint).type[0]) == int(mujoco.mjtJoint.mjJNT_SLIDE)


def bent(velocity: Array, step: Array, most: float) -> Array:
    """Displacement of a spring that follows a joint within ± most, at the middle of each interval, shape (K,)."""
    way, now, shown = velocity * step, 0.0, np.zeros(len(step))
    for k, moved in enumerate(way.tolist()):
        after = min(max(now + moved, -most), most)
        shown[k], now = 0.5 * (now + after), after
    return shown


def gripped(velocity: Array, step: Array, way: float, settled: Array, creep: float = 0.0) -> Array:
    """Bend of bristles z' = v − |v / g| z / way, in units of the way; means of intervals, shape (K,).

    Args:
        velocity: of the joint, rad/s or m/s, shape (K,).
        step: length of each interval in s, shape (K,).
        way: rad or m.
        settled: g, to which z settles at each velocity, with its sign, shape (K,).
        creep: limit of v / g at rest.
    """
    if not way:
        return settled
    turns = np.where(settled == 0.0, creep, velocity / np.where(settled == 0.0, 1.0, settled)) * step / way
    now, shown, left = 0.0, np.zeros(len(step)), np.exp(-turns)
    share = np.where(turns > 0.0, -np.expm1(-turns) / np.where(turns > 0.0, turns, 1.0), 1.0)
    for k, end in enumerate(settled.tolist()):
        shown[k] = end + (now - end) * share[k]
        now = end + (now - end) * left[k]
    return shown
