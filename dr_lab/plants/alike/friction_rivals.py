"""What frictions of a joint could give along a course."""

from collections.abc import Iterator

import numpy as np

from dr_lab.plants.alike.at_joint import AtJoint
from dr_lab.plants.alike.rival import Choice, Rival, mixed
from dr_lab.trajectory import Array


def friction_rivals(at: AtJoint, load: Array) -> Iterator[Rival]:
    """Frictions of a joint.

    Args:
        at: the joint.
        load: |drive − outside| there, N·m or N, shape (K,).
    """
    yield from _sliding(at, load)
    yield _fading(at)
    yield from _creeping(at)
    yield _soft(at)
    yield _falling(at)


def _sliding(at: AtJoint, load: Array) -> Iterator[Rival]:
    q, v, sign = at.q, at.v, _direction(at)
    yield Rival(f"coulomb_friction@{at.name}", 1, at.dry(-sign))
    yield Rival(f"asymmetric_friction@{at.name}", 2, at.dry(-sign, -(sign**2), positive=(True, False)))
    drops = [at.dry(-sign, -sign * np.exp(-((v / s) ** 2))) for s in at.speeds(at.grids.stribeck)]
    yield Rival(f"stribeck_friction@{at.name}", 3, tuple(choice for drop in drops for choice in drop))
    if not at.slides:
        turned = at.dry(-sign, -sign * np.sin(q), -sign * np.cos(q), positive=(True, False, False))
        yield Rival(f"position_dependent_friction@{at.name}", 3, turned)
    yield Rival(f"load_dependent_friction@{at.name}", 1, at.dry(-sign * load))
    yields = [at.linear(-bent(v, at.course.step, y) / y, positive=True)[0] for y in at.ways(at.grids.displacements)]
    yield Rival(f"hysteresis@{at.name}", 2, tuple(yields))
    yield Rival(f"viscous_friction@{at.name}", 1, at.linear(-v, positive=True))
    yield Rival(f"quadratic_drag@{at.name}", 1, at.linear(-np.abs(v) * v, positive=True))


def _direction(at: AtJoint) -> Array:
    """Direction in which a joint slides, 0 while it is held."""
    return np.where(at.course.held[:, at.row], 0.0, at.course.direction[:, at.row])


def _creeping(at: AtJoint) -> Iterator[Rival]:
    """Friction that creeps, and gives way before it slides or not; damping of its bristles is left out."""
    v, slow = at.v, at.speeds(at.grids.creeps)

    def giving(way: float) -> tuple[Choice, ...]:
        bends = gripped(v, at.course.step, way, np.tanh(v[:, None] / slow), slow)
        return mixed([at.pushed(-bend) for bend in bends.T])

    yield Rival(f"smooth_friction@{at.name}", 2, giving(0.0))
    ways = at.ways(at.grids.ways)
    yield Rival(f"presliding_friction@{at.name}", 4, tuple(choice for way in ways for choice in giving(float(way))))


def _soft(at: AtJoint) -> Rival:
    """Friction that grows with the speed up to its size, or is hard."""
    shapes = [-np.clip(at.v / creep, -1.0, 1.0) for creep in at.speeds(at.grids.creeps)]
    soft = [at.linear(shape, positive=True)[0] for shape in shapes]
    return Rival(f"soft_friction@{at.name}", 2, (*at.dry(-_direction(at)), *soft))


def _falling(at: AtJoint) -> Rival:
    """Friction that gives way before it slides and falls with the speed; damping of its bristles is left out."""
    fall = 1 - np.exp(-((at.v[:, None] / at.speeds(at.grids.stribeck)) ** 2))
    steady = np.sign(at.v)[:, None, None] * (1 - np.asarray(at.grids.drops) * fall[:, :, None])
    choices: list[Choice] = []
    for way in at.ways(at.grids.ways[1:]):
        bends = gripped(at.v, at.course.step, float(way), steady)
        for falling in bends.transpose(1, 2, 0):
            choices += mixed([at.pushed(-bend) for bend in falling])
    return Rival(f"lugre_friction@{at.name}", 5, tuple(choices))


def _fading(at: AtJoint) -> Rival:
    """Dry and viscous friction that fade with the time since the log began."""
    sign, choices = _direction(at), []
    for rate in at.grids.rates:
        left = np.exp(-rate * at.course.middle)
        choices += at.dry(-left * sign, -left * at.v)
    return Rival(f"friction_drift@{at.name}", 3, tuple(choices))


def bent(velocity: Array, step: Array, most: float) -> Array:
    """Displacement of a spring that follows a joint within ± most, at the middle of each interval, shape (K,)."""
    way, now, shown = velocity * step, 0.0, np.zeros(len(step))
    for k, moved in enumerate(way.tolist()):
        after = min(max(now + moved, -most), most)
        shown[k], now = 0.5 * (now + after), after
    return shown


def gripped(velocity: Array, step: Array, way: float, settled: Array, creep: Array | float = 0.0) -> Array:
    """Bend of bristles z' = v − |v / g| z / way, in units of the way; means of intervals, of the shape of `settled`.

    Args:
        velocity: of the joint, rad/s or m/s, shape (K,).
        step: length of each interval in s, shape (K,).
        way: rad or m.
        settled: g, to which z settles at each velocity, with its sign; of many frictions at once, shape (K, …).
        creep: limit of v / g at rest; of each friction, where it differs.
    """
    if not way:
        return settled
    speed, time = (np.expand_dims(each, tuple(range(1, settled.ndim))) for each in (velocity, step))
    turns = np.where(settled == 0.0, creep, speed / np.where(settled == 0.0, 1.0, settled)) * time / way
    share = np.where(turns > 0.0, -np.expm1(-turns) / np.where(turns > 0.0, turns, 1.0), 1.0)
    now, shown, left = np.zeros(settled.shape[1:]), np.empty_like(settled), np.exp(-turns)
    for k, end in enumerate(settled):
        shown[k] = end + (now - end) * share[k]
        now = end + (now - end) * left[k]
    return shown
