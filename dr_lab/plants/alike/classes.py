"""The equivalence class of a hidden effect, by regression of what the base lacks on what rivals give."""

import functools
import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from dr_lab.errors import ConfigError
from dr_lab.plants.alike.actuator_rivals import actuator_rivals
from dr_lab.plants.alike.at_joint import AtJoint
from dr_lab.plants.alike.body_rivals import body_rivals
from dr_lab.plants.alike.course import Course, courses, rigid
from dr_lab.plants.alike.extent import Extent
from dr_lab.plants.alike.felt import Felt
from dr_lab.plants.alike.forces import Forces
from dr_lab.plants.alike.grids import Grids
from dr_lab.plants.alike.joint_rivals import joint_rivals, tachometer_rivals
from dr_lab.plants.alike.lacking import borne, lacking, lacking_with, turns_inside, without_inside
from dr_lab.plants.alike.regression import Regression
from dr_lab.plants.alike.response import Signature, response
from dr_lab.plants.alike.rival import Rival, lacked
from dr_lab.plants.hidden.composite import Composite
from dr_lab.plants.hidden.effect import HiddenEffect
from dr_lab.plants.hidden.no_effect import NoEffect
from dr_lab.plants.hidden.several import Several
from dr_lab.plants.rig import Rig
from dr_lab.plants.tachometers import Tachometers
from dr_lab.trajectory import Array

_SHARE = 0.01  # of a free parameter; what it changes is linear


@dataclass(frozen=True)
class Classes:
    """How equivalence classes are predicted.

    A rival, or the base with its free parameters refitted, is of the class of a truth if the least χ² that it leaves of
    noise-free logs exceeds what the truth's own effect of the catalogue leaves by less than the threshold, and if it
    has no more parameters than that.

    Noise counts as white with its density at low frequencies, where motions lie. Backlash and elasticity are rivals
    of themselves alone: what they give along a course is not linear in anything.

    Attributes:
        threshold: χ².
        window: s; each begins at a free state.
        settling: s at the beginning of each log that are left out.
        parts: intervals between two commands.
        grids: shapes of rivals that are tried.
        felt: which of them the joints feel.
    """

    threshold: float
    window: float
    settling: float
    parts: int
    grids: Grids
    felt: Felt

    def of(self, bench: Rig, seed: int) -> dict[str, dict[str, int]]:
        """The class of every effect that is hidden: ``effect@site`` → number of parameters, 0 for the base."""
        labels, regression = [part.label for part in _parts(bench)], self.regression(bench, seed)
        return {label: regression.members(number, labels, self.threshold) for number, label in enumerate(labels)}

    def regression(self, bench: Rig, seed: int) -> Regression:
        """The hidden effects, in their order, and what could be in their place, along all logs."""
        logs = [_Log.of(course) for course in courses(bench, seed, self.settling, self.parts)]
        asked = _Asked(bench, seed, logs, Extent.of([log.course for log in logs], [log.forces for log in logs]))
        regression, many = self._regression(asked, ()), len(_parts(bench))
        if many == 1:
            return regression
        return self._regression(asked, [regression.nearest(number) for number in range(many)])

    def _regression(self, asked: "_Asked", nearest: Sequence[int | None]) -> Regression:
        """All logs in one regression.

        Args:
            asked: the logs.
            nearest: place, among all choices, of the one that stands for each part while another is judged.
        """
        return functools.reduce(Regression.__add__, (self._along(log, asked, nearest) for log in asked.logs))

    def _along(self, log: "_Log", asked: "_Asked", nearest: Sequence[int | None]) -> Regression:
        """The regression of one log."""
        bench, course, parts = asked.bench, log.course, _parts(asked.bench)
        freed, rivals = [lacked(force) for force in _free(log, bench, asked.seed)], tuple(self._rivals(log, asked))
        choices = [choice for rival in rivals for choice in rival.choices]
        beside = [() if place is None else choices[place].columns for place in nearest]
        common = [*(_truth(course, parts, part) for part in parts), *freed, *itertools.chain(*beside)]
        window = max(round(self.window / float(np.median(course.step))), 1)
        seen = response(course, _noise(bench), bench.instruments.sample_rate)
        products = seen.inner_products(common, [choice.signatures for choice in choices], window)
        return Regression(products, len(parts), len(freed), rivals, [len(each) for each in beside])

    def _rivals(self, log: "_Log", asked: "_Asked") -> Iterator[Rival]:
        course, forces, rows = log.course, log.forces, range(len(log.course.machine.joints))
        places = [AtJoint(course, self.grids, asked.extent, row, log.borne) for row in rows]
        yield from joint_rivals(places, np.abs(forces.drive - forces.outside))
        if isinstance(asked.bench.instruments.velocity, Tachometers):
            yield from tachometer_rivals(places)
        yield from actuator_rivals(course, self.grids, asked.extent, forces)
        yield from body_rivals(course, self.grids, self.felt, log.command, log.base)


@dataclass(frozen=True)
class _Log:
    """A course and what the machine without any effect makes of its commands.

    Attributes:
        course: where the machine moves.
        command: mean over each interval, shape (K, actuators).
        base: what the machine without any effect lacks, N·m or N, shape (K, n).
        forces: along the course.
        borne: what the hidden dry friction bears at the joints that it holds, N·m or N, shape (K, n).
    """

    course: Course
    command: Array
    base: Array
    forces: Forces
    borne: Array

    @classmethod
    def of(cls, course: Course) -> "_Log":
        command = course.mean_command(NoEffect())
        base = lacking(course, course.machine, command)
        return cls(course, command, base, Forces.of(course, command, base), borne(course))


@dataclass(frozen=True)
class _Asked:
    """All logs of a machine.

    Attributes:
        bench: the machine with its instruments and what is hidden in it.
        seed: of the logs.
        logs: one after the other.
        extent: how far they reach together.
    """

    bench: Rig
    seed: int
    logs: Sequence[_Log]
    extent: Extent


def _parts(bench: Rig) -> Sequence[HiddenEffect]:
    """What is hidden, one by one.

    Raises:
        ConfigError: more than one of them turns inside; what each lacks would depend on how the other swings.
    """
    parts = bench.hidden.parts if isinstance(bench.hidden, Composite) else (bench.hidden,)
    inside = [part.label for part in parts if turns_inside(part)]
    if len(inside) > 1:
        raise ConfigError(
            f"Classes are predicted of at most one effect that turns inside; here are {', '.join(inside)}. "
            "Hide one of them, or give classes=ranked."
        )
    return parts


def _free(log: _Log, bench: Rig, seed: int) -> Iterator[Array]:
    """What a unit of each free parameter, a share of its value, changes in what the base lacks."""
    true = bench.nominal.true_values(seed)
    for name, value in true.items():
        other = bench.nominal.machine({**true, name: value * (1 + _SHARE)})
        yield (lacking(log.course, rigid(other), log.command) - log.base) / _SHARE


def _truth(course: Course, parts: Sequence[HiddenEffect], part: HiddenEffect) -> Signature:
    """What the model lacks and reads otherwise that knows all hidden parts but one.

    Beside one of which something turns inside, the others are taken by what they give along the same course without it.
    """
    rest = Several({str(number): other for number, other in enumerate(parts) if other is not part})
    if turns_inside(part):
        force = lacking_with(course, rest)
    else:
        whole = Several({str(number): other for number, other in enumerate(parts)})
        force = lacking_with(course, without_inside(rest)) - lacking_with(course, without_inside(whole))
    read, seen = (*course.read_with(rest), *course.speed_with(rest)), (*course.measured, *course.measured_speed)
    pairs = zip(read, seen, strict=True)
    return Signature(force, np.stack([one.at(course.middle) - two.at(course.middle) for one, two in pairs], axis=1))


def _noise(bench: Rig) -> Array:
    """Standard deviations of the encoders' noise, as white, then of the tachometers', where there are any."""
    tools = bench.instruments
    each = [tools.white_equal(), *([tools.velocity.std] if isinstance(tools.velocity, Tachometers) else [])]
    return np.concatenate([np.full(len(bench.joints), std) / bench.turns for std in each])
