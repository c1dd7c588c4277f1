"""A policy on a plant without hidden effects returns what it returns in a model that knows the true values."""

from pathlib import Path

import pytest
from hydra.utils import instantiate
from settings import setting
from torch import Tensor

from dr_lab.cli.compose import compose
from dr_lab.envs.setting import Setting
from dr_lab.errors import ConfigError
from dr_lab.evaluators.evaluator import Subject
from dr_lab.evaluators.real_vs_sim import RealVsSimEvaluator
from dr_lab.plants.bench import Bench

STEPS = 40


def bench(plant: str, *overrides: str) -> Bench:
    return instantiate(compose("record", [f"plant={plant}", *overrides]).source).plant


def wave(observation: Tensor) -> Tensor:
    """A feedback that moves arm and pole, and saturates at times."""
    return 6.0 * observation[:, :1] - 0.5 * observation[:, 4:5] - 0.2 * observation[:, 5:6] + 1.5


def subject(overrides: tuple[str, ...] = ()) -> Subject:
    still = ["env.task.start_position=[0.0,0.0]", "env.task.start_velocity=[0.0,0.0]"]
    found: Setting = setting("furuta", f"env.task.time_limit={STEPS}", "env/reward=furuta/shared", *still, *overrides)
    return Subject("wave", found, wave, lambda *_: pytest.fail("no training is asked for"))


def evaluated(plant: Bench, of: Subject) -> dict[str, float]:
    evaluator = RealVsSimEvaluator(plant, machine=0, episodes=2, confidence=0.9, resamples=50, seed=0)
    found = evaluator.evaluate(of, Path(), lambda _: None)
    assert len(found.rows) == 2
    return dict(found.figures)


def test_without_a_gap_the_returns_agree_and_with_one_they_do_not() -> None:
    exact = evaluated(bench("furuta", "plant.nominal.spread=0.0"), subject())
    assert exact["real"] == pytest.approx(exact["simulated"], rel=1e-5)
    braked = evaluated(bench("furuta", "plant.nominal.spread=0.0", "plant/hidden=coulomb_friction_arm"), subject())
    assert braked["simulated"] == exact["simulated"]
    assert abs(braked["real"] - exact["real"]) > 0.02 * abs(exact["real"])


def test_a_plant_of_another_machine_is_refused() -> None:
    with pytest.raises(ConfigError, match=r"joints pendulum and actuators motor; the model has arm, pole"):
        evaluated(bench("pendulum"), subject())
