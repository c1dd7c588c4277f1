"""Every algorithm, randomizer, learner and collector fits the verb `train`, every target `evaluate`."""

from pathlib import Path

import pytest
from test_configurations import check_verb, options_of, run

__all__ = ["run"]  # a fixture

GROUPS = ("algorithm", "randomizer", "distribution_learner", "collector", "normaliser", "reward_scale")
PLACE = {"normaliser": "normaliser@algorithm.actor.normaliser", "reward_scale": "reward_scale@algorithm.reward_scale"}
PARTS = {"inner_loss": "adaptation.loss", "inner_rate": "adaptation.rate", "policy_step": "step"}
NEEDED = {
    "from_run": ["randomizer.run=outputs"],
    "gail": ["algorithm.expert.path=episodes.mcap"],
    "adr_plus": ["distribution_learner.expert.path=episodes.mcap"],
}


@pytest.mark.parametrize("option", options_of("evaluator"))
def test_evaluator_fits(option: str, monkeypatch: pytest.MonkeyPatch) -> None:
    check_verb("evaluate", [f"evaluator={option}"], monkeypatch)


@pytest.mark.parametrize("option", options_of("baseline"))
def test_baseline_fits(option: str, monkeypatch: pytest.MonkeyPatch) -> None:
    check_verb("train", ["algorithm=reinforce", f"baseline@algorithm.baseline={option}"], monkeypatch)


@pytest.mark.parametrize(("group", "option"), [(group, option) for group in PARTS for option in options_of(group)])
def test_part_of_maml_fits(group: str, option: str, monkeypatch: pytest.MonkeyPatch) -> None:
    check_verb("train", ["algorithm=maml", f"{group}@algorithm.{PARTS[group]}={option}"], monkeypatch)


@pytest.mark.parametrize("option", options_of("target"))
def test_target_fits(option: str, run: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    given = [f"evaluator.target.model.run={run}"] if option == "from_run" else []
    check_verb("evaluate", ["evaluator=real_vs_sim", f"target@evaluator.target={option}", *given], monkeypatch)


@pytest.mark.parametrize("option", options_of("expert"))
def test_expert_fits(option: str, monkeypatch: pytest.MonkeyPatch) -> None:
    given = {"mcap": "algorithm.expert.path=episodes.mcap", "logs": "algorithm.expert.episodes=2"}[option]
    check_verb("train", ["algorithm=gail", f"expert@algorithm.expert={option}", given], monkeypatch)


@pytest.mark.parametrize(("group", "option"), [(group, option) for group in GROUPS for option in options_of(group)])
def test_option_fits(group: str, option: str, monkeypatch: pytest.MonkeyPatch) -> None:
    check_verb("train", [f"{PLACE.get(group, group)}={option}", *NEEDED.get(option, [])], monkeypatch)
