"""The update of φ on a bandit whose sweet spot is known; no policy is trained."""

from functools import partial
from typing import Literal

import numpy as np
import pytest
import torch
from pretended_experience import PretendedExperience
from tensordict import TensorDict

from dr_lab.distribution_learners.lsdr import LSDR
from dr_lab.distribution_learners.none import NoLearner
from dr_lab.errors import ConfigError
from dr_lab.physics.context import ContextSpace
from dr_lab.physics.parameter import Parameter
from dr_lab.randomizers.discrete import DiscreteRandomizer
from dr_lab.randomizers.gaussian import gaussian
from dr_lab.randomizers.product import ProductRandomizer
from dr_lab.randomizers.randomizer import Randomizer
from dr_lab.randomizers.uniform import UniformRandomizer
from dr_lab.trajectory import Array

TORSO = ContextSpace((Parameter("torso.radius", "m", 0.05, -0.1, 0.2),))
SWEET = (0.0, 0.09)  # m
wide = partial(UniformRandomizer, ranges={})


BATCH = TensorDict()  # of no interest to LSDR


def bandit(z: Array) -> Array:
    """J(z) = 1 in the sweet spot, 0 outside; z ≤ 0 does not compile."""
    radius = z[:, 0]
    return np.where(radius <= SWEET[0], np.nan, np.where(radius < SWEET[1], 1.0, 0.0))


def learner(
    randomizer: Randomizer, source: Literal["prior", "learned"], alpha: float, return_rate: float = 0.05
) -> LSDR:
    return LSDR(
        randomizer,
        seed=0,
        prior=wide,
        source=source,
        every=1,
        contexts=32,
        steps=5,
        learning_rate=0.02,
        alpha=alpha,
        return_rate=return_rate,
        divergence_samples=100,
    )


def train(lsdr: LSDR, updates: int) -> float:
    """Entropy after some updates."""
    return [lsdr.update(BATCH, PretendedExperience(bandit)) for _ in range(updates)][-1]["entropy"]


def cells(source: Literal["prior", "learned"], alpha: float, updates: int = 120) -> tuple[Array, Array, float]:
    randomizer = DiscreteRandomizer(TORSO, {}, bins=30)
    entropy = train(learner(randomizer, source, alpha), updates)
    grid = randomizer.distribution()
    return grid.centres[:, 0].numpy(), grid.log_probabilities.exp().detach().numpy(), entropy


def test_mass_moves_to_the_sweet_spot_and_stays_spread_over_it() -> None:
    centre, probability, entropy = cells("prior", alpha=0.2)
    inside = (centre > SWEET[0]) & (centre < SWEET[1])
    assert probability[inside].sum() > 0.97
    assert probability[centre < 0].sum() < 0.02
    # Uniform over the sweet spot has entropy log 0.09.
    assert entropy == pytest.approx(np.log(SWEET[1] - SWEET[0]), abs=0.1)


@pytest.mark.slow
def test_without_the_divergence_a_gaussian_collapses() -> None:
    entropy = {}
    for alpha in (0.24, 0.0):
        randomizer = gaussian(TORSO, {}, {}, relative_std=0.316, clip=False)
        entropy[alpha] = train(learner(randomizer, "learned", alpha), updates=70)
        mean = randomizer.distribution().mean.item()
        assert SWEET[0] < mean < SWEET[1]
    assert entropy[0.0] < entropy[0.24] - 1.0


@pytest.mark.slow
def test_without_the_divergence_cells_collapse() -> None:
    assert cells("learned", alpha=0.0)[2] < cells("learned", alpha=0.2)[2] - 0.3


def terraces(z: Array) -> Array:
    """z ≤ 0 returns −2, then J = 1, from the middle of the range on 0.9."""
    return np.select([z[:, 0] <= 0.0, z[:, 0] < 0.1], [-2.0, 1.0], 0.9)


def test_contexts_of_the_prior_without_the_divergence_give_up_only_what_is_below_the_mean() -> None:
    randomizer = DiscreteRandomizer(TORSO, {}, bins=24)
    lsdr = learner(randomizer, "prior", alpha=0.0)
    lsdr.contexts = 256
    for _ in range(60):
        lsdr.update(BATCH, PretendedExperience(terraces))
    probability = randomizer.distribution().log_probabilities.exp().detach().numpy()
    worst, best, good = probability.reshape(3, 8).sum(1)
    assert worst < 1e-3
    assert best / good == pytest.approx(1.0, abs=0.2)


def test_continues_exactly() -> None:
    def start() -> LSDR:
        return learner(DiscreteRandomizer(TORSO, {}, bins=30), "prior", alpha=0.2)

    whole, first = start(), start()
    train(whole, 6)
    train(first, 3)
    second = start()
    second.load_state_dict(first.state_dict())
    train(second, 3)
    for a, b in zip(whole.randomizer.parameters(), second.randomizer.parameters(), strict=True):
        torch.testing.assert_close(a, b, rtol=0.0, atol=0.0)
    assert whole.state_dict()["rng"] == second.state_dict()["rng"]


def test_no_learner_plays_nothing() -> None:
    assert NoLearner(wide(TORSO), seed=0).update(BATCH, PretendedExperience(bandit)) == {}


def test_nothing_to_learn_is_told() -> None:
    with pytest.raises(ConfigError, match="nothing to learn in UniformRandomizer"):
        learner(wide(TORSO), "prior", alpha=0.2)
    normal = partial(gaussian, mean={}, std={}, relative_std=1.0, clip=False)
    with pytest.raises(ConfigError, match=r"the machine varies no parameter\. Choose some, e\.g\. env/context="):
        learner(normal(ContextSpace(())), "prior", alpha=0.2)
    with pytest.raises(ConfigError, match="nothing to learn in ProductRandomizer"):  # all are in the other factor
        learner(ProductRandomizer(TORSO, {"normal": normal, "flat": wide}, {"normal": []}), "prior", alpha=0.2)


def test_a_prior_beyond_the_cells_is_told() -> None:
    with pytest.raises(ConfigError, match="same ranges"):
        learner(DiscreteRandomizer(TORSO, {"torso.radius": [0.0, 0.1]}, bins=30), "prior", alpha=0.2)


def test_averages_of_more_than_the_newest_batch_are_refused() -> None:
    with pytest.raises(ConfigError, match=r"distribution_learner\.return_rate is 1\.5; expected at most 1\."):
        learner(DiscreteRandomizer(TORSO, {}, bins=3), "prior", alpha=0.1, return_rate=1.5)
