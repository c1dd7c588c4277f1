"""Smooth functions of a machine's state and commands, known only near states that were seen."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import mujoco
import numpy as np
from scipy.linalg import cholesky, solve_triangular

from dr_lab.errors import ModelError
from dr_lab.trajectory import Array

_JITTER = 1e-8  # of the kernel's diagonal, without which centres side by side leave it singular


@dataclass(frozen=True)
class Input:
    """One quantity that a function depends on.

    Attributes:
        quantity: ``angle`` or ``place`` of a joint, its ``velocity``, or the ``command`` of an actuator.
        name: of the joint or actuator.
        scale: width of the bell curves along it, in the quantity's unit.
    """

    quantity: str
    name: str
    scale: float


class Seen(NamedTuple):
    """Positions, velocities and controls of n states, shapes (n, nq), (n, nv) and (n, nu)."""

    qpos: Array
    qvel: Array
    control: Array


def features(inputs: Sequence[Input], model: mujoco.MjModel, seen: Seen) -> Array:
    """States as points whose distance is Euclid's, shape (n, d).

    An angle becomes the point (cos, sin) of a circle, so that a turn leads back; distances are chords there.

    Raises:
        ModelError: the model has no such joint or actuator.
    """
    columns: list[Array] = []
    for each in inputs:
        value = _value(each, model, seen) / each.scale
        if each.quantity == "angle":
            turned = value * each.scale
            columns += [np.cos(turned) / each.scale, np.sin(turned) / each.scale]
        else:
            columns.append(value)
    return np.stack(columns, axis=1)


def _value(each: Input, model: mujoco.MjModel, seen: Seen) -> Array:
    try:
        if each.quantity == "command":
            return seen.control[:, int(model.actuator_ctrladr[model.actuator(each.name).id])]
        joint = model.joint(each.name)
    except KeyError:
        raise ModelError(
            f"A learned force depends on the {each.quantity} of {each.name!r}, which the model has not. Take the model "
            "that it was learned with."
        ) from None
    if each.quantity == "velocity":
        return seen.qvel[:, int(joint.dofadr[0])]
    return seen.qpos[:, int(joint.qposadr[0])]


@dataclass(frozen=True)
class RadialBasis:
    """Bell curves about m centres, which fade to zero away from what was seen.

    φ_j(x) = g(x) Σ_k exp(−|x − c_k|² / 2) (L⁻¹)_jk with K = L Lᵀ the kernel among the centres, so that a function
    Σ_j w_j φ_j whose w_j are independent and of variance σ² is a Gaussian process of the variance σ² that the centres
    induce. g is 1 within `near` of a centre, 0 beyond `far`, and 1 − 3s² + 2s³ between, s being the way from one to the
    other. So a function of it is exactly 0 where nothing was seen. An odd one has k(x, c) − k(x̄, c) in the place of the
    kernel k, x̄ being x with all quantities negated: a machine that is the same either way shows one way what it does
    the other way, too.

    Source: Quiñonero-Candela and Rasmussen, Journal of Machine Learning Research 6 (2005) 1939 (inducing inputs).

    Attributes:
        inputs: what x is made of; see `features`.
        centres: shape (m, d).
        near: distance from a centre within which states were seen.
        far: distance beyond which the function is 0.
        odd: whether F(−x) = −F(x).
    """

    inputs: tuple[Input, ...]
    centres: Array
    near: float
    far: float
    odd: bool = False

    def bells(self, points: Array) -> Array:
        """g(x) k(x, c_k) of points (n, d), shape (n, m)."""
        squared = self._squared(points)
        if not self.odd:
            return self._gate(squared)[:, None] * np.exp(squared / -2.0)
        mirrored = self._squared(points * self._mirror)
        gate = self._gate(np.minimum(squared, mirrored))
        return gate[:, None] * (np.exp(squared / -2.0) - np.exp(mirrored / -2.0))

    def known(self, points: Array) -> Array:
        """g(x) of points (n, d), shape (n,): 1 where states were seen, 0 where none was near."""
        squared = self._squared(points)
        return self._gate(np.minimum(squared, self._squared(points * self._mirror)) if self.odd else squared)

    def functions(self, points: Array) -> Array:
        """φ_j of points (n, d), shape (n, m)."""
        return self.bells(points) @ self._unmixing

    def coefficients(self, weights: Array) -> Array:
        """Coefficients c_k of the bell curves (m,) whose sum has the weights w_j (m,) in the functions φ_j."""
        return self._unmixing @ weights

    @cached_property
    def _unmixing(self) -> Array:
        kernel = np.exp(self._squared(self.centres) / -2.0)
        if self.odd:
            kernel -= np.exp(self._squared(self.centres * self._mirror) / -2.0)
        root = cholesky(kernel + _JITTER * np.eye(len(kernel)), lower=True)
        return solve_triangular(root, np.eye(len(root)), lower=True).T

    @cached_property
    def _mirror(self) -> Array:
        """Signs that turn a point into that of the negated quantities: an angle's cosine stays."""
        return np.concatenate([[1.0, -1.0] if each.quantity == "angle" else [-1.0] for each in self.inputs])

    def _squared(self, points: Array) -> Array:
        own = (points**2).sum(1)[:, None] + (self.centres**2).sum(1)
        return np.maximum(own - 2.0 * points @ self.centres.T, 0.0)

    def _gate(self, squared: Array) -> Array:
        away = np.clip((np.sqrt(squared.min(1)) - self.near) / (self.far - self.near), 0.0, 1.0)
        return 1.0 - away**2 * (3.0 - 2.0 * away)


def around(inputs: tuple[Input, ...], points: Array, most: int, fade: float) -> RadialBasis:
    """A basis about points that were seen.

    Centres are the points that lie farthest from those before them (Gonzalez, Theoretical Computer Science 38 (1985)
    293), so that they cover what was seen evenly, until all points are within half a width of one.

    Args:
        inputs: what the points are made of.
        points: shape (n, d), n ≥ 1.
        most: number of centres.
        fade: over which the function falls to 0 beyond what was seen, in widths of the bell curves.
    """
    middle = points.mean(0)
    chosen = [int(((points - middle) ** 2).sum(1).argmin())]
    away = np.sqrt(((points - points[chosen[0]]) ** 2).sum(1))
    while len(chosen) < most and away.max() > 0.5:
        chosen.append(int(away.argmax()))
        away = np.minimum(away, np.sqrt(((points - points[chosen[-1]]) ** 2).sum(1)))
    near = float(away.max())
    return RadialBasis(inputs, points[chosen], near, near + fade)
