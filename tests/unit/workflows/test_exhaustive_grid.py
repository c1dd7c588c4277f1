from pathlib import Path

import numpy as np
import pytest
from written_runs import train_report, write_run

from dr_lab.recorders.training import Grid
from dr_lab.summaries.exhaustive import LABEL, exhaustive
from dr_lab.summaries.groups import grouped
from dr_lab.summaries.overlays import marginals
from dr_lab.summaries.runs import find_runs


def trained_at(folder: Path, values: dict[str, float], final: float | None, *overrides: str, std: float = 0.0) -> None:
    histogram = {"edges": [0.0, 1.0], "initial": [1.0], "probability": [1.0]}
    context = {name: {"unit": "m", "mean": value, "std": std, **histogram} for name, value in values.items()}
    typed = [f"randomizer.values.{name}={value}" for name, value in values.items()]
    write_run(folder, train_report(final, context), *typed, *overrides)


def drawn(sweep: Path) -> dict[str, Grid]:
    return exhaustive(grouped(find_runs(sweep)[0], ["seed"]))


def test_policies_of_one_context_each_make_a_line_averaged_over_seeds(tmp_path: Path) -> None:
    for seed in range(2):
        for k, size in enumerate([0.3, 0.1, 0.2]):
            trained_at(tmp_path / str(3 * seed + k), {"size": size, "mass": 2.0}, 10 * size + seed, f"seed={seed}")
    (grid,) = drawn(tmp_path).values()
    assert [(axis.name, axis.unit) for axis in grid.axes] == [("size", "m")]
    np.testing.assert_allclose(grid.axes[0].values, [0.1, 0.2, 0.3])
    np.testing.assert_allclose(grid.mean, [1.5, 2.5, 3.5])
    np.testing.assert_allclose(grid.spread, 0.5)


def test_two_parameters_make_a_map_with_gaps_where_nothing_was_trained_or_all_was_infeasible(tmp_path: Path) -> None:
    cells = {(1.0, 3.0): 1.0, (1.0, 4.0): 2.0, (2.0, 3.0): None}
    for k, ((size, mass), final) in enumerate(cells.items()):
        trained_at(tmp_path / str(k), {"size": size, "mass": mass}, final)
    (grid,) = drawn(tmp_path).values()
    np.testing.assert_allclose(grid.mean, [[1.0, 2.0], [np.nan, np.nan]])


def test_other_settings_make_a_grid_each(tmp_path: Path) -> None:
    for k, (size, clip) in enumerate([(0.1, 0.2), (0.2, 0.2), (0.1, 0.3), (0.2, 0.3)]):
        trained_at(tmp_path / str(k), {"size": size}, size + clip, f"algorithm.clip={clip}")
    found = drawn(tmp_path)
    assert list(found) == [f"{LABEL}, algorithm.clip=0.2", f"{LABEL}, algorithm.clip=0.3"]
    np.testing.assert_allclose([grid.mean for grid in found.values()], [[0.3, 0.4], [0.4, 0.5]])


@pytest.mark.parametrize("values", [[{"size": 0.1}, {"size": 0.1}], [{"a": k, "b": k, "c": k} for k in (1.0, 2.0)]])
def test_nothing_is_drawn_of_one_context_or_more_than_two_parameters(
    tmp_path: Path, values: list[dict[str, float]]
) -> None:
    for k, each in enumerate(values):
        trained_at(tmp_path / str(k), each, 1.0, f"seed={k}")
    assert not drawn(tmp_path)


def test_a_distribution_is_no_context_and_a_context_no_distribution(tmp_path: Path) -> None:
    trained_at(tmp_path / "0", {"size": 0.1}, 1.0)
    trained_at(tmp_path / "1", {"size": 0.2}, 1.0)
    trained_at(tmp_path / "2", {"size": 0.3}, 1.0, std=0.1)
    groups = grouped(find_runs(tmp_path)[0], ["seed"])
    np.testing.assert_allclose(drawn(tmp_path)[LABEL].axes[0].values, [0.1, 0.2])
    assert list(marginals(groups)["size"]) == ["size=0.3"]
