"""How fast is experience collected with a policy in the loop, beside TorchRL's own environments and the physics alone?

One policy acts in every arm: untrained, with two hidden layers of 64, or that of a run. Mass, friction and damping of
every body, joint and shape are drawn anew for each episode, by writing model fields. The arms take turns, round after
round, so that all meet the same load; figures are medians over the rounds, ratios are taken within a round.

limit       `mujoco.batch.Batch.step` alone, on starts and actions of a batch of lean
lean        `dr_lab.collectors.lean`
torchrl     `dr_lab.collectors.torchrl`, the default
compiled    lean, the torso's size drawn for each episode: a model is compiled each time (not for every machine)
gymnasium   `torchrl.collectors.Collector` on `ParallelEnv` of 8 `GymEnv`, nothing drawn

    python benchmarks/collect.py
    python benchmarks/collect.py --machines hopper --rounds 3 --seconds 2
    python benchmarks/collect.py --machines hopper --alone --trained outputs/train/hopper/2026-01-31_12-00-00
"""

import argparse
import json
import os
import statistics
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack
from dataclasses import replace
from functools import partial
from pathlib import Path
from types import ModuleType
from typing import cast

import hydra
import numpy as np
import torch
from rich.console import Console
from rich.table import Table
from tensordict import TensorDictBase
from torch import Tensor
from torchrl.collectors import Collector as PlainCollector
from torchrl.envs import EnvBase, GymEnv, ParallelEnv

from dr_lab.cli.arguments import compose_arguments
from dr_lab.cli.compose import HYDRA_VERSION, prepare
from dr_lab.cli.folders import shipped
from dr_lab.collectors.collector import Collector, Policy
from dr_lab.collectors.lean import LeanCollector
from dr_lab.collectors.torchrl import Acting, TorchRLCollector
from dr_lab.envs.gymnasium_model import load
from dr_lab.envs.setting import Setting
from dr_lab.networks.gaussian_actor import GaussianActor
from dr_lab.networks.normaliser import NoNormaliser
from dr_lab.physics.context import ContextSpace
from dr_lab.randomizers.uniform import UniformRandomizer
from dr_lab.training.run_state import RunState
from dr_lab.trajectory import Array

Arm = Callable[[], int]
"""Collects for a while and says how many control steps."""

PEERS = {"hopper": "Hopper-v5", "half_cheetah": "HalfCheetah-v5", "ant_without_contacts": "Ant-v5"}
SIZES = {"hopper": ("torso.size", 0.03, 0.07), "half_cheetah": ("torso.size", 0.03, 0.07)}  # m
WORKERS = 8
SPREAD = (0.8, 1.25)  # of every drawn value about its nominal


def setting(name: str, *overrides: str) -> Setting:
    """What ``env=<name>`` describes."""
    folder = shipped()
    prepare((folder,))
    with hydra.initialize_config_dir(version_base=HYDRA_VERSION, config_dir=str(folder)):
        cfg = hydra.compose(overrides=[f"+env={name}", *overrides])
    return hydra.utils.instantiate(cfg.env, _convert_="all")


def everything(plain: Setting) -> Setting:
    """The setting with mass, friction and damping of all that has any as parameters."""
    compiled = plain.model.nominal()
    spec = plain.model.spec
    values = {f"body.{body.name}.mass": float(compiled.body(body.name).mass[0]) for body in spec.bodies[1:]}
    values |= {f"geom.{geom.name}.friction[0]": float(geom.friction[0]) for geom in spec.geoms}
    values |= {f"joint.{joint.name}.damping": float(np.ravel(joint.damping)[0]) for joint in spec.joints}
    parameters = {
        target: {"target": target, "unit": "SI", "low": SPREAD[0] * value, "high": SPREAD[1] * value}
        for target, value in values.items()
        if value > 0
    }
    return replace(plain, model=load(plain.model.name, parameters))


def uniform(space: ContextSpace) -> UniformRandomizer:
    """Uniform over the bounds."""
    return UniformRandomizer(space, {})


def limit(of: Setting, policy: Policy, slots: int, steps: int, threads: int) -> Arm:
    """The physics alone, of a batch of this policy."""
    env = of.make(uniform(of.space), slots, 0, threads)
    simulator, states = env.episodes.simulator, list[Array]()

    def watched(observation: Tensor) -> Tensor:
        states.append(simulator.batch.state.copy())
        return policy(observation)

    batch = next(LeanCollector(env, watched, steps))
    taken, done = (
        cast(Tensor, batch[key]).transpose(0, 1).contiguous().numpy() for key in ("action", ("next", "done"))
    )
    actions = taken.clip(env.episodes.low, env.episodes.high)
    begun = [np.arange(slots), *(np.flatnonzero(each) for each in done[:-1])]

    def run() -> int:
        for state, action, rows in zip(states, actions, begun, strict=True):
            if len(rows):
                simulator.batch.state[rows] = state[rows]
            simulator.step(action, of.task.frame_skip)
        return steps * slots

    return run


def gathered(collector: Collector) -> Arm:
    """One batch of a collector."""
    return lambda: next(collector).numel()


def untrained(of: Setting) -> Policy:
    """A policy as it is at first."""
    episodes = of.make(None, 1, 0, 1).episodes
    width = episodes.observation.shape[1]
    return GaussianActor(width, episodes.low, episodes.high, 0, NoNormaliser, [64, 64], "tanh", -0.5)


def trained(run: Path) -> Policy:
    """The policy that a run chose, as it explores."""
    recorded = compose_arguments("train", ["++plan.device=cpu"], (shipped(),), recorded=run, only=["plan"])
    algorithm = recorded["plan"].assemble(None).algorithm
    RunState.load(run).restore(algorithm)
    return algorithm.policies["policy"]


def peer(name: str) -> EnvBase:
    """Gymnasium's environment, wrapped by TorchRL; called in a worker process."""
    sys.modules.setdefault("imageio", ModuleType("imageio"))  # imported by gymnasium to write videos
    contacts = {"include_cfrc_ext_in_observation": False, "contact_cost_weight": 0.0} if name.startswith("Ant") else {}
    return GymEnv(name, **contacts)


def plain(name: str, policy: Policy, frames: int, stack: ExitStack) -> Arm:
    """TorchRL's collector on its own environments."""
    environments = ParallelEnv(WORKERS, partial(peer, PEERS[name]))
    collector = PlainCollector(
        environments, Acting(lambda observation: policy(observation.float())), frames_per_batch=frames, total_frames=-1
    )
    stack.callback(collector.shutdown)
    batches: Iterator[TensorDictBase] = iter(collector)
    return lambda: next(batches).numel()


def arms_of(name: str, options: argparse.Namespace, stack: ExitStack) -> dict[str, Arm]:
    """The arms by name."""
    slots, steps, threads = options.slots, options.steps, options.threads
    fields = everything(setting(name))
    policy = untrained(fields) if options.trained is None else trained(options.trained)

    def environment(of: Setting) -> Collector:
        return LeanCollector(of.make(uniform(of.space), slots, 0, threads), policy, steps)

    default = TorchRLCollector(fields.make(uniform(fields.space), slots, 0, threads), policy, steps)
    stack.callback(default.close)
    arms = {"limit": limit(fields, policy, slots, steps, threads), "lean": gathered(environment(fields))}
    arms["torchrl"] = gathered(default)
    if name in SIZES:
        sized = setting(name, f"env/context={name}/torso_size")
        size, low, high = SIZES[name]
        drawn = UniformRandomizer(sized.space, {size: (low, high)})
        arms["compiled"] = gathered(LeanCollector(sized.make(drawn, slots, 0, threads), policy, steps))
    if not options.alone:
        arms["gymnasium"] = plain(name, policy, WORKERS * steps, stack)
    return arms


def rate(arm: Arm, seconds: float) -> float:
    """Control steps per second over at least so long."""
    count, begin = 0, time.perf_counter()
    while (spent := time.perf_counter() - begin) < seconds or not count:
        count += arm()
    return count / spent


def measured(name: str, options: argparse.Namespace) -> dict[str, list[float]]:
    """Rates of every arm in every round."""
    with ExitStack() as stack:
        arms = arms_of(name, options, stack)
        for arm in arms.values():
            arm()
        rates: dict[str, list[float]] = {arm: [] for arm in arms}
        for _ in range(options.rounds):
            for label, arm in arms.items():
                rates[label].append(rate(arm, options.seconds))
    return rates


def ratio(rates: dict[str, list[float]], over: str, under: str) -> float | None:
    """Median over the rounds of the ratio of two arms, or None where one is missing."""
    if over not in rates or under not in rates:
        return None
    return statistics.median(a / b for a, b in zip(rates[over], rates[under], strict=True))


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure, print a table, and as the last line one JSON object."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--machines", default=",".join(PEERS), help="comma-separated, of " + ", ".join(PEERS))
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--seconds", type=float, default=4.0, help="of every arm in every round")
    parser.add_argument("--slots", type=int, default=128, help="episodes side by side in our arms")
    parser.add_argument("--steps", type=int, default=64, help="control steps of each in a batch")
    parser.add_argument("--threads", type=int, default=len(os.sched_getaffinity(0)))
    parser.add_argument("--alone", action="store_true", help="without gymnasium's arm")
    parser.add_argument("--trained", type=Path, help="folder of a training run on the machine, whose policy acts")
    options = parser.parse_args(arguments)
    torch.set_num_threads(1)
    figures = {name: measured(name, options) for name in options.machines.split(",")}
    table = Table("machine", "arm", "steps/s", "of the limit", "× gymnasium")
    text = lambda value: "–" if value is None else f"{value:.2f}"  # noqa: E731
    for name, rates in figures.items():
        for arm, values in rates.items():
            shares = (ratio(rates, arm, "limit"), ratio(rates, arm, "gymnasium"))
            table.add_row(name, arm, f"{statistics.median(values):,.0f}", *map(text, shares))
    Console().print(table)
    result = {
        name: {
            "steps_per_second": {arm: statistics.median(values) for arm, values in rates.items()},
            "of_limit": {arm: ratio(rates, arm, "limit") for arm in rates},
            "times_gymnasium": {arm: ratio(rates, arm, "gymnasium") for arm in rates},
        }
        for name, rates in figures.items()
    }
    print(json.dumps({"slots": options.slots, "threads": options.threads, "rounds": options.rounds, **result}))


if __name__ == "__main__":
    main()
