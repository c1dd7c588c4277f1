"""What windows that chose nothing say: found again, undecided, or contradicted."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from diagnosis_machines import (
    PENDULUM,
    evidence_settings,
    model_of,
    predicted_settings,
    solver_settings,
    swinging,
    windows_of,
    windows_settings,
)

from dr_lab.diagnosis.evidence.bench import Bench, FittedModel, fit_and_score
from dr_lab.diagnosis.evidence.confirmation import Comparison, Confirmation, _grown, confirm
from dr_lab.diagnosis.evidence.paired_gain import paired_gain
from dr_lab.diagnosis.evidence.score import Score
from dr_lab.diagnosis.fit.states import fit_states
from dr_lab.diagnosis.windows.windows import Windows
from dr_lab.physics.model import Model
from dr_lab.trajectory import Array

FREE = {"hinge.damping": {"target": "joint.hinge.damping", "unit": "N·m·s/rad", "low": 0.0, "high": 1.0}}


def comparison(total: float, low: float) -> Comparison:
    return Comparison(5, cast(Any, None), cast(Any, None), cast(Any, SimpleNamespace(total=total, total_low=low)))


@pytest.mark.parametrize(
    ("apart", "worse", "status"),
    [
        (comparison(50.0, 20.0), False, "confirmed"),
        (comparison(50.0, -20.0), False, "undecided"),
        (comparison(-5.0, -20.0), False, "contradicted"),
        (comparison(-5.0, np.nan), False, "undecided"),
        (comparison(50.0, 20.0), True, "contradicted"),
        (None, False, "undecided"),
        (None, True, "contradicted"),
    ],
)
def test_status(apart: Comparison | None, worse: bool, status: str) -> None:
    assert Confirmation(apart, comparison(1.0, 0.0), worse).status == status


def lost() -> Score:
    """Of five windows that all diverge."""
    return replace(chi2(1.0), chi2=np.inf, window_sum=np.zeros(5), window_count=np.zeros(5), infeasible=5)


def test_what_simulates_where_the_calibrated_model_diverges_is_not_contradicted() -> None:
    for before, after, status in ((lost(), chi2(1.0), "undecided"), (chi2(1.0), lost(), "contradicted")):
        apart = Comparison(5, before, after, paired_gain(before, after, evidence_settings()))
        assert Confirmation(apart, comparison(1.0, 0.0), predicted_worse=False).status == status


def chi2(level: float) -> Score:
    """Of five windows with sixty residuals each."""
    sums, count = np.full(5, 60 * level), np.full(5, 60.0)
    return Score(level, {}, {}, {}, sums, count, np.zeros(5, int), 0)


@pytest.mark.parametrize(
    ("before", "after", "grown"),
    [(1.01, 1.03, False), (1.05, 1.4, False), (0.99, 8.0, True), (600.0, 700.0, False), (600.0, 7000.0, True)],
)
def test_few_windows_contradict_what_grows_the_error_there(before: float, after: float, *, grown: bool) -> None:
    few = replace(comparison(-5.0, np.nan), before=chi2(before), after=chi2(after))
    found = Confirmation(few, comparison(1.0, 0.0), predicted_worse=False, grown=_grown(few, evidence_settings()))
    assert found.contradicts == grown


def at(model: Model, bench: Bench, damping: float) -> FittedModel:
    """The model with a damping that is not fitted."""
    fixed = {"hinge.damping": {**FREE["hinge.damping"], "low": damping - 1e-9, "high": damping + 1e-9}}
    rubbed = PENDULUM.replace('damping="0.05"', f'damping="{damping}"')
    return fit_and_score(bench, model_of(rubbed, fixed), np.array([damping]))


def compared(more: float, seconds: float) -> Confirmation:
    """What predicted windows say of a damping that is so much too large, beside the right one."""
    model = model_of(PENDULUM, FREE)
    logs = [swinging(f"log_{k}", model.nominal(), k) for k in range(4)]
    fit, chooses, apart = (windows_of(model, part, windows_settings()) for part in (logs[:2], logs[2:3], logs[3:]))
    bench = Bench(fit, chooses, solver_settings(), evidence_settings(), 1, confirms=apart)
    right = float(model.space.nominal[0])
    good, bad = at(model, bench, right), at(model, bench, right + more)
    found = confirm(bench, windows_of(model, logs[2:3], predicted_settings(seconds=seconds)), good, bad, fits)
    assert found is not None
    return found


def fits(model: Model, z: Array, windows: Windows) -> Any:  # noqa: ANN401 (a replay and a fit of states)
    return fit_states(model, z, windows, solver_settings(), 1)


def test_few_windows_contradict_without_the_threshold_that_guards_a_choice_among_many() -> None:
    found = compared(0.0014, 1.8)
    back = paired_gain(found.predicted.after, found.predicted.before, evidence_settings())
    assert back.total < evidence_settings().threshold
    assert back.total_low > 0
    assert found.predicted_worse


def test_what_is_lost_in_doubt_contradicts_nothing() -> None:
    assert not compared(0.001, 1.8).predicted_worse


def test_what_predicts_worse_beyond_doubt_contradicts_and_what_predicts_better_does_not() -> None:
    model = model_of(PENDULUM, FREE)
    logs = [swinging(f"log_{k}", model.nominal(), k) for k in range(4)]
    fit, chooses, apart = (windows_of(model, part, windows_settings()) for part in (logs[:2], logs[2:3], logs[3:]))
    bench = Bench(fit, chooses, solver_settings(), evidence_settings(), 1, confirms=apart)
    predicted = windows_of(model, logs[2:], predicted_settings())
    right = float(model.space.nominal[0])
    good, bad = at(model, bench, right), at(model, bench, right + 0.4)
    better, worse = (confirm(bench, predicted, *pair, fits) for pair in ((bad, good), (good, bad)))
    assert better is not None
    assert worse is not None
    assert (better.status, better.predicted_worse) == ("confirmed", False)
    assert (worse.status, worse.predicted_worse) == ("contradicted", True)
    assert confirm(bench, predicted, good, good, fits) is None
