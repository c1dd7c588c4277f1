"""A curriculum goes through its stages in equal parts of the training, and a resumed one goes on where it was."""

from collections.abc import Sequence
from functools import partial

import numpy as np
import pytest
import torch
from pretended_experience import PretendedExperience
from tensordict import TensorDict

from dr_lab.cli.arguments import compose_arguments
from dr_lab.cli.folders import shipped
from dr_lab.distribution_learners.curriculum import Curriculum
from dr_lab.errors import ConfigError, UnknownNameError
from dr_lab.physics.context import ContextSpace
from dr_lab.physics.parameter import Parameter
from dr_lab.randomizers.staged import StagedRandomizer
from dr_lab.randomizers.uniform import UniformRandomizer
from dr_lab.training.plan import Plan
from dr_lab.training.snapshots import Snapshots

POWER = ContextSpace((Parameter("engine.power", "N", 13.0, 8.0, 20.0),))
LOW, HIGH = (8.0, 10.0), (18.0, 20.0)  # N


def staged() -> StagedRandomizer:
    ranges = {"low": LOW, "high": HIGH}
    return StagedRandomizer(
        POWER, {name: partial(UniformRandomizer, ranges={"engine.power": each}) for name, each in ranges.items()}
    )


def curriculum(order: Sequence[str] = ("low", "high"), frames: int = 100) -> Curriculum:
    return Curriculum(staged(), 0, order=order, frames=frames)


def learn(learner: Curriculum, frames: int) -> float:
    batch = TensorDict({}, batch_size=[1, frames])
    return learner.update(batch, PretendedExperience(lambda z: z[:, 0]))["stage"]


def drawn_from(learner: Curriculum, limits: tuple[float, float]) -> bool:
    z = learner.randomizer.sample([np.random.default_rng(seed) for seed in range(50)])
    return bool((limits[0] <= z).all() and (z <= limits[1]).all())


@pytest.mark.parametrize("order", [("low", "high"), ("high", "low")])
def test_each_half_of_the_training_has_its_stage(order: tuple[str, str]) -> None:
    learner, limits = curriculum(order), {"low": LOW, "high": HIGH}
    assert drawn_from(learner, limits[order[0]])
    assert learn(learner, 49) == 0.0
    assert drawn_from(learner, limits[order[0]])
    assert learn(learner, 1) == 1.0
    assert drawn_from(learner, limits[order[1]])
    assert learn(learner, 60) == 1.0  # beyond the end
    assert drawn_from(learner, limits[order[1]])


def test_pictures_show_a_stage_as_it_is_and_no_count_of_draws() -> None:
    randomizer = staged()
    randomizer.enter("high")
    whole = randomizer.marginal(0)
    inside = whole[whole > 0]
    assert len(inside) == 10  # of the sixtieths of 12 N, those of 2 N
    np.testing.assert_allclose(inside, 0.1)
    moments = randomizer.moments()
    assert moments is not None
    mean, covariance = moments
    np.testing.assert_allclose(mean, [19.0])
    np.testing.assert_allclose(covariance, [[2.0**2 / 12]])


def test_a_stage_that_is_named_twice_lasts_twice_as_long() -> None:
    learner = curriculum(("low", "low", "high"), frames=90)
    assert [learn(learner, 30) for _ in range(2)] == [1.0, 2.0]
    assert drawn_from(learner, HIGH)


def test_density_and_draws_are_those_of_the_present_stage() -> None:
    randomizer = staged()
    randomizer.enter("high")
    z = torch.tensor([[9.0], [19.0]], dtype=torch.float64)
    torch.testing.assert_close(randomizer.log_prob(z).exp(), torch.tensor([0.0, 0.5], dtype=torch.float64))
    assert randomizer.stage == "high"


def test_pictures_follow() -> None:
    learner = curriculum()
    snapshots = Snapshots(learner.randomizer)
    assert learner.learns
    for iteration in range(2):
        snapshots.take(iteration)
        learn(learner, 50)
    (marginal,) = snapshots.marginals()
    middle = (marginal.edges[1:] + marginal.edges[:-1]) / 2
    for probability, (low, high) in zip(marginal.probability, (LOW, HIGH), strict=True):
        assert probability[(middle > low) & (middle < high)].sum() == pytest.approx(1.0)


def test_continues_in_the_stage_it_was_in() -> None:
    first, second = curriculum(), curriculum()
    learn(first, 30)
    learn(second, 70)
    second.load_state_dict(first.state_dict())
    assert drawn_from(second, LOW)
    assert [learn(each, 19) for each in (first, second)] == [0.0, 0.0]
    assert [learn(each, 1) for each in (first, second)] == [1.0, 1.0]


def test_a_run_that_inherits_begins_in_its_own_first_stage() -> None:
    first, second = curriculum(), curriculum()
    learn(first, 70)
    assert drawn_from(first, HIGH)
    second.inherit(first.state_dict())
    assert drawn_from(second, LOW)
    assert learn(second, 50) == 1.0


def test_what_does_not_fit_is_told() -> None:
    with pytest.raises(UnknownNameError, match=r"no stage 'lwo' in randomizer\.stages\. Did you mean 'low'\?"):
        curriculum(("low", "lwo"))
    with pytest.raises(ConfigError, match=r"order is empty; expected names of stages, of low, high"):
        curriculum(())
    with pytest.raises(ConfigError, match=r"which UniformRandomizer does not have\. Take randomizer=staged\."):
        Curriculum(UniformRandomizer(POWER, {}), 0, order=["low"], frames=10)
    with pytest.raises(ConfigError, match=r"randomizer\.stages is empty"):
        StagedRandomizer(POWER, {})


def test_the_experiment_trains_on_one_range_after_the_other() -> None:
    plan: Plan = compose_arguments("train", ["experiment=curriculum_hopper_mass"], (shipped(),))["plan"]
    randomizer = plan.randomizer(plan.env.space)
    learner = plan.distribution_learner(randomizer, 0)
    assert isinstance(learner, Curriculum)
    assert drawn_from(learner, (3.0, 4.0))
    assert learn(learner, plan.frames // 2) == 1.0
    assert drawn_from(learner, (8.0, 9.0))
