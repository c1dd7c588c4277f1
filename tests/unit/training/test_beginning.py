"""A new run that begins with what an earlier one learnt."""

import functools
import re
import shutil
from pathlib import Path
from typing import Any

import pytest
import torch

from dr_lab.cli.arguments import compose_arguments
from dr_lab.cli.folders import shipped
from dr_lab.errors import DataError
from dr_lab.training.beginning import Beginning
from dr_lab.training.checkpoint import load, save
from dr_lab.training.plan import CHECKPOINT, POLICY, Plan, Training
from dr_lab.training.policy_snapshots import PolicySnapshots

OVERRIDES = [
    "env=hopper",
    "env/context=hopper/friction",
    "env.task.time_limit=20",
    "randomizer=gaussian",
    "algorithm.batch_frames=80",
    "collector=lean",
    "episodes=4",
    "rollout_episodes=2",
    "frames=160",
    "threads=1",
]
PPO = ("algorithm.minibatch=40", "algorithm.epochs=1")
DDPG = ("algorithm=ddpg", "algorithm.minibatch=8", "algorithm.learning_starts=40")
TD3 = ("algorithm=td3", *DDPG[1:], "algorithm.average_steps=5")

# Equal parameters may lie elsewhere in memory, which changes the last digit of a product.
close = functools.partial(torch.allclose, rtol=1e-6, atol=1e-6)


def plan(*more: str, algorithm: tuple[str, ...] = PPO) -> tuple[Plan, Beginning]:
    arguments = compose_arguments("train", [*OVERRIDES, *algorithm, *more], (shipped(),))
    return arguments["plan"], arguments["beginning"]


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("finished")
    training = plan()[0].assemble(folder / CHECKPOINT)
    with torch.no_grad():
        training.randomizer.loc += 0.25  # pyright: ignore[reportOperatorIssue, reportAttributeAccessIssue]
    training.trainer.run(160, lambda *_: None)
    training.trainer.close()
    return folder


def begun(*more: str, algorithm: tuple[str, ...] = PPO) -> Training:
    planned, beginning = plan("seed=1", *more, algorithm=algorithm)
    training = beginning.assemble(planned, None)
    training.trainer.close()
    return training


def state(path: Path) -> dict[str, Any]:
    return torch.load(path / CHECKPOINT, weights_only=False)


def test_policy_and_normaliser_are_taken_over_and_all_else_is_new(finished: Path) -> None:
    left, training = state(finished), begun(f"init={finished}")
    actor = training.algorithm.state_dict()["actor"]
    assert any("normaliser" in key for key in actor)
    for key, value in left["algorithm"]["actor"].items():
        if value.dtype != torch.uint8:  # the state of random numbers
            assert torch.equal(actor[key], value)
    assert training.trainer.frames == 0
    assert not torch.equal(training.algorithm.state_dict()["generator"], left["algorithm"]["generator"])
    assert not training.randomizer.state_dict()["loc"].any()


@pytest.mark.parametrize(("algorithm", "value_network"), [(PPO, "critic"), (DDPG, "critics"), (TD3, "critics")])
def test_the_chosen_policy_is_taken_over_and_the_last_value_network(
    tmp_path: Path, algorithm: tuple[str, ...], value_network: str
) -> None:
    training = plan(algorithm=algorithm)[0].assemble(tmp_path / CHECKPOINT)
    snapshots, observation = PolicySnapshots(training.algorithm, 2), torch.linspace(-1.0, 1.0, 22).view(2, 11)
    training.trainer.run(160, lambda *_: snapshots.take(training.trainer.frames))
    training.trainer.close()
    save(tmp_path / POLICY, snapshots.taken[0])
    first, last = (each.deployed(observation) for each in snapshots.restored())
    assert not close(first, last)
    found = begun(f"init={tmp_path}", algorithm=algorithm).algorithm
    assert close(found.deployed(observation), first)
    for key, value in training.algorithm.state_dict()[value_network].items():
        assert torch.equal(found.state_dict()[value_network][key], value)


def test_the_distribution_is_taken_over_where_asked_for(finished: Path) -> None:
    training = begun(f"init={finished}", "init_distribution=true")
    assert (training.randomizer.state_dict()["loc"] == 0.25).all()


def test_the_first_episodes_are_drawn_from_the_distribution_that_is_taken_over(finished: Path, tmp_path: Path) -> None:
    left = load(finished / CHECKPOINT)
    left["learner"]["randomizer"]["loc"] += 20.0  # standard deviations of a uniform range
    save(tmp_path / CHECKPOINT, left)
    training = begun(f"init={tmp_path}", "init_policy=false", "init_distribution=true")
    first = training.experience.collect()["context"][:, 0, 0].double()
    low, high = (float(bound[0]) for bound in (training.randomizer.space.low, training.randomizer.space.high))
    assert ((first - (low + high) / 2) / ((high - low) / 12**0.5)).numpy() == pytest.approx(20.25, abs=4.0)


def test_the_distribution_is_taken_over_without_the_policy_where_asked_for(finished: Path) -> None:
    training, new = begun(f"init={finished}", "init_policy=false", "init_distribution=true"), begun()
    assert (training.randomizer.state_dict()["loc"] == 0.25).all()
    actors = (each.algorithm.state_dict()["actor"] for each in (training, new))
    for one, other in zip(*(actor.values() for actor in actors), strict=True):
        assert torch.equal(one, other)


def test_another_run_is_refused(finished: Path, tmp_path: Path) -> None:
    with pytest.raises(DataError, match=r"init=.* is a run with another algorithm, other networks or another distr"):
        begun(f"init={finished}", "env.show_context=true")
    with pytest.raises(DataError, match=r"another distribution.*Give algorithm, env and"):
        begun(f"init={finished}", "init_distribution=true", "randomizer=discrete")
    with pytest.raises(DataError, match="explorer is here alone"):
        begun(f"init={finished}", algorithm=DDPG)


def test_other_networks_are_told_by_their_sizes(finished: Path) -> None:
    (finished / "config.yaml").write_text("# dr-lab train env=hopper algorithm=ppo\nseed: 0\n", encoding="utf-8")
    with pytest.raises(DataError) as told:
        begun(f"init={finished}", "env=half_cheetah", "env/context=half_cheetah/friction")
    assert "log_std is 3 there, 6 here; centre is 3 there, 6 here; reach is 3 there, 6 here; and 7 more." in str(
        told.value
    )
    assert "It was made by dr-lab train env=hopper algorithm=ppo. Give algorithm, env and" in str(told.value)
    assert "torch" not in str(told.value)


def test_a_folder_without_a_training_is_told_with_those_beside_it(tmp_path: Path, finished: Path) -> None:
    closed = tmp_path / "closed"
    closed.mkdir()
    (closed / "config.yaml").write_text("# dr-lab close model=furuta\nseed: 0\n", encoding="utf-8")
    (tmp_path / "policy").mkdir()
    shutil.copy(finished / CHECKPOINT, tmp_path / "policy" / CHECKPOINT)
    remedy = f"Give init=FOLDER of a run of dr-lab train, or leave init out. Available: {tmp_path / 'policy'}."
    for given, what in (
        (closed, f"{closed} holds no checkpoint.pt; it is that of a run of dr-lab close"),
        (tmp_path / "nowhere", f"There is no folder {tmp_path / 'nowhere'}"),
    ):
        with pytest.raises(DataError, match="^" + re.escape(f"init={given}: {what}. {remedy}") + "$"):
            begun(f"init={given}")
