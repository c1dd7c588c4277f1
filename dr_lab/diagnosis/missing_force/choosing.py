"""What a missing force depends on, and how smooth and how large it is, by what a linear step did not see."""

from dataclasses import replace

import mujoco
import numpy as np

from dr_lab.diagnosis.evidence.left_out import parts_of
from dr_lab.diagnosis.missing_force.force_step import Choice, Course, Linear, Machine
from dr_lab.diagnosis.missing_force.learning_settings import LearningSettings
from dr_lab.diagnosis.windows.blocks import spread
from dr_lab.physics.radial_basis import Input, RadialBasis, Seen, around, features
from dr_lab.trajectory import Array

_LEAST = 1e-9  # of a scale, below which a quantity rests
_RADIAN = 1.0  # largest scale of an angle, which is a chord's


def choose_basis(machine: Machine, course: Course, cost: float, settings: LearningSettings) -> Choice | None:
    """The basis with which a step explains most of what it did not see; None where that is not worth it.

    Quantities are added one by one, the best first, each with the width of the bell curves along it that is best. The
    force is odd, the same either way, where that explains as much.

    Args:
        machine: joint and data.
        course: how the fitted windows answer to a force.
        cost: of the fit to them, of which shares are told.
        settings: what is tried.
    """
    return _Search(machine, course, cost, settings).run()


class _Search:
    """The search at one joint."""

    def __init__(self, machine: Machine, course: Course, cost: float, settings: LearningSettings) -> None:
        self.machine, self.course, self.cost, self.settings = machine, course, cost, settings
        self.parts = parts_of(machine.bench.fit.log, machine.bench.evidence)
        self.seen = _some(course.seen, settings.states)
        self.inputs = _inputs(machine, self.seen)

    def run(self) -> Choice | None:
        """The choice."""
        best, known = None, tuple[Input, ...]()
        while len(known) < self.settings.inputs:
            taken = {(each.quantity, each.name) for each in known}
            left = [each for each in self.inputs if (each.quantity, each.name) not in taken]
            wide = [replace(each, scale=width * each.scale) for each in left for width in self.settings.widths]
            found = [choice for each in wide if (choice := self._tried((*known, each))) is not None]
            choice = max(found, key=lambda each: each.share, default=None)
            if choice is None or choice.share < (0.0 if best is None else best.share) + self.settings.worth:
                break
            best, known = choice, choice.basis.inputs
        return None if best is None else self._either_way(best)

    def _either_way(self, plain: Choice) -> Choice:
        """The odd force of the same quantities, which knows twice as much, unless that explains less."""
        odd = self._sized(replace(plain.basis, odd=True))
        return max(odd, plain, key=lambda each: each.share)

    def _tried(self, inputs: tuple[Input, ...]) -> Choice | None:
        """The best size with a basis of these; None where so many bell curves do not cover what was seen."""
        points = features(inputs, self.machine.compiled, self.seen)
        basis = around(inputs, points, self.settings.centres, self.settings.fade)
        if basis.near > 1.0:
            return None
        return self._sized(basis)

    def _sized(self, basis: RadialBasis) -> Choice:
        linear = self.course.linear(basis, np.zeros(len(basis.centres)))
        shares = {size: self._share(linear, size) for size in self.settings.sizes}
        size = max(shares, key=lambda each: shares[each])
        return Choice(basis, size, shares[size])

    def _share(self, linear: Linear, size: float) -> float:
        """Share of the cost that the force removes, beyond what the parameters alone do."""
        return (linear.removed(size, self.parts) - linear.removed(None, self.parts)) / self.cost


def _some(seen: Seen, most: int) -> Seen:
    """At most so many of the states, evenly spread; none of windows that diverge."""
    finite = np.flatnonzero(np.isfinite(seen.qpos).all(1) & np.isfinite(seen.qvel).all(1))
    every = finite[spread(len(finite), most)]
    return Seen(*(part[every] for part in seen))


def _inputs(machine: Machine, seen: Seen) -> tuple[Input, ...]:
    """Positions and velocities of the joints whose position is measured, and commands; those that move."""
    found: list[tuple[str, str, Array]] = []
    for channel in (s.channel for s in machine.bench.fit.samples if s.channel.kind == "position"):
        name = channel.name.removesuffix(".position")
        angle = machine.compiled.joint(name).type[0] != int(mujoco.mjtJoint.mjJNT_SLIDE)
        found.append(("angle" if angle else "place", name, seen.qpos[:, channel.address]))
        found.append(("velocity", name, seen.qvel[:, channel.dof]))
    found += [("command", name, seen.control[:, column]) for name, column in machine.bench.fit.commands.items()]
    scales = [min(float(v.std()), _RADIAN) if q == "angle" else float(v.std()) for q, _, v in found]
    return tuple(Input(q, name, s) for (q, name, _), s in zip(found, scales, strict=True) if s > _LEAST)
