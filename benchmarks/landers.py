"""How fast do lunar landers step, beside gymnasium's `AsyncVectorEnv` of as many?

Both are given the same random actions and begin anew what has ended. The arms take turns, round after round; figures
are medians over the rounds, ratios are taken within a round.

here        `env=lunar_lander` in this process alone
shared      the same, shared with other processes
gymnasium   `AsyncVectorEnv`, a process for each lander

    python benchmarks/landers.py
    python benchmarks/landers.py --slots 16 --rounds 3 --seconds 1
"""

import argparse
import json
import os
import statistics
import sys
from collections.abc import Sequence
from contextlib import closing
from functools import partial

import gymnasium
import numpy as np
from collect import Arm, rate, ratio, setting
from gymnasium.vector import AsyncVectorEnv
from rich.console import Console
from rich.table import Table

STEPS = 64  # control steps of every lander between two looks at the clock


def ours(slots: int, threads: int, actions: np.ndarray) -> Arm:
    """Landers of dr_lab."""
    episodes = setting("lunar_lander").make(None, slots, 0, threads).episodes

    def run() -> int:
        for action in actions:
            done = np.flatnonzero(episodes.step(action).done)
            if len(done):
                episodes.begin(done)
        return STEPS * slots

    return run


def gymnasiums(environments: AsyncVectorEnv, actions: np.ndarray) -> Arm:
    """Landers of gymnasium, which begin anew by themselves."""
    environments.reset(seed=0)

    def run() -> int:
        for action in actions:
            environments.step(action)
        return STEPS * environments.num_envs

    return run


def measured(options: argparse.Namespace) -> dict[str, list[float]]:
    """Control steps per second of every arm in every round."""
    actions = np.random.default_rng(0).uniform(-1.0, 1.0, (STEPS, options.slots, 2)).astype(np.float32)
    make = partial(gymnasium.make, "LunarLander-v3", continuous=True)
    with closing(AsyncVectorEnv([make] * options.slots, context="fork")) as environments:
        arms = {
            "here": ours(options.slots, 1, actions),
            "shared": ours(options.slots, options.threads, actions),
            "gymnasium": gymnasiums(environments, actions),
        }
        for arm in arms.values():
            arm()
        rates: dict[str, list[float]] = {name: [] for name in arms}
        for _ in range(options.rounds):
            for name, arm in arms.items():
                rates[name].append(rate(arm, options.seconds))
    return rates


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure, print a table, and as the last line one JSON object."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--seconds", type=float, default=2.0, help="of every arm in every round")
    parser.add_argument("--slots", type=int, default=64, help="landers side by side")
    parser.add_argument("--threads", type=int, default=len(os.sched_getaffinity(0)), help="processes of the second arm")
    options = parser.parse_args(arguments)
    rates = measured(options)
    figures = {name: statistics.median(values) for name, values in rates.items()}
    ratios = {name: ratio(rates, name, "gymnasium") for name in ("here", "shared")}
    table = Table("arm", "control steps / s", "of gymnasium's", title=f"{options.slots} lunar landers")
    for name, value in figures.items():
        table.add_row(name, f"{value:.0f}", f"{ratios.get(name) or 1.0:.2f}")
    Console().print(table)
    print(json.dumps({"slots": options.slots, "threads": options.threads, "rates": figures, "ratios": ratios}))


if __name__ == "__main__":
    sys.exit(main())
