"""Learning the force that a fitted model misses, as a smooth function of measured state and commands.

The force acts in simulations, and what windows say of it is linear in its weights: so each step is a ridge regression
on the residuals of all windows, whose start states and model parameters move along. Which quantities the force depends
on, how smooth and how large it is, is chosen by what parts of the fitted logs say that a step did not see.
"""

from dataclasses import dataclass, replace

import numpy as np

from dr_lab.diagnosis.evidence.bench import FittedModel, scored
from dr_lab.diagnosis.missing_force.choosing import Choice, choose_basis
from dr_lab.diagnosis.missing_force.force_step import Course, Learned, Machine, stepped
from dr_lab.diagnosis.missing_force.learning_settings import LearningSettings


@dataclass(frozen=True)
class Prospect:
    """A force that is worth learning.

    Attributes:
        machine: joint and data.
        begin: the model without it.
        course: how windows answer to a force.
        choice: what the force depends on, and how smooth and how large it is.
    """

    machine: Machine
    begin: Learned
    course: Course
    choice: Choice


def prospect(machine: Machine, base: FittedModel, settings: LearningSettings) -> Prospect | None:
    """What a force at a joint would explain beside a fitted model, by one linear step.

    Args:
        machine: joint and data.
        base: the fitted model.
        settings: how it is learned.

    Returns:
        The best choice; None where no function of what moves and is commanded is worth it on parts of the fitted logs
        that the step did not see.
    """
    begin = Learned(base.model, base.fit, np.zeros(0), base.model.space.names)
    course = Course(machine, begin, settings.parts)
    choice = choose_basis(machine, course, begin.fit.cost, settings)
    if choice is None:
        return None
    return Prospect(machine, replace(begin, weights=np.zeros(len(choice.basis.centres))), course, choice)


def learn_force(found: Prospect, settings: LearningSettings) -> FittedModel | None:
    """Learn the force of a prospect: linear steps of its weights, each refitted by simulation with all parameters.

    Args:
        found: what is learned.
        settings: how.

    Returns:
        The model with the force as its last effect, fitted and scored; None where no step lowers the cost by
        `settings.least`.
    """
    machine, at, course, best = found.machine, found.begin, found.course, None
    for k in range(settings.rounds):
        course = course if k == 0 else Course(machine, at, settings.parts)
        further = stepped(machine, at, course, found.choice, settings.refit)
        gained = further.fit.below(at.fit) >= settings.least * at.fit.cost
        if further.fit.infeasible.sum() > at.fit.infeasible.sum() or not gained:
            break
        best = at = further
    return None if best is None else scored(machine.bench, best.model, best.fit)
