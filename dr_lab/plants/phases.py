"""Phases of motion between which the equations change: each dry friction holds its joint or brakes it."""

import math
from collections.abc import Collection
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg import get_lapack_funcs

from dr_lab.plants.body import Body
from dr_lab.plants.machine import Matrix, Vector

# rad/s or m/s: a sliding joint counts as stopped this far on the other side of zero, so that rounding at the start of a
# slide does not end it at once. Ten orders below the speeds of the machines.
_STOPPED = 1e-9

(_POSV,) = get_lapack_funcs(("posv",), dtype=np.float64)  # solves M x = f for a positive definite M

State = tuple[float, ...]  # positions, then velocities, then what is remembered


@dataclass(frozen=True)
class Phase:
    """One set of equations: of each dry friction, the direction in which its joint slides, or 0 while it is held.

    A slide lasts until the speed passes zero, a hold until the force that holds exceeds the static friction; a body
    without dry friction has a single phase that lasts for ever.

    Attributes:
        body: what moves.
        slides: +1, −1 or 0 for each of the body's dry frictions.
    """

    body: Body
    slides: tuple[int, ...]

    @property
    def can_end(self) -> bool:
        """Whether the phase can end before the command changes."""
        return bool(self.slides)

    def acceleration(self, time: float, state: State, command: Vector) -> Vector:
        """Accelerations in rad/s² or m/s²; zero at a held joint."""
        return solve(*self._terms(time, state, command), self._held)

    def margin(self, time: float, state: State, command: Vector) -> float:
        """Positive while the phase lasts; it ends where this falls through zero."""
        return min(self._margins(time, state, command))

    def after(self, time: float, state: State, command: Vector) -> "tuple[Phase, State]":
        """The phase that follows where this one has ended, never the same one again, and the state it starts in."""
        margins = self._margins(time, state, command)
        ended = margins.index(min(margins))
        joint, friction = self.body.frictions[ended]
        rest = self._at_rest(state, joint)
        before = self.slides[ended]
        load = self._with(ended, 0).loads(time, rest, command)[joint]
        push = int(math.copysign(1, load))
        reverses = push == -before and abs(load) > friction.limit(push)
        following = self._with(ended, push if before == 0 or reverses else 0)
        return following._released(time, rest, command, spared=ended), rest

    def loads(self, time: float, state: State, command: Vector) -> Vector:
        """Force that must be balanced at each joint to keep it from accelerating as it does not; zero where it is free.

        At a held joint this is what friction must bear, in N·m or N, positive where it pushes the joint forward.
        """
        mass, force = self._terms(time, state, command)
        gained = solve(mass, force, self._held)
        return [f - sum(m * a for m, a in zip(row, gained, strict=True)) for f, row in zip(force, mass, strict=True)]

    def _terms(self, time: float, state: State, command: Vector) -> tuple[Matrix, Vector]:
        degrees = self.body.degrees
        velocity, drag = state[degrees : 2 * degrees], [0.0] * degrees
        for (joint, friction), slide in zip(self.body.frictions, self.slides, strict=True):
            if slide:
                drag[joint] = -slide * friction.sliding(slide, velocity[joint])
        return self.body.terms(time, state[:degrees], velocity, command, drag, state[2 * degrees :])

    def _margins(self, time: float, state: State, command: Vector) -> list[float]:
        """Of each dry friction: speed in the direction of its slide, or static friction less the load."""
        degrees = self.body.degrees
        loads = self.loads(time, state, command) if 0 in self.slides else ()
        margins = []
        for (joint, friction), slide in zip(self.body.frictions, self.slides, strict=True):
            if slide:
                margins.append(slide * state[degrees + joint] + _STOPPED)
            else:
                margins.append(friction.limit(math.copysign(1.0, loads[joint])) - abs(loads[joint]))
        return margins

    def _released(self, time: float, state: State, command: Vector, spared: int | None = None) -> "Phase":
        """This phase without the holds that cannot bear their load; one friction is spared the question."""
        phase = self
        while 0 in phase.slides:
            margins = phase._margins(time, state, command)
            broken = [k for k, slide in enumerate(phase.slides) if slide == 0 and k != spared and margins[k] <= 0]
            if not broken:
                break
            worst = min(broken, key=margins.__getitem__)
            load = phase.loads(time, state, command)[self.body.frictions[worst][0]]
            phase = phase._with(worst, int(math.copysign(1, load)))
        return phase

    def _with(self, which: int, slide: int) -> "Phase":
        return Phase(self.body, (*self.slides[:which], slide, *self.slides[which + 1 :]))

    @cached_property
    def _held(self) -> Collection[int]:
        return [j for (j, _), slide in zip(self.body.frictions, self.slides, strict=True) if slide == 0]

    def _at_rest(self, state: State, joint: int) -> State:
        row = self.body.degrees + joint
        return (*state[:row], 0.0, *state[row + 1 :])


def phase_at(body: Body, time: float, state: State, command: Vector) -> tuple[Phase, State]:
    """The phase in which a state moves on, and that state.

    A joint within the rounding of zero speed is put to rest, and held if static friction can hold it.
    """
    slides, rest = [], list(state)
    for joint, _ in body.frictions:
        row = body.degrees + joint
        moving = abs(state[row]) > 2 * _STOPPED
        slides.append(int(math.copysign(1, state[row])) if moving else 0)
        rest[row] = state[row] if moving else 0.0
    found = tuple(rest)
    return Phase(body, tuple(slides))._released(time, found, command), found


def solve(mass: Matrix, force: Vector, held: Collection[int] = ()) -> Vector:
    """M⁻¹ f with the accelerations of held joints at zero.

    One and two free joints are solved in plain floats, which is several times faster than NumPy on so little.
    """
    free = [row for row in range(len(force)) if row not in held] if held else range(len(force))
    gained = [0.0] * len(force)
    if len(free) == 1:
        (a,) = free
        gained[a] = force[a] / mass[a][a]
    elif len(free) == 2:
        a, b = free
        determinant = mass[a][a] * mass[b][b] - mass[a][b] * mass[b][a]
        gained[a] = (mass[b][b] * force[a] - mass[a][b] * force[b]) / determinant
        gained[b] = (mass[a][a] * force[b] - mass[b][a] * force[a]) / determinant
    elif free:
        # LAPACK itself: NumPy's checks take longer than the arithmetic.
        rows = np.asarray(mass)[np.ix_(free, free)] if held else mass
        _, values, _ = _POSV(rows, [force[row] for row in free])
        for row, value in zip(free, values.tolist(), strict=True):
            gained[row] = value
    return gained
