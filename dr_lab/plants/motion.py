"""How the machine moves under a command: SciPy's DOP853, from command edge to command edge."""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.integrate import DOP853
from scipy.optimize import root_scalar

from dr_lab.errors import DataError
from dr_lab.plants.command import Command
from dr_lab.plants.furuta import Furuta
from dr_lab.plants.hidden.effect import HiddenEffect
from dr_lab.plants.phases import Body, Phase, State, phase_at
from dr_lab.trajectory import Array

# Points of a step at which the end of a phase is looked for, so that a slide that ends and starts anew within one step
# is seen.
_LOOKS = 8
_ROOT = 1e-14  # s, how closely the end of a phase is found
_REST: State = (0.0, 0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Accuracy:
    """How closely the motion is followed.

    Attributes:
        relative: share of a state allowed as error of one step.
        absolute: rad and rad/s allowed as error of one step.
        longest_step: s; within a step the states come from an interpolant, whose error only a short step keeps down.
    """

    relative: float
    absolute: float
    longest_step: float


def simulate(
    machine: Furuta,
    effect: HiddenEffect,
    command: Command,
    time: Array,
    *,
    accuracy: Accuracy,
    start: State = _REST,
) -> Array:
    """True motion of the machine with its hidden effect.

    Each stretch of constant voltage is integrated by itself, so that no step crosses a jump of the command; a change
    between sticking and sliding is found on the step's dense output and the integration starts anew there.

    Args:
        machine: the machine without the effect.
        effect: what is hidden in it.
        command: voltage applied to the driver, before the effect acts on it.
        time: when to report the state, s, not decreasing; before 0 the machine is in its start state.
        accuracy: how closely to follow it.
        start: (θ, α, θ', α') at time 0 in rad and rad/s.

    Returns:
        (θ, α, θ', α') at each time, shape (n, 4).

    Raises:
        DataError: `time` is empty or decreases, or the integration fails.
    """
    if len(time) == 0 or (np.diff(time) < 0).any():
        raise DataError(f"Plant: give times that do not decrease at which to report the motion; got {len(time)}.")
    held = effect.command(command)
    end = float(time[-1])
    inside = held.edge[(held.edge > 0) & (held.edge < end)]
    bounds = np.concatenate([[0.0], inside, [end]])
    run = _Run(Body(effect.alter(machine), effect), accuracy, time, start)
    for begin, stop, voltage in zip(bounds[:-1], bounds[1:], held.at(bounds[:-1]), strict=True):
        run.advance(float(begin), float(stop), float(voltage))
    return run.states


class _Run:
    """One simulation under way: where the machine is and which of the asked states are known."""

    def __init__(self, body: Body, accuracy: Accuracy, time: Array, start: State) -> None:
        self.states = np.tile(np.asarray(start, dtype=np.float64), (len(time), 1))
        self._body = body
        self._friction = body.effect.friction()
        self._accuracy = accuracy
        self._time = time
        self._state = start
        self._known = int(np.searchsorted(time, 0.0, side="right"))

    def advance(self, begin: float, stop: float, voltage: float) -> None:
        """Move from begin to stop at one voltage, through as many phases as it takes."""
        phase, self._state = phase_at(self._body, self._friction, self._state, voltage)
        while begin < stop:
            begin, ended = self._follow(self._solver(phase, begin, stop, voltage), phase, voltage)
            if ended:
                phase, self._state = phase.after(self._state, voltage)

    def _solver(self, phase: Phase, begin: float, stop: float, voltage: float) -> DOP853:
        def slope(_: float, y: Array) -> Sequence[float]:
            now: State = tuple(y.tolist())
            return (now[2], now[3], *phase.acceleration(now, voltage))

        wanted = self._accuracy
        return DOP853(
            slope,
            begin,
            self._state,
            stop,
            max_step=wanted.longest_step,
            rtol=wanted.relative,
            atol=wanted.absolute,
            first_step=min(stop - begin, wanted.longest_step),
        )

    def _follow(self, solver: DOP853, phase: Phase, voltage: float) -> tuple[float, bool]:
        """Step until the stretch or the phase ends; returns that time and whether the phase ended."""
        while solver.status == "running":
            message = solver.step()
            if message is not None:
                raise DataError(f"Plant: the integration failed at {solver.t} s: {message}")
            end = _end_of_phase(solver, phase, voltage) if phase.can_end else None
            self._report(solver, float(solver.t) if end is None else end)
            if end is not None:
                self._state = tuple(solver.dense_output()(end).tolist())
                return end, True
        self._state = tuple(solver.y.tolist())
        return float(solver.t), False

    def _report(self, solver: DOP853, reached: float) -> None:
        upto = int(np.searchsorted(self._time, reached, side="right"))
        if upto > self._known:
            self.states[self._known : upto] = solver.dense_output()(self._time[self._known : upto]).T
            self._known = upto


def _end_of_phase(solver: DOP853, phase: Phase, voltage: float) -> float | None:
    """The time within the last step at which the phase's margin falls through zero, if it does."""
    dense = solver.dense_output()

    def margin(time: float) -> float:
        return phase.margin(tuple(dense(time).tolist()), voltage)

    looks = np.linspace(float(solver.t_old or 0.0), float(solver.t), _LOOKS + 1).tolist()
    for before, after in itertools.pairwise(looks):
        if margin(after) < 0:
            # A margin that rounding already made negative at the start of the step has no root to find.
            return after if margin(before) <= 0 else root_scalar(margin, bracket=(before, after), xtol=_ROOT).root
    return None
