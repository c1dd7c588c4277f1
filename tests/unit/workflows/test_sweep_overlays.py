from pathlib import Path
from typing import Any

import numpy as np
import pytest
from written_runs import STATISTICS, grid_report, train_report, two_kinds, write_run

from dr_lab.errors import DataError
from dr_lab.summaries.doubts import lost_trainings, repeated_runs
from dr_lab.summaries.evaluated import with_trained
from dr_lab.summaries.groups import grouped
from dr_lab.summaries.overlays import bands, grids, marginals, violins
from dr_lab.summaries.runs import find_runs


@pytest.fixture
def sweep(tmp_path: Path) -> Path:
    return two_kinds(tmp_path / "sweep")


def test_bands_hold_the_mean_of_the_seeds_at_every_control_step(sweep: Path) -> None:
    first, second = bands(grouped(find_runs(sweep)[0], ["seed"]), STATISTICS)
    assert (first.group, first.name) == ("lsdr", "episode_return")
    np.testing.assert_array_equal(first.frames, [100, 200, 300, 400])
    np.testing.assert_allclose(first.value, [np.nan, 5.5, 8.25, 11.0])
    assert (first.low[1:] < first.value[1:]).all()
    np.testing.assert_allclose(second.high[1:], [2.0, 3.0, 4.0])


def test_learned_distributions_are_averaged_over_seeds(sweep: Path) -> None:
    found = marginals(grouped(find_runs(sweep)[0], ["seed"]))
    assert list(found["torso.size"]) == ["lsdr", "none"]
    np.testing.assert_allclose(found["torso.size"]["lsdr"].probability, [[0.2, 0.8]])


def test_distributions_that_reach_apart_are_averaged_where_they_are(tmp_path: Path) -> None:
    reached = {0: ([0.0, 0.1, 0.2], [0.2, 0.8]), 1: ([0.0, 0.1, 0.2, 0.3], [0.0, 0.4, 0.6])}
    for seed, (edges, learned) in reached.items():
        entry = {"unit": "m", "std": 0.1, "edges": edges, "initial": learned, "probability": learned}
        write_run(tmp_path / str(seed), train_report(1.0, {"size": entry}), f"seed={seed}")
    (mean,) = marginals(grouped(find_runs(tmp_path)[0], ["seed"]))["size"].values()
    np.testing.assert_allclose(mean.edges, [0.0, 0.1, 0.2, 0.3])
    np.testing.assert_allclose(mean.probability, [[0.1, 0.6, 0.3]])
    np.testing.assert_allclose(mean.initial, [0.2, 0.8, 0.0])


def test_grids_are_averaged_cell_by_cell(tmp_path: Path) -> None:
    for seed in range(2):
        rows: list[dict[str, Any]] = [
            {"size": s, "mass": m, "return": s + m + seed, "std": 1.0} for s in (1.0, 2.0) for m in (3.0, 4.0, 5.0)
        ]
        rows[0]["return"] = None  # infeasible
        units = {"size": "m", "mass": "kg"}
        write_run(tmp_path / str(seed), grid_report(rows, units), f"seed={seed}")
    (grid,) = grids(grouped(find_runs(tmp_path)[0], ["seed"])).values()
    assert [(axis.name, axis.unit) for axis in grid.axes] == [("size", "m"), ("mass", "kg")]
    np.testing.assert_allclose(grid.mean, [[np.nan, 5.5, 6.5], [5.5, 6.5, 7.5]])
    # Two runs whose means lie ½ off their mean, with a standard deviation of 1 each.
    np.testing.assert_allclose(grid.spread, np.sqrt(1.25) * np.array([[np.nan, 1, 1], [1, 1, 1]]))


def test_violins_hold_the_returns_of_all_seeds_unseen_and_taught_apart(tmp_path: Path) -> None:
    for seed, kinds in enumerate([("unseen", "teachers"), ("unseen",)]):
        rows = [{"domains": kind, "domain": 0.0, "start": 0.0, "return": float(seed)} for kind in kinds]
        report = grid_report(rows, {}) | {"evaluator": "UnseenDomainsEvaluator"}
        write_run(tmp_path / str(seed), report, f"seed={seed}")
    ((label, (unseen, teachers)),) = violins(grouped(find_runs(tmp_path)[0], ["seed"])).items()
    assert (unseen.name, teachers.name) == (f"{label} · unseen", f"{label} · teachers")
    np.testing.assert_array_equal(np.sort(unseen.value), [0.0, 1.0])
    np.testing.assert_array_equal(teachers.value, [0.0])


def test_evaluations_are_told_apart_by_how_their_policies_were_trained(tmp_path: Path) -> None:
    sweep, number = two_kinds(tmp_path / "trained"), 0
    for folder in sorted(sweep.iterdir()):
        if (folder / "report.json").is_file():
            number += 1
            value = 100.0 if int(folder.name) < 10 else 1.0
            report = grid_report([{"size": 1.0, "return": value, "std": 0.0}], {"size": "m"}) | {"trained": str(folder)}
            write_run(tmp_path / "evaluated" / str(number), report, f"run={folder}", "evaluator=grid")
    found = grids(grouped(find_runs(tmp_path / "evaluated")[0], with_trained(["seed"])))
    assert {label: grid.mean.tolist() for label, grid in found.items()} == {
        "learner=lsdr": [100.0],
        "learner=none": [1.0],
    }
    (sweep / "0" / "config.yaml").write_bytes(b"\xff")  # what is no text is told apart by its folder
    assert len(grids(grouped(find_runs(tmp_path / "evaluated")[0], with_trained(["seed"])))) == 3
    (sweep / "0" / "config.yaml").unlink()  # and so is what is gone
    assert len(grids(grouped(find_runs(tmp_path / "evaluated")[0], with_trained(["seed"])))) == 3


def test_evaluations_whose_training_is_gone_are_not_called_alike(tmp_path: Path) -> None:
    for number, kind in enumerate(["maml", "maml", "reptile"]):
        report = grid_report([{"size": 1.0, "return": 1.0, "std": 0.0}], {}) | {"trained": f"/gone/{kind}"}
        write_run(tmp_path / str(number), report, "run=latest", f"seed={number}")
    runs = find_runs(tmp_path)[0]
    groups = grouped(runs, with_trained(["seed"]))
    assert [(group.label, len(group.runs)) for group in groups] == [
        ("trained=/gone/maml", 2),
        ("trained=/gone/reptile", 1),
    ]
    assert repeated_runs(runs, ["threads"]) == []
    (told,) = lost_trainings(runs)
    assert told.endswith("so that its path alone tells these evaluations apart: 0, 1, 2.")


def test_grids_over_different_contexts_are_not_averaged(tmp_path: Path) -> None:
    for seed, sizes in enumerate([(1.0, 2.0), (1.0, 2.0, 3.0)]):
        rows = [{"size": size, "return": size, "std": 1.0} for size in sizes]
        write_run(tmp_path / str(seed), grid_report(rows, {}), f"seed={seed}")
    with pytest.raises(DataError, match=r"1 was evaluated over other contexts than .*0"):
        grids(grouped(find_runs(tmp_path)[0], ["seed"]))


def test_a_grid_without_returns_is_told(tmp_path: Path) -> None:
    write_run(tmp_path / "run", grid_report([{"size": 1.0, "return": 1.0}], {}), "seed=0")
    with pytest.raises(DataError, match=r"run/report\.json: a row lacks 'std', which those of evaluator=grid have"):
        grids(grouped(find_runs(tmp_path)[0], ["seed"]))
