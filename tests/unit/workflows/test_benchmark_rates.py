"""Rates against closed forms, and the figures of a handful of outcomes."""

import csv
import io
import json
from math import sqrt
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from pretended_cases import A, B, C, case_of, named, outcome_of
from recorder_samples import read_recording

from dr_lab.benchmark.outcome import Outcome, numbers_of
from dr_lab.benchmark.pages import report_page
from dr_lab.benchmark.rates import medians, parameter_errors, rate, rates, within_stated
from dr_lab.benchmark.scoring import Goals, Scoring
from dr_lab.benchmark.summary import answers, benchmark_report, cases_csv
from dr_lab.cli.compose import compose
from dr_lab.cli.folders import shipped
from dr_lab.cli.groups import every
from dr_lab.effects.effect import Effect
from dr_lab.plants.hidden.actuator_lag import ActuatorLag
from dr_lab.plants.hidden.coasting_bridge import CoastingBridge
from dr_lab.plants.hidden.effect import HiddenEffect
from dr_lab.plants.hidden.force_limit import ForceLimit
from dr_lab.plants.hidden.joint_coupling import JointCoupling
from dr_lab.plants.hidden.rate_limit import RateLimit
from dr_lab.plants.hidden.torque_speed_limit import TorqueSpeedLimit
from dr_lab.plants.hidden.wind import Wind
from dr_lab.recorders.benchmark_review import write_benchmark_review
from dr_lab.recorders.confusion import confusion, confusion_csv, confusion_picture
from dr_lab.recorders.look import Look
from dr_lab.reports.benchmark import BenchmarkReport, GoalEntry
from dr_lab.reports.json_file import typed, write_json

GOALS = Goals({"top_1": 0.7}, {"false_alarm": 0.02})
ALIASES = {"saturation": {"limit": "inverse_limit"}}
OUTCOMES = [
    named(A, seed=0),
    named(A, seed=1),
    named(A, seed=2, answer=B, classes={A: {A: 1}}),
    outcome_of("single", B, classes={B: {B: 1}}, ranking=[A, B]),
    outcome_of("several", A, B, verdict="named", found=[[A], [B]]),
    outcome_of("none", chi2=1.2),
    outcome_of("none", seed=1, verdict="named", found=[[C]]),
    outcome_of("outside", verdict="unexplained", chi2=40.0),
]


@pytest.mark.parametrize(("count", "of"), [(0, 100), (2, 108), (95, 100), (1, 1)])
def test_intervals_are_wilsons(count: int, of: int) -> None:
    found = rate([True] * count + [False] * (of - count))
    assert found is not None
    z, p = 1.959963984540054, count / of
    middle = (p + z**2 / (2 * of)) / (1 + z**2 / of)
    half = z / (1 + z**2 / of) * sqrt(p * (1 - p) / of + z**2 / (4 * of**2))
    assert (found.count, found.of, found.share) == (count, of, p)
    assert (found.low, found.high) == pytest.approx((max(middle - half, 0), min(middle + half, 1)), abs=1e-12)


def test_no_case_has_no_rate() -> None:
    assert rate([]) is None


def test_rates_count_the_cases_that_they_speak_of() -> None:
    found = {name: (r.count, r.of) for name, r in rates(OUTCOMES, ALIASES).items() if r is not None}
    assert found == {
        "top_1": (2, 4),
        "top_3": (4, 4),
        "identifiable": (2, 4),
        "both_found": (1, 1),
        "doubles": (1, 1),
        "false_alarm": (1, 2),
        "wrong_with_confidence": (2, 8),
        "outside_unexplained": (1, 1),
        "abstained_equivalent": (0, 4),
        "abstained_none": (1, 4),
        "abstained_unexplained": (0, 4),
    }


def test_parameter_errors_speak_the_catalogues_names() -> None:
    limit = named(
        "saturation@motor",
        magnitudes={"saturation@motor": {"limit": 4.0}},
        fitted={"saturation@motor": {"inverse_limit": 0.2}},
    )
    assert parameter_errors(limit, ALIASES) == {"saturation@motor.inverse_limit": pytest.approx(0.25)}
    two = {A: {"torque": 2e-3}, B: {"stiffness": 2.0, "rest": 0.1}}
    both = outcome_of("several", A, B, magnitudes=two, fitted={A: {"torque": -2.1e-3}, B: {"stiffness": 1.8}})
    expected = {f"{A}.torque": pytest.approx(0.05), f"{B}.stiffness": pytest.approx(0.1)}
    assert parameter_errors(both, ALIASES) == expected
    assert parameter_errors(named(A, magnitudes={A: {"torque": 2e-3}}), ALIASES) == {}


@pytest.mark.parametrize(
    ("hidden", "fitted"),
    [
        (ActuatorLag(0.004, "motor"), {"tau": 0.004}),
        (RateLimit(50.0, 1e-4, "motor"), {"inverse_rate": 0.02}),
        (ForceLimit("wheel", 4.0), {"inverse_limit": 0.25}),
        (TorqueSpeedLimit("wheel", 0.5, 20.0), {"inverse_stall": 2.0, "inverse_speed": 0.05}),
        (CoastingBridge("wheel", 20.0), {"inverse_speed": 0.05}),
        (Wind(along_x=-3.0), {"x": -3.0}),
        (JointCoupling("elbow", "shoulder", 600.0, 0.03, 0.06, 0.0), {"stiffness": 0.54, "ratio": 2.0}),
    ],
)
def test_what_is_fitted_exactly_has_no_error(hidden: HiddenEffect, fitted: dict[str, float]) -> None:
    """600 N/m over pulleys of 3 cm are 0.54 N·m/rad at the joint."""
    label, main = hidden.label, next(iter(fitted))
    exact = named(label, magnitudes=numbers_of([label], hidden.parameters), fitted={label: fitted})
    aliases = compose("benchmark", []).parameter_aliases
    assert parameter_errors(exact, aliases) == {f"{label}.{main}": pytest.approx(0.0, abs=1e-12)}


@pytest.mark.parametrize(
    ("fitted", "std", "answer", "remaining", "within"),
    [
        pytest.param(0.26, 0.006, "saturation@motor", "at_floor", [True], id="within two of the reciprocal"),
        pytest.param(0.26, 0.004, "saturation@motor", "at_floor", [False], id="beyond"),
        pytest.param(-0.26, 0.006, "saturation@motor", "at_floor", [True], id="with the other sign"),
        pytest.param(0.26, 0.006, "saturation@motor", "unexplained", [], id="the model misses something else"),
        pytest.param(0.26, 0.006, B, "at_floor", [], id="another effect is named"),
    ],
)
def test_stated_intervals_are_counted_where_the_answer_is_right(
    fitted: float, std: float, answer: str, remaining: str, within: list[bool]
) -> None:
    limit = named(
        "saturation@motor",
        answer=answer,
        remaining=remaining,
        magnitudes={"saturation@motor": {"limit": 4.0}},
        fitted={"saturation@motor": {"inverse_limit": fitted}},
        stated={"saturation@motor": {"inverse_limit": std}},
    )
    assert within_stated(limit, ALIASES) == within
    found = rates([limit, *OUTCOMES], ALIASES)["parameter_within_stated"]
    assert [found and (found.count, found.of)] == ([(sum(within), 1)] if within else [None])


@pytest.mark.parametrize(("fitted", "std"), [(0.5, np.inf), (0.5, np.nan), (np.nan, 0.1), (np.inf, 0.1)])
def test_what_is_not_finite_counts_nowhere_fresh_or_read_back(fitted: float, std: float) -> None:
    fresh = named(A, magnitudes={A: {"torque": 1.0}}, fitted={A: {"torque": fitted}}, stated={A: {"torque": std}})
    errors = {f"{A}.torque": 0.5} if np.isfinite(fitted) else {}
    for outcome in (fresh, Outcome.from_json(fresh.to_json())):
        assert within_stated(outcome, ALIASES) == []
        assert parameter_errors(outcome, ALIASES) == errors
        assert medians([outcome], ALIASES)["median_parameter_error"] == (0.5 if errors else None)


def test_the_report_holds_goals_machines_and_misses(tmp_path: Path) -> None:
    failed = {case_of("none", seed=9): "DataError: no logs"}
    found = benchmark_report(OUTCOMES, failed, Scoring(GOALS, ALIASES, {}))
    assert found.goals == {"top_1": GoalEntry("≥ 0.7", met=None), "false_alarm": GoalEntry("≤ 0.02", met=None)}
    judged = benchmark_report(OUTCOMES, {}, Scoring(GOALS, ALIASES, {}))
    assert judged.goals == {"top_1": GoalEntry("≥ 0.7", met=False), "false_alarm": GoalEntry("≤ 0.02", met=False)}
    assert "| 2 of 4 | ≥ 0.7 | MISSED |" in report_page(judged, OUTCOMES, ALIASES).markdown()
    assert found.medians["median_chi2"] == pytest.approx(1.01)
    assert found.machines["crank"].cases == found.cases == 8
    assert [row.truth for row in found.misses] == [A, B, "none"]
    path = tmp_path / "benchmark.json"
    write_json(path, found)
    assert typed(BenchmarkReport, json.loads(path.read_text(encoding="utf-8")), path) == found
    page = report_page(found, OUTCOMES, ALIASES).markdown()
    assert "| effect and site right, one hidden effect | 50 % | 15 % … 85 % | 2 of 4 | ≥ 0.7 | not judged |" in page
    assert "failed: crank-none-encoders-9: DataError: no logs" in page
    rows = list(csv.DictReader(io.StringIO(cases_csv(OUTCOMES, ALIASES))))
    assert [row["right"] for row in rows] == ["True", "True", "False", "False", "True", "True", "False", "True"]


def test_the_confusion_matrix_counts_effects_and_leaves_sites_and_pairs_out() -> None:
    effects: dict[str, Effect] = {}
    matrix = answers(OUTCOMES, effects)
    assert matrix.truths == ("outside", "none", "coulomb_friction", "spring")
    assert matrix.answers == ("none", "unexplained", "actuator_delay", "coulomb_friction", "spring")
    assert matrix.count.sum() == 7
    assert matrix.right.sum() == 4
    assert "coulomb_friction,coulomb_friction,2,2\n" in confusion_csv(matrix)
    assert "coulomb_friction,spring,1,0\n" in confusion_csv(matrix)


def test_the_picture_is_blue_where_right_and_orange_where_wrong(look: Look) -> None:
    matrix = confusion([("a", "a", True), ("b", "a", False)], ["a", "b"])
    picture = confusion_picture(matrix, look)
    blue, orange = (np.array(look.colour(role)[:3]) for role in ("after", "before"))
    here, there = ((picture == colour).all(-1) for colour in (blue, orange))
    cell = 32 * 32
    for found in (here, there):
        assert cell / 2 < found.sum() < 1.5 * cell
    # the first row lies above the second, in the same column
    (first, column), (second, below) = (np.argwhere(found).mean(0) for found in (here[:-60], there[:-60]))
    assert first + 25 < second
    assert column == pytest.approx(below, abs=3)


def test_the_picture_of_the_whole_catalogue_has_a_cell_for_every_pair(look: Look) -> None:
    names = every("effect", (shipped(),))
    pairs = [(name, name, True) for name in names]
    picture = confusion_picture(confusion(pairs, names), look)
    assert picture.shape[0] > 32 * len(names)
    assert Image.fromarray(picture).size == picture.shape[1::-1]


def test_the_recording_holds_the_picture_and_the_pages(look: Look, tmp_path: Path) -> None:
    picture = confusion_picture(confusion([("a", "a", True)], ["a"]), look)
    write_benchmark_review(tmp_path / "review.rrd", picture, {"Figures": "one", "Misses": "two"})
    entities = read_recording(tmp_path / "review.rrd")
    assert {"/confusion", "/pages/Figures", "/pages/Misses"} <= set(entities)
