"""Every collector hands out what a learner proposes, and learners see the same of all."""

from typing import Any

import numpy as np
import pytest

from dr_lab.cli.arguments import compose_arguments
from dr_lab.cli.folders import shipped
from dr_lab.collectors.collector import SeededPolicy
from dr_lab.distribution_learners.adr.adr import ADR
from dr_lab.training.plan import Plan, Training
from dr_lab.trajectory import Array

OVERRIDES = [
    *("env=hopper", "env/context=hopper/torso_mass", "env.task.time_limit=20", "randomizer=empirical"),
    *("distribution_learner=adr", "distribution_learner.svpg.count=2", "distribution_learner.svpg.proposals=3"),
    *("algorithm=ppo", "algorithm.batch_frames=40", "algorithm.minibatch=20", "algorithm.epochs=1"),
    *("episodes=4", "rollout_episodes=3", "frames=800", "threads=1"),
]


def trained(collector: str, *more: str) -> Training:
    arguments: dict[str, Any] = dict(
        compose_arguments("train", [*OVERRIDES, f"collector={collector}", *more], (shipped(),))
    )
    plan: Plan = arguments["plan"]
    training = plan.assemble(None)
    policy = training.algorithm.policies["policy"]
    assert isinstance(policy, SeededPolicy)
    policy.reseed(0)  # TorchRL tries it out
    training.trainer.run(plan.frames, lambda *_: None)
    training.trainer.close()
    return training


def rounds(training: Training) -> list[tuple[float, float]]:
    history = training.trainer.history
    return [(row["frames"], row["discriminator_accuracy"]) for row in history if "discriminator_accuracy" in row]


def proposed(training: Training) -> Array:
    assert isinstance(training.learner, ADR)
    return training.learner.source.z


@pytest.mark.parametrize("shown", ["false", pytest.param("true", marks=pytest.mark.slow)])
def test_lean_and_torchrl_end_with_the_same_proposals(shown: str) -> None:
    lean, torchrl = (trained(kind, f"env.show_context={shown}") for kind in ("lean", "torchrl"))
    assert len(rounds(lean)) > 2
    assert rounds(lean) == rounds(torchrl)
    np.testing.assert_array_equal(proposed(lean), proposed(torchrl))


@pytest.mark.daemons
def test_ray_answers_rounds_too() -> None:
    assert len(rounds(trained("ray", "collector.workers=2", "collector.cores=1"))) > 2
