from pathlib import Path
from typing import Any

import pytest
from test_summarize import trained

from dr_lab.errors import UnknownNameError
from dr_lab.summaries.groups import Group, Statistics, find_group, grouped, shared_figures, summed_up
from dr_lab.summaries.runs import Run, find_runs
from dr_lab.summaries.tables import summary_page

STATISTICS = Statistics(confidence=0.95, resamples=200, seed=0)
FIGURES = {"dr_lab/train/1": ["final_return", "mass", "verdict"]}


def group(label: str, *returns: float | None) -> Group:
    reports = [
        {"schema": "dr_lab/train/1", "final_return": value, "mass": 0.05, "verdict": "none"} for value in returns
    ]
    runs = [Run(str(k), Path(str(k)), {}, {}, report, None) for k, report in enumerate(reports)]
    return Group({"learner": label}, runs, label)


def test_what_all_runs_share_is_said_once() -> None:
    groups = [group("lsdr", 10.0, 11.0), group("none", 10.0, 10.0)]
    shared = shared_figures(groups, FIGURES)
    assert shared == {"mass": 0.05, "verdict": "none"}
    cells = [summed_up(each, FIGURES, STATISTICS) for each in groups]
    page = summary_page("sweep", groups, cells, shared, [], STATISTICS, groups[0], {}).markdown()
    assert "The same in all runs: mass 0.05, verdict none." in page
    assert page.count("| final_return |") == 2
    assert "| mass |" not in page


def test_a_group_is_better_than_the_reference_with_a_probability() -> None:
    groups = [group("none", 1.0, 2.0, 3.0, 0.0), group("lsdr", 2.0, 4.0, 5.0, 4.0)]
    cells = [summed_up(each, FIGURES, STATISTICS, groups[0]) for each in groups]
    page = summary_page("sweep", groups, cells, {}, [], STATISTICS, groups[0], {}).markdown()
    larger: Any = cells[1]["final_return"]
    assert larger.larger.value == pytest.approx(14.5 / 16)  # of 16 pairs one is lost, one is a tie
    assert larger.larger.low < 14.5 / 16 < larger.larger.high
    assert "than in one of none:" in page
    assert "| final_return | lsdr | 4 | 4 (2 … 5) | 0.9062 (" in page
    assert cells[0]["final_return"] == summed_up(groups[0], FIGURES, STATISTICS)["final_return"]


@pytest.mark.parametrize("count", [1, 3])
def test_few_runs_are_not_better_with_a_probability(count: int) -> None:
    groups = [group("none", *[1.0] * count), group("lsdr", *[2.0] * count)]
    cells = [summed_up(each, FIGURES, STATISTICS, groups[0]) for each in groups]
    assert "larger" not in summary_page("sweep", groups, cells, {}, [], STATISTICS, groups[0], {}).markdown()


def test_the_reference_is_the_first_group_or_the_one_that_is_named() -> None:
    groups = [group("none", 1.0), group("lsdr", 2.0)]
    assert find_group(groups, None) is groups[0]
    assert find_group(groups, "lsdr") is groups[1]
    with pytest.raises(UnknownNameError, match="lsdr"):
        find_group(groups, "lsd")


def test_keys_and_figures_are_short_where_that_tells_them_apart() -> None:
    reports = [{"schema": "dr_lab/evaluate/1", "figures": {"hard.iqm": value}} for value in (1.0, 2.0)]
    settings = {"trained.experiment": "adr", "trained.seed": "0", "evaluator.seed": "1"}
    groups = [Group(settings, [Run("0", Path("0"), {}, {}, report, None)], "adr") for report in reports]
    cells = [summed_up(each, {"dr_lab/evaluate/1": ["figures.*"]}, STATISTICS) for each in groups]
    page = summary_page("sweep", groups, cells, {}, [], STATISTICS, groups[0], {}).markdown()
    assert "| figure | experiment | trained.seed | evaluator.seed | runs | mean (interval) |" in page
    assert "| hard.iqm | adr | 0 | 1 | 1 | 1 |" in page


def test_one_group_shares_nothing_with_others() -> None:
    assert shared_figures([group("lsdr", 1.0, 1.0)], FIGURES) == {}


def test_what_one_run_lacks_is_not_shared() -> None:
    assert "final_return" not in shared_figures([group("lsdr", 1.0, None), group("none", 1.0)], FIGURES)


def test_a_run_that_was_gone_on_with_is_one_of_its_group(tmp_path: Path) -> None:
    for seed, typed in enumerate([[], ["resume=/runs/1"], []]):
        trained(tmp_path / str(seed), 1.0, [1.0, 0.0], f"seed={seed}", *typed)
    (group,) = grouped(find_runs(tmp_path)[0], ["seed"], ["resume"])
    assert len(group.runs) == 3
