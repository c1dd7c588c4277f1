from pathlib import Path

import numpy as np
import pytest
from recorder_samples import read_recording
from scipy.stats import chi2

from dr_lab.recorders.course import course
from dr_lab.recorders.distributions import CANVAS, ellipse
from dr_lab.recorders.grids import return_span
from dr_lab.recorders.heat_map import ColourScale, heat_map
from dr_lab.recorders.look import Look
from dr_lab.recorders.spread import bands
from dr_lab.recorders.sweep_review import SweepRecord, write_sweep_review
from dr_lab.recorders.training import (
    Comparison,
    Comparisons,
    ContextAxis,
    Curve,
    Decline,
    Gain,
    Grid,
    Marginal,
    Pair,
    Sample,
    Spread,
    Ways,
)
from dr_lab.recorders.training_review import TrainingRecord, write_training_review

ITERATION = np.arange(5)
CURVE = Curve("return", "", ITERATION, np.array([0.0, 1.0, np.nan, 3.0, 4.0]))
EDGES = np.array([0.0, 0.1, 0.3])


def marginal() -> Marginal:
    share = np.linspace(0.5, 0.9, 5)
    return Marginal("torso.size", "m", EDGES, np.array([0.5, 0.5]), ITERATION, np.stack([share, 1 - share], axis=1))


def pair() -> Pair:
    mean = np.stack([np.linspace(1.0, 2.0, 5), np.full(5, 0.5)], axis=1)
    covariance = np.tile(np.diag([0.04, 0.01]), (5, 1, 1))
    names, units = ("friction", "torso.size"), ("1", "m")
    return Pair(names, units, np.array([0.0, 0.0]), np.array([4.0, 1.0]), ITERATION, mean, covariance)


def test_an_ellipse_holds_its_share() -> None:
    mean, covariance = np.array([1.0, -2.0]), np.array([[4.0, 1.0], [1.0, 0.5]])
    line = np.stack(ellipse(mean, covariance, 0.95), axis=1) - mean
    distance = np.einsum("ki,ij,kj->k", line, np.linalg.inv(covariance), line)
    np.testing.assert_allclose(distance, chi2.ppf(0.95, df=2))
    draws = np.random.default_rng(0).multivariate_normal(mean, covariance, 20_000) - mean
    inside = np.einsum("ki,ij,kj->k", draws, np.linalg.inv(covariance), draws) < distance[0]
    assert inside.mean() == pytest.approx(0.95, abs=0.005)


def test_a_heat_map_runs_through_its_three_colours(look: Look) -> None:
    scale = ColourScale(0.0, 10.0, ("fixed", "after", "measured"))
    colours = heat_map(np.array([[0.0, 5.0, 10.0, 20.0, np.nan]]), scale, look)[0]
    stops = [look.colour(name)[:3] for name in ("fixed", "after", "measured", "measured", "ground")]
    assert [tuple(map(int, colour)) for colour in colours] == stops


def test_grids_share_one_span() -> None:
    axis = ContextAxis("friction", "1", np.array([0.0, 1.0]))
    one, other = (Grid("a", [axis], np.array(mean), np.zeros(2), "episodes") for mean in ([1.0, np.nan], [-3.0, 2.0]))
    assert return_span([one, other]) == (-3.0, 2.0)
    assert return_span([]) == (0.0, 1.0)


def test_the_span_holds_what_lies_a_standard_deviation_off_a_line_but_not_off_a_map() -> None:
    axis = ContextAxis("friction", "1", np.array([0.0, 1.0]))
    assert return_span([Grid("line", [axis], np.array([1.0, 2.0]), np.array([4.0, 0.5]), "episodes")]) == (-3.0, 5.0)
    assert return_span([Grid("map", [axis, axis], np.eye(2), np.ones((2, 2)), "episodes")]) == (0.0, 1.0)


def test_lines_over_several_parameters_have_a_chart_each_and_groups_their_colour(
    tmp_path: Path, look: Look, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("RERUN_STRICT", "1")
    axes = {"a": ("friction", "1"), "b": ("torso.size", "m"), "c": ("torso.size", "m")}
    lines = {
        group: Grid(group, [ContextAxis(*axis, np.array([0.0, 1.0]))], np.array([1.0, 2.0]), np.ones(2), "episodes")
        for group, axis in axes.items()
    }
    record = SweepRecord("sweep", list(axes), marginals={"torso.size": {"c": marginal()}}, grids=lines)
    write_sweep_review(tmp_path / "review.rrd", record, look)
    found = read_recording(tmp_path / "review.rrd")
    assert found["/returns/friction/titles"]["Points2D:labels"][-1] == ["friction", "return"]
    assert found["/returns/torso.size/titles"]["Points2D:labels"][-1] == ["torso.size [m]", "return"]
    for chart, line, number in (("returns/friction", "0/mean", 0), ("returns/torso.size", "1/mean", 2)):
        assert colour(found[f"/{chart}/{line}"]["LineStrips2D:colors"]) == look.series(number)
    assert colour(found["/distribution/torso.size/learned_0"]["LineStrips2D:colors"]) == look.series(2)


def colour(column: list) -> tuple[int, ...]:
    return tuple(int(column[-1][0]).to_bytes(4, "big"))


def test_a_recording_of_training_has_everything_at_its_iteration(
    tmp_path: Path, look: Look, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("RERUN_STRICT", "1")
    axis = ContextAxis("friction", "1", np.array([0.0, 1.0, 2.0]))
    line = Grid("line", [axis], np.array([np.nan, 1.0, 2.0]), np.zeros(3), "episodes")
    area = Grid("area", [axis, axis], np.arange(9.0).reshape(3, 3), np.zeros((3, 3)), "episodes")
    path = tmp_path / "review.rrd"
    record = TrainingRecord("run", [CURVE], [marginal()], [pair()], [line, area], {"Report": "# Report"})
    write_training_review(path, record, look)
    found = read_recording(path)
    returns = found["/curve/return"]
    np.testing.assert_array_equal(returns["iteration"], ITERATION)
    np.testing.assert_array_equal(np.array(returns["Scalars:scalars"], dtype=float).ravel(), CURVE.value)
    assert len(found["/distribution/torso.size/learned"]["iteration"]) == 5
    ellipses = "/distribution/friction\\,\\ torso.size/ellipses"
    assert {f"{ellipses}/{k}" for k in range(3)} < found.keys()
    strips = np.array(found[f"{ellipses}/0"]["LineStrips2D:strips"][-1])
    middle = strips.reshape(-1, 2)[:-1].mean(axis=0)
    np.testing.assert_allclose(middle, [CANVAS.width / 2, CANVAS.height / 2], rtol=1e-3)
    assert {"/grid/line/mean", "/grid/area/map", "/course/torso.size/map", "/pages/Report"} < found.keys()


def test_a_distributions_course_shows_the_histogram_taken_last() -> None:
    shares = np.array([[0.5, 0.5], [0.9, 0.1], [0.2, 0.8]])
    learned = Marginal("torso.size", "m", EDGES, shares[0], np.array([0, 1, 4]), shares)
    density = shares / [0.1, 0.2]
    # iterations 0.5, 1.5, 2.5, 3.5 at 0.25, 0.15 and 0.05 m
    expected = density[[0, 1, 1, 1]].T[[1, 1, 0]]
    np.testing.assert_allclose(course(learned, rows=3, columns=4), expected)


def test_bands_hold_one_and_two_standard_deviations() -> None:
    spread = Spread("mass", "kg", np.array([0, 2, 4]), np.array([2.0, 2.0, 3.0]), np.array([1.0, 0.4, 0.4]))
    # at 3.5, 2.5, 1.5 and 0.5 kg in iterations 0.5, 1.5, 2.5 and 3.5: 2 ± 0.85, 2 ± 0.55, 2.25 ± 0.4, 2.75 ± 0.4 kg
    expected = [[1, 0, 0, 1], [2, 2, 2, 2], [2, 2, 1, 0], [1, 0, 0, 0]]
    np.testing.assert_array_equal(bands(spread, (0.0, 4.0), rows=4, columns=4), expected)


def test_target_and_model_are_drawn_by_iteration(tmp_path: Path, look: Look, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("RERUN_STRICT", "1")
    time = np.array([0.1, 0.2])
    shown = [Comparison("arm.position", "rad", time, time, 1.0 - time, np.full((3, 2), 9.0 * k)) for k in range(2)]
    spread = Spread("torso.size", "m", ITERATION, np.linspace(1.0, 2.0, 5), np.full(5, 0.1))
    decline = Decline(
        "discrepancy", np.array([1, 3]), {"mean": np.array([10.0, 0.01]), "draws": np.array([1.0, np.nan])}
    )
    path = tmp_path / "review.rrd"
    record = TrainingRecord(
        "run",
        marginals=[marginal()],
        spreads=[spread],
        comparisons=[Comparisons(np.array([1, 3]), shown)],
        declines=[decline],
    )
    write_training_review(path, record, look)
    found = read_recording(path)
    drawn = found["/comparison/arm.position/drawn"]
    np.testing.assert_array_equal(drawn["iteration"], [1, 3])
    assert [len(each) for each in drawn["LineStrips2D:strips"]] == [3, 3]
    target, mean = (found[f"/comparison/arm.position/{name}"]["LineStrips2D:strips"] for name in ("target", "mean"))
    ends = np.array([np.array(each[1]).reshape(2, 2)[:, 1] for each in (target, mean)])
    np.testing.assert_allclose(ends.sum(axis=0), CANVAS.height, rtol=1e-5)  # one is the other upside down
    falling = np.array(found["/decline/discrepancy/mean"]["LineStrips2D:strips"][0]).reshape(2, 2)[:, 1]
    assert 0.0 < falling[0] < falling[1] < CANVAS.height
    assert {"/course/torso.size/bands", "/course/torso.size/mean"} < found.keys()
    assert "/course/torso.size/map" not in found


def test_a_density_and_not_a_probability_is_drawn(tmp_path: Path, look: Look, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("RERUN_STRICT", "1")
    path = tmp_path / "review.rrd"
    write_training_review(path, TrainingRecord("run", marginals=[marginal()]), look)
    strips = read_recording(path)["/distribution/torso.size/learned"]["LineStrips2D:strips"]
    heights = CANVAS.height - np.array(strips[0]).reshape(-1, 2)[:, 1]
    # equal shares of 0.1 m and 0.2 m: twice the density in the first
    assert heights[1] == pytest.approx(2 * heights[3], rel=1e-3)


def test_gains_and_ways_are_drawn_with_what_is_in_doubt(
    tmp_path: Path, look: Look, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("RERUN_STRICT", "1")
    axis = ContextAxis("goal.x", "m", np.array([-1.0, 1.0]))
    value = np.array([[2.0, 1.0], [-2.0, np.nan]])
    area = Gain("of 1 update", [axis, axis], value, value - [[1.0, 2.0], [1.0, np.nan]], value + 1.0)
    assert area.doubtful.tolist() == [[False, True], [False, True]]
    line = Gain("of 2 updates", [axis], value[:, 0], value[:, 0] - 1.0, value[:, 0] + 1.0)
    near, far = np.array([[0.0, 0.0], [0.5, 0.5]]), np.array([[0.0, 0.0], [1.0, 0.0], [90.0, 0.0], [1.0, 0.0]])
    ways = Ways("after 1 update", np.array([[1.0, 1.0], [-1.0, 1.0]]), [near, near], [near, far])
    path = tmp_path / "review.rrd"
    write_training_review(path, TrainingRecord("run", gains=[area, line], ways=[ways]), look)
    found = read_recording(path)
    (doubtful,) = found["/gain/of\\ 1\\ update/doubtful"]["Points2D:positions"]
    assert len(doubtful) == 1  # what is not known at all is not in doubt
    assert "/gain/of\\ 2\\ updates/zero" in found
    course = np.array(found["/ways/after\\ 1\\ update/after_1/way"]["LineStrips2D:strips"][0])
    assert course.shape[-2] == 2  # it ends where it leaves the chart
    assert "/ways/after\\ 1\\ update/after_1/end" not in found
    assert "/ways/after\\ 1\\ update/after_0/end" in found


def test_violins_stand_below_one_another_with_their_medians(tmp_path: Path, look: Look) -> None:
    drawn = [Sample("unseen", np.array([0.0, 10.0, 20.0])), Sample("teachers", np.append(np.full(11, 20.0), np.nan))]
    write_training_review(tmp_path / "review.rrd", TrainingRecord("violins", samples=drawn), look)
    found = read_recording(tmp_path / "review.rrd")
    medians = [found[f"/violins/violin_0{k}_median"]["Points2D:positions"][0][0] for k in (0, 1)]
    # 10 and 20 on an axis from -1 to 21
    np.testing.assert_allclose([at[0] / 130.0 for at in medians], [11 / 22, 21 / 22], rtol=1e-6)
    assert medians[0][1] < medians[1][1]
    dots = np.array(found["/violins/violin_00_returns"]["Points2D:positions"]).reshape(-1, 2)
    np.testing.assert_allclose(dots[:, 0] / 130.0, [1 / 22, 11 / 22, 21 / 22], rtol=1e-6)  # few have no outline
    assert "/violins/violin_00_outline" not in found
    outline = np.array(found["/violins/violin_01_outline"]["LineStrips2D:strips"][0]).reshape(-1, 2)
    assert outline[np.argmin(outline[:, 1]), 0] == pytest.approx(medians[1][0], abs=1.0)  # widest where all returns are
