from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from html_pages import figures, require_whole, text, traces, values
from written_runs import grid_report, train_report

from dr_lab.html.return_figures import grid_maps, grid_plots
from dr_lab.html.training_page import write_training_page
from dr_lab.recorders import grids
from dr_lab.recorders.training import (
    Comparison,
    Comparisons,
    ContextAxis,
    Curve,
    Decline,
    Gain,
    Grid,
    Marginal,
    Matrix,
    Pair,
    Sample,
    Spread,
    Ways,
)
from dr_lab.recorders.training_review import TrainingRecord
from dr_lab.reports.evaluate import EvaluateReport
from dr_lab.reports.evaluate_page import evaluate_page
from dr_lab.reports.page import Section
from dr_lab.reports.plain import from_plain
from dr_lab.reports.train import ChoiceEntry, SnapshotEntry, TrainReport
from dr_lab.reports.train_page import train_page

AXIS = ContextAxis("friction", "N·m", np.array([0.0, 1.0, 3.0]))
ITERATION = np.arange(5)


def trained(folder: Path, record: TrainingRecord, choice: ChoiceEntry | None = None) -> str:
    report = from_plain(TrainReport, train_report(12.0, {"torso.size": {"unit": "m", "std": 0.1}}))
    if choice:
        report = replace(report, choice=choice, final_episodes=5, deployed_return=choice.mean_return)
    write_training_page(folder / "report.html", train_page(report), report, record)
    return (folder / "report.html").read_text("utf-8")


def evaluated(folder: Path, record: TrainingRecord) -> str:
    report = from_plain(EvaluateReport, grid_report([{"friction": 0.0, "return": 1.0}], {"friction": "N·m"}))
    write_training_page(folder / "report.html", evaluate_page(report, "Two episodes.", report.rows), report, record)
    page = (folder / "report.html").read_text("utf-8")
    require_whole(page)
    return page


def test_training_shows_the_return_what_was_learnt_and_the_choice(tmp_path: Path) -> None:
    curve = Curve("episode_return", "", ITERATION, np.array([0.0, 1.0, np.nan, 3.0, 4.0]))
    share = np.linspace(0.5, 0.9, 5)
    learned = np.stack([share, 1 - share], axis=1)
    marginal = Marginal("torso.size", "m", np.array([0.0, 0.1, 0.3]), np.array([0.5, 0.5]), ITERATION, learned)
    covariance = np.tile(np.diag([0.04, 0.01]), (5, 1, 1))
    pair = Pair(("a", "b"), ("1", "m"), np.zeros(2), np.ones(2), ITERATION, np.full((5, 2), 0.5), covariance)
    kept = (SnapshotEntry(100, 3.0), SnapshotEntry(200, 9.0), SnapshotEntry(300, 5.0))
    choice = ChoiceEntry(kept, 200, 3200, "policy.pt")
    page = trained(tmp_path, TrainingRecord("run", [curve], [marginal], [pair]), choice=choice)
    require_whole(page)
    assert "The deployed policy returns 9 on average, without exploration." in text(page)
    assert "While it trained, 5 episodes that ended last returned 12 on average, with exploration" in text(page)
    assert "Mean undiscounted return of the feasible episodes that ended, with exploration." in text(page)
    (returns,) = traces(page, "each iteration")
    assert values(returns["y"]).tolist() == [0.0, 1.0, 3.0, 4.0]
    (density,) = [t for t in traces(page, "learned") if "fillcolor" in t]
    np.testing.assert_allclose(values(density["y"]), [0.0, 9.0, 9.0, 0.5, 0.5, 0.0], rtol=1e-6)  # 0.9/0.1, 0.1/0.2
    course = next(t for figure in figures(page) for t in figure["data"] if t["type"] == "heatmap")
    np.testing.assert_allclose(values(course["z"])[:, 0], [5.0, 2.5])
    (deployed,) = traces(page, "deployed")
    assert (deployed["x"], deployed["y"]) == ([200], [9.0])


def test_a_distribution_that_nothing_learns_is_drawn_once(tmp_path: Path) -> None:
    once = Marginal("torso.size", "m", np.array([0.0, 0.1]), np.ones(1), np.zeros(1, int), np.ones((1, 1)))
    page = trained(tmp_path, TrainingRecord("run", marginals=[once]))
    assert not traces(page, "learned")
    assert "Contexts of training" in page
    assert "Learned distribution" not in page


def test_an_infeasible_cell_is_hatched_within_its_bounds(tmp_path: Path) -> None:
    mean = np.arange(9.0).reshape(3, 3)
    mean[2, 0] = np.nan  # friction 3 across, 0 up
    page = evaluated(
        tmp_path, TrainingRecord("run", grids=[Grid("area", [AXIS, AXIS], mean, np.ones((3, 3)), "episodes")])
    )
    (hatch,) = traces(page, "infeasible")
    x, y = (np.array([v for v in hatch[k] if v is not None]) for k in "xy")
    assert (x.min(), x.max()) == (2.0, 4.0)
    assert (y.min(), y.max()) == (-0.5, 0.5)
    (heat,) = [t for t in figures(page)[0]["data"] if t["type"] == "heatmap"]
    np.testing.assert_array_equal(values(heat["z"]), mean.T)
    assert figures(page)[0]["layout"]["xaxis"]["title"]["text"] == "friction [N·m]"
    assert "Hatched: infeasible" in text(page)


def test_returns_over_one_parameter_have_their_band(tmp_path: Path) -> None:
    grid = Grid("line", [AXIS], np.array([np.nan, 1.0, 2.0]), np.array([np.nan, 0.5, 0.25]), "episodes")
    page = evaluated(tmp_path, TrainingRecord("run", grids=[grid]))
    (line,) = traces(page, "line")
    assert values(line["y"]).tolist() == [1.0, 2.0]
    band = figures(page)[0]["data"][0]
    assert values(band["y"]).tolist() == [1.5, 2.25, 1.75, 0.5]
    assert "Grey: infeasible" in text(page)


def test_returns_before_and_after_stand_in_one_plot_with_ticks_at_their_values(tmp_path: Path) -> None:
    returns = [
        Grid(name, [AXIS], np.full(3, k + 1.0), np.full(3, 0.5), "episodes")
        for k, name in enumerate(("before", "after"))
    ]
    page = evaluated(tmp_path, TrainingRecord("run", grids=returns))
    (plot,) = (each for each in figures(page) if {"before", "after"} & {t.get("name") for t in each["data"]})
    assert [t["name"] for t in plot["data"] if t.get("mode") == "lines+markers"] == ["before", "after"]
    assert values(plot["layout"]["xaxis"]["tickvals"]).tolist() == AXIS.values.tolist()


def test_captions_say_what_the_spread_is_over() -> None:
    ones, square = np.ones(3), np.ones((3, 3))
    line = partial(Grid, axes=[AXIS], mean=ones, spread=ones)
    of_contexts, of_runs = line("after", over="contexts"), line("each", over="runs")
    area = Grid("area", [AXIS, AXIS], square, square, "adaptations")
    (alone,) = grid_plots([of_contexts])
    assert alone.caption == "Bands: ± a standard deviation over contexts."
    (both,) = grid_plots([of_contexts, of_runs])
    assert both.caption == "Bands: ± a standard deviation over contexts (after), runs (each)."
    assert "span four standard deviations over adaptations in a cell" in grid_maps([area])[0].caption
    assert grids.told([of_runs]) == " (thin: ± std over runs)"


@pytest.mark.parametrize(("spread", "ends"), [(0.1, (0.0, 8.0)), (3.0, (-2.0, 10.0))])
def test_colours_of_a_map_span_what_chance_does(spread: float, ends: tuple[float, float], tmp_path: Path) -> None:
    """Means from 0 to 8: four standard deviations of an episode are 0.4 or 12."""
    grid = Grid("area", [AXIS, AXIS], np.arange(9.0).reshape(3, 3), np.full((3, 3), spread), "episodes")
    page = evaluated(tmp_path, TrainingRecord("run", grids=[grid]))
    (heat,) = [t for t in figures(page)[0]["data"] if t["type"] == "heatmap"]
    assert (heat["zmin"], heat["zmax"]) == pytest.approx(ends)


def test_maps_over_the_same_parameters_share_their_colours(tmp_path: Path) -> None:
    """Before and after an update: as dark is as good."""
    other = ContextAxis("mass", "kg", AXIS.values)
    before, after, apart = (
        Grid(title, axes, mean + np.arange(9.0).reshape(3, 3), np.full((3, 3), 0.1), "adaptations")
        for title, axes, mean in (
            ("before", [AXIS, AXIS], 0.0),
            ("after", [AXIS, AXIS], 50.0),
            ("apart", [AXIS, other], 900.0),
        )
    )
    page = evaluated(tmp_path, TrainingRecord("run", grids=[before, after, apart]))
    heats = [t for figure in figures(page) for t in figure["data"] if t["type"] == "heatmap"]
    assert [(heat["zmin"], heat["zmax"]) for heat in heats] == [(0.0, 58.0), (0.0, 58.0), (900.0, 908.0)]
    assert text(page).count("and are the same in all maps over these parameters") == 2


def test_violins_hold_what_is_known(tmp_path: Path) -> None:
    samples = [Sample("uniform", np.array([1.0, np.nan, 3.0]), "A context each."), Sample("nominal", np.ones(3))]
    page = evaluated(tmp_path, TrainingRecord("run", samples=samples))
    (uniform,) = traces(page, "uniform")
    assert uniform["type"] == "violin"
    assert values(uniform["y"]).tolist() == [1.0, 3.0]
    assert "A context each. Dots: these values; box: quartiles and median; dashed: mean" in text(page)


def test_what_is_in_doubt_is_marked(tmp_path: Path) -> None:
    value = np.array([[2.0, 1.0], [-2.0, np.nan]])
    axis = ContextAxis("goal.x", "m", np.array([-1.0, 1.0]))
    area = Gain("of 1 update", [axis, axis], value, value - [[1.0, 2.0], [1.0, np.nan]], value + 1.0)
    line = Gain("of 2 updates", [axis], value[:, 0], value[:, 0] - 1.0, value[:, 0] + 1.0)
    cosine = Matrix("initial", axis, np.eye(2), np.array([[False, True], [True, False]]))
    way = np.array([[0.0, 0.0], [0.5, 0.5]])
    ways = Ways("after 1 update", np.array([[1.0, 1.0], [-1.0, 1.0]]), [way, way], [way, -way])
    page = evaluated(tmp_path, TrainingRecord("run", gains=[area, line], matrices=[cosine], ways=[ways]))
    doubtful = [t for figure in figures(page) for t in figure["data"] if t.get("marker", {}).get("size") == 5]
    assert [values(t["x"]).tolist() for t in doubtful] == [[-1.0], [-1.0, 1.0]]
    (after,) = traces(page, "after")
    assert np.isnan(values(after["x"])).sum() == 2  # a gap behind each way


def test_a_pair_of_contexts_without_a_cosine_need_not_be_infeasible(tmp_path: Path) -> None:
    value = np.array([[1.0, np.nan, np.nan], [np.nan] * 3, [np.nan] * 3])
    page = evaluated(tmp_path, TrainingRecord("run", matrices=[Matrix("cosine", AXIS, value, np.isnan(value))]))
    assert "Hatched: infeasible, or no gradient that is told from noise." in text(page)


def test_what_is_no_return_is_not_called_one(tmp_path: Path) -> None:
    """Where no episode ended the first figure is another."""
    page = trained(tmp_path, TrainingRecord("run", [Curve("objective", "", ITERATION, np.ones(5))]))
    assert "<h2>Return</h2>" not in page
    assert "<h2>Other figures</h2>" in page


def test_long_names_of_figures_are_not_cut_and_their_meaning_is_told(tmp_path: Path) -> None:
    """At the height of a small plot "infeasible share while training on" began with "feasible share"."""
    names = ["episode_return", "infeasible share while training on", "return_after_3"]
    page = trained(tmp_path, TrainingRecord("run", [Curve(name, "", ITERATION, np.ones(5)) for name in names]))
    titles = [figure["layout"]["yaxis"]["title"]["text"] for figure in figures(page)]
    assert titles[:3] == ["episode return", "infeasible share while<br>training on", "return after 3"]
    assert "Share of the contexts without a return." in text(page)
    assert "Mean return over the tasks after so many updates, with exploration." in text(page)


def test_plots_and_words_of_one_title_stand_in_one_chapter(tmp_path: Path) -> None:
    report = from_plain(TrainReport, train_report(12.0, {"torso.size": {"unit": "m", "std": 0.1}}))
    page = replace(train_page(report), sections=[Section("ladder", "Target and model", "The table.")])
    record = TrainingRecord("run", declines=[Decline("discrepancy", ITERATION, {"mean, after": np.ones(5)})])
    write_training_page(tmp_path / "report.html", page, report, record)
    written = (tmp_path / "report.html").read_text("utf-8")
    assert written.count("<h2>Target and model</h2>") == 1
    assert text(written).index("Between target and model") < text(written).index("The table.")


@pytest.mark.parametrize("count", [1, 400])
def test_long_curves_have_a_running_mean_and_short_ones_do_not(tmp_path: Path, count: int) -> None:
    curve = Curve("loss", "", np.arange(count), np.full(count, 2.0))
    page = trained(tmp_path, TrainingRecord("run", [curve]))
    means = traces(page, "mean over 1/20 of the training")
    assert len(means) == (count > 1)
    assert all(np.all(values(mean["y"]) == 2.0) for mean in means)
    assert ("One point alone: 2." in text(page)) == (count == 1)


def test_the_running_mean_is_that_of_all_values_not_of_those_that_are_drawn(tmp_path: Path) -> None:
    value = np.where(np.arange(8000) % 10 == 0, 10.0, 0.0)
    (mean,) = traces(
        trained(tmp_path, TrainingRecord("run", [Curve("kl", "", np.arange(8000), value)])),
        "mean over 1/20 of the training",
    )
    assert values(mean["y"]) == pytest.approx(1.0, abs=1e-3)
    assert len(values(mean["x"])) == 800


@pytest.mark.slow
def test_many_parameters_stay_small(tmp_path: Path) -> None:
    iteration, edges = np.arange(500), np.linspace(0.0, 1.0, 101)
    share = np.full((500, 100), 0.01)
    marginals = [Marginal(f"p{k}", "kg", edges, share[0], iteration, share) for k in range(40)]
    mean, covariance = np.full((500, 2), 0.5), np.tile(0.01 * np.eye(2), (500, 1, 1))
    names = [(f"p{i}", f"p{j}") for i in range(40) for j in range(i)]
    pairs = [Pair(each, ("kg", "kg"), np.zeros(2), np.ones(2), iteration, mean, covariance) for each in names]
    curves = [Curve(f"figure {k}", "", np.arange(20_000), np.arange(20_000.0)) for k in range(30)]
    page = trained(tmp_path, TrainingRecord("run", curves, marginals, pairs))
    assert len(page) < 6_000_000
    assert len([t for figure in figures(page) for t in figure["data"] if t["type"] == "heatmap"]) == 40


def test_a_gaussian_that_draws_near_to_a_target_is_told_by_its_spread(tmp_path: Path) -> None:
    share = np.full((5, 1), 1.0)
    marginal = Marginal("mass", "kg", np.array([0.0, 2.0]), share[0], ITERATION, share)
    spread = Spread("mass", "kg", ITERATION, np.linspace(1.0, 2.0, 5), np.full(5, 0.25))
    time = np.array([0.0, 0.1])
    first, last = (Comparison("arm.position", "rad", time, time, off * time, off * time[None]) for off in (3.0, 1.5))
    decline = Decline("discrepancy", ITERATION, {"at the mean": np.array([18.0, 9.0, 4.0, 2.0, 1.5])})
    record = TrainingRecord(
        "run", marginals=[marginal], spreads=[spread], comparisons=[Comparisons(np.array([1, 4]), [first, last])],
        declines=[decline],
    )  # fmt: skip
    page = trained(tmp_path, record)
    require_whole(page)
    assert "heatmap" not in page  # mean and deviation tell it better
    axes = [figure["layout"] for figure in figures(page) if figure["layout"]["yaxis"].get("type") == "log"]
    assert [(each["xaxis"]["dtick"], each["yaxis"]["dtick"]) for each in axes] == [(1, "D2")]  # no 6, 7, 8, 9 upon 10
    (mean,), (around,) = traces(page, "mean"), traces(page, "± std")
    assert values(mean["y"]).tolist() == [1.0, 1.25, 1.5, 1.75, 2.0]
    assert values(around["y"])[[0, -1]].tolist() == [1.25, 0.75]
    at_mean = [values(t["y"]) for t in traces(page, "model at the mean")]
    np.testing.assert_allclose(at_mean, [[0.0, 0.3], [0.0, 0.15]], rtol=1e-6)
    (falls,) = traces(page, "at the mean")
    np.testing.assert_allclose(values(falls["y"]), [18.0, 9.0, 4.0, 2.0, 1.5], rtol=1e-6)
    assert any(each["layout"]["yaxis"].get("type") == "log" for each in figures(page))
