"""Normal equations of a fit whose windows' initial states are eliminated by a Schur complement."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import lsq_linear

from dr_lab.diagnosis.fit.solved import ROUNDING, solved
from dr_lab.trajectory import Array

Mask = NDArray[np.bool_]
Room = tuple[Array, Array]  # the lowest and the highest move of each parameter, shapes (p,)
_APART = 1e-12  # of scaled moves, so that an entry without room still has two ends


class Reduced(NamedTuple):
    """What is left of normal equations once the states are eliminated, without the parameters' prior.

    Attributes:
        information: Σ_w (JθᵀWJθ − (JθᵀWJx)(JxᵀWJx + P)⁻¹(JxᵀWJθ)), shape (p, p).
        gradient: its counterpart of every window, shape (w, p).
        gain: by how much a parameter moves the states that fit best, (JxᵀWJx + P)⁻¹ JxᵀWJθ, shape (w, s, p).
        states: minus the step of the states alone, shape (w, s).
    """

    information: Array
    gradient: Array
    gain: Array
    states: Array


class Decrease(NamedTuple):
    """By how much a step lowers the cost.

    Attributes:
        total: of all windows and priors; 0 at least for what the parameters add to the states.
        windows: of each window, without the parameters' prior, shape (w,).
    """

    total: float
    windows: Array


@dataclass(frozen=True)
class NormalEquations:
    """Gauss–Newton model of the cost ½‖W(r + J_x δ + J_θ θ)‖² + priors, window by window.

    Unknowns are one initial state a window (s entries) and the parameters common to all windows (p entries).

    Attributes:
        state: JxᵀWJx + P per window, shape (w, s, s).
        mixed: JxᵀWJθ per window, shape (w, s, p).
        state_gradient: JxᵀWr + P δ per window, shape (w, s).
        parameter: JθᵀWJθ per window, shape (w, p, p).
        parameter_gradient: JθᵀWr per window, shape (w, p).
        prior: precision of the parameters' weak prior, shape (p,).
        prior_gradient: gradient of that prior, shape (p,).
    """

    state: Array
    mixed: Array
    state_gradient: Array
    parameter: Array
    parameter_gradient: Array
    prior: Array
    prior_gradient: Array

    @classmethod
    def build(
        cls,
        *,
        residual: Array,
        state_jacobian: Array,
        parameter_jacobian: Array,
        weight: Array,
        delta: Array,
        state_precision: Array,
        prior: Array,
        prior_gradient: Array,
    ) -> "NormalEquations":
        """Assemble from weighted residuals.

        Args:
            residual: shape (w, m).
            state_jacobian: ∂r/∂δ, shape (w, m, s).
            parameter_jacobian: ∂r/∂θ, shape (w, m, p).
            weight: weight of each residual, shape (w, m).
            delta: current state corrections, shape (w, s).
            state_precision: prior precision of a state, shape (s,).
            prior: precision of the parameters' prior, shape (p,).
            prior_gradient: gradient of that prior, shape (p,).
        """
        weighted_state = (state_jacobian * weight[..., None]).transpose(0, 2, 1)
        weighted_parameter = (parameter_jacobian * weight[..., None]).transpose(0, 2, 1)
        return cls(
            state=weighted_state @ state_jacobian + np.diag(state_precision),
            mixed=weighted_state @ parameter_jacobian,
            state_gradient=(weighted_state @ residual[..., None])[..., 0] + state_precision * delta,
            parameter=weighted_parameter @ parameter_jacobian,
            parameter_gradient=(weighted_parameter @ residual[..., None])[..., 0],
            prior=prior,
            prior_gradient=prior_gradient,
        )

    def pick(self, rows: NDArray[np.intp]) -> "NormalEquations":
        """The equations of some windows."""
        names = ("state", "mixed", "state_gradient", "parameter", "parameter_gradient")
        return replace(self, **{name: getattr(self, name)[rows] for name in names})

    def step(self, damping: float, free: Mask, room: Room | None = None) -> tuple[Array, Array]:
        """Damped step of the free parameters and of all states.

        Args:
            damping: Levenberg–Marquardt λ, relative to the diagonal.
            free: parameters that may move, shape (p,).
            room: how far each may move; None for any distance.

        Returns:
            Parameter step, shape (p,), zero where not free, and state steps, shape (w, s).
        """
        information, gradient, gain, offset = self._reduce(damping)
        damped = information + damping * np.diag(np.diag(information))
        unbounded = np.asarray(-np.linalg.solve(damped[np.ix_(free, free)], gradient[free]), np.float64)
        move = within(unbounded, damped, gradient, free, room)
        return move, -(offset + gain @ move)

    def foretold(self, move: Array, states: Array) -> float:
        """By how much a step lowers the cost, as `full_step` counts it; parameter step (p,) and state steps (w, s)."""
        slope = (self.state_gradient * states).sum() + float(self.parameter_gradient.sum(0) @ move)
        bent = (states[:, None] @ (self.state @ states[..., None] + 2 * self.mixed @ move[:, None])).sum()
        bent += float(move @ self.parameter.sum(0) @ move)
        return -float(2 * slope + bent + move @ (2 * self.prior_gradient + self.prior * move))

    def made_up(self, moved: Mask, move: Array, room: Room) -> tuple[Array, Array]:
        """The step in which all other parameters, and all states, make up best for the moves of some.

        θ_f = −I_ff⁻¹ (g_f + I_fm θ_m) of the information I and the gradient g once the states are eliminated.

        Args:
            moved: parameters whose moves are given, shape (p,).
            move: their moves, shape (p,); of the others it says nothing.
            room: how far each may move.

        Returns:
            Parameter step, shape (p,), and state steps, shape (w, s).
        """
        information, gradient, gain, offset = self._reduce(0.0)
        given, free = np.where(moved, move, 0.0), ~moved
        slope = gradient + information @ given
        unbounded = np.asarray(-np.linalg.solve(information[np.ix_(free, free)], slope[free]), np.float64)
        found = given + within(unbounded, information, slope, free, room)
        return found, -(offset + gain @ found)

    def decrease(self, free: Mask, room: Room | None = None) -> float:
        """By how much a full step lowers the cost; see `full_step`."""
        return self.full_step(free, room).total

    def full_step(self, free: Mask, room: Room | None = None) -> Decrease:
        """By how much a full step of the free parameters and of all states lowers Σ wr² + priors, to second order.

        Args:
            free: parameters that may move, shape (p,).
            room: how far each may move; None for any distance.
        """
        reduced, slope = self.reduced, self.slope
        root = inverse_root(reduced.information[np.ix_(free, free)], self.prior[free])
        whole = reduced.information + np.diag(self.prior)
        move = within(-root @ (root.T @ slope[free]), whole, slope, free, room)
        curved = self.parameter @ move - (self.mixed.transpose(0, 2, 1) @ (reduced.gain @ move)[..., None])[..., 0]
        alone, moved = (self.state_gradient * reduced.states).sum(1), -(2 * reduced.gradient + curved) @ move
        gained = moved.sum() - float(move @ (2 * self.prior_gradient + self.prior * move))
        return Decrease(float(alone.sum()) + max(float(gained), 0.0), alone + moved)

    @property
    def slope(self) -> Array:
        """Gradient by the parameters once the states are eliminated, prior included, shape (p,)."""
        return self.reduced.gradient.sum(0) + self.prior_gradient

    @cached_property
    def reduced(self) -> Reduced:
        """The equations of the parameters alone, without their prior."""
        gain, states, gradient = self._eliminated(self.state)
        through = np.tensordot(self.mixed, gain, axes=((0, 1), (0, 1)))
        return Reduced(self.parameter.sum(0) - through, gradient, gain, states)

    def window_information(self) -> tuple[Array, Array]:
        """Each window's share of the information and of its gradient, without the prior, shapes (w, p, p), (w, p)."""
        return self._left(self.reduced.gain), self.reduced.gradient

    def _reduce(self, damping: float) -> tuple[Array, Array, Array, Array]:
        """Information and gradient, prior included, gain and states, where the states are damped."""
        diagonal = np.einsum("wii->wi", self.state)
        damped = self.state + damping * diagonal[:, :, None] * np.eye(self.state.shape[1])
        gain, states, gradient = self._eliminated(damped)
        information = self._left(gain).sum(0) + np.diag(self.prior)
        return information, gradient.sum(0) + self.prior_gradient, gain, states

    def _eliminated(self, state: Array) -> tuple[Array, Array, Array]:
        """Gain, states and gradient as of `Reduced`, with other equations of the states, shape (w, s, s)."""
        gain, states = solved(state, self.mixed), solved(state, self.state_gradient[..., None])[..., 0]
        return gain, states, self.parameter_gradient - (self.mixed.transpose(0, 2, 1) @ states[..., None])[..., 0]

    def _left(self, gain: Array) -> Array:
        """What each window says of the parameters once its states follow by a gain, shape (w, p, p)."""
        return self.parameter - self.mixed.transpose(0, 2, 1) @ gain


def inverse_root(information: Array, prior: Array) -> Array:
    """R with R Rᵀ = (I + diag(prior))⁻¹, shape (…, p, p).

    Very fine measurements make I so large beside the prior that parameters which can replace one another leave their
    sum singular to rounding; a direction of which I knows less than rounding is left to the prior.

    Args:
        information: I, without the prior, shape (…, p, p).
        prior: precisions above 0, shape (p,).
    """
    scale = prior**-0.5
    values, vectors = np.linalg.eigh(information * scale * scale[:, None])
    floor = ROUNDING * values.max(axis=-1, keepdims=True, initial=0.0)
    known = np.where(values > floor, values, 0.0)
    return scale[:, None] * vectors / np.sqrt(known + 1)[..., None, :]


def within(unbounded: Array, information: Array, gradient: Array, free: Mask, room: Room | None) -> Array:
    """The move that minimises ½ xᵀ I x + gᵀ x, whose entries stay within their room; zero where not free, shape (p,).

    Where the unbounded minimum lies outside, the bounds hold some entries back and the others make the best of it.

    Source: Stark and Parker, Computational Statistics 10 (1995) 129 (bounded-variable least squares).

    Args:
        unbounded: −I⁻¹ g of the free entries.
        information: I, shape (p, p).
        gradient: g, shape (p,).
        free: entries that may move, shape (p,).
        room: their lowest and highest values; None for any.
    """
    move = np.zeros(len(free))
    move[free] = unbounded
    if room is None or (np.clip(move, *room) == move).all():
        return move
    low, high = (ends[free] for ends in room)
    diagonal = np.diag(information)[free]
    scale = 1.0 / np.sqrt(np.maximum(diagonal, ROUNDING * diagonal.max()))  # rounding may leave less than nothing
    values, vectors = np.linalg.eigh(information[np.ix_(free, free)] * scale * scale[:, None])
    root = np.sqrt(np.maximum(values, ROUNDING * values[-1]))
    aim = -(vectors.T @ (gradient[free] * scale)) / root
    found = lsq_linear(root[:, None] * vectors.T, aim, (low / scale - _APART, high / scale + _APART), method="bvls")
    move[free] = np.clip(np.asarray(found.x, np.float64) * scale, low, high)
    return move
