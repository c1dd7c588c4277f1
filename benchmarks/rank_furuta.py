"""How long does the ranking of 14 candidates take on the demo's logs, and what takes the time?

The candidates are those of `dr-lab diagnose model=furuta measurements=furuta`, dealt out in rounds: every effect of
the catalogue at its first site, then at its second, and so on, up to `--count`. So 14 of them hold every effect once,
the slowest included, and the first effect in the alphabet with a second site. The calibration that precedes the
ranking is timed beside it. CPU times of a candidate are those of the thread that fits it; simulation is what
`mujoco.batch.Batch.rollout` takes of them, the rest is compiling models, reading samples, solving, and for effects
that act through laws the simulation as well.

    python benchmarks/rank_furuta.py
    python benchmarks/rank_furuta.py --count 22
    python benchmarks/rank_furuta.py --effects coulomb_friction,stribeck_friction
"""

import argparse
import json
import os
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from itertools import chain, zip_longest
from threading import local
from typing import Any
from unittest.mock import patch

import numpy as np
from hydra.utils import instantiate
from mujoco.batch import Batch
from rich.console import Console
from rich.table import Table

from dr_lab.cli.compose import compose
from dr_lab.comparison.calibrated import calibrate
from dr_lab.comparison.study import Study, prepare
from dr_lab.diagnosis.search.rank import Candidate, rank
from dr_lab.effects.catalogue import candidates
from dr_lab.effects.effect import Effect, PlacedEffect
from dr_lab.trajectory import Array


@dataclass
class Spent:
    """What one candidate took: s of CPU, s of CPU in simulation steps, and steps of one simulation."""

    cpu: float
    simulation: float = 0.0
    steps: int = 0


@dataclass
class Meter:
    """Sums up, thread by thread, what each candidate takes; `done` closes one."""

    spent: dict[str, Spent] = field(default_factory=dict)
    _open: local = field(default_factory=local)

    def done(self, label: str) -> None:
        """Book what this thread has spent since its last candidate."""
        now, current = time.thread_time(), self._current()
        current.cpu = now - getattr(self._open, "since", 0.0)
        self.spent[label] = current
        self._open.since, self._open.current = now, Spent(0.0)

    @contextmanager
    def watching(self) -> Iterator[None]:
        """Time every batch of simulations inside the block."""
        plain: Callable[..., Any] = Batch.rollout

        def timed(batch: Batch, nstep: int, *arguments: object, **options: object) -> object:
            current, begin = self._current(), time.thread_time()
            out = plain(batch, nstep, *arguments, **options)
            current.simulation += time.thread_time() - begin
            current.steps += batch.nsim * nstep
            return out

        with patch.object(Batch, "rollout", timed):
            yield

    def _current(self) -> Spent:
        if not hasattr(self._open, "current"):
            self._open.current = Spent(0.0)
        return self._open.current


def study_of(threads: int | None) -> tuple[Study, Mapping[str, Effect]]:
    """The demo's study and the catalogue."""
    cfg = compose("diagnose", ["model=furuta", "measurements=furuta", f"threads={threads or 'null'}"])
    return prepare(instantiate(cfg.comparison, _convert_="all")), instantiate(cfg.effects, _convert_="all")


def chosen(study: Study, effects: Mapping[str, Effect], count: int) -> list[PlacedEffect]:
    """Every effect at its first site, then at its second, …, at most `count`."""
    rows = [candidates(study.model, {n: e}, study.scales, study.compiled).placed for n, e in sorted(effects.items())]
    return [placed for placed in chain.from_iterable(zip_longest(*rows)) if placed is not None][:count]


def clock() -> Array:
    """Wall and CPU time, s."""
    return np.array([time.perf_counter(), time.process_time()])


def show(spent: Mapping[str, Spent], ranking: Sequence[Candidate]) -> None:
    """Print one row a candidate, slowest first."""
    table = Table("candidate", "parameters", "iterations", "simulated steps", "CPU s", "in steps", "χ²")
    found = {c.effect.label: c for c in ranking}
    for label, s in sorted(spent.items(), key=lambda item: -item[1].cpu):
        parameters, fit = len(found[label].effect.parameters), found[label].fitted_model.fit
        share, chi2 = f"{s.simulation / s.cpu:.0%}", f"{found[label].fitted_model.held_out.chi2:.3f}"
        table.add_row(label, str(parameters), str(fit.iterations), f"{s.steps:,}", f"{s.cpu:.2f}", share, chi2)
    Console(width=120).print(table)


def main() -> None:
    """Calibrate, rank and print what it took."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=14)
    parser.add_argument("--effects", type=lambda text: text.split(","), help="names of the catalogue; default: all")
    parser.add_argument("--threads", type=int, help="default: all cores")
    options = parser.parse_args()
    study, catalogue = study_of(options.threads)
    if unknown := set(options.effects or ()) - set(catalogue):
        parser.error(f"there is no effect {', '.join(sorted(unknown))}; the catalogue holds {', '.join(catalogue)}")
    placed = chosen(study, {name: catalogue[name] for name in options.effects or catalogue}, options.count)
    load, meter, begin = os.getloadavg()[0], Meter(), clock()
    base, calibrated = calibrate(study), clock()
    with meter.watching():
        ranking = rank(study.bench, base, placed, meter.done).candidates
    calibration, ranked = calibrated - begin, clock() - calibrated
    show(meter.spent, ranking)
    simulation, steps = (sum(getattr(s, name) for s in meter.spent.values()) for name in ("simulation", "steps"))
    summary = {
        "candidates": len(placed),
        "threads": study.bench.threads,
        "load_before": load,
        "calibration": {"wall_s": calibration[0], "cpu_s": calibration[1]},
        "ranking": {"wall_s": ranked[0], "cpu_s": ranked[1]},
        "simulation_share": simulation / ranked[1],
        "steps_per_cpu_s": steps / simulation if simulation else None,  # none where every candidate acts through laws
        "cpu_s": {label: s.cpu for label, s in meter.spent.items()},
    }
    print(json.dumps(summary))


if __name__ == "__main__":
    main()
