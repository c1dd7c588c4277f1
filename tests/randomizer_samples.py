"""Randomizers over two parameters that several tests share."""

from functools import partial

import numpy as np
import torch

from dr_lab.physics.context import ContextSpace
from dr_lab.physics.parameter import Parameter
from dr_lab.randomizers.discrete import DiscreteRandomizer
from dr_lab.randomizers.gaussian import GaussianRandomizer, gaussian
from dr_lab.randomizers.mixture import MixtureRandomizer
from dr_lab.randomizers.product import ProductRandomizer
from dr_lab.randomizers.truncated_normal import TruncatedNormalRandomizer
from dr_lab.randomizers.uniform import UniformRandomizer

SPACE = ContextSpace((Parameter("mass", "kg", 1.0, 0.5, 2.5), Parameter("friction", "1", 0.0, -1.0, 1.0)))


def correlated(space: ContextSpace = SPACE) -> GaussianRandomizer:
    return GaussianRandomizer(space, np.array([1.4, 0.2]), np.array([[0.09, -0.03], [-0.03, 0.04]]), clip=False)


def uneven(space: ContextSpace = SPACE) -> DiscreteRandomizer:
    randomizer = DiscreteRandomizer(space, {}, bins=3)
    with torch.no_grad():
        randomizer.logits.copy_(torch.tensor([[0.0, 1.0, -1.0], [0.5, -2.0, 0.0], [1.5, 0.0, 0.0]]))
    return randomizer


def mixed(space: ContextSpace = SPACE) -> MixtureRandomizer:
    return MixtureRandomizer(space, {"narrow": correlated, "cells": uneven}, {"narrow": 3.0, "cells": 1.0})


def truncated(space: ContextSpace = SPACE) -> TruncatedNormalRandomizer:
    return TruncatedNormalRandomizer(space, {"mass": 2.2}, {"friction": 0.4}, relative_std=1.0)


def factored(space: ContextSpace = SPACE) -> ProductRandomizer:
    factors = {"normal": partial(gaussian, mean={"mass": 1.4}, std={"mass": 0.3}, relative_std=1.0, clip=False)}
    uniform = partial(UniformRandomizer, ranges=None)
    return ProductRandomizer(space, {**factors, "uniform": uniform}, {"normal": ["mass"]})


def uniform(space: ContextSpace = SPACE) -> UniformRandomizer:
    return UniformRandomizer(space, {"friction": [0.0, 0.5]})
