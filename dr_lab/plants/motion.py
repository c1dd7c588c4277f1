"""How the machine moves under its commands: SciPy's DOP853, from command edge to command edge."""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.integrate import DOP853, DenseOutput
from scipy.optimize import root_scalar

from dr_lab.bounds import Positive
from dr_lab.errors import DataError
from dr_lab.plants.body import Body
from dr_lab.plants.command import Command
from dr_lab.plants.hidden.effect import HiddenEffect
from dr_lab.plants.machine import Machine, Vector
from dr_lab.plants.memory import Bristle, SlowCommand, SlowReading, SlowVelocity
from dr_lab.plants.phases import Phase, State, phase_at
from dr_lab.trajectory import Array

# Points of a step at which the end of a phase is looked for, so that a slide that ends and starts anew within one step
# is seen.
_LOOKS = 8
_ROOT = 1e-14  # s, how closely the end of a phase is found


@dataclass(frozen=True)
class Accuracy:
    """How closely the motion is followed.

    Attributes:
        relative: share of a state allowed as error of one step.
        absolute: rad and rad/s, or m and m/s, allowed as error of one step.
        longest_step: s; within a step the states come from an interpolant, whose error only a short step keeps down.
    """

    relative: Positive
    absolute: Positive
    longest_step: Positive


def simulate(
    machine: Machine,
    effect: HiddenEffect,
    commands: Sequence[Command],
    time: Array,
    *,
    accuracy: Accuracy,
    start: State | None = None,
) -> Array:
    """True motion of the machine with its hidden effect, under commands that are known beforehand.

    Each stretch of constant commands is integrated by itself, so that no step crosses a jump of them; a change
    between sticking and sliding is found on the step's dense output and the integration starts anew there.

    Args:
        machine: the machine without the effect.
        effect: what is hidden in it.
        commands: what is sent to each actuator, before the effect acts on it.
        time: when to report the state, s, not decreasing; before 0 the machine is in its start state.
        accuracy: how closely to follow it.
        start: positions, then velocities, of the machine's joints at time 0; None means zero.

    Returns:
        Positions, then velocities, at each time in rad, m, rad/s and m/s, then what is remembered, shape
        (n, 2 · degrees of freedom + memories); those of a hidden oscillator or motor come after the joints'.

    Raises:
        DataError: `time` is empty or decreases, or the integration fails.
    """
    before = [command.before for command in commands]
    run = Run(Body.of(machine, effect), accuracy, time, start, before)
    acting = [effect.command(name, command) for name, command in zip(machine.actuators, commands, strict=True)]
    edges = np.concatenate([[0.0, run.end], *(command.edge for command in acting)])
    bounds = np.unique(edges[(edges >= 0) & (edges <= run.end)])
    values = np.stack([command.at(bounds) for command in acting], axis=1).tolist()
    for begin, stop, value in zip(bounds[:-1], bounds[1:], values, strict=False):
        run.advance(float(begin), float(stop), value)
    return run.states


class Run:
    """One simulation under way: where the machine is and which of the asked states are known.

    Attributes:
        states: at each asked time, shape (n, 2 · degrees of freedom + memories).
        state: now.
        body: what moves.
        end: the last time that is asked for, s.

    Raises:
        DataError: `time` is empty or decreases.
    """

    def __init__(
        self, body: Body, accuracy: Accuracy, time: Array, start: State | None, before: Sequence[float] = ()
    ) -> None:
        if len(time) == 0 or (np.diff(time) < 0).any():
            raise DataError(f"Plant: give times that do not decrease at which to report the motion; got {len(time)}.")
        self.state = _whole(body, start, before)
        self.states = np.tile(np.asarray(self.state, dtype=np.float64), (len(time), 1))
        self.end = float(time[-1])
        self.body = body
        self._accuracy = accuracy
        self._time = time
        self._known = int(np.searchsorted(time, 0.0, side="right"))

    def advance(self, begin: float, stop: float, command: Vector) -> None:
        """Move from begin to stop at constant commands, through as many phases as it takes."""
        phase, self.state = phase_at(self.body, begin, self.state, command)
        while begin < stop:
            begin, ended = self._follow(self._solver(phase, begin, stop, command), phase, command)
            if ended:
                phase, self.state = phase.after(begin, self.state, command)

    def _solver(self, phase: Phase, begin: float, stop: float, command: Vector) -> DOP853:
        degrees, wanted = self.body.degrees, self._accuracy

        def slope(time: float, y: Array) -> Sequence[float]:
            now: State = tuple(y.tolist())
            position, velocity, kept = now[:degrees], now[degrees : 2 * degrees], now[2 * degrees :]
            gained = phase.acceleration(time, now, command)
            return (
                (*velocity, *gained, *self.body.rates(position, velocity, command, kept))
                if kept
                else (*velocity, *gained)
            )

        return DOP853(
            slope,
            begin,
            self.state,
            stop,
            max_step=wanted.longest_step,
            rtol=wanted.relative,
            atol=wanted.absolute,
            first_step=min(stop - begin, wanted.longest_step),
        )

    def _follow(self, solver: DOP853, phase: Phase, command: Vector) -> tuple[float, bool]:
        """Step until the stretch or the phase ends; returns that time and whether the phase ended."""
        while solver.status == "running":
            message = solver.step()
            if message is not None:
                raise DataError(f"Plant: the integration failed at {solver.t} s: {message}")
            dense = solver.dense_output()
            end = _end_of_phase(dense, phase, command) if phase.can_end else None
            self._report(dense, float(solver.t) if end is None else end)
            if end is not None:
                self.state = tuple(dense(end).tolist())
                return end, True
        self.state = tuple(solver.y.tolist())
        return float(solver.t), False

    def _report(self, dense: DenseOutput, reached: float) -> None:
        upto = int(np.searchsorted(self._time, reached, side="right"))
        if upto > self._known:
            self.states[self._known : upto] = dense(self._time[self._known : upto]).T
            self._known = upto


def _end_of_phase(dense: DenseOutput, phase: Phase, command: Vector) -> float | None:
    """The time within the last step at which the phase's margin falls through zero, if it does."""

    def margin(time: float) -> float:
        return phase.margin(time, tuple(dense(time).tolist()), command)

    looks = np.linspace(dense.t_old, dense.t, _LOOKS + 1).tolist()
    for before, after in itertools.pairwise(looks):
        if margin(after) < 0:
            # A margin that rounding already made negative at the start of the step has no root to find.
            return after if margin(before) <= 0 else root_scalar(margin, bracket=(before, after), xtol=_ROOT).root
    return None


def _whole(body: Body, start: State | None, before: Sequence[float]) -> State:
    """The start state with every hidden oscillator and motor as its joint, and memories of a machine at rest.

    `before` are the commands that act before the first one; none are zeros.
    """
    own = len(body.machine.joints)
    joints = (0.0,) * (2 * own) if start is None else start
    position, velocity = joints[:own], joints[own:]
    inside = [joint for joint, _ in body.inside]
    moving = (*position, *(position[j] for j in inside), *velocity, *(velocity[j] for j in inside))
    sent = before or (0.0,) * len(body.machine.actuators)
    kept = {SlowCommand: sent, SlowReading: position, SlowVelocity: velocity, Bristle: (0.0,) * own}
    return (*moving, *(kept[type(memory)][place] for place, memory in body.memories))
