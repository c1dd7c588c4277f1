"""The rules by which an answer is right, each with an answer whose judgement is known."""

import json
from dataclasses import replace

import numpy as np
import pytest
from pretended_cases import STANDING, A, B, C, named, outcome_of

from dr_lab.benchmark.causes import cause
from dr_lab.benchmark.outcome import BASE, Outcome
from dr_lab.benchmark.score import mark, missed

BOTH = {A: {A: 1, B: 1}}
RICHER = {A: {A: 1, B: 1, "stribeck_friction@arm": 3}}
HIDDEN = {A: {A: 1, BASE: 0}}

RIGHT = {
    "named exactly": named(A),
    "named by another of its class": named(A, answer=B, classes=BOTH),
    "exactly the class": outcome_of("single", A, verdict="equivalent", found=[[B, A]], classes=BOTH),
    "the class without richer members": outcome_of("single", A, verdict="equivalent", found=[[A, B]], classes=RICHER),
    "absorbed and listed": outcome_of("single", A, absorbed=[C, A], classes=HIDDEN),
    "not excited and listed": outcome_of(
        "single", A, classes=HIDDEN, standing={A: replace(STANDING, status="not_excited")}
    ),
    "nothing hidden": outcome_of("none"),
    "outside": outcome_of("outside", verdict="unexplained"),
    "both": outcome_of("several", A, B, verdict="named", found=[[B], [A]]),
    "both, one with a rival": outcome_of("several", A, B, verdict="equivalent", found=[[C, A], [B]]),
    "both, one by its class": outcome_of("several", A, B, verdict="named", found=[[C], [B]], classes={A: {A: 1, C: 1}}),
    "one shown, one absorbed": outcome_of(
        "several", A, B, verdict="named", found=[[B]], absorbed=[A], classes={A: {A: 1, BASE: 0}}
    ),
}
WRONG = {
    "another effect": named(A, answer=B, classes={A: {A: 1}}),
    "an abstention where the class has one member": outcome_of("single", A, classes={A: {A: 1}}),
    "a set that is too large": outcome_of("single", A, verdict="equivalent", found=[[A, B]], classes={A: {A: 1}}),
    "a set that is too small": outcome_of(
        "single", A, verdict="equivalent", found=[[A, B]], classes={A: {A: 1, B: 1, C: 1}}
    ),
    "absorbed, not listed": outcome_of("single", A, classes=HIDDEN),
    "an effect for one that does not show": named(A, answer=B, classes=HIDDEN),
    "a false alarm": outcome_of("none", verdict="named", found=[[A]]),
    "a gap where there is none": outcome_of("none", verdict="unexplained"),
    "something of the catalogue for something outside": outcome_of("outside", verdict="named", found=[[A]]),
    "one of two": outcome_of("several", A, B, verdict="named", found=[[A]], classes={B: {B: 1}}),
    "one effect for two": outcome_of("several", A, B, verdict="equivalent", found=[[A, B]]),
}
FALSE = {
    "another effect",
    "an effect for one that does not show",
    "a false alarm",
    "something of the catalogue for something outside",
}


@pytest.mark.parametrize("name", RIGHT)
def test_right_answers(name: str) -> None:
    judged = mark(RIGHT[name])
    assert (judged.right, judged.top_3, judged.false) == (True, True, False)
    assert cause(RIGHT[name]) == ""


@pytest.mark.parametrize("name", WRONG)
def test_wrong_answers(name: str) -> None:
    judged = mark(WRONG[name])
    assert not judged.right
    assert judged.false == (name in FALSE)
    assert cause(WRONG[name])


def test_an_extra_effect_beside_two_right_ones_is_false() -> None:
    judged = mark(outcome_of("several", A, B, verdict="named", found=[[A], [B], [C]]))
    assert judged.right
    assert judged.false


def test_top_3_looks_at_the_ranking() -> None:
    assert mark(outcome_of("single", C, ranking=[A, B, C], classes={C: {C: 1}})).top_3
    assert not mark(outcome_of("single", C, ranking=[A, B, BASE, C], classes={C: {C: 1}})).top_3


def test_the_truth_named_exactly_is_matched_before_its_rivals() -> None:
    assert missed(outcome_of("several", A, B, verdict="named", found=[[B, A], [A]])) == []


def test_causes_say_what_stood_in_the_way() -> None:
    unfitted = outcome_of("single", A, classes={A: {A: 1}}, standing={A: replace(STANDING, fitted=False)})
    assert cause(unfitted) == f"{A} was not fitted: a linear step promised 40 % of the cost."
    assert cause(outcome_of("single", A, classes={A: {A: 1}}, standing={})) == f"{A} was no candidate."
    assert "came 2. with χ² 1.3, evidence 300 (at least -5), closing 60 %" in cause(WRONG["another effect"])
    assert cause(WRONG["a set that is too small"]) == f"The set of equivalent effects lacks {C}."
    assert cause(WRONG["a set that is too large"]) == f"The set of equivalent effects adds {B}."


def test_an_outcome_survives_its_file() -> None:
    outcome = RIGHT["one shown, one absorbed"]
    again = Outcome.from_json(outcome.to_json())
    assert again == outcome
    assert hash(again.case) == hash(outcome.case)


def test_numbers_that_are_not_finite_come_back_as_nan() -> None:
    unknown = replace(STANDING, chi2=np.inf, gap=np.nan)
    outcome = named(
        A, standing={A: unknown}, fitted={A: {"torque": np.nan}}, stated={A: {"torque": np.inf}}, chi2=np.inf
    )
    again = Outcome.from_json(outcome.to_json())
    back = (again.standing[A].chi2, again.standing[A].gap, again.fitted[A]["torque"], again.stated[A]["torque"])
    assert np.isnan(np.array([*back, again.chi2], dtype=float)).all()
    assert Outcome.from_json(again.to_json()).to_json() == outcome.to_json()
    assert cause(replace(again, found=[[B]])).startswith(f"{A} came 2. with χ² –")


def test_an_outcome_of_an_earlier_version_is_read() -> None:
    """Numbers of an only truth stood alone, and a truth that was no candidate had an empty standing."""
    outcome = outcome_of("single", A, magnitudes={A: {"torque": 2e-3}}, standing={})
    earlier = json.loads(outcome.to_json()) | {"magnitudes": {"torque": 2e-3, "site": "arm"}, "standing": {A: {}}}
    assert Outcome.from_json(json.dumps(earlier)) == outcome
