"""Run folders as trainings leave them, with figures that are known."""

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import yaml

from dr_lab.summaries.groups import Statistics
from dr_lab.sweeps.overrides import by_key

STATISTICS = Statistics(confidence=0.95, resamples=200, seed=0)
EDGES = [0.0, 0.1, 0.2]


def train_report(final: float | None, context: Mapping[str, Mapping[str, Any]]) -> dict[str, Any]:
    """A report with the keys alone that every version has written."""
    named = {"schema": "dr_lab/train/1", "verb": "train", "env": "hopper", "algorithm": "PPO", "run": "outputs"}
    counted = {"iterations": 4, "frames": 400, "seconds": 0.0, "final": {}, "checkpoint": "checkpoint.pt"}
    bounds = {"low": 0.0, "high": 1.0, "mean": 0.5}
    return named | counted | {"final_return": final, "context": {k: bounds | dict(v) for k, v in context.items()}}


def grid_report(rows: Sequence[Mapping[str, float | None]], units: Mapping[str, str]) -> dict[str, Any]:
    """A report of evaluator=grid."""
    named = {"schema": "dr_lab/evaluate/1", "verb": "evaluate", "trained": "run", "env": "hopper", "run": "outputs"}
    return named | {"evaluator": "GridEvaluator", "figures": {}, "units": dict(units), "rows": [dict(r) for r in rows]}


def write_run(folder: Path, report: dict[str, Any] | None, *overrides: str) -> None:
    folder.mkdir(parents=True)
    configured = {key: yaml.safe_load(value) for key, value in by_key(overrides).items()}
    write_configuration(folder, configured, *overrides)
    if report is not None:
        (folder / "report.json").write_text(json.dumps(report), "utf-8")


def write_configuration(folder: Path, configured: dict[str, Any], *overrides: str) -> None:
    made_with = {"made_with": {"overrides": list(overrides)}}
    (folder / "config.yaml").write_text(yaml.safe_dump(configured | made_with), "utf-8")


def trained(folder: Path, final: float, learned: list[float], *overrides: str) -> None:
    entry = {"unit": "m", "mean": 0.05, "std": 0.01, "edges": EDGES, "initial": [0.5, 0.5], "probability": learned}
    write_run(folder, train_report(final, {"torso.size": entry}), *overrides)
    rows = [["iteration", "frames", "seconds", "episodes", "episode_return"]]
    rows += [[str(k), str(100 * k), "0", "2", str(final * k / 4) if k > 1 else ""] for k in range(1, 5)]
    (folder / "metrics.csv").write_text("\n".join(",".join(row) for row in rows) + "\n", "utf-8")


def two_kinds(folder: Path) -> Path:
    """Two kinds of training with three seeds each, in numbered folders, and a run that was stopped."""
    for seed in range(3):
        trained(folder / str(seed), 10.0 + seed, [0.2, 0.8], "env=hopper", f"seed={seed}", "learner=lsdr")
        trained(folder / str(10 + seed), 4.0, [0.5, 0.5], "env=hopper", f"seed={seed}", "+learner=none")
    write_run(folder / "20", None, "env=hopper")
    return folder
