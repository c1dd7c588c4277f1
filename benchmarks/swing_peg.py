"""How fast are samples of SimOpt's swing-peg task simulated? Whole episodes of 150 control steps, a context each.

    python benchmarks/swing_peg.py
    python benchmarks/swing_peg.py --samples 480 --rounds 3 --threads 1

nominal   the same context in all episodes, and still arms
fields    31 parameters of joints, rope, peg and hole, drawn for each episode and written as fields
compiled  the peg's radius besides, for which each context is compiled

Velocities of ±1 at random act in the latter two, so that arms, ropes and pegs touch what they can. The arms take turns;
figures are medians over the rounds.
"""

import argparse
import json
import os
import statistics
import sys
import time
from collections.abc import Callable, Sequence

import hydra
import numpy as np
from rich.console import Console
from rich.table import Table

from dr_lab.cli.compose import HYDRA_VERSION, prepare
from dr_lab.cli.folders import shipped
from dr_lab.envs.setting import Setting

PARTS = tuple(f"swing_peg/{part}" for part in ("joints", "action_scaling", "rope", "rope_twist", "peg"))
INNER = (0.3, 0.7)  # of the bounds, from which contexts are drawn


def setting(*contexts: str) -> Setting:
    """The environment with these options of ``env/context``."""
    folder = shipped()
    prepare((folder,))
    with hydra.initialize_config_dir(version_base=HYDRA_VERSION, config_dir=str(folder)):
        cfg = hydra.compose(overrides=["+env=swing_peg", f"env/context=[{','.join(contexts) or 'none'}]"])
    return hydra.utils.instantiate(cfg.env, _convert_="all")


def episodes_of(of: Setting, samples: int, threads: int, amplitude: float) -> Callable[[], int]:
    """Plays one episode in each of so many contexts and says how many were infeasible."""
    episodes, rng = of.make(None, samples, 0, threads).episodes, np.random.default_rng(0)

    def run() -> int:
        episodes.give_contexts(of.space.from_unit(rng.uniform(*INNER, (samples, len(of.space.names)))))
        episodes.begin(np.arange(samples))
        before = episodes.infeasible
        for _ in range(of.time_limit):
            episodes.step(amplitude * rng.uniform(episodes.low, episodes.high, (samples, 7)))
        return episodes.infeasible - before

    return run


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure, print a table, and as the last line one JSON object."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--samples", type=int, default=480, help="episodes side by side")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--threads", type=int, default=len(os.sched_getaffinity(0)))
    options = parser.parse_args(arguments)
    arms = {
        "nominal": episodes_of(setting(), options.samples, options.threads, 0.0),
        "fields": episodes_of(setting(*PARTS), options.samples, options.threads, 1.0),
        "compiled": episodes_of(setting(*PARTS, "swing_peg/peg_radius"), options.samples, options.threads, 1.0),
    }
    seconds, infeasible = ({name: list[float]() for name in arms} for _ in range(2))
    for _ in range(options.rounds):
        for name, arm in arms.items():
            begin = time.perf_counter()
            infeasible[name].append(arm() / options.samples)
            seconds[name].append(time.perf_counter() - begin)
    table = Table("arm", "s", "samples / s", "infeasible", title=f"{options.samples} samples of 150 control steps")
    figures = {name: statistics.median(values) for name, values in seconds.items()}
    for name, value in figures.items():
        rate, failed = options.samples / value, statistics.mean(infeasible[name])
        table.add_row(name, f"{value:.2f}", f"{rate:.1f}", f"{100 * failed:.1f} %")
    Console().print(table)
    rates = {name: options.samples / value for name, value in figures.items()}
    result = {"samples": options.samples, "threads": options.threads, "seconds": figures, "samples_per_second": rates}
    print(json.dumps(result | {"infeasible": {name: statistics.mean(each) for name, each in infeasible.items()}}))


if __name__ == "__main__":
    sys.exit(main())
