"""Randomise around what a run of `dr-lab close` found: a closed gap is a distribution to train on."""

import numpy as np

from dr_lab.errors import UnknownNameError
from dr_lab.physics.context import ContextSpace
from dr_lab.physics.context_file import read_context
from dr_lab.randomizers.gaussian import GaussianRandomizer


def from_run(space: ContextSpace, run: str, clip: bool) -> GaussianRandomizer:
    """The Gaussian of a fitted context: its values, its full covariance.

    Args:
        space: the parameters of the model that is trained on: the run's model with the effects that it added, which
            `dr_lab.effects.from_run` (``model@env.model=from_run``) puts together.
        run: the run folder, or its `context.yaml`.
        clip: whether samples are moved to the nearest admissible context.

    Raises:
        ConfigError: there is no such file, or it is not a fitted context.
        UnknownNameError: run and model do not have the same parameters.
    """
    found = read_context(run)
    names = found.space.names
    for name in set(names) ^ set(space.names):
        if name in names:
            lacking = f"the model, though run {run} has it. Train on that run's model: model@env.model=from_run"
            raise UnknownNameError("parameter", name, space.names, lacking)
        raise UnknownNameError("parameter", name, names, f"run {run}, though the model has it")
    order = [names.index(name) for name in space.names]
    return GaussianRandomizer(space, found.mean[order], found.covariance[np.ix_(order, order)], clip)
