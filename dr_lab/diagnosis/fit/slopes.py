"""Finite differences of residuals: columns of the Jacobian, simulated as one batch."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag

from dr_lab.diagnosis.fit.point import Mask, Point
from dr_lab.diagnosis.fit.replay import Replay
from dr_lab.diagnosis.settings import SolverSettings
from dr_lab.physics.base_inertia import base_directions
from dr_lab.trajectory import Array


@dataclass(frozen=True)
class Slopes:
    """Jacobian of the residuals.

    Attributes:
        state: ∂r/∂δ by window, shape (w, m, s).
        parameter: ∂r/∂θ in unit-cube parameters, shape (w, m, p).
    """

    state: Array
    parameter: Array

    def pick(self, rows: NDArray[np.intp]) -> "Slopes":
        """The slopes of some windows."""
        return Slopes(self.state[rows], self.parameter[rows])

    def secant(self, change: Array, state_move: Array, move: Array) -> "Slopes":
        """The nearest slopes that foretell what a step changed, window by window.

        J + (Δr − J s)(D² s)ᵀ / sᵀD²s with D the norms of the columns, so that no unit counts.

        Source: Broyden, Mathematics of Computation 19 (1965) 577, method 1.

        Args:
            change: Δr, shape (w, m).
            state_move: step of the states, shape (w, s).
            move: step of the parameters in the unit cube, shape (p,).
        """
        slope = np.concatenate([self.state, self.parameter], axis=2)
        step = np.concatenate([state_move, np.broadcast_to(move, (len(change), len(move)))], axis=1)
        missed = change - (slope @ step[..., None])[..., 0]
        along = (slope**2).sum(1) * step
        length = (along * step).sum(1)[:, None]
        share = np.divide(missed, length, out=np.zeros_like(missed), where=length > 0)
        found, states = slope + share[..., None] * along[:, None], self.state.shape[2]
        return Slopes(found[..., :states], found[..., states:])


def quick_differences(
    replay: Replay, settings: SolverSettings, point: Point, *, states: bool, columns: NDArray[np.intp]
) -> Array:
    """`differences` by steps that evaluate the model once (`Replay.quick`).

    Columns are off by a few per cent, and by up to a fifth where friction sticks. A descent bears that, for the model's
    own steps tell how good its end is. Where a window diverges by the cheaper steps alone, all columns are taken by the
    model's own.
    """
    quick = replay.quick
    if quick is not replay and (states or len(columns)):
        moved = _moved(replay, settings, point, states, columns)
        z, deltas = np.concatenate([point.z[None], moved.z]), np.concatenate([point.delta[None], moved.delta])
        found, lost = _in_parts(quick, settings, z, deltas)
        if not (lost[0] & ~point.infeasible).any():
            return moved.columns(found[1:], found[0], lost[1:])
    return differences(replay, settings, point, states=states, columns=columns)


def differences(
    replay: Replay, settings: SolverSettings, point: Point, *, states: bool, columns: NDArray[np.intp]
) -> Array:
    """Forward differences for the start states (if wanted) and the given parameters.

    A parameter in the upper half of its bounds steps down, so no column leaves them; of bodies that are free as a whole
    see `_ways`. Windows that diverge in a column get zeros there.

    Args:
        replay: windows and model.
        settings: sizes of the steps.
        point: where.
        states: whether to differentiate by the start states.
        columns: parameters to differentiate by.

    Returns:
        Columns, states first, shape (w, m, columns).
    """
    moved = _moved(replay, settings, point, states, columns)
    if not len(moved.steps):
        return np.zeros((*point.residuals.shape, 0))
    residuals, infeasible = _in_parts(replay, settings, moved.z, moved.delta)
    return moved.columns(residuals, point.residuals, infeasible)


def quick_around(
    replay: Replay, settings: SolverSettings, z: Array, delta: Array, columns: NDArray[np.intp], first: Point | None
) -> tuple[Array, Mask, Array]:
    """`around` with slopes by steps that evaluate the model once; see `quick_differences`."""
    quick = replay.quick
    if quick is not replay and len(columns):
        residuals, infeasible, _ = around(replay, settings, z, delta, columns[:0], first)
        _, lost, slopes = around(quick, settings, z, delta, columns, None)
        if not (lost & ~infeasible).any():
            return residuals, infeasible, slopes
    return around(replay, settings, z, delta, columns, first)


def around(
    replay: Replay, settings: SolverSettings, z: Array, delta: Array, columns: NDArray[np.intp], first: Point | None
) -> tuple[Array, Mask, Array]:
    """Residuals at several contexts with the same states, and forward differences there, all as one batch.

    Args:
        replay: windows and model.
        settings: sizes of the steps.
        z: contexts, shape (c, n).
        delta: states, shape (w, nstate).
        columns: parameters to differentiate by, p of them; see `differences`.
        first: with the residuals at the first context, if they are known.

    Returns:
        Residuals, shape (c, w, m), windows that diverge, shape (c, w), and columns, shape (c, w, m, p).
    """
    space, count = replay.model.space, len(columns)
    unit = space.to_unit(z)
    steps = np.where(unit[:, columns] > 0.5, -1.0, 1.0) * _steps(replay, settings).parameter
    units = np.repeat(unit[:, None], 1 + count, axis=1)
    units[:, 1 + np.arange(count), columns] += steps
    contexts = space.from_unit(units)
    contexts[:, 0] = z
    rows = contexts.reshape(-1, z.shape[1])[0 if first is None else 1 :]
    residuals, infeasible = _in_parts(replay, settings, rows, np.broadcast_to(delta, (len(rows), *delta.shape)))
    if first is not None:
        residuals = np.concatenate([first.residuals[None], residuals])
        infeasible = np.concatenate([first.infeasible[None], infeasible])
    residuals = residuals.reshape(len(z), 1 + count, *residuals.shape[1:])
    infeasible = infeasible.reshape(len(z), 1 + count, -1)
    slopes = (residuals[:, 1:] - residuals[:, :1]) / steps[:, :, None, None]
    slopes[infeasible[:, 1:]] = 0.0
    return residuals[:, 0], infeasible[:, 0], slopes.transpose(0, 2, 3, 1)


@dataclass(frozen=True)
class _Moved:
    """Simulations beside a point that tell its slopes.

    Attributes:
        z: contexts, shape (k, n).
        delta: states, shape (k, w, nstate).
        steps: sizes of the moves, shape (k,).
        told: moves of the unknowns that are asked for, orthonormal, shape (k, unknowns); None where each is of one.
    """

    z: Array
    delta: Array
    steps: Array
    told: Array | None

    def columns(self, moved: Array, here: Array, infeasible: Mask) -> Array:
        """Slopes (w, m, unknowns) from residuals after each move (k, w, m) and before (w, m)."""
        slopes = (moved - here) / self.steps[:, None, None]
        slopes[infeasible] = 0.0
        slopes = slopes.transpose(1, 2, 0)
        return slopes if self.told is None else slopes @ self.told


def _moved(replay: Replay, settings: SolverSettings, point: Point, states: bool, columns: NDArray[np.intp]) -> _Moved:
    """Contexts and states, each moved by one step from a point."""
    space = replay.model.space
    unit = space.to_unit(point.z)
    sizes = _steps(replay, settings)
    state_steps = sizes.state * replay.windows.prior.std if states else np.zeros(0)
    ways = _ways(replay, point, columns)
    moves = np.eye(len(columns)) if ways is None else ways
    unit_steps = np.where(moves @ unit[columns] > 0.5 * moves.sum(1), -1.0, 1.0) * sizes.parameter
    steps, first = np.concatenate([state_steps, unit_steps]), len(state_steps)
    units, deltas = np.tile(unit, (len(steps), 1)), np.tile(point.delta, (len(steps), 1, 1))
    for i, step in enumerate(state_steps):
        deltas[i, :, i] += step
    units[first:, columns] += unit_steps[:, None] * moves
    told = None if ways is None else np.asarray(block_diag(np.eye(first), ways), np.float64)
    return _Moved(space.from_unit(units), deltas, steps, told)


def _ways(replay: Replay, point: Point, columns: NDArray[np.intp]) -> Array | None:
    """Moves of the parameters that are asked for which tell all of their slopes, orthonormal, (k, columns).

    Bodies that are free as a whole move together, along what the motion depends on; they may leave their bounds by a
    step, outside of which are bodies, too. Any other parameter moves alone. None where all do: also where shapes touch,
    for MuJoCo softens a contact by more of the bodies' inertia than the motion feels.
    """
    space, bodies = replay.model.space, replay.model.inertials
    rows = np.array([space.index(p.name) for each in bodies for p in each.parameters], np.intp)
    if not len(rows) or not np.isin(rows, columns).all() or replay.touching:
        return None
    together = base_directions(replay.model, point.z)
    if together is None:
        return None
    alone = np.flatnonzero(~np.isin(columns, rows))
    ways = np.zeros((len(alone) + len(together), len(columns)))
    ways[np.arange(len(alone)), alone] = 1.0
    ways[len(alone) :, [int(np.flatnonzero(columns == row)[0]) for row in rows]] = together
    return ways


class _Steps(NamedTuple):
    """Sizes of the steps: of a state in prior standard deviations, of a parameter in widths of its bounds."""

    state: float
    parameter: float


def _steps(replay: Replay, settings: SolverSettings) -> _Steps:
    """How wide steps are; wider where shapes touch: narrow ones show the jags that contacts make in the cost."""
    states, parameters = 1.0, 1.0
    if replay.windows.prior.grounded:
        states = parameters = settings.rolling
    elif replay.touching:
        states, parameters = settings.touching_states, settings.touching
    return _Steps(settings.state_step * states, settings.parameter_step * parameters)


def _in_parts(replay: Replay, settings: SolverSettings, z: Array, delta: Array) -> tuple[Array, Mask]:
    """`Replay.residuals`, at most so many simulations at a time as the settings say."""
    if not len(z):
        return np.empty((0, *replay.fitted.shape)), np.empty((0, len(replay.fitted)), bool)
    most = max(1, settings.batch // delta.shape[1])
    parts = [replay.residuals(z[k : k + most], delta[k : k + most]) for k in range(0, len(z), most)]
    residuals, infeasible = (np.concatenate(rows) for rows in zip(*parts, strict=True))
    return residuals, infeasible
