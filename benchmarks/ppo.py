"""PPO on Hopper-v5: time and final return, beside stable-baselines3.

Every run is a process of its own; the arms take turns, seed after seed, so that all meet the same load of the machine.
Beside the wall time stands the CPU time of all threads, which other work on the machine hardly changes. Finished runs
are kept in a file, and the same command goes on where it was interrupted. All policies play in gymnasium's environment:
the final one its most likely actions; those at the last ten checkpoints, which lie 40 960 control steps apart, their
most likely actions and actions that they draw.

sb3      stable-baselines3's PPO, its defaults, 8 environments; needs `pip install stable-baselines3`
matched  dr_lab, algorithm=ppo_sb3: the same settings
tuned    dr_lab, algorithm=ppo

    python benchmarks/ppo.py
    python benchmarks/ppo.py --arms tuned --seeds 0,1 --frames 200000 --results outputs/short.jsonl
"""

import argparse
import copy
import json
import statistics
import subprocess
import sys
import tempfile
import time
from collections import deque
from collections.abc import Callable, Sequence
from contextlib import closing
from pathlib import Path
from types import ModuleType
from typing import NamedTuple

import numpy as np
import torch
from hydra.utils import instantiate
from rich.console import Console
from rich.table import Table

from dr_lab.cli.compose import compose
from dr_lab.collectors.collector import Policy
from dr_lab.evaluators.statistics import iqm_interval
from dr_lab.training.plan import Plan
from dr_lab.training.policy_snapshots import PolicySnapshots
from dr_lab.trajectory import Array

TASK = "Hopper-v5"
OURS = {"matched": ["algorithm=ppo_sb3", "episodes=8"], "tuned": ["algorithm=ppo"]}
SLOTS = 8  # environments of stable-baselines3
PLAYED = 20  # episodes of the final policy
KEPT, EACH = 10, 5  # checkpoints that are played, and episodes of each, with and without exploration
EVERY = 40_960  # control steps between two checkpoints, as conf/train.yaml has it
LOW = 2000.0  # return of a seed that failed
CONFIDENCE, RESAMPLES = 0.95, 2000
CLOCKS = ("seconds", "cpu")  # of the wall, of all threads
LAST = ("last deterministic", "last stochastic")  # returns at the last checkpoints, without exploration and with it
RETURNS = ("final", *LAST)  # of the final policy, and these

Act = Callable[[Array], Array]
"""Action for one observation."""


class Trained(NamedTuple):
    """What a run leads to.

    Attributes:
        spent: wall and CPU seconds of the training.
        final: the last policy, without exploration.
        kept: policies at the last checkpoints, without exploration and with it.
    """

    spent: Array
    final: Act
    kept: list[tuple[Act, Act]]


def clocks() -> Array:
    """Wall and CPU time in s."""
    return np.array([time.perf_counter(), time.process_time()])


def train_ours(arm: str, seed: int, frames: int) -> Trained:
    """Train with dr_lab."""
    overrides = ["env=hopper", "randomizer=fixed", f"seed={seed}", f"frames={frames}", *OURS[arm]]
    plan: Plan = instantiate(compose("train", [*overrides, f"checkpoint_every={EVERY}"]).plan, _convert_="all")
    with tempfile.TemporaryDirectory() as folder:
        training = plan.assemble(Path(folder) / "checkpoint.pt")
        snapshots = PolicySnapshots(training.algorithm, KEPT)

        def watch(figures: object, finished: object) -> None:
            del figures, finished
            if training.trainer.due or training.trainer.frames >= frames:
                snapshots.take(training.trainer.frames)

        begin = clocks()
        with closing(training.trainer):
            training.trainer.run(frames, watch)
        spent = clocks() - begin
    kept = [(acting(each.deployed), acting(each.exploring)) for each in snapshots.restored()]
    return Trained(spent, kept[-1][0], kept)


def acting(policy: Policy) -> Act:
    """What a policy of dr_lab does."""

    def act(observation: Array) -> Array:
        with torch.no_grad():
            return policy(torch.from_numpy(observation.astype(np.float32))[None]).numpy()[0]

    return act


def train_theirs(seed: int, frames: int) -> Trained:
    """Train with stable-baselines3."""
    from stable_baselines3 import PPO  # pyright: ignore[reportMissingImports] # noqa: PLC0415 (not of this project)
    from stable_baselines3.common.callbacks import (  # pyright: ignore[reportMissingImports] # noqa: PLC0415
        ConvertCallback,
        EveryNTimesteps,
    )
    from stable_baselines3.common.env_util import (  # pyright: ignore[reportMissingImports] # noqa: PLC0415
        make_vec_env,
    )

    def made() -> PPO:
        return PPO("MlpPolicy", make_vec_env(TASK, SLOTS, seed=seed), seed=seed, device="cpu")

    model, states = made(), deque[dict[str, torch.Tensor]](maxlen=KEPT)

    def keep(local_names: dict[str, object], global_names: dict[str, object]) -> bool:
        del local_names, global_names
        states.append(copy.deepcopy(model.policy.state_dict()))
        return True

    begin = clocks()
    model.learn(frames, EveryNTimesteps(EVERY, ConvertCallback(keep)))
    spent = clocks() - begin
    keep({}, {})
    kept = list[tuple[Act, Act]]()
    for state in states:
        policy = made().policy
        policy.load_state_dict(state)
        kept.append((predicting(policy.predict, True), predicting(policy.predict, False)))
    return Trained(spent, kept[-1][0], kept)


def predicting(predict: Callable[..., tuple[Array, object]], deterministic: bool) -> Act:
    """What a policy of stable-baselines3 does."""
    return lambda observation: predict(observation, deterministic=deterministic)[0]


def play(act: Act, seed: int, episodes: int) -> list[float]:
    """Returns of episodes in gymnasium's environment."""
    import gymnasium  # noqa: PLC0415 (what it imports is pretended in this process alone)

    env, returns = gymnasium.make(TASK), []
    for episode in range(episodes):
        observation, _ = env.reset(seed=1000 * seed + episode)
        total, over = 0.0, False
        while not over:
            observation, reward, terminated, truncated, _ = env.step(np.clip(act(observation), -1.0, 1.0))
            total, over = total + float(reward), terminated or truncated
        returns.append(total)
    return returns


def one(arm: str, seed: int, frames: int) -> None:
    """Train, play, print the result as JSON."""
    sys.modules.setdefault("imageio", ModuleType("imageio"))  # imported by gymnasium to write videos
    torch.set_num_threads(1)  # a second thread helps no arm with networks this small
    trained = train_theirs(seed, frames) if arm == "sb3" else train_ours(arm, seed, frames)
    row = {"arm": arm, "seed": seed, "frames": frames, **dict(zip(CLOCKS, trained.spent, strict=True))}
    row["final"] = play(trained.final, seed, PLAYED)
    means = [[float(np.mean(play(act, seed, EACH))) for act in pair] for pair in trained.kept]
    row |= dict(zip(LAST, zip(*means, strict=True), strict=True))
    print(json.dumps(row))


def collected(options: argparse.Namespace) -> list[dict[str, object]]:
    """The asked runs, those that are missing run now."""
    kept = Path(options.results)
    done = [json.loads(line) for line in kept.read_text().splitlines()] if kept.is_file() else []
    found = {(row["arm"], row["seed"], row["frames"]): row for row in done}
    wanted = [(arm, int(seed)) for seed in options.seeds.split(",") for arm in options.arms.split(",")]
    for arm, seed in wanted:
        if (arm, seed, options.frames) in found:
            continue
        command = [sys.executable, __file__, "--one", arm, "--seeds", str(seed), "--frames", str(options.frames)]
        line = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout.splitlines()[-1]
        with kept.open("a") as file:
            file.write(line + "\n")
        found[arm, seed, options.frames] = row = json.loads(line)
        Console().print(f"{arm} seed {seed}: {row['seconds']:.0f} s, return {np.mean(row['final']):.0f}")
    return [found[arm, seed, options.frames] for arm, seed in wanted]


def summary(rows: Sequence[dict[str, object]], arm: str) -> dict[str, float]:
    """Median wall and CPU seconds, and over the seeds the returns of the final policy and at the last checkpoints.

    Of each kind of return a seed has a mean; of these the interquartile mean, its interval, and the share below `LOW`.
    """
    own = [row for row in rows if row["arm"] == arm]
    found = {clock: statistics.median(float(str(row[clock])) for row in own) for clock in CLOCKS}
    for kind in RETURNS:
        means = np.array([np.asarray(row[kind], float).mean() for row in own], float)
        interval = iqm_interval(means, CONFIDENCE, RESAMPLES, 0)
        found |= {kind: interval.value, f"{kind}.low": interval.low, f"{kind}.high": interval.high}
        found |= {f"{kind}.worst": means.min(), f"{kind}.failed": float((means < LOW).mean())}
    return found


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure, print a table, and as the last line one JSON object."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--arms", default="sb3,matched,tuned")
    parser.add_argument("--seeds", default="0,1,2,3,4")
    parser.add_argument("--frames", type=int, default=1_000_000)
    parser.add_argument("--results", default="outputs/ppo.jsonl", help="where finished runs are kept")
    parser.add_argument("--one", help=argparse.SUPPRESS)
    options = parser.parse_args(arguments)
    if options.one:
        one(options.one, int(options.seeds), options.frames)
        return
    rows = collected(options)
    figures = {arm: summary(rows, arm) for arm in options.arms.split(",")}
    table = Table("arm", "wall s", "× faster", "CPU s", "× less")
    returns = Table("arm", "return", "IQM", "interval", "worst seed", f"seeds below {LOW:.0f}")
    for arm, each in figures.items():
        ratios = {clock: f"{figures['sb3'][clock] / each[clock]:.2f}" if "sb3" in figures else "–" for clock in CLOCKS}
        times = [text for clock in CLOCKS for text in (f"{each[clock]:.0f}", ratios[clock])]
        table.add_row(arm, *times)
        for kind in RETURNS:
            interval = f"{each[f'{kind}.low']:.0f} … {each[f'{kind}.high']:.0f}"
            worst = (f"{each[f'{kind}.worst']:.0f}", f"{each[f'{kind}.failed']:.0%}")
            returns.add_row(arm, kind, f"{each[kind]:.0f}", interval, *worst)
    Console().print(table)
    Console().print(returns)
    print(json.dumps({"seeds": options.seeds, "frames": options.frames, **figures}))


if __name__ == "__main__":
    main()
