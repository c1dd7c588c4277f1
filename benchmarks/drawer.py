"""How fast does the drawer's arm step, and on how many targets does a run's policy open the drawer?

    python benchmarks/drawer.py speed
    python benchmarks/drawer.py success --run FOLDER --offsets 0,0.15,0.22

speed    whole episodes side by side under random actions, seconds of each round by the clock and of the cores
success  every policy that the run kept, from some starts with the cabinet moved aside: share of episodes at whose end
         the drawer is open, and the mean opening
"""

import argparse
import json
import statistics
import time
from collections.abc import Sequence
from functools import partial
from pathlib import Path

import numpy as np
import torch
from collect import setting
from rich.console import Console
from rich.table import Table

from dr_lab.cli.arguments import compose_arguments
from dr_lab.cli.folders import shipped
from dr_lab.collectors.play import play
from dr_lab.envs.episodes import Episodes
from dr_lab.evaluators.trained_run import subject_of

PARAMETER, JOINT = "cabinet.lateral", 9  # the context's name; column of the drawer in the positions
OPEN = 0.2  # m


def seconds(episodes: Episodes, rng: np.random.Generator) -> tuple[float, float]:
    """Time of one whole episode of all, by the clock and of all threads."""
    episodes.begin(np.arange(episodes.nsim))
    clock, cores = time.perf_counter(), time.process_time()
    for _ in range(episodes.task.time_limit):
        episodes.step(rng.uniform(episodes.low, episodes.high, (episodes.nsim, len(episodes.low))))
    return time.perf_counter() - clock, time.process_time() - cores


def speed(samples: int, rounds: int, threads: int | None) -> None:
    """Measure and print."""
    made = setting("drawer", "env/context=[drawer/cabinet]").make(None, samples, 0, threads)
    rng = np.random.default_rng(0)
    clock, cores = zip(*(seconds(made.episodes, rng) for _ in range(rounds)), strict=True)
    print(f"{samples} samples: median {statistics.median(clock):.2f} s, of the cores {statistics.median(cores):.2f} s")
    print(json.dumps({"samples": samples, "clock": clock, "cores": cores}))


def success(run: Path, offsets: Sequence[float], count: int, seed: int) -> None:
    """Play, and print a table."""
    torch.set_num_threads(1)
    subject = subject_of(run, partial(compose_arguments, folders=(shipped(),)), 1)
    slots, space = subject.slots(count, seed), subject.setting.space
    table = Table(
        "control steps",
        *(f"{offset:g} m" for offset in offsets),
        title="share of episodes with an open drawer, mean opening [m]",
    )
    found = dict[int, list[float]]()
    for snapshot in subject.kept():
        opened = []
        for offset in offsets:
            played = play(slots, snapshot.deployed, np.tile(space.vector({PARAMETER: offset}), (count, 1)))
            opened.append(played["next", "qpos"][:, -1, JOINT].numpy())  # pyright: ignore[reportAttributeAccessIssue]
        found[snapshot.frames] = [float(np.mean(each >= OPEN)) for each in opened]
        table.add_row(str(snapshot.frames), *(f"{np.mean(each >= OPEN):.2f}, {each.mean():.3f}" for each in opened))
    Console().print(table)
    print(json.dumps({"run": str(run), "offsets": offsets, "open": found}))


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure what is asked for."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=("speed", "success"))
    parser.add_argument("--samples", type=int, default=480, help="speed: episodes side by side")
    parser.add_argument("--rounds", type=int, default=5, help="speed: episodes, one after the other")
    parser.add_argument("--threads", type=int, help="speed: C threads; all cores unless given")
    parser.add_argument("--run", type=Path, help="success: folder of a training run")
    parser.add_argument("--offsets", default="0,0.15,0.22", help="success: of the cabinet, m, comma-separated")
    parser.add_argument("--episodes", type=int, default=20, help="success: of each policy at each offset")
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args(arguments)
    if options.what == "speed":
        speed(options.samples, options.rounds, options.threads)
    elif options.run is None:
        parser.error("success needs --run FOLDER of a training run")
    else:
        success(options.run, [float(each) for each in options.offsets.split(",")], options.episodes, options.seed)


if __name__ == "__main__":
    main()
