"""How far a force that is missing, or a reading that is wrong, shows in logs cut into windows with free starts."""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from dr_lab.plants.alike.course import Course, rigid
from dr_lab.plants.alike.inner_products import InnerProducts
from dr_lab.plants.alike.lacking import acting, bristled
from dr_lab.trajectory import Array

_TINY = 1e-5  # rad, rad/s: step of the derivatives, whose error is its square


@dataclass(frozen=True)
class Signature:
    """What a model lacks or reads otherwise along a course; both change its residuals.

    Attributes:
        force: that the model lacks to move as the machine does, N·m or N, shape (K, n).
        reading: of the model's encoders beyond its positions, rad or m, then of its tachometers beyond its velocities,
            rad/s or m/s, shape (K, 2n).
    """

    force: Array
    reading: Array


@dataclass(frozen=True)
class Response:
    """The linearised motion about a course.

    With x = (δq, δq'), x' = A x + (0, M⁻¹ τ): over an interval of h, by the trapezoid rule, x → F x + B τ.

    Attributes:
        carried: F of each interval, shape (K, 2n, 2n).
        pushed: B, shape (K, 2n, n).
        information: of each interval and what is measured, samples in it over the noise's variance, shape (K, n), or
            (K, 2n) with velocities.
    """

    carried: Array
    pushed: Array
    information: Array

    def inner_products(
        self, common: Sequence[Signature], choices: Sequence[Sequence[Signature]], window: int
    ) -> InnerProducts:
        """Inner products, weighed by the noise, of what signatures make of the residuals; starts are regressed out.

        Args:
            common: signatures that stand beside any choice.
            choices: signatures that stand there one choice at a time.
            window: intervals in a window; a rest that is shorter than half of one is left out.

        Returns:
            In units of χ².
        """
        listed, sizes = [*common, *itertools.chain(*choices)], [len(each) for each in choices]
        count, joints = common[0].force.shape
        total: InnerProducts | None = None
        for begin in range(0, count, window):
            stop = min(begin + window, count)
            if stop - begin < window / 2:
                break
            force, reading = (
                np.stack([getattr(s, part)[begin:stop] for s in listed], axis=2) for part in ("force", "reading")
            )
            seen = self._seen(force, reading, begin)
            starts, rest = seen[:, : 2 * joints], seen[:, 2 * joints :]
            basis, _ = np.linalg.qr(starts)
            found = InnerProducts.of(rest - basis @ (basis.T @ rest), len(common), sizes)
            total = found if total is None else total + found
        if total is None:
            return InnerProducts.of(np.zeros((0, len(listed))), len(common), sizes)
        return total

    def _seen(self, force: Array, reading: Array, begin: int) -> Array:
        """Weighed residuals of a window: of unit starts, then of the signatures; shape (samples, 2n + m)."""
        count, joints, many = force.shape
        own = 2 * joints
        measured = self.information.shape[1]
        state, rows = np.zeros((own, own + many)), np.zeros((count, measured, own + many))
        state[:, :own] = np.eye(own)
        for k in range(count):
            after = self.carried[begin + k] @ state
            # A model that lacks a force falls behind: measured − simulated is what that force would do.
            after[:, own:] += self.pushed[begin + k] @ force[k]
            rows[k] = 0.5 * (state[:measured] + after[:measured])
            state = after
        rows[:, :, own:] -= reading[:, :measured]
        rows *= np.sqrt(self.information[begin : begin + count])[:, :, None]
        return rows.reshape(count * measured, -1)


def response(course: Course, std: Array, rate: float) -> Response:
    """The linearised motion about a course, what is hidden included.

    Args:
        course: a log.
        std: standard deviation of the noise of each joint's encoder, as white, rad or m, then of its tachometer, where
            there are any, rad/s or m/s, shape (n,) or (2n,).
        rate: samples per second, Hz.
    """
    slopes, inverse = _slopes(course)
    count, joints = course.position.shape
    half, one = 0.5 * course.step[:, None, None], np.eye(2 * joints)
    drift, entry = np.zeros((count, 2 * joints, 2 * joints)), np.zeros((count, 2 * joints, joints))
    drift[:, :joints, joints:] = np.eye(joints)
    drift[:, joints:], entry[:, joints:] = slopes, inverse
    left = one - half * drift
    return Response(
        carried=np.asarray(np.linalg.solve(left, one + half * drift), dtype=np.float64),
        pushed=np.asarray(np.linalg.solve(left, 2 * half * entry), dtype=np.float64),
        information=course.step[:, None] * rate / std**2,
    )


def _slopes(course: Course) -> tuple[Array, Array]:
    """∂q''/∂(q, q'), shape (K, n, 2n), and ∂q''/∂τ = M⁻¹, shape (K, n, n).

    With r = M q'' − f, which is 0 along the motion, ∂q''/∂x = −M⁻¹ ∂r/∂x at the q'' that is there.
    """
    command = acting(course, course.true_body, course.effect)
    joints = course.position.shape[1]
    there, none = np.concatenate([course.position, course.velocity], axis=1), np.zeros_like(course.position)
    force = -_asked(course, command, there, none)
    mass = np.stack([_asked(course, command, there, none + unit) + force for unit in np.eye(joints)], axis=2)
    inverse = np.asarray(np.linalg.inv(mass), dtype=np.float64)
    gained = (inverse @ force[:, :, None])[:, :, 0]
    sides = (
        [_asked(course, command, there + side * nudge, gained) for side in (1.0, -1.0)]
        for nudge in _TINY * np.eye(2 * joints)
    )
    slopes = np.stack([(ahead - behind) / (2 * _TINY) for ahead, behind in sides], axis=2)
    return -inverse @ slopes, inverse


def _asked(course: Course, command: Array, states: Array, acceleration: Array) -> Array:
    """M q'' − f of the machine with what is hidden in it, in states near the course, shape (K, n).

    A motor or rotor inside counts as fixed to its joint: how it swings is left out of the linearised motion.
    """
    body, joints = course.true_body, acceleration.shape[1]
    position, velocity = states[:, :joints], states[:, joints:]
    rows = rigid(body.machine).lacking(position, velocity, acceleration, command)
    for joint, rotor in body.inside:
        rows[:, joint] += rotor.inertia * acceleration[:, joint]
    for joint, law in body.laws:
        each = zip(course.middle.tolist(), position[:, joint].tolist(), velocity[:, joint].tolist(), strict=True)
        rows[:, joint] -= [law(*x) for x in each]
    for joint, force in bristled(course, body, velocity):
        rows[:, joint] -= force
    return rows
