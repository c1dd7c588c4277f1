"""The force that a model lacks to move along the true course."""

from collections.abc import Iterator

import numpy as np

from dr_lab.plants.alike.course import Course, rigid
from dr_lab.plants.body import Body
from dr_lab.plants.dry_friction import DryFriction
from dr_lab.plants.hidden.composite import Composite
from dr_lab.plants.hidden.effect import HiddenEffect, Law
from dr_lab.plants.hidden.several import Several
from dr_lab.plants.memory import Bristle, Memory, SlowCommand
from dr_lab.plants.mujoco_machine import MujocoMachine
from dr_lab.trajectory import Array

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(4)


def lacking(course: Course, machine: MujocoMachine, command: Array) -> Array:
    """M q'' − f of a machine along the course, N·m or N, shape (K, n).

    Args:
        course: where it moves.
        machine: whose equations are asked.
        command: mean over each interval, shape (K, actuators).
    """
    return machine.lacking(course.position, course.velocity, course.acceleration, command)


def lacking_with(course: Course, effect: HiddenEffect) -> Array:
    """The same of the machine with an effect that is hidden in it, or with some of its parts.

    What dry friction holds lacks nothing: it bears what it must. Nor does a machine with something inside that turns by
    itself: its motion is not part of the course.
    """
    body = Body.of(course.machine, effect)
    joints = len(course.machine.joints)
    if body.inside:
        return np.zeros((len(course.step), joints))
    rows = lacking(course, rigid(body.machine), acting(course, body, effect))
    for joint, law in body.laws:
        rows[:, joint] -= _averaged(course, joint, law)
    for joint, force in bristled(course, body, course.velocity):
        rows[:, joint] -= force
    for joint, friction in body.frictions:
        rows[:, joint] += _rubbed(course, joint, friction)
        rows[course.held[:, joint], joint] = 0.0
    return rows


def acting(course: Course, body: Body, effect: HiddenEffect) -> Array:
    """Commands that act in the middle of each interval on a body that an effect makes, shape (K, actuators)."""
    command = course.mean_command(effect)
    for column, (actuator, memory) in zip(_columns(course, body), body.memories, strict=True):
        if isinstance(memory, SlowCommand):
            command[:, actuator] = course.kept[:, column]
    return command


def bristled(course: Course, body: Body, velocity: Array) -> Iterator[tuple[int, Array]]:
    """Joint and force, shape (K,), of a body's bristles, bent as along the course, at some velocities, shape (K, n)."""
    for column, (joint, memory) in zip(_columns(course, body), body.memories, strict=True):
        if isinstance(memory, Bristle):
            states = zip(course.kept[:, column].tolist(), velocity[:, joint].tolist(), strict=True)
            yield joint, np.array([memory.force(z, memory.rate(z, v), v) for z, v in states])


def borne(course: Course) -> Array:
    """What the hidden dry friction bears at the joints that it holds, N·m or N, shape (K, n); 0 while they slide."""
    parts = course.effect.parts if isinstance(course.effect, Composite) else (course.effect,)
    rest = Several({str(number): part for number, part in enumerate(parts) if not part.frictions()})
    return np.where(course.held, lacking_with(course, without_inside(rest)), 0.0)


def turns_inside(effect: HiddenEffect) -> bool:
    """Whether something of an effect turns by itself, unseen."""
    return bool(effect.oscillators() or effect.motors())


def without_inside(several: Several) -> Several:
    """Those of several effects of which nothing turns by itself."""
    return Several({name: part for name, part in several.effects.items() if not turns_inside(part)})


def _columns(course: Course, body: Body) -> list[int]:
    """Of each memory of a body its column among those of the course, whose body holds it too."""
    own: list[tuple[int, Memory]] = list(course.true_body.memories)
    return [own.index(memory) for memory in body.memories]


def _rubbed(course: Course, joint: int, friction: DryFriction) -> Array:
    """What dry friction takes, shape (K,)."""
    direction = course.direction[:, joint]
    states = zip(np.sign(direction).tolist(), course.velocity[:, joint].tolist(), strict=True)
    return direction * np.array([friction.sliding(sign, v) for sign, v in states])


def _averaged(course: Course, joint: int, law: Law) -> Array:
    """Mean of a law over each interval, through which the velocity changes evenly, shape (K,)."""
    q, v, a = (values[:, joint] for values in (course.position, course.velocity, course.acceleration))
    total = np.zeros(len(course.step))
    for node, weight in zip(_NODES, _WEIGHTS, strict=True):
        ahead = 0.5 * node * course.step
        there = (course.middle + ahead, q + ahead * v, v + ahead * a)
        total += 0.5 * weight * np.array([law(*x) for x in zip(*(part.tolist() for part in there), strict=True)])
    return total
