"""Does the stated 99 % hold, where nothing of the catalogue is missing but noise is coloured and the model is wrong?

Nulls are logs of simulated machines (`nulls/machines.py`) that lack none of the six candidates: four logs to fit and
two held out, 6 s at 500 Hz. The noise is white, coloured (20 ms), low-passed (20 Hz) or rounding; the model error is
none, or a slow force in time, a harmonic of position or a sloshing mass, of 1, 3 or 10 times the noise. Each null is
diagnosed as `dr-lab diagnose` does, its noise estimated; a candidate that the ranking leaves unfitted is fitted for
this table. What a fitted candidate truly gains is scored on twenty further logs of the same machine.

alarms       nulls in which an effect is named or told as equivalent; unreal: its first effect truly gains nothing
holds        fits whose lower bound of the gain (99 %) lies below what they truly gain; ± of the nulls' scatter
claims       fits whose lower bound is above 0; false: those that truly gain nothing
wider        times as far as it is that the bound would have to lie from the estimate to hold in 99 % of the fits
left         what the calibrated model leaves, in true noise standard deviations, median
σ            estimated noise in true ones, median

Fits that ended where the effect is absent say nothing and are not counted. With model error a candidate may truly gain
by taking a part of it, which is no false alarm of the statistic, though the name is wrong.

    python benchmarks/calibration.py
    python benchmarks/calibration.py --count 40 --out nulls.jsonl     # goes on where nulls.jsonl ends
    python benchmarks/calibration.py --kinds white,coloured --sizes 0,3 --processes 2
"""

import argparse
import json
import os
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from itertools import product
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np
from nulls.machines import ERRORS
from nulls.noise import NOISES
from nulls.trial import Null, judge
from rich.console import Console
from rich.table import Table

from dr_lab.seeding import derived_seed

SIZES = (0.0, 1.0, 3.0, 10.0)  # of the model error, in noise standard deviations
ARM_EVERY = 8  # the pendulum is four times cheaper
STATED = 0.99

Row = Mapping[str, Any]


def nulls(kinds: Sequence[str], sizes: Sequence[float], count: int) -> list[Null]:
    """The first so many nulls: every kind of noise with every size of model error, then all anew with other seeds."""
    cells = list(product(kinds, sizes))
    made, errors = [], list(ERRORS)
    for k in range(count):
        turn, (noise, size) = k // len(cells), cells[k % len(cells)]
        machine = "arm" if (k + turn) % ARM_EVERY == ARM_EVERY - 1 else "pendulum"
        made.append(Null(machine, noise, errors[turn % len(errors)], size, _seed(noise, size, turn)))
    return made


def _seed(noise: str, size: float, turn: int) -> int:
    """A seed of its own for each null, the same whichever others are asked for."""
    return derived_seed(turn, "null", noise, str(float(size)))


def name(row: Row) -> str:
    """What tells a null from all others."""
    return "-".join(str(row[key]) for key in ("machine", "noise", "error", "size", "seed"))


def judged(wanted: Sequence[Null], truth_logs: int, processes: int) -> Iterator[Row]:
    """Results as they come."""
    if processes == 1:
        yield from (judge(null, truth_logs) for null in wanted)
        return
    with ProcessPoolExecutor(processes, mp_context=get_context("spawn")) as pool:
        for job in as_completed([pool.submit(judge, null, truth_logs) for null in wanted]):
            yield job.result()


def known(out: Path | None) -> dict[str, Row]:
    """Results of earlier runs."""
    if out is None or not out.exists():
        return {}
    return {name(row): row for row in map(json.loads, out.read_text().splitlines())}


def figures(rows: Sequence[Row]) -> dict[str, float]:
    """Rates and medians of some nulls; NaN where nothing is counted."""
    fits = [[f for f in row["fits"] if f["total"] != 0.0 and np.isfinite(f["total_low"])] for row in rows]
    every = [fit for some in fits for fit in some]
    total, low, truth = (np.array([f[key] for f in every]) for key in ("total", "total_low", "truth"))
    over = [sum(f["total_low"] > f["truth"] for f in some) for some in fits]
    alarms = [row for row in rows if row["verdict"] in ("named", "equivalent")]
    share, spread = _ratio(over, [len(some) for some in fits])
    return {
        "nulls": len(rows),
        "alarms": len(alarms) / len(rows),
        "unreal": sum(_true_gain(row) <= 0 for row in alarms) / len(rows),
        "any_supported": float(np.mean([any(f["supported"] for f in row["fits"]) for row in rows])),
        "fits": len(every),
        "holds": 1 - share,
        "holds_std": spread,
        "claims": int((low > 0).sum()),
        "false_claims": int(((low > 0) & (truth <= 0)).sum()),
        "wider": float(np.quantile((total - truth) / np.maximum(total - low, 1e-9), STATED)) if every else np.nan,
        "none": _share(rows, "none", "not_excited"),
        "unexplained": _share(rows, "unexplained"),
        "refused": _share(rows, "refused"),
        "left": float(np.median([row.get("left", np.nan) for row in rows])),
        "noise_ratio": float(np.median([row["noise_ratio"] for row in rows])),
        "cpu_s": float(np.mean([row["cpu_s"] for row in rows])),
    }


def _true_gain(row: Row) -> float:
    """What the effect that is told first truly gains."""
    return next(f["truth"] for f in row["fits"] if f["label"] == row["effects"][0])


def _share(rows: Sequence[Row], *verdicts: str) -> float:
    return sum(row["verdict"] in verdicts for row in rows) / len(rows)


def _ratio(hits: Sequence[int], counts: Sequence[int]) -> tuple[float, float]:
    """A share and its standard deviation where hits of one null come together; Cochran 1977, §3.12."""
    if not sum(counts):
        return np.nan, np.nan
    share = sum(hits) / sum(counts)
    scatter = np.linalg.norm(np.array(hits) - share * np.array(counts)) / sum(counts)
    return share, float(scatter)


def grouped(rows: Sequence[Row]) -> dict[str, dict[str, float]]:
    """Figures by kind of noise and size of model error, then by each of them, then of all."""
    kinds, sizes = (list(dict.fromkeys(row[key] for row in rows)) for key in ("noise", "size"))
    groups = {
        f"{kind} {size:g}": [r for r in rows if r["noise"] == kind and r["size"] == size]
        for kind, size in product(sorted(kinds, key=list(NOISES).index), sorted(sizes))
    }
    groups |= {f"{kind} all": [r for r in rows if r["noise"] == kind] for kind in sorted(kinds, key=list(NOISES).index)}
    groups |= {f"all {size:g}": [r for r in rows if r["size"] == size] for size in sorted(sizes)}
    groups["all all"] = list(rows)
    return {label: figures(group) for label, group in groups.items() if group}


def show(found: Mapping[str, Mapping[str, float]]) -> None:
    """Print a line a group."""
    table = Table(
        "noise, error",
        "nulls",
        "alarms",
        "unreal",
        "none",
        "unexpl.",
        "refused",
        "fits",
        "holds",
        "claims",
        "false",
        "wider",
        "left",
        "σ",
        "CPU s",
        box=None,
    )
    for label, f in found.items():
        shares = (f"{f[key]:.0%}" for key in ("alarms", "unreal", "none", "unexplained", "refused"))
        holds = f"{100 * f['holds']:.1f} ± {100 * f['holds_std']:.1f} %"
        numbers = (f"{f[key]:.3g}" for key in ("wider", "left", "noise_ratio", "cpu_s"))
        table.add_row(
            label, f"{f['nulls']}", *shares, f"{f['fits']}", holds, f"{f['claims']}", f"{f['false_claims']}", *numbers
        )
    Console(width=150).print(table)


def main() -> None:
    """Judge what is not known yet, and print the figures of all."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=304, help="nulls")
    parser.add_argument("--kinds", type=lambda text: text.split(","), default=list(NOISES), help="of noise")
    parser.add_argument("--sizes", type=lambda text: [float(s) for s in text.split(",")], default=list(SIZES))
    parser.add_argument("--truth-logs", type=int, default=20, help="further logs that tell the truth")
    parser.add_argument("--processes", type=int, default=1)
    parser.add_argument("--out", type=Path, help="file of results, one JSON object a line; known ones are kept")
    options = parser.parse_args()
    if unknown := set(options.kinds) - set(NOISES):
        parser.error(f"there is no noise {', '.join(sorted(unknown))}; there are {', '.join(NOISES)}")
    os.environ.setdefault("OMP_NUM_THREADS", "1")  # of processes that are started
    wanted, results = nulls(options.kinds, options.sizes, options.count), known(options.out)
    names = [name(vars(null)) for null in wanted]
    left = [null for null, key in zip(wanted, names, strict=True) if key not in results]
    for row in judged(left, options.truth_logs, options.processes):
        results[name(row)] = row
        if options.out is not None:
            with options.out.open("a") as file:
                file.write(json.dumps(row) + "\n")
    found = grouped([results[key] for key in names])
    show(found)
    print(json.dumps({"stated": STATED, "truth_logs": options.truth_logs, "groups": found}))


if __name__ == "__main__":
    main()
