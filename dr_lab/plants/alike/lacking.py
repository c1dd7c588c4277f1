"""The force that a model lacks to move along the true course."""

import numpy as np

from dr_lab.plants.alike.course import Course, rigid
from dr_lab.plants.body import Body
from dr_lab.plants.hidden.effect import HiddenEffect, Law
from dr_lab.plants.memory import Bristle, Memory, SlowCommand
from dr_lab.plants.mujoco_machine import MujocoMachine
from dr_lab.trajectory import Array


def lacking(course: Course, machine: MujocoMachine, command: Array) -> Array:
    """M q'' − f of a machine along the course, N·m or N, shape (K, n).

    Args:
        course: where it moves.
        machine: whose equations are asked.
        command: mean over each interval, shape (K, actuators).
    """
    none, rows = [0.0] * len(machine.joints), []
    for q, v, a, u in zip(course.position, course.velocity, course.acceleration, command, strict=True):
        mass, force = machine.terms(q.tolist(), v.tolist(), u.tolist(), none)
        rows.append(np.asarray(mass) @ a - force)
    return np.asarray(rows)


def lacking_with(course: Course, effect: HiddenEffect) -> Array:
    """The same of the machine with an effect that is hidden in it, or with some of its parts.

    What dry friction holds lacks nothing: it bears what it must. Nor does a machine with something inside that turns by
    itself: its motion is not part of the course.
    """
    body = Body.of(course.machine, effect)
    joints = len(course.machine.joints)
    if body.inside:
        return np.zeros((len(course.step), joints))
    columns = _columns(course, body)
    machine = rigid(body.machine)
    command = course.mean_command(effect)
    for place, (_, memory) in enumerate(body.memories):
        if isinstance(memory, SlowCommand):
            command[:, body.memories[place][0]] = course.kept[:, columns[place]]
    rows = lacking(course, machine, command)
    for joint, law in body.laws:
        rows[:, joint] -= _averaged(course, joint, law)
    for place, (joint, memory) in enumerate(body.memories):
        if isinstance(memory, Bristle):
            rows[:, joint] -= [
                memory.force(z, memory.rate(z, v), v)
                for z, v in zip(
                    course.kept[:, columns[place]].tolist(), course.velocity[:, joint].tolist(), strict=True
                )
            ]
    for joint, friction in body.frictions:
        direction = course.direction[:, joint]
        sliding = [friction.sliding(np.sign(d), v) for d, v in zip(direction, course.velocity[:, joint], strict=True)]
        rows[:, joint] += direction * sliding
        rows[course.held[:, joint], joint] = 0.0
    return rows


def _columns(course: Course, body: Body) -> list[int]:
    """Of each memory of a body its column among those of the course, whose body holds it too."""
    own: list[tuple[int, Memory]] = list(course.true_body.memories)
    return [own.index(memory) for memory in body.memories]


_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(4)


def _averaged(course: Course, joint: int, law: Law) -> Array:
    """Mean of a law over each interval, through which the velocity changes evenly, shape (K,)."""
    q, v, a = (values[:, joint] for values in (course.position, course.velocity, course.acceleration))
    total = np.zeros(len(course.step))
    for node, weight in zip(_NODES, _WEIGHTS, strict=True):
        ahead = 0.5 * node * course.step
        there = (course.middle + ahead, q + ahead * v, v + ahead * a)
        total += 0.5 * weight * np.array([law(*x) for x in zip(*(part.tolist() for part in there), strict=True)])
    return total
