"""Whether weight shows from which direction an angle counts.

A servo's unknown stiffness can do what the weight of a wrongly read angle asks for, and the equation of motion is then
fulfilled by that alone. So it must be fulfilled clearly better with weight than without.
"""

from copy import copy
from dataclasses import replace

import numpy as np

from dr_lab.proposal.search import Readings
from dr_lab.proposal.settings import ProposalSettings
from dr_lab.proposal.trial import Outcome, Trial


def shown_by_weight(trial: Trial, readings: Readings, heavy: Outcome, settings: ProposalSettings) -> bool:
    """Whether gravity takes away most of what each moved joint would leave without it.

    A joint whose weight does not change with the motion says nothing against its offset: other forces show it.

    Args:
        trial: all of whose joints are hinges or slides.
        readings: with offsets.
        heavy: these, tried.
        settings: how much gravity must take away, and how much of the forces it must be to count.
    """
    floating = copy(trial.model)
    floating.opt.gravity[:] = 0.0
    light = replace(trial, model=floating)(readings)
    weight = heavy.need - light.need
    acts = ((weight - weight.mean(0)) ** 2).sum(0) > settings.felt**2 * heavy.size
    shown = heavy.left * heavy.size < (1 - settings.weighs) * light.left * light.size
    return all(shown[j] or not acts[j] for j in np.flatnonzero([each.offset for each in readings]))
