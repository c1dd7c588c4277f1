"""Workers of Ray gather what one process gathers, and go on where they stopped."""

import logging
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
import ray
import test_collectors
import torch
from omegaconf import OmegaConf
from point_mass import actor
from ray import cloudpickle
from ray.exceptions import RayError
from settings import composed, setting
from test_collectors import LAYOUT, Deterministic, Gaussian
from torch import nn

from dr_lab.algorithms.ddpg.uniform_start import UniformStart
from dr_lab.collectors.lean import LeanCollector
from dr_lab.collectors.ray import RayCollector
from dr_lab.collectors.shares import joined, shares
from dr_lab.envs.mujoco_env import MujocoEnv
from dr_lab.errors import ConfigError
from dr_lab.extras import MissingLibraryError
from dr_lab.networks.deterministic_actor import DeterministicActor
from dr_lab.networks.gaussian_actor import GaussianActor
from dr_lab.networks.normaliser import NoNormaliser
from dr_lab.networks.policy_stack import GaussianPolicyStack
from dr_lab.physics.context import ContextSpace
from dr_lab.randomizers.fixed import FixedRandomizer
from dr_lab.ray_cluster import HERE, prepare

CHOICE = ("env/context=hopper/friction", "env.task.time_limit=8")
NENV, STEPS, WORKERS = 4, 20, 2


def env(slots: int = NENV) -> MujocoEnv:
    found = setting("hopper", *CHOICE)
    return found.make(at(found.space, 1.0), slots, 0, threads=1)


def at(space: ContextSpace, friction: float) -> FixedRandomizer:
    return FixedRandomizer(space, {space.names[0]: friction})


def stacked(policies: int) -> GaussianPolicyStack:
    return GaussianPolicyStack([actor()(11, -np.ones(3), np.ones(3), seed=seed) for seed in range(policies)])


def collector(policy: nn.Module, workers: int = WORKERS, address: str = HERE, slots: int = NENV) -> RayCollector:
    recipe = OmegaConf.to_container(composed("env=hopper", *CHOICE), resolve=True)
    assert isinstance(recipe, dict)
    recipe = {str(key): value for key, value in recipe.items()}
    return RayCollector(
        env(slots), policy, STEPS, setting=recipe, workers=workers, cores=1, address=address, patience=10.0
    )


@pytest.fixture(scope="module")
def runtime() -> Iterator[None]:
    """One Ray for all tests: it takes seconds to start."""
    cloudpickle.register_pickle_by_value(test_collectors)  # workers do not know the tests' folder
    prepare("collector.address", HERE, patience=10.0)
    ray.init(HERE, num_cpus=2 * WORKERS, include_dashboard=False, log_to_driver=False, logging_level=logging.ERROR)
    yield
    ray.shutdown()


def test_states_are_shared_and_joined_without_loss() -> None:
    episodes = env().episodes
    for _ in range(3):
        episodes.step(np.ones((NENV, 3)))
    before: dict[str, Any] = episodes.state_dict() | {"infeasible": 5}
    parts = shares(before, NENV, WORKERS)
    assert [part["contexts"].shape[0] for part in parts] == [2, 2]
    assert parts[1]["streams"] == before["streams"][2:]
    after = joined(parts, NENV)
    for key in ("contexts", "steps", "returns", "marker", "observation"):
        np.testing.assert_array_equal(after[key], before[key])
    for one, other in zip(after["simulator"], before["simulator"], strict=True):
        np.testing.assert_array_equal(one, other)
    assert after["streams"] == before["streams"]
    assert (after["infeasible"], after["given"]) == (5, None)


def test_workers_that_cannot_share_equally_are_told() -> None:
    with pytest.raises(ConfigError, match=r"collector\.workers is 3, which does not divide 4 episodes"):
        collector(Deterministic(), workers=3)


@pytest.mark.parametrize(
    ("policies", "workers", "slots", "message"),
    [(3, 1, 4, "3 policies cannot share 4 episodes"), (4, 3, 12, "3 workers cannot share 4 policies")],
)
def test_policies_that_cannot_be_shared_equally_are_told(policies: int, workers: int, slots: int, message: str) -> None:
    with pytest.raises(ConfigError, match=message):
        collector(stacked(policies), workers=workers, slots=slots)


def test_a_machine_without_ray_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("dr_lab.collectors.ray.find_spec", lambda name: None)
    with (
        collector(Deterministic()) as one,
        pytest.raises(MissingLibraryError, match=r"needs ray, .*, on every machine"),
    ):
        next(one)


@pytest.mark.parametrize("error", [ConnectionError, RayError])
def test_a_cluster_that_does_not_answer_or_refuses_is_told(
    error: type[Exception], monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*_: object, **__: object) -> None:
        raise error("timed out.")

    monkeypatch.setattr("dr_lab.collectors.ray.find_spec", lambda name: name)
    monkeypatch.setattr("dr_lab.collectors.ray.prepare", lambda *_: None)  # it sets what Ray reads once a process
    monkeypatch.setattr("dr_lab.collectors.ray.TorchRLRayCollector", refuse)
    with collector(Deterministic()) as one, pytest.raises(ConfigError, match=r"No Ray cluster at .*: timed out"):
        next(one)


@pytest.mark.parametrize(("address", "cores"), [(HERE, WORKERS), ("auto", None)])
def test_ray_that_is_started_here_joins_no_cluster_and_is_told_its_cores(
    address: str, cores: int | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of itself Ray joins what runs, or what a file says that ran, on this machine, and refuses a number of cores."""
    asked = {}

    def hear(*_: object, ray_init_config: dict[str, object], **__: object) -> None:
        asked.update(ray_init_config)
        raise ConnectionError

    monkeypatch.setattr("dr_lab.collectors.ray.find_spec", lambda name: name)
    monkeypatch.setattr("dr_lab.collectors.ray.prepare", lambda *_: None)  # it sets what Ray reads once a process
    monkeypatch.setattr("dr_lab.collectors.ray.TorchRLRayCollector", hear)
    with collector(Deterministic(), address=address) as one, pytest.raises(ConfigError):
        next(one)
    assert asked["address"] == address
    assert asked.get("num_cpus") == cores


@pytest.mark.daemons
@pytest.mark.usefixtures("runtime")
def test_workers_gather_what_one_process_gathers() -> None:
    policy, lean = Deterministic(), LeanCollector(env(), Deterministic(), STEPS)
    with collector(policy) as one:
        for _ in range(2):
            found, expected = next(one), next(lean)
            assert set(found.keys(True, True)) == LAYOUT - {"action_log_prob"}
            assert found.batch_size == (NENV, STEPS)
            for key in LAYOUT - {"action_log_prob"}:
                torch.testing.assert_close(found[key], expected[key], rtol=0, atol=0)


@pytest.mark.daemons
@pytest.mark.usefixtures("runtime")
def test_workers_follow_the_policy_and_the_distribution_and_draw_their_own_noise() -> None:
    policy = Gaussian(11, 3)
    with collector(policy) as one:
        first = next(one)
        noise = first["action"] - policy.mean(first["observation"])
        assert (noise[:2] != noise[2:]).all()
        with torch.no_grad():
            policy.mean.bias.add_(100.0)
        source = one._env.episodes.source
        assert isinstance(source, FixedRandomizer)
        one._env.episodes.source = at(source.space, 2.0)
        second = next(one)
    torch.testing.assert_close(second["action_log_prob"], policy.log_prob(second["observation"], second["action"]))
    assert second["action"].mean() > 90.0
    assert set(first["context"].unique().tolist()) == {1.0}
    assert set(second["context"].unique().tolist()) == {1.0, 2.0}


@pytest.mark.daemons
@pytest.mark.usefixtures("runtime")
@pytest.mark.parametrize("follows", [False, True])
def test_an_off_policy_explorer_acts_otherwise_at_every_worker_and_in_every_batch(follows: bool) -> None:
    actor = DeterministicActor(11, -np.ones(3), np.ones(3), 0, NoNormaliser, [4], "tanh", noise=0.1)
    explorer = UniformStart(actor)
    explorer.follows.fill_(follows)
    with collector(explorer) as one:
        first, second = next(one)["action"], next(one)["action"]
    assert (first[:2] != first[2:]).all()
    assert (first != second).all()


@pytest.mark.daemons
@pytest.mark.usefixtures("runtime")
@pytest.mark.parametrize("policies", [1, 4])
def test_policies_that_share_the_slots_act_at_the_workers_of_their_own(policies: int) -> None:
    stack = stacked(policies)
    for policy in stack.policies:
        assert isinstance(policy, GaussianActor)
        policy.log_std.data.fill_(-20.0)  # no noise, which workers draw otherwise
    with collector(stack) as one, LeanCollector(env(), stack, STEPS) as lean:
        found, expected = next(one), next(lean)
    assert set(found.keys(True, True)) == LAYOUT | {"policy"}
    assert found["policy"].tolist() == [[slot * policies // NENV] * STEPS for slot in range(NENV)]
    for key in ("observation", "action", "policy"):
        torch.testing.assert_close(found[key], expected[key], rtol=1e-4, atol=1e-4)


@pytest.mark.daemons
@pytest.mark.usefixtures("runtime")
def test_policies_that_share_the_slots_go_on_exactly() -> None:
    stack = stacked(4)
    with collector(stack) as one:
        next(one)
        state, noise = one.state_dict(), stack.state_dict()
        noise = {key: value.clone() for key, value in noise.items()}
        expected = next(one)
    with collector(stack) as other:
        other.load_state_dict(state)
        stack.load_state_dict(noise)
        found = next(other)
    for key in LAYOUT:
        assert torch.equal(found[key], expected[key])


@pytest.mark.daemons
@pytest.mark.usefixtures("runtime")
def test_resumed_equals_uninterrupted() -> None:
    policy = actor()(11, -np.ones(3), np.ones(3), seed=0)
    with collector(policy) as one:
        next(one)
        state, noise = one.state_dict(), policy.get_extra_state()
        expected = next(one)
    with collector(policy) as other:
        other.load_state_dict(state)
        policy.set_extra_state(noise)
        found = next(other)
    for key in LAYOUT:
        assert torch.equal(found[key], expected[key])
