"""Does `diagnose` find what was hidden? Every hidden effect of the Furuta plant × seeds, scored by equivalence class.

A case is right if the verdict is `named` with a member of the truth's class, `equivalent` with exactly that class, or
`none` where the class holds the base (DESIGN: the rivals whose predicted Δχ² from noise-free truth is below the
evidence threshold). Finished cases are kept in the output folder, so that an interrupted run goes on.

    python benchmarks/hidden_effects.py --seeds 3 --none-seeds 10 --output outputs/benchmark/hidden_effects
"""

import argparse
import contextlib
import io
import json
import os
import time
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from multiprocessing import get_context
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from hydra.utils import instantiate
from rich.console import Console
from rich.progress import track
from rich.table import Table

from dr_lab.cli.compose import compose
from dr_lab.diagnosis.ladder import Rung, climb
from dr_lab.diagnosis.rank import Candidate
from dr_lab.recorders.files import write_text
from dr_lab.workflows.calibrated import calibrate
from dr_lab.workflows.record import record
from dr_lab.workflows.study import Study, prepare

HIDDEN = {
    "coulomb_friction_arm": "coulomb_friction@arm",
    "coulomb_friction_pole": "coulomb_friction@pole",
    "stribeck_friction_arm": "stribeck_friction@arm",
    "quadratic_drag_arm": "quadratic_drag@arm",
    "quadratic_drag_pole": "quadratic_drag@pole",
    "spring_arm": "spring@arm",
    "armature_arm": "armature@arm",
    "armature_pole": "armature@pole",
    "payload_pole": "payload@pole",
    "base_tilt": "base_tilt@world",
    "actuator_delay": "actuator_delay@motor",
    "torque_scale": "torque_scale@motor",
    "constant_offset_arm": "constant_offset@arm",
    "saturation": "saturation@motor",
    "sensor_time_offset_pole": "sensor_time_offset@pole",
    "viscous_friction_arm": "viscous_friction@arm",
}
BASE = "base"


@dataclass(frozen=True)
class Case:
    """One hidden effect and seed."""

    hidden: str
    seed: int

    @property
    def name(self) -> str:
        """File stem of the result."""
        return f"{self.hidden}_{self.seed}"


def study_of(case: Case, folder: Path, instruments: str) -> tuple[Study, dict[str, Any]]:
    """Generate the logs of a case and prepare the diagnosis on them."""
    options = ["experiment=furuta_demo", f"plant/hidden={case.hidden}", f"plant/instruments={instruments}"]
    source = instantiate(compose("record", options).source, _convert_="all")
    with contextlib.redirect_stdout(io.StringIO()):
        record(source, str(folder), case.seed, folder)
    noise = [] if instruments == "encoders" else _encoder_noise()
    cfg = compose("diagnose", [f"measurements.logs=[{folder}/*.mcap]", *noise])
    keys = ("model", "measurements", "windows", "predicted", "solver", "evidence", "localise")
    built = {key: instantiate(cfg[key], _convert_="all") for key in keys}
    return prepare(**built, threads=1), instantiate(cfg.effects, _convert_="all")


def _encoder_noise() -> list[str]:
    """Noise-free logs are weighed by what the encoder's noise would be: 2048 counts, uniform."""
    std = 2 * np.pi / 2048 / np.sqrt(12)
    return [f"measurements.outputs.{joint}.position.noise_std={std}" for joint in ("arm", "pole")]


def diagnosed(case: Case, instruments: str) -> tuple[Study, Rung]:
    """First rung of the ladder on a case's logs."""
    with TemporaryDirectory() as folder:
        study, effects = study_of(case, Path(folder), instruments)
        ladder = climb(
            study.bench, calibrate(study), effects, study.scales, study.compiled, most=0, watch=lambda _: lambda _: None
        )
    return study, ladder.rungs[0]


def equivalence_class(case: Case, threshold: float) -> list[str]:
    """Candidates, the base included, that fit the noise-free logs of the truth to within the threshold."""
    _, rung = diagnosed(case, "exact")
    sums = {BASE: rung.base.held_out.window_sum.sum() + (rung.base.fit.residuals**2).sum()}
    sums |= {
        c.effect.label: c.explained.held_out.window_sum.sum() + (c.explained.fit.residuals**2).sum()
        for c in rung.ranking
    }
    return [label for label, total in sums.items() if total < threshold]


def run(case: Case) -> dict[str, Any]:
    """Diagnose one case and score it."""
    begin = time.process_time()
    study, rung = diagnosed(case, "encoders")
    seconds = time.process_time() - begin
    truth = HIDDEN.get(case.hidden, BASE)
    verdict = rung.verdict
    members = [truth]
    exact = verdict.kind == "named" and verdict.effects == (truth,)
    if case.hidden != "none" and not exact:
        members = equivalence_class(case, study.bench.evidence.threshold)
    best: Candidate | None = next((c for c in rung.ranking if c.effect.label in verdict.effects[:1]), None)
    return {
        "hidden": truth,
        "seed": case.seed,
        "verdict": verdict.kind,
        "effects": list(verdict.effects),
        "absorbed": list(verdict.absorbed),
        "class": members,
        "right": right(verdict.kind, verdict.effects, verdict.absorbed, truth, members),
        "chi2_base": rung.base.held_out.chi2,
        "chi2_best": best.explained.held_out.chi2 if best else None,
        "cpu_s": seconds,
        "values": {p: float(v) for p, v in zip(best.explained.model.space.names, best.explained.fit.z, strict=True)}
        if best
        else {},
    }


def right(kind: str, effects: tuple[str, ...], absorbed: tuple[str, ...], truth: str, members: list[str]) -> bool:
    """Score by equivalence class."""
    if truth == BASE:
        return kind == "none"
    if kind == "named":
        return effects[0] in members
    if kind == "equivalent":
        return set(effects) == set(members) - {BASE}
    return kind == "none" and BASE in members and truth in absorbed


def kept(path: Path, case: Case) -> dict[str, Any]:
    """Result of a case, from its file where it has been run before."""
    file = path / f"{case.name}.json"
    if not file.exists():
        write_text(file, json.dumps(run(case), indent=1))
    return json.loads(file.read_text())


def show(results: list[dict[str, Any]]) -> None:
    """Print the table and, last, one JSON line."""
    table = Table("hidden", "seed", "verdict", "found", "χ² calibrated", "χ² with effect", "right", "CPU s")
    for r in results:
        found = ", ".join(r["effects"]) or "absorbed: " * bool(r["absorbed"]) + ", ".join(r["absorbed"])
        after = f"{r['chi2_best']:.3f}" if r["chi2_best"] else "–"
        table.add_row(
            r["hidden"],
            str(r["seed"]),
            r["verdict"],
            found,
            f"{r['chi2_base']:.3f}",
            after,
            "yes" if r["right"] else "NO",
            f"{r['cpu_s']:.0f}",
        )
    Console(width=200).print(table)
    none = [r for r in results if r["hidden"] == BASE]
    hidden = [r for r in results if r["hidden"] != BASE]
    summary = {
        "hidden_right": sum(r["right"] for r in hidden),
        "hidden": len(hidden),
        "none_right": sum(r["right"] for r in none),
        "none": len(none),
        "median_chi2_best": float(np.median([r["chi2_best"] for r in hidden if r["chi2_best"]] or [np.nan])),
        "median_cpu_s": float(np.median([r["cpu_s"] for r in results])),
    }
    print(json.dumps(summary))


def main() -> None:
    """Run the cases side by side, one process a core."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--none-seeds", type=int, default=10)
    parser.add_argument("--only", nargs="*", default=list(HIDDEN))
    parser.add_argument("--output", type=Path, default=Path("outputs/benchmark/hidden_effects"))
    options = parser.parse_args()
    cases = [Case(hidden, seed) for seed in range(options.seeds) for hidden in options.only]
    cases += [Case("none", seed) for seed in range(options.none_seeds)]
    with ProcessPoolExecutor(len(os.sched_getaffinity(0)), get_context("spawn")) as pool:
        jobs = [pool.submit(kept, options.output, case) for case in cases]
        show([job.result() for job in track(jobs, "Diagnosing")])


if __name__ == "__main__":
    main()
