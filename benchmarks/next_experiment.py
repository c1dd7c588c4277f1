"""May every proposed experiment be played, and does it separate its rivals better than six random ones?

On each of five machines a plant with a hidden effect writes logs, two rivals are fitted to them, and experiments are
proposed: with other seeds, durations and aims. Each is then played on the plant, in whose equations and integrator no
part of the proposal had a hand, and its true motion is held against limits that are taken from the true motion in the
logs: joint ranges, speeds and actuator forces (with the settings' margin, where the model declares none), and the
distances of parts, by ``mj_geomDistance``, that the logs keep. What is left of no limit is a violation.

    python benchmarks/next_experiment.py play --machine furuta --count 200 --output out
    python benchmarks/next_experiment.py separate --machine furuta --output out
    python benchmarks/next_experiment.py summary --output out

`play` and `separate` go on where files in the output folder end, so that a machine's proposals may be made in parts.
"""

import argparse
import json
import tempfile
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from hydra.utils import instantiate
from rich.console import Console
from rich.table import Table
from six_experiments import gentle, six
from true_motion import Bed

from dr_lab.cli.compose import compose
from dr_lab.comparison.deciding import contender
from dr_lab.comparison.experiment_machine import experiment_machine
from dr_lab.comparison.study import prepare
from dr_lab.diagnosis.evidence.bench import fit_and_score
from dr_lab.diagnosis.next_experiment.aims import separating
from dr_lab.diagnosis.next_experiment.machine import ExperimentMachine
from dr_lab.diagnosis.next_experiment.propose import Proposal, Refusal, separate, sharpen
from dr_lab.diagnosis.next_experiment.trial import tried
from dr_lab.diagnosis.next_experiment.worth import Shots, missed
from dr_lab.effects.catalogue import candidates
from dr_lab.sources.source import write_logs
from dr_lab.trajectory import Array

# What is hidden, and a rival whose fitted value is not its absent one: with none it is the machine as given, which the
# other contains, so that no experiment separates the two.
MACHINES: Mapping[str, tuple[list[str], str, str]] = {
    "furuta": (["plant/hidden=furuta/coulomb_friction_arm"], "coulomb_friction@arm", "dead_zone@motor"),
    "cartpole": (["plant/hidden=cartpole/coulomb_friction_cart"], "coulomb_friction@cart", "dead_zone@motor"),
    "double_pendulum": (
        ["plant/hidden=double_pendulum/coulomb_friction_shoulder"],
        "coulomb_friction@shoulder",
        "viscous_friction@shoulder",
    ),
    "seven": (
        ["plant/hidden=general/coulomb_friction", "plant.hidden.site=joint2", "plant.hidden.torque=3.0"],
        "coulomb_friction@joint2",
        "dead_zone@joint2",
    ),
    "elbow_servo": (
        ["plant/hidden=general/coulomb_friction", "plant.hidden.site=shoulder", "plant.hidden.torque=0.3"],
        "coulomb_friction@shoulder",
        "hysteresis@shoulder",
    ),
}
DURATIONS = (6.0, 4.0, 2.5)  # s, in turn


def bed(name: str, seed: int) -> Bed:
    """Logs of a machine, and two rivals fitted to them."""
    hidden, *labels = MACHINES[name]
    machine = instantiate(compose("benchmark", [f"machine={name}"]).machines)[name]
    source = instantiate(compose("record", [*machine.record, *hidden, f"seed={seed}"]).source, _convert_="all")
    folder = Path(tempfile.mkdtemp())
    write_logs(source, seed, folder)
    config = compose("diagnose", [*machine.diagnose, f"measurements.logs=[{folder}/*.mcap]", "threads=1"])
    study = prepare(instantiate(config.comparison, _convert_="all"))
    effects = instantiate(config.effects, _convert_="all")
    placed = {e.label: e for e in candidates(study.model, effects, study.scales, study.compiled).placed}
    models = [study.model.with_effect(placed[label]) for label in labels]
    one, other = (fit_and_score(study.bench, model, model.space.nominal) for model in models)
    settings = instantiate(config.next_experiment, _convert_="all")
    return Bed(name, source.plant, seed, study, (one, other), settings)


def proposals(made: Bed, first: int, count: int) -> Iterator[tuple[str, Proposal | Refusal, Array, float]]:
    """Aim, proposal, start and CPU s of the next so many experiments, each searched with another seed."""
    one, other = (contender(made.study, each) for each in made.rivals)
    for number in range(first, first + count):
        settings = replace(
            made.settings,
            seed=number,
            durations=(DURATIONS[number % len(DURATIONS)], 1.5),
            population=8,
            generations=2,
            refitted=1,
            poor=1e-6,
        )
        begun = time.process_time()
        found = experiment_machine(made.study, made.rivals[0], settings)
        assert found is not None
        machine, at_rest = found
        aim = "separate" if number % 10 == 0 else "sharpen"
        proposal = separate(one, other, machine, settings) if aim == "separate" else sharpen(one, machine, settings)
        assert proposal is not None
        yield aim, proposal, at_rest.qpos, time.process_time() - begun


def play(name: str, seed: int, count: int, output: Path) -> None:
    """Propose and play, and append what was seen to the machine's file."""
    path = output / f"{name}_{seed}.jsonl"
    done = len(path.read_text("utf-8").splitlines()) if path.exists() else 0
    made = bed(name, seed)
    with path.open("a", encoding="utf-8") as file:
        for aim, proposal, start, cpu in proposals(made, done, count):
            row: dict[str, Any] = {"machine": name, "aim": aim, "cpu": cpu}
            if isinstance(proposal, Refusal):
                row["refused"] = proposal.reason
            else:
                wrong, share = made.violations(proposal.commands, start)
                row |= {"violations": wrong, "share": share, "duration": proposal.duration, "taken": proposal.taken}
            file.write(json.dumps(row) + "\n")
            file.flush()


def sigma(values: Array, machine: ExperimentMachine, pair: Sequence[Any]) -> float:
    """√Δχ² that the wrong model misses after a refit, whichever is the wrong one."""
    times = np.arange(values.shape[1]) / machine.command_rate
    signals, duration = machine.signals(values[None], times), float(times[-1])
    shown = [Shots(signals, tried(c, c.z[None], signals, machine, 0.02).outputs, duration) for c in pair]
    return min(missed(shown[0], pair[1], machine), missed(shown[1], pair[0], machine))


def compare(name: str, seed: int, output: Path) -> None:
    """What the proposed experiment separates, beside the best of six random ones with and without the limits.

    It is also played: one that leaves a limit is worth nothing.
    """
    made = bed(name, seed)
    found = experiment_machine(made.study, made.rivals[0], made.settings)
    assert found is not None
    machine, at_rest = found
    one, other = (contender(made.study, each) for each in made.rivals)
    begun = time.process_time()
    proposal = separate(one, other, machine, made.settings)
    cpu = time.process_time() - begun
    row: dict[str, Any] = {"machine": name, "cpu": cpu}
    if isinstance(proposal, Proposal):
        pair, begun = separating(one, other, machine, 1.0, 1).contenders, time.process_time()
        given = six(machine, proposal.duration, made.settings.seed)
        free = [sigma(each, machine, pair) for each in given]
        row["cpu_six"] = time.process_time() - begun
        kept = [gentle(each, machine, pair, made.settings) for each in given]
        bound = [sigma(each, machine, pair) for each in kept if each is not None]
        wrong, share = made.violations(proposal.commands, at_rest.qpos)
        row |= {
            "sigma": proposal.sigma,
            "free": max(free),
            "bound": max(bound, default=None),
            "duration": proposal.duration,
            "violations": wrong,
            "share": share,
        }
    (output / f"{name}_{seed}.separates.json").write_text(json.dumps(row) + "\n", "utf-8")
    print(json.dumps(row))


def summary(output: Path) -> None:
    """Table of all machines, and its figures as JSON."""
    table, figures = Table(title="Proposed experiments, played on the plants"), {}
    for column in (
        "machine",
        "proposed",
        "refused",
        "violations",
        "largest share",
        "σ",
        "six, kept",
        "six, free",
        "CPU s",
    ):
        table.add_column(column)
    for name in MACHINES:
        rows = [json.loads(line) for path in sorted(output.glob(f"{name}_[0-9]*.jsonl")) for line in path.open()]
        told = [json.loads(path.read_text("utf-8")) for path in sorted(output.glob(f"{name}_[0-9]*.separates.json"))]
        played = [row for row in rows if "refused" not in row]
        best = told[0] if told else {}
        figures[name] = {
            "proposed": len(played),
            "refused": len(rows) - len(played),
            "violations": sum(bool(row["violations"]) for row in played),
            "share": max((row["share"] for row in played), default=None),
            **{key: best.get(key) for key in ("sigma", "bound", "free", "cpu")},
        }
        table.add_row(name, *(f"{v:.3g}" if isinstance(v, int | float) else "–" for v in figures[name].values()))
    Console(width=140).print(table)
    print(json.dumps(figures))


def main() -> None:
    """The part that is asked for."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("part", choices=["play", "separate", "summary"])
    parser.add_argument("--machine", choices=list(MACHINES), default="furuta")
    parser.add_argument("--count", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1, help="of the plant's true parameters and its logs")
    parser.add_argument("--output", type=Path, default=Path("outputs/next_experiment"))
    given = parser.parse_args()
    given.output.mkdir(parents=True, exist_ok=True)
    if given.part == "play":
        play(given.machine, given.seed, given.count, given.output)
    elif given.part == "separate":
        compare(given.machine, given.seed, given.output)
    else:
        summary(given.output)


if __name__ == "__main__":
    main()
