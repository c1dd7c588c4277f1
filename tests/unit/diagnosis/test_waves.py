from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from diagnosis_machines import pendulum
from effect_machines import catalogue_effect, scales_of
from screened_pendulum import DRY_FRICTIONS, NAMES, bear, bench_of, creep, placed_of, rub

from dr_lab.diagnosis.evidence.support import supported
from dr_lab.diagnosis.search import waves
from dr_lab.diagnosis.search.candidate_fits import CandidateFits
from dr_lab.diagnosis.search.rank import rank
from dr_lab.effects.catalogue import candidates
from dr_lab.effects.presliding_friction import PreslidingFriction


@pytest.mark.parametrize(("most_fits", "least_promise"), [(9, 0.5), pytest.param(3, 0.0, marks=pytest.mark.slow)])
def test_only_what_promises_enough_is_fitted(most_fits: int, least_promise: float) -> None:
    bench, base = bench_of(most_fits=most_fits, least_promise=least_promise)
    placed, told = placed_of(NAMES), list[str]()
    ranking = rank(bench, base, placed, told.append).candidates
    fitted = [c for c in ranking if c.fitted]
    assert ranking[0].effect.effect.name == "constant_offset"
    assert 1 <= len(fitted) <= min(most_fits, len(placed) - 1)
    assert sorted(told) == sorted(p.label for p in placed)
    for rest in (c for c in ranking if not c.fitted):
        assert rest.gain.total == 0
        assert rest.predicted <= min(c.predicted for c in fitted)
        assert rest.fitted_model.held_out.chi2 == base.held_out.chi2
    assert np.isfinite([c.predicted for c in ranking]).all()


@pytest.mark.slow
def test_what_is_fitted_brings_its_special_case_along() -> None:
    """Although a kind that holds it promises more and only one place is left."""
    bench, base = bench_of(rub, most_fits=1, least_promise=0.0)
    placed = placed_of(DRY_FRICTIONS[:3])
    ranking = rank(bench, base, placed, lambda _: None).candidates
    promised = {c.effect.effect.name: c.predicted for c in ranking}
    assert sum(promise > promised["coulomb_friction"] for promise in promised.values()) >= 1
    assert "coulomb_friction" in {c.effect.effect.name for c in ranking if c.fitted}


@pytest.mark.slow
def test_others_have_their_turn_where_what_promised_most_gains_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    """Promises are turned round, so that the true effect is the last."""
    monkeypatch.setattr(waves, "shortlist", lambda order, placed, most: list(order)[::-1][:most])
    monkeypatch.setattr(waves.Waves, "_typical", lambda *_: [])
    bench, base = bench_of(most_fits=1, least_promise=0.0, least_hope=0.0)
    placed = placed_of(("viscous_friction", "quadratic_drag", "constant_offset"))
    best, *first = rank(bench, base, placed, lambda _: None).candidates
    for each in first:
        assert each.fitted
        assert not (each.final and supported(each.gain, 1, bench.evidence))
    assert best.effect.effect.name == "constant_offset"
    assert best.final
    assert supported(best.gain, 1, bench.evidence)


@pytest.mark.slow
def test_what_promises_more_than_the_best_one_gained_is_fitted(monkeypatch: pytest.MonkeyPatch) -> None:
    """Although the best one is supported, and the first place went to what holds special cases."""
    monkeypatch.setattr(waves, "shortlist", lambda order, placed, most: sorted(order)[:most])
    bench, base = bench_of(most_fits=1, least_promise=0.0)
    names = ("asymmetric_friction", "constant_offset")
    alone = rank(bench, base, placed_of(names[:1]), lambda _: None).candidates[0]
    assert supported(alone.gain, 2, bench.evidence)
    best, second = rank(bench, base, placed_of(names), lambda _: None).candidates
    assert second.effect.effect.name == "asymmetric_friction"
    assert alone.fitted_model.fit.below(base.fit) < best.predicted * base.fit.cost
    assert best.effect.effect.name == "constant_offset"
    assert best.final


@pytest.mark.slow
def test_what_holds_the_best_one_is_fitted_although_others_promise_more() -> None:
    bench, base = bench_of(creep, most_fits=2, least_promise=0.0)
    model = pendulum()
    soft = catalogue_effect("presliding_friction")
    assert isinstance(soft, PreslidingFriction)
    misled = replace(soft, creeps=(2e-3, 0.5, 0.5), start_shapes=[(3e-3, 0.5)])  # looks where it creeps too fast
    catalogue = {**{name: catalogue_effect(name) for name in DRY_FRICTIONS[:3]}, soft.name: misled}
    placed = candidates(model, catalogue, scales_of(model, torque=0.5), model.nominal()).placed
    ranking = rank(bench, base, placed, lambda _: None).candidates
    promised = {c.effect.effect.name: c.predicted for c in ranking}
    assert promised["presliding_friction"] == min(promised.values())
    assert {c.effect.effect.name for c in ranking if c.fitted} >= {"presliding_friction", "coulomb_friction"}


@pytest.mark.slow
def test_what_is_confused_with_the_best_one_is_fitted_although_no_place_is_left() -> None:
    bench, base = bench_of(creep, most_fits=1, least_promise=0.0)
    placed = placed_of(("coulomb_friction", "load_dependent_friction", "spring"))
    ranking = rank(bench, base, placed, lambda _: None).candidates
    assert min(c.predicted for c in ranking) > 0.01  # each is worth a fit
    assert {c.effect.effect.name for c in ranking if c.fitted} == {"coulomb_friction", "load_dependent_friction"}


def test_what_holds_one_that_gains_about_as_much_as_the_best_is_fitted() -> None:
    bench, base = bench_of(bear, most_fits=2, least_promise=0.0)
    fits = CandidateFits(bench, base)
    contest = waves.Waves(
        fits, placed_of(("coulomb_friction", "load_dependent_friction", "asymmetric_friction")), print
    )
    found = {contest.placed[k].effect.name: each for k, each in contest.first().items()}
    best, other = found["load_dependent_friction"], found["coulomb_friction"]
    assert best.gain.total > other.gain.total
    assert found["asymmetric_friction"].fitted


def test_what_promises_most_in_typical_windows_is_fitted_beside_what_promises_most_in_all() -> None:
    bench, base = bench_of(most_fits=1, least_promise=0.0, least_hope=0.0)
    asked = waves.Waves(CandidateFits(bench.beside(base), base), placed_of(NAMES), lambda _: None)
    gains = [look.gain for look in asked._looks]
    least, most = int(np.argmin(gains)), int(np.argmax(gains))
    asked._looks = [replace(look, evidence=float(k == least)) for k, look in enumerate(asked._looks)]
    assert {least, most} <= asked.first().keys() < {*range(len(NAMES))}


def test_the_next_ones_are_those_that_promise_most_in_typical_windows() -> None:
    bench, base = bench_of(most_fits=1, least_hope=0.0)
    chosen = []
    for first, last in ((2.0, 1.0), (1.0, 2.0)):
        asked = waves.Waves(CandidateFits(bench.beside(base), base), placed_of(NAMES[:2]), lambda _: None)
        evidence = dict(zip(asked.placed, (first, last), strict=True))
        asked._looks = [replace(look, evidence=evidence[p]) for p, look in zip(asked.placed, asked._looks, strict=True)]
        place, *_ = asked.next()  # and what is confused with it
        chosen.append(asked.placed[place].effect.name)
    assert chosen == [*NAMES[:2]]


def test_the_next_ones_bring_along_what_holds_the_best_of_them() -> None:
    bench, base = bench_of(rub, most_fits=1, least_hope=0.0)
    names = ("coulomb_friction", "asymmetric_friction", "quadratic_drag")
    asked = waves.Waves(CandidateFits(bench.beside(base), base), placed_of(names), lambda _: None)
    asked._looks = [
        replace(look, evidence=float(each.effect.name == "coulomb_friction"))
        for each, look in zip(asked.placed, asked._looks, strict=True)
    ]
    found = {asked.placed[place].effect.name for place in asked.next()}
    assert found == {"coulomb_friction", "asymmetric_friction"}


@pytest.mark.parametrize(
    ("tried", "confused"),
    [
        ([("command_power", 9.0)], [("torque_scale", "rail")]),  # at another site it would not be asked
        ([("torque_scale", 9.0)], [("payload", "second"), ("viscous_friction", "rail")]),  # a load sits at bodies
        ([("command_power", 9.0), ("torque_scale", 8.0)], [("payload", "second"), ("viscous_friction", "rail")]),
        ([("command_power", 9.0), ("torque_scale", 4.0)], []),  # which explains far less
    ],
)
def test_what_the_best_one_or_the_simplest_like_it_says_that_it_is_confused_with_is_fitted(
    tried: list[tuple[str, float]], confused: list[tuple[str, str]]
) -> None:
    """A gain is no kind of a power of the command and says nothing of it, but the power near 1 passes for a gain."""
    begun = [(name, "rail") for name, _ in tried]
    sites = [*begun, *confused, ("torque_scale", "other"), ("spring", "rail"), ("payload", "first")]
    placed = [
        SimpleNamespace(effect=catalogue_effect(name), site=site, parameters=range(1 + (name == "command_power")))
        for name, site in dict.fromkeys(sites)
    ]
    contest = cast(Any, object.__new__(waves.Waves))
    contest.placed, contest._bench = placed, SimpleNamespace(evidence=SimpleNamespace(least_named=0.5))
    contest._fits, contest._waiting = SimpleNamespace(start=None), [*range(len(tried), len(placed))]
    contest._looks = [SimpleNamespace(gain=2.0 if each.site == "second" else 1.0) for each in placed]
    found = {k: fitted(total) for k, (_, total) in enumerate(tried)}
    crowded = {(placed[k].effect.name, placed[k].site) for k in contest._crowded_out(found)}
    assert crowded == {*confused}


def fitted(total: float) -> SimpleNamespace:
    """A candidate that gains so much."""
    fit = SimpleNamespace(below=lambda _: total)
    return SimpleNamespace(gain=SimpleNamespace(total=total), fitted_model=SimpleNamespace(fit=fit))
