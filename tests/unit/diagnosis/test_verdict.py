"""The verdict on rankings of which only the scores are known."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from effect_machines import block, placed
from pretended_rankings import (
    ABSORBED,
    CLEAR,
    COUNT,
    HIDDEN,
    SETTINGS,
    WINDOWS,
    at_values,
    candidate,
    few,
    judged,
    model,
    score,
    wild,
)

from dr_lab.diagnosis.evidence.confirmation import Comparison, Confirmation
from dr_lab.diagnosis.evidence.paired_gain import paired_gain
from dr_lab.diagnosis.evidence.score import ChannelScore, Score
from dr_lab.diagnosis.search.climb import _as_before
from dr_lab.diagnosis.search.ladder import Ladder
from dr_lab.diagnosis.search.rung import Rung
from dr_lab.diagnosis.search.step import AddedEffect
from dr_lab.diagnosis.search.verdict import _absorbed, decide
from dr_lab.reports.quantity import number, percent


def test_the_one_effect_that_closes_the_gap_is_named() -> None:
    verdict = judged(20.0, ("actuator_delay", 12.0), ("coulomb_friction", 1.0), ("viscous_friction", 19.0))
    assert verdict.kind == "named"
    assert verdict.effects == ("coulomb_friction@rail",)
    assert verdict.status == {
        "coulomb_friction@rail": "named",
        "actuator_delay@drive": "rejected",
        "viscous_friction@rail": "rejected",
    }
    assert "20" in verdict.reason


def test_the_reason_prints_what_decides_and_where_it_is_from() -> None:
    base = model(20.0)
    found = candidate(base, "coulomb_friction", wild(1.0), CLEAR)
    reason = decide(base, [found], SETTINGS, "fit logs").reason
    assert found.fitted_model.held_out.chi2 > base.held_out.chi2  # one wild window, which the mean alone follows
    assert f"closes {percent(found.gain.gap)} of a typical window's gap" in reason
    evidence, low = (number(value, 4) for value in (found.gain.total, found.gain.total_low))
    assert f"evidence Δχ² {evidence} (99 % interval from {low}, 27 needed)" in reason
    assert f"mean χ² {number(base.held_out.chi2)} before and {number(found.fitted_model.held_out.chi2)} after" in reason
    assert "on the fit logs" in reason
    assert "lowers" not in reason


@pytest.mark.parametrize(("level", "rivals"), [(20.0, 1), (20.0, 2), (20.0, 0), (1.0, 0)])
def test_no_reason_speaks_of_held_out_logs_where_there_are_none(level: float, rivals: int) -> None:
    base = model(level)
    ranking = [candidate(base, name, 1.0, CLEAR) for name in ("coulomb_friction", "constant_offset")[:rivals]]
    for scored in ("fit logs", "held-out logs"):
        reason = decide(base, ranking, SETTINGS, scored).reason
        assert scored in reason
        assert ("held-out" in reason) == (scored == "held-out logs")


def test_what_explains_but_little_of_a_gap_is_not_named() -> None:
    little, enough = judged(20.0, ("coulomb_friction", 17.0)), judged(20.0, ("coulomb_friction", 14.0))
    assert (little.kind, little.effects) == ("unexplained", ())
    assert enough.effects == ("coulomb_friction@rail",)


@pytest.mark.parametrize(
    ("bounds", "left", "kind"),
    [(2, 14.0, "unexplained"), (1, 14.0, "named"), (2, 8.0, "named"), (2, 1.0, "named")],
)
def test_what_is_bent_to_several_bounds_must_explain_most_of_a_gap(bounds: int, left: float, kind: str) -> None:
    """A soft shaft with the largest rotor and damping closes 0.3, 0.6 or all of a gap."""
    base, shaft = model(20.0), placed(block(), "motor_side_elasticity", "rail")
    ends = {p.name.rpartition(".")[2]: p.high for p in shaft.parameters if p.high > p.nominal}
    values = dict(list(ends.items())[-bounds:])
    assert len(values) == bounds
    assert decide(base, [at_values(base, "motor_side_elasticity", left, values)], SETTINGS).kind == kind


@pytest.mark.parametrize(
    ("share", "left", "kind"), [(0.0, 14.0, "unexplained"), (0.1, 14.0, "named"), (0.0, 8.0, "named")]
)
def test_a_cogging_of_less_than_half_a_period_must_explain_most_of_a_gap(share: float, left: float, kind: str) -> None:
    base, force = model(20.0), placed(block(), "cogging", "rail")
    periods = next(p for p in force.parameters if p.name.endswith(".periods"))
    values = {"sine": 1.0, "periods": periods.low + share * (periods.high - periods.low)}
    assert decide(base, [at_values(base, "cogging", left, values)], SETTINGS).kind == kind


@pytest.mark.parametrize(
    ("left", "rivals", "kind"), [(1.0, 0, "named"), (1.0, 1, "equivalent"), (12.0, 1, "unexplained")]
)
def test_what_is_named_closes_most_of_the_gap(left: float, rivals: int, kind: str) -> None:
    base, last = model(20.0), model(left)
    rival = candidate(base, "constant_offset", left, CLEAR)
    ladder = Ladder((), base, (AddedEffect(model(14.0), ()), AddedEffect(last, (rival,) * rivals)))
    assert ladder.verdict(SETTINGS) == kind
    closed = (base.held_out.chi2 - last.held_out.chi2) / (base.held_out.chi2 - 1)
    np.testing.assert_allclose(ladder.closed(SETTINGS), closed, rtol=0.05)


def test_what_leaves_only_noise_is_named_however_small_the_gap_was() -> None:
    base, last = model(1.06), model(1.045)
    ladder = Ladder((), base, (AddedEffect(last, ()),))
    assert ladder.closed(SETTINGS) < SETTINGS.least_named
    assert ladder.verdict(SETTINGS) == "named"


@pytest.mark.parametrize(("noise", "kind"), [(False, "unexplained"), (True, "named")])
def test_what_leaves_coloured_noise_of_the_instruments_need_not_explain_a_part_of_it(noise: bool, kind: str) -> None:
    """A χ² of 20 falls to 17, of which an effect could take nothing more away if that is noise."""
    base, left = model(with_channel(score(20.0), noise=False)), with_channel(score(17.0), noise=noise)
    assert decide(base, [candidate(base, "coulomb_friction", left, CLEAR)], SETTINGS).kind == kind


@pytest.mark.parametrize(
    ("level", "noise", "words"),
    [
        (1.0, True, "at the noise floor"),
        (20.0, True, "the sensors' coloured noise"),
        (1.05, False, "at the noise floor"),
    ],
)
def test_the_floor_of_coloured_noise_is_told_as_such(*, level: float, noise: bool, words: str) -> None:
    verdict = decide(model(with_channel(score(level), noise=noise)), [], SETTINGS)
    assert verdict.kind == "none"
    assert words in verdict.reason


def with_channel(whole: Score, *, noise: bool) -> Score:
    channel = ChannelScore(whole.window_sum, whole.window_count, 1.0, instrumental=noise)
    return replace(whole, channels={"rail.position": channel})


def test_the_first_step_is_what_the_first_rung_names() -> None:
    base = model(20.0)
    ranking = (candidate(base, "coulomb_friction", 12.0, CLEAR),)
    ladder = Ladder((Rung(base, ranking, decide(base, ranking, SETTINGS)),), base, ())
    assert ladder.verdict(SETTINGS) == "named"  # of the first ranking, which is judged alone
    assert ladder.with_first_step().models == (base, ranking[0].fitted_model)
    assert ladder.with_first_step().verdict(SETTINGS) == "unexplained"


def test_nothing_is_named_at_the_noise_floor() -> None:
    verdict = judged(1.0, ("coulomb_friction", 1.0), ("viscous_friction", 1.0))
    assert (verdict.kind, verdict.effects) == ("none", ())
    assert set(verdict.status.values()) == {"rejected"}


@pytest.mark.parametrize(("level", "kind", "left"), [(1.0, "none", 0), (20.0, "unexplained", 1)])
def test_what_other_windows_contradict_is_dropped_where_only_noise_was_to_explain(
    level: float, kind: str, left: int
) -> None:
    base = model(level)
    found = candidate(base, "coulomb_friction", 0.5 * level, CLEAR)
    rung = Rung(base, (found,), decide(base, [found], SETTINGS))
    step = cast(Any, SimpleNamespace(fitted_model=found.fitted_model, effect=found.effect, rivals=()))
    predicted = Comparison(5, score(1.0), score(3.0), found.gain)
    ladder = Ladder((rung,), base, (step,))
    assert ladder.confirmed_by(None, SETTINGS).confirmation is None
    judged_again = ladder.confirmed_by(Confirmation(None, predicted, predicted_worse=True), SETTINGS)
    assert (judged_again.verdict(SETTINGS), len(judged_again.steps)) == (kind, left)
    assert judged_again.dropped == (() if left else ("coulomb_friction@rail",))


def test_a_gap_that_nothing_closes_is_unexplained() -> None:
    verdict = judged(20.0, ("coulomb_friction", 20.0), ("viscous_friction", 20.1))
    assert verdict.kind == "unexplained"
    assert "above the noise floor" in verdict.reason


def drop(chi2: float) -> Score:
    """One window that holds three independent residuals."""
    return replace(few(chi2), chi2=chi2, window_sum=np.array([3.0 * chi2]), window_count=np.array([3.0]))


def test_of_too_little_data_the_nearest_effect_is_told() -> None:
    base = model(drop(656.0))
    reason = decide(base, [candidate(base, "quadratic_drag", drop(39.5), CLEAR)], SETTINGS).reason
    assert "No effect of the catalogue lowers that beyond doubt. quadratic_drag@rail comes nearest." in reason
    assert "27 needed), mean χ² 656 before and 39.5 after, which is not beyond doubt" in reason
    assert "comes nearest" not in judged(20.0, ("coulomb_friction", 20.0)).reason


def test_an_effect_that_closes_a_trifle_of_a_wide_gap_is_not_named() -> None:
    assert judged(20.0, ("coulomb_friction", 19.0)).kind == "unexplained"


def test_what_the_data_do_not_excite_is_told() -> None:
    verdict = judged(1.0, ("coulomb_friction", 1.0), coulomb_friction=HIDDEN)
    assert (verdict.kind, verdict.effects) == ("not_excited", ())
    assert verdict.status == {"coulomb_friction@rail": "not_excited"}
    assert verdict.absorbed == ()
    assert "coulomb_friction@rail" in verdict.reason


def test_where_other_effects_would_show_none_is_the_answer_and_the_silent_one_is_listed() -> None:
    verdict = judged(1.0, ("coulomb_friction", 1.0), ("viscous_friction", 1.0), coulomb_friction=HIDDEN)
    assert verdict.kind == "none"
    assert "would not show in the logs: coulomb_friction@rail." in verdict.reason


def test_a_gap_beside_silent_effects_stays_unexplained() -> None:
    assert judged(20.0, ("coulomb_friction", 20.0), coulomb_friction=HIDDEN).kind == "unexplained"


def test_what_free_parameters_can_replace_is_told() -> None:
    verdict = judged(1.0, ("armature", 1.0), ("coulomb_friction", 1.0), armature=ABSORBED)
    assert verdict.kind == "none"
    assert verdict.absorbed == ("armature@rail",)
    assert verdict.status == {"armature@rail": "equivalent", "coulomb_friction@rail": "rejected"}


@pytest.mark.parametrize(("total", "gap", "absorbed"), [(60.0, 0.6, False), (60.0, 0.3, True), (9.0, 0.6, True)])
def test_what_gains_much_is_replaced_by_nothing(total: float, gap: float, *, absorbed: bool) -> None:
    base = model(20.0)
    found = candidate(base, "armature", 12.0, ABSORBED)
    found = replace(found, gain=replace(found.gain, total=total, gap=gap, channels={}))
    assert _absorbed(found, SETTINGS) == absorbed


def test_what_free_parameters_can_replace_is_told_of_few_data_as_well() -> None:
    base = model(few(1.0))
    verdict = decide(base, [candidate(base, "armature", few(1.0), ABSORBED)], SETTINGS)
    assert verdict.status == {"armature@rail": "equivalent"}


def diverging(level: float, windows: int) -> Score:
    whole = score(level)
    lost = np.arange(WINDOWS) < windows
    sums, counts = np.where(lost, 0.0, whole.window_sum), np.where(lost, 0.0, COUNT)
    chi2 = float(sums.sum() / counts.sum()) if counts.any() else np.inf
    return Score(chi2, {}, {}, {}, sums, counts, whole.log, windows)


@pytest.mark.parametrize("lost", [1, WINDOWS])
def test_windows_that_diverge_are_no_gain(lost: int) -> None:
    verdict = judged(20.0, ("coulomb_friction", diverging(1.0, lost)))
    assert (verdict.kind, verdict.effects) == ("unexplained", ())


def test_a_model_that_diverges_everywhere_is_not_at_the_noise_floor() -> None:
    assert judged(diverging(1.0, WINDOWS), ("coulomb_friction", 1.0)).kind == "unexplained"


@pytest.mark.parametrize(("lost", "kind"), [(14, "none"), (15, "unexplained"), (WINDOWS, "unexplained")])
def test_half_of_the_windows_must_be_simulated_at_the_noise_floor(lost: int, kind: str) -> None:
    verdict = judged(with_channel(diverging(1.0, lost), noise=False))
    assert verdict.kind == kind
    assert f"{lost} of 30 windows diverge" in verdict.reason


def test_windows_that_only_the_base_loses_count_for_neither() -> None:
    verdict = judged(diverging(20.0, 5), ("coulomb_friction", 1.0))
    assert verdict.effects == ("coulomb_friction@rail",)


@pytest.mark.parametrize(
    ("needless", "level", "status"), [(True, 1.0, "not_needed"), (False, 1.0, "rejected"), (True, 19.9, "rejected")]
)
def test_what_explained_as_much_on_few_windows_is_not_needed_beside_what_is_named(
    needless: bool, level: float, status: str
) -> None:
    base = model(20.0)
    named = candidate(base, "coulomb_friction", level, CLEAR)
    tried = replace(candidate(base, "stribeck_friction", 1.0, CLEAR), final=False, needless=needless)
    verdict = decide(base, [named, tried], SETTINGS)
    assert bool(verdict.effects) == (level == 1.0)
    assert verdict.status["stribeck_friction@rail"] == status


def test_a_special_case_takes_the_place_of_what_is_put_back_to_it() -> None:
    verdict = judged(20.0, ("stribeck_friction", 1.0), ("coulomb_friction", 12.0), ("viscous_friction", 19.0))
    assert verdict.effects == ("stribeck_friction@rail",)
    settled = verdict.put_back("stribeck_friction@rail", "coulomb_friction@rail")
    assert settled.effects == ("coulomb_friction@rail",)
    assert settled.status == {
        "coulomb_friction@rail": "named",
        "stribeck_friction@rail": "not_needed",
        "viscous_friction@rail": "rejected",
    }
    assert settled.put_back("stribeck_friction@rail", "coulomb_friction@rail") is settled
    assert verdict.put_back("stribeck_friction@rail", "coulomb_friction@elbow") is verdict  # none of the candidates


@pytest.mark.parametrize(
    ("judged_at", "now", "wanted", "kept"),
    [
        (1.0, 0.99, ("viscous_friction",), True),
        (1.0, 0.99, ("viscous_friction", "spring"), False),  # one of them was not judged
        (1.0, 20.0, ("viscous_friction",), False),
        (20.0, 1.0, ("viscous_friction",), False),
    ],
)
def test_candidates_keep_their_fits_beside_a_model_of_the_same_effects_at_the_noise_floor(
    judged_at: float, now: float, wanted: tuple[str, ...], *, kept: bool
) -> None:
    plain = cast(Any, SimpleNamespace(effects=()))
    base, last = (replace(model(level), model=plain) for level in (judged_at, now))
    ranking = tuple(candidate(base, name, 0.98, CLEAR) for name in ("coulomb_friction", "viscous_friction"))
    ladder = Ladder((Rung(base, ranking, decide(base, ranking, SETTINGS)),), last, ())
    placed = [candidate(base, name, 0.98, CLEAR).effect for name in wanted]
    found = _as_before(ladder, placed, SETTINGS)
    assert (found is not None) == kept
    if found is not None:
        (again,) = found.candidates
        assert (found.base, again.effect.label) == (last, "viscous_friction@rail")
        expected = paired_gain(last.held_out, again.fitted_model.held_out, SETTINGS)
        assert again.gain.total == pytest.approx(expected.total)
