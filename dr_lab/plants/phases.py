"""Phases of motion between which the equations change: free of dry friction, sliding, held."""

import math
from dataclasses import dataclass, replace
from typing import ClassVar, Protocol

from dr_lab.plants.dry_friction import DryFriction
from dr_lab.plants.furuta import Furuta, Pair
from dr_lab.plants.hidden.effect import HiddenEffect

# rad/s: a sliding joint counts as stopped this far on the other side of zero, so that rounding at the start of a slide
# does not end it at once. Ten orders below the speeds of the machine.
_STOPPED = 1e-9

State = tuple[float, float, float, float]


@dataclass(frozen=True)
class Body:
    """A machine with its hidden effect: mass matrix and smooth force at a state (θ, α, θ', α')."""

    machine: Furuta
    effect: HiddenEffect

    def terms(self, state: State, voltage: float) -> tuple[tuple[float, float, float], Pair]:
        """Mass matrix (M_θθ, M_θα, M_αα) in kg·m² and force (arm, pole) in N·m."""
        position, velocity = state[:2], state[2:]
        force = self.machine.force(position, velocity, voltage)
        extra = self.effect.force(position, velocity)
        return self.machine.mass(position[1]), (force[0] + extra[0], force[1] + extra[1])


class Phase(Protocol):
    """One set of equations and the condition under which they hold.

    Attributes:
        can_end: whether the phase can end before the command changes.
    """

    can_end: ClassVar[bool]

    def acceleration(self, state: State, voltage: float) -> Pair:
        """(θ'', α'') in rad/s²."""
        ...

    def margin(self, state: State, voltage: float) -> float:
        """Positive while the phase lasts; it ends where this falls through zero."""
        ...

    def after(self, state: State, voltage: float) -> "tuple[Phase, State]":
        """The phase that follows where this one has ended, never the same one again, and the state it starts in."""
        ...


@dataclass(frozen=True)
class Free:
    """No dry friction; lasts for ever."""

    can_end: ClassVar[bool] = False
    body: Body

    def acceleration(self, state: State, voltage: float) -> Pair:
        """M⁻¹ f."""
        return _solve(*self.body.terms(state, voltage))

    def margin(self, state: State, voltage: float) -> float:
        """Always one."""
        del state, voltage
        return 1.0

    def after(self, state: State, voltage: float) -> tuple[Phase, State]:
        """The same motion: nothing ends it."""
        del voltage
        return self, state


@dataclass(frozen=True)
class Slide:
    """A joint slides in one direction; lasts until its speed passes zero."""

    can_end: ClassVar[bool] = True
    body: Body
    friction: DryFriction
    direction: float

    def acceleration(self, state: State, voltage: float) -> Pair:
        """M⁻¹ (f − direction · |τ|(v) at the joint)."""
        mass, (arm, pole) = self.body.terms(state, voltage)
        joint = self.friction.joint
        drag = self.direction * self.friction.sliding(state[2 + joint])
        return _solve(mass, (arm - drag, pole) if joint == 0 else (arm, pole - drag))

    def margin(self, state: State, voltage: float) -> float:
        """Speed in the direction of the slide."""
        del voltage
        return self.direction * state[2 + self.friction.joint] + _STOPPED

    def after(self, state: State, voltage: float) -> tuple[Phase, State]:
        """Held, unless the load overcomes static friction the other way."""
        held = Stick(self.body, self.friction)
        rest = held.at_rest(state)
        if self.direction * held.load(rest, voltage) < -self.friction.static:
            return replace(self, direction=-self.direction), rest
        return held, rest


@dataclass(frozen=True)
class Stick:
    """A joint is held; lasts until the force that holds it exceeds the static friction."""

    can_end: ClassVar[bool] = True
    body: Body
    friction: DryFriction

    def acceleration(self, state: State, voltage: float) -> Pair:
        """Zero at the held joint, force over inertia at the other."""
        mass, force = self.body.terms(state, voltage)
        return (0.0, force[1] / mass[2]) if self.friction.joint == 0 else (force[0] / mass[0], 0.0)

    def margin(self, state: State, voltage: float) -> float:
        """Static friction less the holding force."""
        return self.friction.static - abs(self.load(state, voltage))

    def after(self, state: State, voltage: float) -> tuple[Phase, State]:
        """Sliding, the way the load pushes."""
        rest = self.at_rest(state)
        return Slide(self.body, self.friction, math.copysign(1.0, self.load(rest, voltage))), rest

    def load(self, state: State, voltage: float) -> float:
        """Force that friction must balance to hold the joint, in N·m, positive where it pushes the joint forward."""
        mass, force = self.body.terms(state, voltage)
        joint = self.friction.joint
        return force[joint] - mass[1] * self.acceleration(state, voltage)[1 - joint]

    def at_rest(self, state: State) -> State:
        """The state with the joint's speed set to zero."""
        arm, pole, arm_speed, pole_speed = state
        return (arm, pole, 0.0, pole_speed) if self.friction.joint == 0 else (arm, pole, arm_speed, 0.0)


def phase_at(body: Body, friction: DryFriction | None, state: State, voltage: float) -> tuple[Phase, State]:
    """The phase in which a state moves on, and that state.

    A joint within the rounding of zero speed is put to rest, and held if static friction can hold it.
    """
    if friction is None:
        return Free(body), state
    speed = state[2 + friction.joint]
    if abs(speed) > 2 * _STOPPED:
        return Slide(body, friction, math.copysign(1.0, speed)), state
    held = Stick(body, friction)
    rest = held.at_rest(state)
    return (held, rest) if held.margin(rest, voltage) > 0 else held.after(rest, voltage)


def _solve(mass: tuple[float, float, float], force: Pair) -> Pair:
    first, across, second = mass
    determinant = first * second - across * across
    return (
        (second * force[0] - across * force[1]) / determinant,
        (first * force[1] - across * force[0]) / determinant,
    )
