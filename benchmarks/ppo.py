"""PPO on Hopper-v5: time and final return, beside stable-baselines3.

Every run is a process of its own; the arms take turns, seed after seed, so that all meet the same load of the machine.
Beside the wall time stands the CPU time of all threads, which other work on the machine hardly changes. Finished runs
are kept in a file, and the same command goes on where it was interrupted. The final policy plays its most likely
actions in gymnasium's environment.

sb3      stable-baselines3's PPO, its defaults, 8 environments; needs `pip install stable-baselines3`
matched  dr_lab, algorithm=ppo_sb3: the same settings
tuned    dr_lab, algorithm=ppo

    python benchmarks/ppo.py
    python benchmarks/ppo.py --arms tuned --seeds 0,1 --frames 200000 --results outputs/short.jsonl
"""

import argparse
import json
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from contextlib import closing
from pathlib import Path
from types import ModuleType

import numpy as np
import torch
from hydra.utils import instantiate
from rich.console import Console
from rich.table import Table

from dr_lab.cli.compose import compose
from dr_lab.evaluators.statistics import iqm_interval
from dr_lab.training.plan import Plan
from dr_lab.trajectory import Array

TASK = "Hopper-v5"
OURS = {"matched": ["algorithm=ppo_sb3", "episodes=8"], "tuned": ["algorithm=ppo"]}
SLOTS = 8  # environments of stable-baselines3
PLAYED = 20  # episodes of the final policy
CONFIDENCE, RESAMPLES = 0.95, 2000
CLOCKS = ("seconds", "cpu")  # of the wall, of all threads

Act = Callable[[Array], Array]
"""Action for one observation."""


def clocks() -> Array:
    """Wall and CPU time in s."""
    return np.array([time.perf_counter(), time.process_time()])


def train_ours(arm: str, seed: int, frames: int) -> tuple[Array, Act]:
    """Wall and CPU seconds of training with dr_lab, and the policy."""
    overrides = ["env=hopper", "randomizer=fixed", f"seed={seed}", f"frames={frames}", *OURS[arm]]
    plan: Plan = instantiate(compose("train", overrides).plan, _convert_="all")
    with tempfile.TemporaryDirectory() as folder:
        training = plan.assemble(Path(folder) / "checkpoint.pt")
        begin = clocks()
        with closing(training.trainer):
            training.trainer.run(frames, lambda figures, finished: None)
        spent = clocks() - begin
    policy = training.algorithm.deployed

    def act(observation: Array) -> Array:
        with torch.no_grad():
            return policy(torch.from_numpy(observation.astype(np.float32))[None]).numpy()[0]

    return spent, act


def train_theirs(seed: int, frames: int) -> tuple[Array, Act]:
    """Wall and CPU seconds of training with stable-baselines3, and the policy."""
    from stable_baselines3 import PPO  # pyright: ignore[reportMissingImports] # noqa: PLC0415 (not of this project)
    from stable_baselines3.common.env_util import (  # pyright: ignore[reportMissingImports] # noqa: PLC0415
        make_vec_env,
    )

    model = PPO("MlpPolicy", make_vec_env(TASK, SLOTS, seed=seed), seed=seed, device="cpu")
    begin = clocks()
    model.learn(frames)
    spent = clocks() - begin
    return spent, lambda observation: model.predict(observation, deterministic=True)[0]


def play(act: Act, seed: int) -> list[float]:
    """Returns of episodes in gymnasium's environment."""
    import gymnasium  # noqa: PLC0415 (what it imports is pretended in this process alone)

    env, returns = gymnasium.make(TASK), []
    for episode in range(PLAYED):
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
    (seconds, cpu), act = train_theirs(seed, frames) if arm == "sb3" else train_ours(arm, seed, frames)
    row = {"arm": arm, "seed": seed, "frames": frames, "seconds": seconds, "cpu": cpu, "returns": play(act, seed)}
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
        Console().print(f"{arm} seed {seed}: {row['seconds']:.0f} s, return {np.mean(row['returns']):.0f}")
    return [found[arm, seed, options.frames] for arm, seed in wanted]


def summary(rows: Sequence[dict[str, object]], arm: str) -> dict[str, float]:
    """Median wall and CPU seconds, and the interquartile mean over the seeds' mean returns."""
    own = [row for row in rows if row["arm"] == arm]
    returns = np.array([np.asarray(row["returns"], float).mean() for row in own], float)
    found = iqm_interval(returns, CONFIDENCE, RESAMPLES, 0)
    spent = {clock: statistics.median(float(str(row[clock])) for row in own) for clock in CLOCKS}
    return {**spent, "return": found.value, "low": found.low, "high": found.high, "worst": returns.min()}


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
    table = Table("arm", "wall s", "× faster", "CPU s", "× less", "return (IQM)", "interval", "worst seed")
    for arm, each in figures.items():
        ratios = {clock: f"{figures['sb3'][clock] / each[clock]:.2f}" if "sb3" in figures else "–" for clock in CLOCKS}
        times = [text for clock in CLOCKS for text in (f"{each[clock]:.0f}", ratios[clock])]
        interval = f"{each['low']:.0f} … {each['high']:.0f}"
        table.add_row(arm, *times, f"{each['return']:.0f}", interval, f"{each['worst']:.0f}")
    Console().print(table)
    print(json.dumps({"seeds": options.seeds, "frames": options.frames, **figures}))


if __name__ == "__main__":
    main()
