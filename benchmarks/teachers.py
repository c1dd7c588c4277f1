"""How long does an iteration of DiDoR's teachers take, side by side and one run after another?

    python benchmarks/teachers.py
    python benchmarks/teachers.py --teachers 8 --share 8 --rounds 5

stacked    all teachers in one batch: `dr_lab.algorithms.teachers.teachers`, `share` slots each, a whole episode in each
alone      a run for each teacher, in as many slots as it has in the stack
wide       a run for each teacher, in as many slots as the whole stack has, and so many fewer control steps in each

Every arm gives each teacher the same number of control steps of the Furuta pendulum and the same update of PPO. The
arms take turns, round after round; ratios are taken within a round. `cpu` is the time of the process, which other work
on the machine disturbs least, `wall` what passed meanwhile.
"""

import argparse
import json
import statistics
import time
from collections.abc import Callable, Sequence
from typing import cast

import torch
from hydra.utils import instantiate
from rich.console import Console
from rich.table import Table

from dr_lab.algorithms.algorithm import Algorithm, Interface
from dr_lab.cli.compose import compose
from dr_lab.collectors.experience import Experience
from dr_lab.collectors.lean import LeanCollector
from dr_lab.envs.environment import Environment
from dr_lab.randomizers.uniform import UniformRandomizer

Arm = Callable[[], object]


def experience(env: Environment, algorithm: Algorithm, slots: int, steps: int) -> Experience:
    """Of an algorithm's policies, in so many slots."""
    collector = LeanCollector(env.make(None, slots, 0), algorithm.collecting, steps)
    played = env.make(None, 8, 1).episodes
    return Experience(collector, algorithm.policies["policy"], played, UniformRandomizer(env.space, {}))


def algorithm(env: Environment, changes: Sequence[str], seed: int) -> Algorithm:
    """As it is configured."""
    episodes = env.make(None, 1, 0).episodes
    make = instantiate(compose("train", changes).algorithm, _convert_="all")
    return make(Interface(episodes.observation.shape[1], episodes.low, episodes.high), seed)


def stacked(env: Environment, teachers: int, share: int) -> Arm:
    """One iteration of all."""
    made = algorithm(
        env, ["algorithm=ensemble", f"algorithm.teachers.count={teachers}", f"episodes={teachers * share}"], 0
    )
    seen = experience(env, made, teachers * share, env.time_limit)
    return lambda: made.iterate(seen)


def one_by_one(env: Environment, teachers: int, slots: int, steps: int) -> Arm:
    """An iteration of each."""
    every = [algorithm(env, ["algorithm=ppo"], seed) for seed in range(teachers)]
    seen = [experience(env, each, slots, steps) for each in every]
    return lambda: [each.update(of.collect()) for each, of in zip(every, seen, strict=True)]


def seconds(arm: Arm) -> tuple[float, float]:
    """CPU and wall time of one iteration."""
    begin = time.process_time(), time.perf_counter()
    arm()
    return time.process_time() - begin[0], time.perf_counter() - begin[1]


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure, print a table, and as the last line one JSON object."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--teachers", type=int, default=8)
    parser.add_argument("--share", type=int, default=8, help="slots of each teacher in the stack")
    parser.add_argument("--rounds", type=int, default=5)
    options = parser.parse_args(arguments)
    torch.set_num_threads(1)
    env = cast(
        Environment, instantiate(compose("train", ["env=furuta", "env.task.time_limit=400"]).env, _convert_="all")
    )
    teachers, share, steps = options.teachers, options.share, env.time_limit
    arms = {
        "stacked": stacked(env, teachers, share),
        "alone": one_by_one(env, teachers, share, steps),
        "wide": one_by_one(env, teachers, teachers * share, steps // teachers),
    }
    for arm in arms.values():
        arm()
    rounds = [{name: seconds(arm) for name, arm in arms.items()} for _ in range(options.rounds)]
    table, figures = Table("arm", "cpu [s]", "wall [s]", "cpu: arm / stacked", "wall: arm / stacked"), {}
    for name in arms:
        own = [statistics.median(each[name][k] for each in rounds) for k in (0, 1)]
        ratio = [statistics.median(each[name][k] / each["stacked"][k] for each in rounds) for k in (0, 1)]
        figures[name] = {"cpu": own[0], "wall": own[1], "cpu_ratio": ratio[0], "wall_ratio": ratio[1]}
        table.add_row(name, *(f"{value:.2f}" for value in (*own, *ratio)))
    Console().print(table)
    print(json.dumps({**vars(options), "arms": figures}))


if __name__ == "__main__":
    main()
