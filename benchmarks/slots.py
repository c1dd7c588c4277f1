"""What do many policies cost that act at once? N policies on the slots of one, beside the one and beside N by turns.

    python benchmarks/slots.py
    python benchmarks/slots.py --policies 4,16,64 --slots 128

one       one policy's pass over all slots: normaliser, network, noise
stacked   the same slots shared by N policies: `dr_lab.networks.policy_stack`
by turns  N policies, one after the other, each on its share

The arms take turns, round after round; times are medians over the rounds, ratios are taken within a round.
"""

import argparse
import json
import statistics
import time
from collections.abc import Callable, Sequence
from functools import partial

import numpy as np
import torch
from rich.console import Console
from rich.table import Table

from dr_lab.networks.gaussian_actor import GaussianActor
from dr_lab.networks.normaliser import RunningNormaliser
from dr_lab.networks.policy_stack import GaussianPolicyStack

OBSERVATION, ACTION = 11, 3  # Hopper
PASSES = 50  # of an arm in a round


def actor(seed: int) -> GaussianActor:
    """A policy with two hidden layers of 64."""
    bound = np.ones(ACTION)
    normaliser = partial(RunningNormaliser, clip=10.0)
    return GaussianActor(OBSERVATION, -bound, bound, seed, normaliser, [64, 64], "tanh", log_std=-0.5)


def arms_of(count: int, slots: int) -> dict[str, Callable[[], object]]:
    """The arms by name."""
    policies = [actor(seed) for seed in range(count)]
    stack = GaussianPolicyStack(policies)
    observation = torch.randn(slots, OBSERVATION, generator=torch.Generator().manual_seed(0))
    shares = observation.split(slots // count)
    return {
        "one": lambda: policies[0](observation),
        "stacked": lambda: stack(observation),
        "by turns": lambda: [policy(share) for policy, share in zip(policies, shares, strict=True)],
    }


def microseconds(arm: Callable[[], object]) -> float:
    """Time of one pass."""
    begin = time.perf_counter()
    for _ in range(PASSES):
        arm()
    return 1e6 * (time.perf_counter() - begin) / PASSES


def measured(count: int, slots: int, rounds: int) -> dict[str, float]:
    """Medians of the arms' times in µs, and of their ratios to one policy's."""
    arms = arms_of(count, slots)
    for arm in arms.values():
        microseconds(arm)
    times = [{name: microseconds(arm) for name, arm in arms.items()} for _ in range(rounds)]
    figures = {f"{name} [µs]": statistics.median(each[name] for each in times) for name in arms}
    ratios = {name: statistics.median(each[name] / each["one"] for each in times) for name in arms if name != "one"}
    return figures | {f"{name} / one": value for name, value in ratios.items()}


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure, print a table, and as the last line one JSON object."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--policies", default="1,4,16,64", help="comma-separated numbers of policies")
    parser.add_argument("--slots", type=int, default=128, help="episodes side by side")
    parser.add_argument("--rounds", type=int, default=41)
    options = parser.parse_args(arguments)
    torch.set_num_threads(1)
    counts = [int(count) for count in options.policies.split(",")]
    with torch.no_grad():
        figures = {count: measured(count, options.slots, options.rounds) for count in counts}
    table = Table("policies", *next(iter(figures.values())))
    for count, row in figures.items():
        table.add_row(str(count), *(f"{value:.2f}" if "/" in name else f"{value:.0f}" for name, value in row.items()))
    Console().print(table)
    print(json.dumps({"slots": options.slots, "rounds": options.rounds, "policies": figures}, ensure_ascii=False))


if __name__ == "__main__":
    main()
