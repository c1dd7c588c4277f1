"""How long does one meta-batch of MAML take, collection included, beside a plain loop over tasks?

    python benchmarks/maml.py
    python benchmarks/maml.py --tasks 20 --share 20 --rounds 5

batched   `dr_lab.algorithms.maml`: all tasks in the same slots, adapted by one vmap, derivatives written out
thinned   the same with a Hessian from every fifth control step
loop      what is usually written: task by task, a network of its own plays in slots of its own; autograd adapts it, and
          adds up the outer loss and the divergence task by task; Hessian products go back through the gradient's graph

All take the same step on nav2d: REINFORCE inside, one update of second order, ten products of conjugate gradients, a
line search. The arms take turns, round after round; times are medians over the rounds, ratios are taken within a round.
Seconds are those of the process, which other work on the machine disturbs least.
"""

import argparse
import json
import statistics
import time
from collections.abc import Callable, Mapping, Sequence
from typing import Any, cast

import numpy as np
import torch
from hydra.utils import instantiate
from rich.console import Console
from rich.table import Table
from torch import Tensor
from torch.func import functional_call

from dr_lab.algorithms.algorithm import Interface
from dr_lab.algorithms.maml.maml import MAML
from dr_lab.algorithms.reinforce.linear_baseline import LinearBaseline
from dr_lab.algorithms.reinforce.whole_episodes import whole_episodes
from dr_lab.cli.compose import compose
from dr_lab.collectors.experience import Experience
from dr_lab.collectors.first_episodes import first_episodes
from dr_lab.collectors.lean import LeanCollector
from dr_lab.envs.environment import Environment
from dr_lab.networks.gaussian_actor import GaussianActor
from dr_lab.networks.normaliser import NoNormaliser
from dr_lab.randomizers.uniform import UniformRandomizer
from dr_lab.trajectory import Array

Parameters = dict[str, Tensor]


def environment() -> Environment:
    """2D navigation."""
    return instantiate(compose("train", ["env=nav2d"]).env, _convert_="all")


def batched(options: argparse.Namespace, every: int) -> Callable[[], Mapping[str, float]]:
    """One iteration of MAML."""
    changes = [
        "algorithm=maml_paper",
        f"episodes={options.tasks * options.share}",
        f"algorithm.tasks={options.tasks}",
        f"algorithm.step.hessian_every={every}",
    ]
    env, slots = environment(), options.tasks * options.share
    played = env.make(None, slots, 0)
    episodes = played.episodes
    interface = Interface(episodes.observation.shape[1], episodes.low, episodes.high)
    make = cast(Callable[..., MAML], instantiate(compose("train", changes).algorithm, _convert_="all"))
    algorithm = make(interface, 0)
    collector = LeanCollector(played, algorithm.collecting, env.time_limit)
    source = UniformRandomizer(env.space, {})
    experience = Experience(collector, algorithm.policies["policy"], env.make(None, 1, 0).episodes, source)
    return lambda: algorithm.iterate(experience)


class Task:
    """One task's slots, and a policy that plays in them."""

    def __init__(self, env: Environment, share: int, seed: int) -> None:
        played = env.make(None, share, seed)
        bounds = played.episodes.low, played.episodes.high
        width = played.episodes.observation.shape[1]
        self.actor = GaussianActor(width, *bounds, seed, NoNormaliser, [64, 64], "tanh", log_std=0.0)
        collector = LeanCollector(played, self.actor, env.time_limit)
        self._experience = Experience(collector, self.actor, played.episodes)
        self._share, self._baseline = share, LinearBaseline(ridge=1e-5, horizon=100.0)

    @torch.no_grad()
    def play(self, parameters: Parameters, z: Array) -> tuple[Tensor, Tensor, Tensor, Tensor]:
        """Observations, actions, advantages and weights of whole episodes, one row a control step."""
        for name, value in self.actor.named_parameters():
            value.copy_(parameters[name])
        batch = self._experience.collect_whole(np.tile(z, (self._share, 1)))
        episodes = whole_episodes(batch, first_episodes(batch), self.actor)
        to_go = episodes.returns_to_go(0.99)
        advantage = (to_go - self._baseline(episodes, to_go))[episodes.mask > 0]
        standard = (advantage - advantage.mean()) / advantage.std()
        rows = episodes.mask > 0
        return episodes.observation[rows], episodes.action[rows], standard, torch.full_like(standard, 1 / len(standard))


class Loop:
    """MAML with TRPO, task by task, in plain torch."""

    def __init__(self, options: argparse.Namespace) -> None:
        env = environment()
        self._tasks = [Task(env, options.share, seed) for seed in range(options.tasks)]
        self._actor = self._tasks[0].actor
        self._theta = {name: value.detach().clone() for name, value in self._actor.named_parameters()}
        self._low, self._high = env.space.low, env.space.high
        self._rng = np.random.default_rng(0)

    def __call__(self) -> Mapping[str, float]:
        """One meta-batch."""
        data = []
        for task in self._tasks:
            z = self._rng.uniform(self._low, self._high)
            before = task.play(self._theta, z)
            leaves = {name: value.requires_grad_() for name, value in self._theta.items()}
            after = task.play(_detached(self._adapted(leaves, before)), z)
            data.append((before, after, None))
        olds = [self._acting(self._adapted(self._theta, before), after) for before, after, _ in data]
        data = [(b, a, tuple(p.detach() for p in old)) for (b, a, _), old in zip(data, olds, strict=True)]
        self._step(data)
        return {}

    def _acting(self, parameters: Parameters, rows: Sequence[Tensor]) -> tuple[Tensor, Tensor]:
        body = {name.removeprefix("body."): value for name, value in parameters.items() if name != "log_std"}
        return functional_call(self._actor.body, body, (rows[0],)), parameters["log_std"]

    def _log_prob(self, acting: tuple[Tensor, Tensor], rows: Sequence[Tensor]) -> Tensor:
        return torch.distributions.Normal(acting[0], acting[1].exp()).log_prob(rows[1]).sum(-1)

    def _adapted(self, theta: Parameters, rows: Sequence[Tensor]) -> Parameters:
        loss = -(self._log_prob(self._acting(theta, rows), rows) * rows[2] * rows[3]).sum()
        slopes = torch.autograd.grad(loss, list(theta.values()), create_graph=True)
        return {name: value - 0.1 * slope for (name, value), slope in zip(theta.items(), slopes, strict=True)}

    def _outer(self, theta: Parameters, data: Sequence[Any]) -> tuple[Tensor, Tensor]:
        losses, divergences = [], []
        for before, after, old in data:
            acting = self._acting(self._adapted(theta, before), after)
            ratio = (self._log_prob(acting, after) - self._log_prob(old, after)).exp()
            losses.append(-(ratio * after[2] * after[3]).sum())
            pair = (torch.distributions.Normal(mean, log_std.exp()) for mean, log_std in (old, acting))
            divergences.append((torch.distributions.kl_divergence(*pair).sum(-1) * after[3]).sum())
        return torch.stack(losses).mean(), torch.stack(divergences).mean()

    def _step(self, data: Sequence[Any]) -> None:
        theta = {name: value.detach().requires_grad_() for name, value in self._theta.items()}
        leaves = list(theta.values())
        loss, divergence = self._outer(theta, data)
        wanted = -_flat(torch.autograd.grad(loss, leaves, retain_graph=True))
        slope = _flat(torch.autograd.grad(divergence, leaves, create_graph=True))

        def product(vector: Tensor) -> Tensor:
            return _flat(torch.autograd.grad(slope @ vector, leaves, retain_graph=True)) + 1e-5 * vector

        found, residual, direction = torch.zeros_like(wanted), wanted.clone(), wanted.clone()
        for _ in range(10):
            image, before = product(direction), residual @ residual
            length = before / (direction @ image)
            found, residual = found + length * direction, residual - length * image
            direction = residual + (residual @ residual) / before * direction
        found *= (2 * 0.01 / (found @ product(found))).sqrt()
        self._search(theta, found, data, loss.item())

    def _search(self, theta: Parameters, step: Tensor, data: Sequence[Any], begin: float) -> None:
        parts = dict(zip(theta, step.split([value.numel() for value in theta.values()]), strict=True))
        for trial in range(15):
            moved = {
                name: (value + 0.8**trial * parts[name].view_as(value)).detach().requires_grad_()
                for name, value in theta.items()
            }
            loss, divergence = self._outer(moved, data)
            if loss.item() < begin and divergence.item() <= 0.01:
                self._theta = {name: value.detach() for name, value in moved.items()}
                return


def _flat(parts: Sequence[Tensor]) -> Tensor:
    return torch.cat([part.flatten() for part in parts])


def _detached(parameters: Parameters) -> Parameters:
    return {name: value.detach() for name, value in parameters.items()}


def seconds(arm: Callable[[], object]) -> float:
    """Time of one meta-batch."""
    begin = time.process_time()
    arm()
    return time.process_time() - begin


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure, print a table, and as the last line one JSON object."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--tasks", type=int, default=20)
    parser.add_argument("--share", type=int, default=20, help="episodes of each task before, and after, the update")
    parser.add_argument("--rounds", type=int, default=5)
    options = parser.parse_args(arguments)
    torch.set_num_threads(1)
    arms = {"batched": batched(options, 1), "thinned": batched(options, 5), "loop": Loop(options)}
    for arm in arms.values():
        arm()
    times = [{name: seconds(arm) for name, arm in arms.items()} for _ in range(options.rounds)]
    figures = {name: statistics.median(each[name] for each in times) for name in arms}
    ratios = {n: statistics.median(each["loop"] / each[n] for each in times) for n in arms if n != "loop"}
    table = Table("arm", "s a meta-batch", "loop / arm")
    for name, value in figures.items():
        table.add_row(name, f"{value:.2f}", f"{ratios[name]:.2f}" if name in ratios else "")
    Console().print(table)
    print(json.dumps({**vars(options), "seconds": figures, "loop over arm": ratios}))


if __name__ == "__main__":
    main()
