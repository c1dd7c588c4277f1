"""What an experiment is for: to separate two models, or to sharpen what is poorly known of one."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import mujoco
import numpy as np

from dr_lab.diagnosis.next_experiment.machine import Contender, ExperimentMachine
from dr_lab.diagnosis.next_experiment.trial import watched
from dr_lab.diagnosis.next_experiment.worth import Shots, apart, missed, missed_at_most, told
from dr_lab.trajectory import Array


class Aim(Protocol):
    """What makes one experiment better than another; the more the better."""

    @property
    def contenders(self) -> Sequence[Contender]:
        """The models that play every experiment, each `watched`."""
        ...

    @property
    def quick(self) -> Sequence[Contender]:
        """The same with a cheaper integrator, for comparisons among themselves."""
        ...

    @property
    def simulations(self) -> int:
        """Simulations of one experiment that its rough worth takes."""
        ...

    def hint(self, shown: Sequence[Shots]) -> Array:
        """What n experiments promise, without a further simulation, shape (n,); what each contender shows is given."""
        ...

    def worth(self, shown: Sequence[Shots]) -> Array:
        """What n experiments are worth, roughly, shape (n,); what each quick contender shows is given."""
        ...

    def value(self, shown: Sequence[Shots]) -> float:
        """What one experiment is worth."""
        ...


@dataclass(frozen=True)
class Separating:
    """T-optimal: √Δχ² by which the wrong model, refitted to the experiment, would miss it, whichever is the wrong one.

    Source: Atkinson and Fedorov 1975, The design of experiments for discriminating between two rival models.

    Attributes:
        contenders: the two models.
        quick: the same with a cheaper integrator.
        machine: on which the experiment is played.
        seconds: s of each experiment that a rough refit looks at.
        iterations: first steps of a rough refit.
    """

    contenders: Sequence[Contender]
    quick: Sequence[Contender]
    machine: ExperimentMachine
    seconds: float
    iterations: int

    @property
    def simulations(self) -> int:
        """Those of the first steps of a refit in both roles."""
        return self.iterations * sum(_columns(each) for each in self.quick)

    def hint(self, shown: Sequence[Shots]) -> Array:
        """How far the two differ, before any refit."""
        return apart(*shown, machine=self.machine)

    def worth(self, shown: Sequence[Shots]) -> Array:
        """The least that either model misses of what the other one shows after the first steps of a refit."""
        every = range(len(shown[0].commands))
        return np.array([self._roughly([each.pick([k]) for each in shown]) for k in every])

    def _roughly(self, shown: Sequence[Shots]) -> float:
        one, other = self.quick
        first = missed_at_most(shown[0], other, self.machine, self.seconds, self.iterations)
        if not np.isfinite(first):
            return first
        return min(first, missed_at_most(shown[1], one, self.machine, self.seconds, self.iterations))

    def value(self, shown: Sequence[Shots]) -> float:
        """The same after refits."""
        one, other = self.contenders
        first = missed(shown[0], other, self.machine)
        return min(first, missed(shown[1], one, self.machine)) if np.isfinite(first) else first


@dataclass(frozen=True)
class Sharpening:
    """D-optimal for some parameters: −½ log det of their covariance, beside all others, after the experiment.

    Attributes:
        contenders: the one model.
        quick: the same with a cheaper integrator.
        machine: on which the experiment is played.
        seconds: s of each experiment that a linear step looks at.
        poor: places of the parameters that are poorly known.
    """

    contenders: Sequence[Contender]
    quick: Sequence[Contender]
    machine: ExperimentMachine
    seconds: float
    poor: Sequence[int]

    @property
    def simulations(self) -> int:
        """Those of a linear step."""
        return _columns(self.quick[0])

    def hint(self, shown: Sequence[Shots]) -> Array:
        """How much the channels move."""
        (shots,) = shown
        return apart(
            shots, replace(shots, outputs={n: np.zeros_like(v) for n, v in shots.outputs.items()}), self.machine
        )

    def worth(self, shown: Sequence[Shots]) -> Array:
        """What is known of the parameters after each experiment, in nats."""
        return np.array([-0.5 * np.linalg.slogdet(each)[1] for each in self._after(self.quick[0], shown, self.seconds)])

    def value(self, shown: Sequence[Shots]) -> float:
        """The same of the whole experiment."""
        (covariance,) = self._after(self.contenders[0], shown, np.inf)
        return float(-0.5 * np.linalg.slogdet(covariance)[1])

    def after(self, shown: Sequence[Shots]) -> Array:
        """Standard deviations of the poorly known parameters after one experiment, in their units."""
        (covariance,) = self._after(self.contenders[0], shown, np.inf)
        return np.sqrt(np.diag(covariance)) * self.contenders[0].model.space.span[list(self.poor)]

    def _after(self, contender: Contender, shown: Sequence[Shots], seconds: float) -> Array:
        """Covariance of the poorly known parameters after each experiment, in the unit cube."""
        (shots,) = shown
        span = contender.model.space.span
        now = contender.covariance / np.outer(span, span)
        further = told(shots, contender, self.machine, seconds)
        # (C⁻¹ + I)⁻¹ without an inverse of C, which is singular where a parameter is at its bound
        after = now @ np.linalg.inv(np.eye(len(now)) + further @ now)
        return after[:, list(self.poor)][:, :, list(self.poor)]


def separating(
    one: Contender, other: Contender, machine: ExperimentMachine, seconds: float, iterations: int
) -> Separating:
    """The aim to tell two models apart."""
    pair = [_watched(one), _watched(other)]
    return Separating(pair, [_quick(each) for each in pair], machine, seconds, iterations)


def sharpening(contender: Contender, poor: Sequence[int], machine: ExperimentMachine, seconds: float) -> Sharpening:
    """The aim to know some parameters better."""
    model = _watched(contender)
    return Sharpening([model], [_quick(model)], machine, seconds, poor)


def poorly_known(contender: Contender, share: float, least: float) -> list[int]:
    """Places of the parameters whose standard deviation is a large share of their size.

    A parameter's size is that of its value, or a share of the width of its bounds, `least`, where that is more.
    """
    size = np.maximum(np.abs(contender.z), least * contender.model.space.span)
    std = np.sqrt(np.maximum(np.diag(contender.covariance), 0.0))
    return [int(k) for k in np.flatnonzero(std > share * size)]


def _columns(contender: Contender) -> int:
    return 1 + 2 * contender.model.nominal().nv + len(contender.z)


def _watched(contender: Contender) -> Contender:
    return replace(contender, model=watched(contender.model))


def _quick(contender: Contender) -> Contender:
    """A contender whose steps are evaluated once in place of four times; its error is in all that is compared."""
    spec = contender.model.spec.copy()
    if spec.option.integrator == int(mujoco.mjtIntegrator.mjINT_RK4):
        spec.option.integrator = int(mujoco.mjtIntegrator.mjINT_IMPLICITFAST)
    return replace(contender, model=replace(contender.model, spec=spec))
