"""When does it pay to learn on a device?

    python benchmarks/device.py
    python benchmarks/device.py --devices cpu cuda --threads 1 2 16 --cases ppo ddpg

For each case and device the median seconds of an iteration, and of the part of it in which the policy learns: all but
the collection of experience, moving the batch included. `threads` are torch's on the CPU; `dr-lab train` has it use 1.
The first iteration is left out. The second table says how long one step of acting takes for 64 episodes: by a network
on the CPU, and across the boundary, where observations go to the device and actions come back.
"""

import argparse
import json
import statistics
import time
from collections.abc import Sequence
from typing import Any

import torch
from rich.console import Console
from rich.table import Table
from tensordict import TensorDict

from dr_lab.cli.arguments import compose_arguments
from dr_lab.cli.folders import shipped
from dr_lab.collectors.collector import Collector
from dr_lab.networks.gaussian_actor import GaussianActor
from dr_lab.networks.normaliser import RunningNormaliser
from dr_lab.training.plan import Plan

HOPPER = ["env=hopper", "collector=lean"]
DOMAINS = ["env=cartpole_domains", "randomizer=didor/cartpole", "collector=lean", "algorithm=didor"]
DIDOR = [*DOMAINS, "algorithm.teachers.count=8"]
CASES = {
    "ppo": [*HOPPER, "algorithm=ppo"],
    "ppo_256": [*HOPPER, "algorithm=ppo", "algorithm.actor.hidden=[256,256]", "algorithm.critic.hidden=[256,256]"],
    "ppo_1024": [*HOPPER, "algorithm=ppo", "algorithm.actor.hidden=[1024,1024]", "algorithm.critic.hidden=[1024,1024]"],
    "ppo_256_wide": [
        *[*HOPPER, "algorithm=ppo", "algorithm.actor.hidden=[256,256]", "algorithm.critic.hidden=[256,256]"],
        *["episodes=1024", "algorithm.batch_frames=65536", "algorithm.minibatch=16384"],
    ],
    "ddpg": [*HOPPER, "algorithm=ddpg", "algorithm.learning_starts=0"],
    "ddpg_4096": [*HOPPER, "algorithm=ddpg", "algorithm.learning_starts=0", "algorithm.minibatch=4096"],
    "didor_teachers": DIDOR,
    "didor_student": [*DIDOR, "algorithm.teacher_frames=1"],
    "maml": ["experiment=maml_nav2d"],
}
ITERATIONS = {"ddpg": 20, "ddpg_4096": 5}  # that are measured; of the others as many as `--iterations`
WIDTHS = {"64": [64, 64], "256": [256, 256], "1024": [1024, 1024]}  # of the networks that act


class Watched:
    """A collector that adds up the time it takes."""

    def __init__(self, collector: Collector) -> None:
        self.seconds, self._collector = 0.0, collector
        self.begin, self.close = collector.begin, collector.close

    def __next__(self) -> TensorDict:
        """The next batch."""
        begin = time.perf_counter()
        batch = next(self._collector)
        self.seconds += time.perf_counter() - begin
        return batch


def measured(case: str, device: str, threads: int, iterations: int) -> dict[str, Any]:
    """Seconds of an iteration and of its learning, and the memory that this took on the device [MiB]."""
    torch.set_num_threads(threads)
    if device != "cpu":
        torch.cuda.reset_peak_memory_stats()
    plan: Plan = compose_arguments("train", [*CASES[case], f"device={device}"], (shipped(),), only=["plan"])["plan"]
    training = plan.assemble(None)
    experience: Any = training.experience
    experience._collector = collecting = Watched(experience._collector)
    whole, learning = list[float](), list[float]()
    for _ in range(1 + ITERATIONS.get(case, iterations)):
        collecting.seconds, begin = 0.0, time.perf_counter()
        training.algorithm.iterate(experience)
        if device != "cpu":
            torch.cuda.synchronize()
        whole.append(time.perf_counter() - begin)
        learning.append(whole[-1] - collecting.seconds)
    training.trainer.close()
    memory = 0 if device == "cpu" else torch.cuda.max_memory_allocated() >> 20
    return {
        **{"case": case, "device": device, "threads": threads, "MiB": memory},
        **{"iteration": statistics.median(whole[1:]), "learning": statistics.median(learning[1:])},
    }


def acting(width: str, device: str, steps: int = 200) -> dict[str, Any]:
    """Seconds of one step of acting for 64 episodes of Hopper."""
    torch.set_num_threads(1)
    low = torch.full((3,), -1.0).numpy()
    actor = GaussianActor(11, low, -low, 0, lambda size: RunningNormaliser(size, 10.0), WIDTHS[width], "tanh", 0.0)
    actor, observation, noise = actor.to(device), torch.randn(64, 11), torch.randn(64, 3)
    taken = list[float]()
    for _ in range(steps):
        begin = time.perf_counter()
        actor.act(observation.to(device), noise.to(device)).cpu()
        taken.append(time.perf_counter() - begin)
    return {"width": width, "device": device, "acting": statistics.median(taken)}


def shown(title: str, rows: Sequence[dict[str, Any]]) -> Table:
    """Rows as a table, seconds in milliseconds."""
    table = Table(title=title)
    for name in rows[0]:
        table.add_column(name, justify="right")
    for row in rows:
        cells = (f"{1000 * value:.2f} ms" if isinstance(value, float) else str(value) for value in row.values())
        table.add_row(*cells)
    return table


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure, print two tables, and as the last line one JSON object."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    present = ["cpu", "cuda"] if torch.cuda.is_available() else ["cpu"]
    parser.add_argument("--devices", nargs="+", default=present)
    parser.add_argument("--threads", nargs="+", type=int, default=[1, 2], help="torch's on the CPU")
    parser.add_argument("--cases", nargs="+", default=list(CASES), choices=list(CASES))
    parser.add_argument("--iterations", type=int, default=5)
    options = parser.parse_args(arguments)
    learnt = list[dict[str, Any]]()
    for case in options.cases:
        for device in options.devices:
            for threads in options.threads if device == "cpu" else [1]:
                learnt.append(measured(case, device, threads, options.iterations))
                print(json.dumps(learnt[-1]), flush=True)
    acted = [acting(width, device) for width in WIDTHS for device in options.devices]
    Console(width=120).print(shown("Learning", learnt), shown("Acting, one step of 64 episodes", acted))
    print(json.dumps({"learning": learnt, "acting": acted}))


if __name__ == "__main__":
    main()
