"""Contexts in which episodes can be played."""

from collections.abc import Callable

import numpy as np
from tensordict import TensorDict

from dr_lab.collectors.experience import Experience
from dr_lab.collectors.play import outcomes
from dr_lab.errors import ConfigError
from dr_lab.trajectory import Array

_DRAWS = 100  # of a context, until one is feasible


def feasible_contexts(
    experience: Experience, rng: np.random.Generator, owners: list[str], tried: Callable[[Array], TensorDict]
) -> Array:
    """Draws of p(z), of which those that turn out to be infeasible are drawn anew, shape (k, n).

    Args:
        experience: knows p(z).
        rng: of the draws.
        owners: whom each of the k contexts is for, as a message calls them.
        tried: plays in contexts, as `Experience.play` does.

    Raises:
        ConfigError: none of many draws is feasible.
    """
    found, missing = experience.contexts(rng, len(owners)), np.arange(len(owners))
    for _ in range(_DRAWS):
        missing = missing[outcomes(tried(found[missing]))[1]]
        if not len(missing):
            return found
        found[missing] = experience.contexts(rng, len(missing))
    raise ConfigError(
        f"The randomizer drew {_DRAWS} contexts for {owners[missing[0]]}, one after the other, and all are infeasible; "
        "expected one in which an episode can be played. Narrow the randomizer's distribution."
    )
