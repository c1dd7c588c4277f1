"""One linear step of a force that is learned: what windows say of its weights, their states and parameters moving."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import NamedTuple

import mujoco
import numpy as np
from numpy.typing import NDArray

from dr_lab.diagnosis.evidence.bench import Bench
from dr_lab.diagnosis.fit.fit import Fit, movable
from dr_lab.diagnosis.fit.levenberg_marquardt import Fitter
from dr_lab.diagnosis.fit.normal_equations import NormalEquations
from dr_lab.diagnosis.fit.prior import prior_precision
from dr_lab.diagnosis.fit.replay import Replay
from dr_lab.diagnosis.missing_force.pulses import pulse_responses
from dr_lab.diagnosis.windows.blocks import Indices
from dr_lab.effects.effect import Scales, place
from dr_lab.effects.joint_effect import slides
from dr_lab.effects.learned_force import LearnedForce
from dr_lab.effects.residual_force import ResidualForce
from dr_lab.physics.model import Model
from dr_lab.physics.parameter import Parameter
from dr_lab.physics.radial_basis import RadialBasis, Seen, features
from dr_lab.trajectory import Array

_SHARES = (1.0, 0.5, 0.25, 0.125)  # of a linear step


@dataclass(frozen=True)
class Machine:
    """The joint of a machine at which a force is learned, and the windows that it is learned from.

    Attributes:
        bench: windows and settings of the fits.
        compiled: the compiled nominal model without effects.
        scales: typical magnitudes of the machine.
        joint: name of a hinge or slide joint.
        most: largest factor on a learned force.
    """

    bench: Bench
    compiled: mujoco.MjModel
    scales: Scales
    joint: str
    most: float

    @property
    def unit(self) -> str:
        """Unit of the force."""
        return "N" if slides(self.compiled, self.joint) else "N·m"

    @property
    def torque(self) -> float:
        """Typical force at the joint, N·m or N."""
        return max(self.scales.torque.get(self.joint, 0.0), float(np.finfo(float).tiny))


@dataclass(frozen=True)
class Learned:
    """A fitted model with the force as far as it is learned.

    Attributes:
        model: the model; with the force as its last effect, once there is one.
        fit: its parameters, the factor on the force among them.
        weights: of the functions of the force's basis, N·m or N, the factor included, shape (m,).
        parameters: names of the parameters beside the factor.
    """

    model: Model
    fit: Fit
    weights: Array
    parameters: tuple[str, ...]


class Choice(NamedTuple):
    """A force's basis.

    Attributes:
        basis: the functions.
        size: standard deviation of the force, in the joint's typical torque.
        share: share of the cost that a step removes of parts of the logs that it did not see.
    """

    basis: RadialBasis
    size: float
    share: float


@dataclass(frozen=True)
class Linear:
    """What windows say of parameters and weights together, in unit-cube parameters and in units of `Machine.torque`.

    Attributes:
        information: J'WJ of each window, its state eliminated, shape (w, p + m, p + m).
        gradient: J'Wr, shape (w, p + m).
        prior: precision of the p parameters, shape (p,).
        prior_gradient: shape (p,).
        free: parameters that their bounds do not hold back, shape (p,).
        weights: that the force has, in units of the torque, shape (m,).
    """

    information: Array
    gradient: Array
    prior: Array
    prior_gradient: Array
    free: NDArray[np.bool_]
    weights: Array

    def steps(self, size: float | None, without: list[Indices]) -> Array:
        """Step that lowers the cost most, for each set of windows that is left out, shape (parts, p + m).

        Args:
            size: standard deviation of the force; None lets the weights stay.
            without: windows of each part.
        """
        count, m = len(self.prior), len(self.weights)
        moves = np.concatenate([self.free, np.full(m, size is not None)])
        precision = 0.0 if size is None else size**-2.0
        prior = np.concatenate([self.prior, np.full(m, precision)])
        pull = np.concatenate([self.prior_gradient, precision * self.weights])
        whole, gradient = self.information.sum(0), self.gradient.sum(0)
        found = np.zeros((len(without), count + m))
        for move, rows in zip(found, without, strict=True):
            rest = whole - self.information[rows].sum(0) + np.diag(prior)
            slope = gradient - self.gradient[rows].sum(0) + pull
            move[moves] = -np.linalg.solve(rest[np.ix_(moves, moves)], slope[moves])
        return found

    def removed(self, size: float | None, parts: list[Indices]) -> float:
        """By how much the cost of the parts falls, each by the step that all others ask for, to second order."""
        total = 0.0
        for step, rows in zip(self.steps(size, parts), parts, strict=True):
            gradient, information = self.gradient[rows].sum(0), self.information[rows].sum(0)
            total -= float(2.0 * gradient @ step + step @ information @ step)
        return total


class Course:
    """The windows under a model as far as its force is learned, and how they answer to a force: any basis is quick.

    Args:
        machine: joint and windows.
        at: the model.
        parts: in how many parts of a window the answer to a force is told.
    """

    def __init__(self, machine: Machine, at: Learned, parts: int) -> None:
        self._machine, self._at, bench, fit = machine, at, machine.bench, at.fit
        self._replay = Replay(at.model, bench.fit, bench.threads)
        tape, _ = self._replay.simulate(fit.z[None], fit.delta[None])
        steps = tape.controls.shape[2]
        self._shape = (len(bench.fit), steps)
        half = [0.5 * (part[0][:, :-1] + part[0][:, 1:]) for part in (tape.qpos, tape.qvel)]
        flat = (part.reshape(len(bench.fit) * steps, -1) for part in (*half, tape.controls[0]))
        self.seen = Seen(*flat)
        self._part = np.arange(steps) * min(parts, steps) // steps
        pulse = Parameter("pulse", machine.unit, 0.0, -0.5 * machine.torque, 0.5 * machine.torque)
        self._answers = pulse_responses(bench, at.model, fit, pulse, machine.joint, self._part)

    def linear(self, basis: RadialBasis, weights: Array) -> Linear:
        """What the fitted windows say of a force of a basis that has these weights already, N·m or N."""
        at, solver, fit = self._at, self._machine.bench.solver, self._at.fit
        own = np.array([at.model.space.index(name) for name in at.parameters], np.intp)
        space = at.model.space
        unit, nominal = space.to_unit(fit.z)[own], space.to_unit(space.nominal)[own]
        prior = prior_precision(space, solver)[own]
        slopes = self._answers @ self._means(basis)
        equations = NormalEquations.build(
            residual=fit.residuals,
            state_jacobian=fit.slopes.state,
            parameter_jacobian=np.concatenate([fit.slopes.parameter[..., own], slopes], axis=2),
            weight=self._replay.weights(fit.residuals, fit.infeasible, solver.huber),
            delta=fit.delta,
            state_precision=self._replay.windows.prior.std**-2.0,
            prior=np.ones(len(own) + len(weights)),
            prior_gradient=np.zeros(len(own) + len(weights)),
        )
        information, gradient = equations.window_information()
        pull = prior * (unit - nominal)
        free = movable(unit, gradient.sum(0)[: len(own)] + pull)
        return Linear(information, gradient, prior, pull, free, weights / self._machine.torque)

    def _means(self, basis: RadialBasis) -> Array:
        """Mean of each function of the basis in each part of each window, shape (w, k, m)."""
        points = features(basis.inputs, self._machine.compiled, self.seen)
        values = basis.functions(points).reshape(*self._shape, -1)
        edges = np.flatnonzero(np.diff(self._part, prepend=-1))
        counts = np.diff(np.append(edges, self._shape[1]))
        return np.add.reduceat(values, edges, axis=1) / counts[:, None]


def stepped(machine: Machine, at: Learned, course: Course, choice: Choice, most: int) -> Learned:
    """The model after one linear step of weights and parameters, refitted in so many steps at most.

    A step is linear in the force, but not in how the force changes with the motion that it causes. So the refit begins
    at that part of the step with which the windows fit best.
    """
    step = course.linear(choice.basis, at.weights).steps(choice.size, [np.zeros(0, np.intp)])[0]
    found = [_Begun(machine, at, choice.basis, share * step) for share in _SHARES]
    best = min(found, key=lambda each: (each.point.infeasible.sum(), each.point.cost))
    return best.fitted(most)


class _Begun:
    """A fit of the model behind a step, before it begins.

    Args:
        machine: joint and windows.
        at: the model before the step.
        basis: of the force.
        step: of parameters and weights, as `Linear.steps` gives it.
    """

    def __init__(self, machine: Machine, at: Learned, basis: RadialBasis, step: Array) -> None:
        space, count = at.model.space, len(at.parameters)
        self._machine, self._at, self._basis = machine, at, basis
        self._weights = at.weights + machine.torque * step[count:]
        unit = space.to_unit(at.fit.z)
        unit[[space.index(name) for name in at.parameters]] += step[:count]
        self._values = space.mapping(space.from_unit(np.clip(unit, 0.0, 1.0)))
        self._fitter, z = self._model(self._weights, self._values)
        self.point = self._fitter.begin(z, at.fit.delta)

    def fitted(self, most: int) -> Learned:
        """The fit after so many steps at most; the factor that it finds becomes part of the force, which is then 1."""
        fit = self._fitter.run(self.point.z, self.point.delta, iterations=most)
        weights = float(fit.z[-1]) * self._weights
        fitter, z = self._model(weights, self._fitter.space.mapping(fit.z))
        fit = fitter.run(z, fit.delta, iterations=0)
        return Learned(fitter.replay.model, fit, weights, self._at.parameters)

    def _model(self, weights: Array, values: Mapping[str, float]) -> tuple[Fitter, Array]:
        """A fit of the model with a force of these weights, and its context there, the factor being 1."""
        machine, bench = self._machine, self._machine.bench
        force = LearnedForce(self._basis, self._basis.coefficients(weights), machine.unit)
        effect = ResidualForce(machine.most, {machine.joint: force})
        placed = place(effect, machine.compiled, machine.joint, machine.scales)
        known = [each for each in self._at.model.effects if each.label != placed.label]
        model = replace(self._at.model, effects=(*known, placed))
        z = model.space.vector({**values, placed.parameters[0].name: 1.0})
        return Fitter(Replay(model, bench.fit, bench.threads), bench.solver), z
