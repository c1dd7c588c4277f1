"""EPOpt learns from the contexts that go worst, ranked by whole episodes; its critic from all."""

from collections.abc import Mapping
from typing import Any, cast

import numpy as np
import pytest
import torch
from playing import Uniform
from point_mass import ppo_arguments
from settings import setting
from tensordict import TensorDict
from torch import Tensor

from dr_lab.algorithms.algorithm import Interface
from dr_lab.algorithms.epopt.epopt import EPOpt, worst_contexts
from dr_lab.algorithms.ppo.surrogate import PolicySamples
from dr_lab.cli.arguments import compose_arguments
from dr_lab.cli.folders import shipped
from dr_lab.collectors.experience import Experience
from dr_lab.collectors.lean import LeanCollector
from dr_lab.errors import ConfigError
from dr_lab.training.plan import Plan


def batch(reward: list[list[float]], done: list[list[int]], infeasible: list[list[int]] | None = None) -> TensorDict:
    flags = {"done": done, "infeasible": infeasible or [[0] * len(row) for row in done]}
    values = {key: torch.tensor(rows, dtype=torch.bool)[..., None] for key, rows in flags.items()}
    shape = [len(reward), len(reward[0])]
    after = TensorDict({"reward": torch.tensor(reward)[..., None], **values}, batch_size=shape)
    return TensorDict({"next": after}, batch_size=shape)


def test_contexts_are_ranked_by_the_mean_of_the_first_episode_of_each_of_their_slots() -> None:
    # Returns 2 and 6 in the first context, mean 4; 3 and 3 in the second, whose surplus of −9 does not count.
    played = batch(
        [[1.0, 1.0, 9.0], [2.0, 2.0, 2.0], [3.0, -9.0, -9.0], [1.0, 2.0, 9.0]],
        [[0, 1, 1], [0, 0, 1], [1, 0, 1], [0, 1, 1]],
    )
    assert worst_contexts(played, 2, 0.5).tolist() == [False, False, True, True]
    assert worst_contexts(played, 2, 0.1).tolist() == [False, False, True, True]
    assert worst_contexts(played, 2, 1.0).all()
    assert worst_contexts(played, 1, 0.25).tolist() == [True, False, False, False]  # single episodes: luck
    assert worst_contexts(batch([[1.0]] * 25, [[1]] * 25), 1, 0.28).sum() == 7  # which 0.28 · 25 exceeds by rounding


def test_a_context_with_an_infeasible_episode_is_neither_ranked_nor_learnt_from() -> None:
    reward, done = [[-9.0, 1.0], [1.0, 1.0], [2.0, 2.0], [3.0, 3.0]], [[1, 1], [0, 1], [0, 1], [0, 1]]
    infeasible = [[1, 0], [0, 0], [0, 0], [0, 0]]
    assert worst_contexts(batch(reward, done, infeasible), 2, 0.5).tolist() == [False, False, True, True]
    assert not worst_contexts(batch(reward, done, done), 2, 0.5).any()


class Watched(EPOpt):
    """Notes what its policy and its critic learn from."""

    sizes: tuple[int, int] = (0, 0)

    def _fit(self, policy: PolicySamples, value: PolicySamples) -> Mapping[str, float]:
        self.sizes = (len(policy.target), len(value.target))
        return super()._fit(policy, value)


def arguments(**changes: Any) -> dict[str, Any]:  # noqa: ANN401
    own = {"epsilon": 0.5, "warm_up": 0.5, "frames": 1000, "slots": 8, "episodes_per_context": 4}
    return ppo_arguments(**own | changes)


def made(seed: int = 0, **changes: Any) -> tuple[Watched, Experience]:  # noqa: ANN401
    of = setting("half_cheetah", "env/context=half_cheetah/density", "env.task.time_limit=10")
    source = Uniform(of.space.low, of.space.high)
    env = of.make(source, 8, seed, threads=1, staggered=True)
    slots = env.episodes
    interface = Interface(slots.observation.shape[1], slots.low, slots.high)
    algorithm = Watched(**arguments(seed=seed, interface=interface, **changes))
    policy = algorithm.policies["policy"]
    played = of.make(None, 2, 1, threads=1).episodes
    return algorithm, Experience(LeanCollector(env, policy, 5), policy, played, source)


def test_the_policy_learns_from_the_worst_half_once_it_has_warmed_up_and_the_critic_from_all() -> None:
    algorithm, experience = made(frames=320, anneal_frames=320)
    figures = [algorithm.iterate(experience) for _ in range(4)]
    # 80 control steps each: ε begins after 160 of 320, and with it the learning rate falls.
    assert [each["epsilon"] for each in figures] == [1.0, 1.0, 0.5, 0.5]
    assert [each["learning_rate"] / 3e-3 for each in figures] == pytest.approx([1.0, 1.0, 1.0, 0.5])
    assert algorithm.sizes == (40, 80)


def test_the_infeasible_end_of_a_later_episode_is_not_learnt_from() -> None:
    algorithm, experience = made(warm_up=0.0)
    played = experience.collect_whole(np.ones((8, 1)))
    played["next", "done"][:, 4] = True  # ends the episodes that are ranked
    played["next", "infeasible"][:, 9] = True
    algorithm.update(played)
    assert algorithm.sizes == (4 * 9, 8 * 9)


def test_four_whole_episodes_are_played_in_each_context() -> None:
    algorithm, experience = made()
    heard = list[TensorDict]()
    experience.listen(heard.append)
    for _ in range(2):
        algorithm.iterate(experience)
    contexts = [cast(Tensor, each["context"]) for each in heard]
    for context in contexts:
        assert torch.equal(context, context[:, :1].expand_as(context))
        assert context[:, 0, 0].unique().numel() == 2
        assert torch.equal(context[:4, 0], context[:1, 0].expand(4, -1))
    assert not torch.equal(*contexts)


def test_continues_exactly() -> None:
    whole, first, second = (made(warm_up=0.0) for _ in range(3))
    for _ in range(3):
        whole[0].iterate(whole[1])
    first[0].iterate(first[1])
    second[0].load_state_dict(first[0].state_dict())
    second[1].load_state_dict(first[1].state_dict())
    for _ in range(2):
        second[0].iterate(second[1])
    for a, b in zip(whole[0].actor.parameters(), second[0].actor.parameters(), strict=True):
        assert torch.equal(a, b)


def test_training_on_selects_at_once() -> None:
    algorithm, experience = made(warm_up=0.9)
    algorithm.begin_schedules()
    assert algorithm.iterate(experience)["epsilon"] == 0.5


def test_training_on_draws_other_contexts() -> None:
    seen = []
    for seed in (0, 0, 1):
        algorithm, experience = made()
        algorithm.explore_anew(seed)
        experience.listen(lambda batch: seen.append(cast(Tensor, batch["context"])[:, 0].tolist()))
        algorithm.iterate(experience)
    assert seen[0] == seen[1] != seen[2]


def test_the_default_settings_select_within_a_run() -> None:
    for chosen in ("algorithm=epopt", "algorithm=epopt_paper"):
        plan: Plan = compose_arguments("train", [chosen, "frames=1000000"], (shipped(),))["plan"]
        algorithm = plan.algorithm(Interface(3, np.array([-1.0]), np.array([1.0])), 0)
        assert isinstance(algorithm, EPOpt)
        assert algorithm.share == 1.0
        algorithm.frames = 400_000
        assert algorithm.share == 0.1


def test_a_warm_up_that_leaves_nothing_is_refused() -> None:
    with pytest.raises(ConfigError, match=r"warm_up is 1 of the 1000 control steps .* leaves nothing .*warm_up=0\.3"):
        EPOpt(**arguments(warm_up=1.0))


def test_a_number_out_of_its_range_is_told() -> None:
    with pytest.raises(ConfigError, match=r"algorithm\.epsilon is 1\.5; expected at most 1\."):
        EPOpt(**arguments(epsilon=1.5))
    with pytest.raises(ConfigError, match=r"episodes_per_context is 3, which does not divide 8 episodes"):
        EPOpt(**arguments(episodes_per_context=3))
