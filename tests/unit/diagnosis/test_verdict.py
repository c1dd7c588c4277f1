from dataclasses import dataclass, replace
from typing import Any, cast

import numpy as np
import pytest
from diagnosis_machines import evidence_settings
from effect_machines import block, placed

from dr_lab.diagnosis.evidence import paired_gain
from dr_lab.diagnosis.identifiability import Identifiability
from dr_lab.diagnosis.ladder import Ladder, Rung, Step
from dr_lab.diagnosis.rank import Candidate, Explained
from dr_lab.diagnosis.score import Score
from dr_lab.diagnosis.verdict import Verdict, decide

SETTINGS = evidence_settings()
WINDOWS, COUNT = 30, 300.0
NOISE = np.random.default_rng(0).chisquare(COUNT, WINDOWS)
CLEAR, HIDDEN = Identifiability(alone=1e4, beside=1e3), Identifiability(alone=1.0, beside=0.5)
ABSORBED = Identifiability(alone=1e6, beside=1.0)


def score(level: float, seed: int = 0) -> Score:
    """A χ² per sample of about `level` in every window, the same noise below all models."""
    extra = (level - 1) * COUNT * np.random.default_rng(seed).uniform(0.5, 1.5, WINDOWS)
    sums = NOISE + extra
    return Score(
        float(sums.sum() / COUNT / WINDOWS), {}, {}, {}, sums, np.full(WINDOWS, COUNT), np.arange(WINDOWS) // 10, 0
    )


def wild(level: float) -> Score:
    """The same, but for one window far off."""
    whole = score(level)
    sums = whole.window_sum.copy()
    sums[7] = 700.0 * COUNT
    return replace(whole, chi2=float(sums.sum() / COUNT / WINDOWS), window_sum=sums)


@dataclass(frozen=True)
class Fitted:
    """A fit of which only the cost is known."""

    cost: float

    def below(self, other: "Fitted") -> float:
        """By how much the cost is below another's."""
        return other.cost - self.cost


def model(level: float | Score, cost: float = 0.0) -> Explained:
    nothing = cast(Any, None)
    return Explained(nothing, cast(Any, Fitted(cost)), nothing, level if isinstance(level, Score) else score(level))


def candidate(base: Explained, name: str, level: float | Score, known: Identifiability, cost: float = 0.0) -> Candidate:
    explained = model(level, cost)
    gain = paired_gain(base.held_out, explained.held_out, SETTINGS)
    site = "drive" if name in ("actuator_delay", "saturation", "torque_scale") else "rail"
    return Candidate(placed(block(), name, site), explained, gain, known, predicted=1.0)


def judged(level: float | Score, *levels: tuple[str, float | Score], **known: Identifiability) -> Verdict:
    """Verdict on effects that bring the χ² to a level each; `known` by effect."""
    base = model(level)
    ranking = [candidate(base, name, each, known.get(name, CLEAR)) for name, each in levels]
    return decide(base, sorted(ranking, key=lambda c: -c.gain.total), SETTINGS)


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
    assert found.explained.held_out.chi2 > base.held_out.chi2  # one wild window, which the mean alone follows
    assert f"closes {100 * found.gain.gap:.3g} % of a typical window's gap" in reason
    assert f"evidence Δχ² {found.gain.total:.4g} (99 % interval from {found.gain.total_low:.4g}, 27 needed)" in reason
    assert f"mean χ² {base.held_out.chi2:.3f} before and {found.explained.held_out.chi2:.3f} after" in reason
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
    ("left", "rivals", "kind"), [(1.0, 0, "named"), (1.0, 1, "equivalent"), (9.0, 1, "unexplained")]
)
def test_what_is_named_closes_most_of_the_gap(left: float, rivals: int, kind: str) -> None:
    base, last = model(20.0), model(left)
    rival = candidate(base, "constant_offset", left, CLEAR)
    ladder = Ladder((), base, (Step(model(14.0), ()), Step(last, (rival,) * rivals)))
    assert ladder.verdict(SETTINGS) == kind
    closed = (base.held_out.chi2 - last.held_out.chi2) / (base.held_out.chi2 - 1)
    np.testing.assert_allclose(ladder.closed(SETTINGS), closed, rtol=0.05)


def test_what_leaves_only_noise_is_named_however_small_the_gap_was() -> None:
    base, last = model(1.06), model(1.03)
    ladder = Ladder((), base, (Step(last, ()),))
    assert ladder.closed(SETTINGS) < SETTINGS.least_named
    assert ladder.verdict(SETTINGS) == "named"


def test_the_first_step_is_what_the_first_rung_names() -> None:
    base = model(20.0)
    ranking = (candidate(base, "coulomb_friction", 9.0, CLEAR),)
    ladder = Ladder((Rung(base, ranking, decide(base, ranking, SETTINGS)),), base, ())
    assert ladder.verdict(SETTINGS) == "named"  # of the first ranking, which is judged alone
    assert ladder.with_first_step().models == (base, ranking[0].explained)
    assert ladder.with_first_step().verdict(SETTINGS) == "unexplained"


def test_nothing_is_named_at_the_noise_floor() -> None:
    verdict = judged(1.0, ("coulomb_friction", 1.0), ("viscous_friction", 1.0))
    assert (verdict.kind, verdict.effects) == ("none", ())
    assert set(verdict.status.values()) == {"rejected"}


def test_a_gap_that_nothing_closes_is_unexplained() -> None:
    verdict = judged(20.0, ("coulomb_friction", 20.0), ("viscous_friction", 20.1))
    assert verdict.kind == "unexplained"
    assert "above the noise floor" in verdict.reason


def test_an_effect_that_closes_a_trifle_of_a_wide_gap_is_not_named() -> None:
    assert judged(20.0, ("coulomb_friction", 19.0)).kind == "unexplained"


def test_effects_that_explain_equally_well_are_equivalent() -> None:
    verdict = judged(20.0, ("actuator_delay", 1.001), ("coulomb_friction", 1.0), ("constant_offset", 5.0))
    assert verdict.kind == "equivalent"
    assert set(verdict.effects) == {"actuator_delay@drive", "coulomb_friction@rail"}
    assert verdict.effects[0] == "coulomb_friction@rail"  # friction is nearer to the joint than the actuator
    assert verdict.status["constant_offset@rail"] == "rejected"
    assert verdict.status["actuator_delay@drive"] == "equivalent"


def rivals(level: float, cost: float, best: str = "coulomb_friction", other: str = "constant_offset") -> Verdict:
    """The verdict on two effects that bring a χ² of 20 down to a level, one of them at a higher cost on fitted logs."""
    base = model(20.0)
    ranking = [
        candidate(base, best, level, CLEAR, 9000.0),
        candidate(base, other, level, CLEAR, 9000.0 + cost),
    ]
    return decide(base, ranking, SETTINGS)


def test_at_the_noise_floor_the_fitted_logs_tell_rivals_apart_too() -> None:
    assert SETTINGS.threshold == 25
    assert rivals(1.0, 24.0).kind == "equivalent"
    assert rivals(1.0, 26.0).effects == ("coulomb_friction@rail",)


@pytest.mark.parametrize(("left", "kind"), [(24.0, "equivalent"), (26.0, "named")])
def test_where_no_logs_are_held_out_the_fitted_ones_count_once(left: float, kind: str) -> None:
    base, best = model(20.0), score(1.0)
    worse = replace(best, window_sum=best.window_sum + left / WINDOWS, chi2=best.chi2 + left / COUNT / WINDOWS)
    scores = {"coulomb_friction": (best, 9000.0), "constant_offset": (worse, 9000.0 + left)}
    apart = [candidate(base, name, each, CLEAR, cost) for name, (each, cost) in scores.items()]
    same = [replace(c, explained=replace(c.explained, apart=False)) for c in apart]
    assert decide(base, apart, SETTINGS).kind == "named"
    assert decide(base, same, SETTINGS, "fit logs").kind == kind


@pytest.mark.parametrize(
    ("held_out", "fitted", "rich"),
    [(30.0, 30.0, True), (28.0, 300.0, False), (280.0, 28.0, False), (30.0, 28.0, False)],
)
def test_at_the_noise_floor_a_richer_effect_must_be_more_likely_on_fitted_and_held_out_logs(
    held_out: float, fitted: float, *, rich: bool
) -> None:
    """Stribeck friction has two parameters more, which cost 2 each."""
    assert (SETTINGS.penalty, SETTINGS.threshold) == (2, 25)
    base, best = model(20.0), score(1.0)
    doubt = np.where(np.arange(WINDOWS) % 6 < 3, 40.0, -40.0)
    sums = best.window_sum + held_out / WINDOWS + doubt
    worse = replace(best, window_sum=sums, chi2=best.chi2 + held_out / COUNT / WINDOWS)
    ranking = [
        candidate(base, "stribeck_friction", best, CLEAR, 9000.0),
        candidate(base, "coulomb_friction", worse, CLEAR, 9000.0 + fitted),
    ]
    assert decide(base, ranking, SETTINGS).effects == (f"{'stribeck' if rich else 'coulomb'}_friction@rail",)


def test_above_the_noise_floor_the_fitted_logs_do_not_decide() -> None:
    assert rivals(2.0, 500.0).kind == "equivalent"


def test_without_a_threshold_the_best_effect_still_stands() -> None:
    base, every = model(20.0), replace(SETTINGS, threshold=0.0)
    one, other = (candidate(base, name, 1.0, CLEAR) for name in ("coulomb_friction", "constant_offset"))
    assert decide(base, [one], every).effects == ("coulomb_friction@rail",)
    assert decide(base, [one, other], every).kind == "equivalent"


def test_a_richer_effect_that_explains_no_more_is_no_rival() -> None:
    verdict = judged(20.0, ("stribeck_friction", 1.0), ("coulomb_friction", 1.0005))
    assert verdict.effects == ("coulomb_friction@rail",)
    assert verdict.status["stribeck_friction@rail"] == "rejected"


def test_a_needlessly_rich_effect_hides_no_rival_of_the_one_that_takes_its_place() -> None:
    """Against the richest one the worst is 34 behind, against the simple one that stands for it only 12."""
    base, best = model(20.0), score(1.0)
    behind = {"stribeck_friction": 0.0, "coulomb_friction": 22.0, "viscous_friction": 34.0}
    ranking = [
        candidate(base, name, replace(best, window_sum=best.window_sum + each / WINDOWS), CLEAR, 9000.0)
        for name, each in behind.items()
    ]
    simple = {"coulomb_friction@rail", "viscous_friction@rail"}
    assert set(decide(base, ranking[1:], SETTINGS).effects) == simple
    assert set(decide(base, ranking, SETTINGS).effects) == simple


def test_what_the_needlessly_rich_effect_beats_joins_and_displaces_nothing() -> None:
    """Each is behind the one before by less than counts, the last behind the first by more."""
    base, best = model(20.0), score(1.0)
    behind = {"stribeck_friction": 0.0, "spring": 22.0, "viscous_friction": 44.0}
    ranking = [
        candidate(base, name, replace(best, window_sum=best.window_sum + each / WINDOWS), CLEAR)
        for name, each in behind.items()
    ]
    verdict = decide(base, ranking, SETTINGS)
    assert verdict.kind == "equivalent"
    assert set(verdict.effects) == {"spring@rail", "viscous_friction@rail"}


@dataclass(frozen=True)
class InTurn:
    """A fit that is better than the next of three and worse than the one before, as in windows that differ."""

    place: int

    def below(self, other: "InTurn") -> float:
        return 60.0 if (other.place - self.place) % 3 == 1 else -60.0


def test_effects_each_of_which_loses_to_another_one_all_stay() -> None:
    base, names = model(20.0), ("coulomb_friction", "viscous_friction", "quadratic_drag")
    ranking = [candidate(base, name, 1.0, CLEAR) for name in names]
    ranking = [
        replace(c, explained=replace(c.explained, fit=cast(Any, InTurn(place)))) for place, c in enumerate(ranking)
    ]
    verdict = decide(base, ranking, SETTINGS)
    assert verdict.kind == "equivalent"
    assert set(verdict.effects) == {f"{name}@rail" for name in names}


def test_a_richer_effect_that_explains_more_is_named() -> None:
    verdict = judged(20.0, ("stribeck_friction", 1.0), ("coulomb_friction", 1.3))
    assert verdict.effects == ("stribeck_friction@rail",)


def test_what_the_data_do_not_excite_is_told() -> None:
    verdict = judged(1.0, ("coulomb_friction", 1.0), coulomb_friction=HIDDEN)
    assert (verdict.kind, verdict.effects) == ("not_excited", ())
    assert verdict.status == {"coulomb_friction@rail": "not_excited"}
    assert verdict.absorbed == ()
    assert "coulomb_friction@rail" in verdict.reason


def test_where_other_effects_would_show_none_is_the_answer_and_the_silent_one_is_listed() -> None:
    verdict = judged(1.0, ("coulomb_friction", 1.0), ("viscous_friction", 1.0), coulomb_friction=HIDDEN)
    assert verdict.kind == "none"
    assert "would not show: coulomb_friction@rail." in verdict.reason


def test_a_gap_beside_silent_effects_stays_unexplained() -> None:
    assert judged(20.0, ("coulomb_friction", 20.0), coulomb_friction=HIDDEN).kind == "unexplained"


def test_what_free_parameters_can_replace_is_told() -> None:
    verdict = judged(1.0, ("armature", 1.0), ("coulomb_friction", 1.0), armature=ABSORBED)
    assert verdict.kind == "none"
    assert verdict.absorbed == ("armature@rail",)
    assert verdict.status == {"armature@rail": "equivalent", "coulomb_friction@rail": "rejected"}


def test_what_free_parameters_can_replace_is_told_of_few_data_as_well() -> None:
    base = model(few(1.0))
    verdict = decide(base, [candidate(base, "armature", few(1.0), ABSORBED)], SETTINGS)
    assert verdict.status == {"armature@rail": "equivalent"}


def few(level: float) -> Score:
    """One window of one log."""
    whole = score(level)
    one = np.arange(1)
    return replace(whole, window_sum=whole.window_sum[one], window_count=whole.window_count[one], log=whole.log[one])


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


def test_windows_that_only_the_base_loses_count_for_neither() -> None:
    verdict = judged(diverging(20.0, 5), ("coulomb_friction", 1.0))
    assert verdict.effects == ("coulomb_friction@rail",)


def first_two(whole: Score) -> Score:
    """What its first two windows, one block of data, say."""
    sums, counts = whole.window_sum[:2], whole.window_count[:2]
    return replace(
        whole, chi2=float(sums.sum() / counts.sum()), window_sum=sums, window_count=counts, log=whole.log[:2]
    )


@pytest.mark.parametrize(("rich", "answer"), [(2.8, ["stribeck", "coulomb"]), (4.9, ["coulomb"]), (1.2, ["stribeck"])])
def test_on_too_few_data_a_richer_effect_that_seems_to_explain_much_more_stays_and_goes_first(
    rich: float, answer: list[str]
) -> None:
    verdict = judged(
        first_two(score(20.0)),
        ("coulomb_friction", first_two(score(5.0))),
        ("stribeck_friction", first_two(score(rich))),
    )
    assert verdict.effects == tuple(f"{name}_friction@rail" for name in answer)
    assert verdict.kind == ("named" if len(answer) == 1 else "equivalent")


def test_on_too_few_data_what_seems_to_explain_much_more_goes_first_all_the_way() -> None:
    levels = {"coulomb_friction": 5.5, "constant_offset": 3.6, "actuator_delay": 2.5}
    verdict = judged(first_two(score(20.0)), *((name, first_two(score(level))) for name, level in levels.items()))
    assert verdict.effects == ("actuator_delay@drive", "constant_offset@rail", "coulomb_friction@rail")
