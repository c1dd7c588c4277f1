"""Which of several effects that explain much the same stand."""

from dataclasses import dataclass, replace
from typing import Any, cast

import numpy as np
import pytest
from pretended_rankings import CLEAR, COUNT, SETTINGS, WINDOWS, candidate, judged, model, score

from dr_lab.diagnosis.evidence.paired_gain import paired_gain
from dr_lab.diagnosis.evidence.score import Score
from dr_lab.diagnosis.search.verdict import Verdict, decide


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
    same = [replace(c, fitted_model=replace(c.fitted_model, apart=False)) for c in apart]
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


@pytest.mark.parametrize(("level", "rich"), [(1.0, True), (1.2, False)])
def test_a_richer_effect_that_alone_leaves_noise_stands_although_windows_gain_unequally(
    level: float, *, rich: bool
) -> None:
    """Three windows gain all that Stribeck friction gains, so that the scatter between blocks leaves it in doubt."""
    base, best = model(20.0), score(level)
    behind = np.where(np.arange(WINDOWS) < 3, 3.0 * COUNT, -3.0)
    worse = replace(best, window_sum=best.window_sum + behind, chi2=best.chi2 + float(behind.mean()) / COUNT)
    ranking = [
        candidate(base, "stribeck_friction", best, CLEAR, 9000.0),
        candidate(base, "coulomb_friction", worse, CLEAR, 9000.0),  # on the logs that were fitted no less likely
    ]
    assert paired_gain(worse, best, SETTINGS).total_low < 0
    assert decide(base, ranking, SETTINGS).effects == (f"{'stribeck' if rich else 'coulomb'}_friction@rail",)


def test_a_richer_effect_that_diverges_in_some_windows_displaces_none() -> None:
    """It leaves noise in all windows but the two that it cannot simulate."""
    base, best, lost = model(20.0), score(1.0), np.arange(WINDOWS) < 2
    sums, counts = (np.where(lost, 0.0, each) for each in (best.window_sum, best.window_count))
    part = replace(best, window_sum=sums, window_count=counts, chi2=float(sums.sum() / counts.sum()), infeasible=2)
    ranking = [
        candidate(base, "stribeck_friction", part, CLEAR, 9000.0),
        candidate(base, "coulomb_friction", score(3.0), CLEAR, 9000.0),
    ]
    assert decide(base, ranking, SETTINGS).effects == ("coulomb_friction@rail",)


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
    assert verdict.status["stribeck_friction@rail"] == "not_needed"


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


@pytest.mark.parametrize(
    ("richer", "poorer", "stand"),
    [
        pytest.param("spring", "viscous_friction", {"spring@rail", "viscous_friction@rail"}, id="another kind"),
        pytest.param("stribeck_friction", "coulomb_friction", {"coulomb_friction@rail"}, id="a special case"),
    ],
)
def test_a_poorer_effect_displaces_none_that_explains_much_more_though_not_beyond_doubt(
    richer: str, poorer: str, stand: set[str]
) -> None:
    """In half of the windows the poorer one leaves 2.5 times as much, in the others 0.6 times."""
    base, best = model(40.0), score(4.0)
    worse = replace(best, window_sum=best.window_sum * np.where(np.arange(WINDOWS) % 6 < 3, 2.5, 0.6))
    gain = paired_gain(worse, best, SETTINGS)
    assert gain.total_low < 0 < SETTINGS.threshold < gain.total
    ranking = [candidate(base, richer, best, CLEAR), candidate(base, poorer, worse, CLEAR)]
    assert set(decide(base, ranking, SETTINGS).effects) == stand


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
        replace(c, fitted_model=replace(c.fitted_model, fit=cast(Any, InTurn(place))))
        for place, c in enumerate(ranking)
    ]
    verdict = decide(base, ranking, SETTINGS)
    assert verdict.kind == "equivalent"
    assert set(verdict.effects) == {f"{name}@rail" for name in names}


def test_a_richer_effect_that_explains_more_is_named() -> None:
    verdict = judged(20.0, ("stribeck_friction", 1.0), ("coulomb_friction", 1.3))
    assert verdict.effects == ("stribeck_friction@rail",)


def first_two(whole: Score) -> Score:
    """What its first two windows, one block of data, say."""
    sums, counts = whole.window_sum[:2], whole.window_count[:2]
    return replace(
        whole, chi2=float(sums.sum() / counts.sum()), window_sum=sums, window_count=counts, log=whole.log[:2]
    )


@pytest.mark.parametrize(
    ("levels", "answer"),
    [
        pytest.param({"coulomb_friction": 5.0, "stribeck_friction": 3.4}, (), id="more than noise is left"),
        pytest.param({"coulomb_friction": 1.0, "stribeck_friction": 1.0}, ("coulomb",), id="both leave noise"),
        pytest.param({"coulomb_friction": 2.0, "stribeck_friction": 1.0}, ("stribeck",), id="the richer one does"),
    ],
)
def test_on_too_few_data_only_what_leaves_noise_is_named(levels: dict[str, float], answer: tuple[str, ...]) -> None:
    """Two windows tell how likely noise is; how large a model's error would be in others they do not tell."""
    verdict = judged(first_two(score(20.0)), *((name, first_two(score(level))) for name, level in levels.items()))
    assert verdict.effects == tuple(f"{name}_friction@rail" for name in answer)
    assert verdict.kind == ("named" if answer else "unexplained")
