"""Fits of candidates to all windows: soft friction or a constant torque on a pendulum is the truth."""

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from typing import Any

import mujoco
import numpy as np
import pytest
from refit_machines import CREEP, OFFSET, creeping, effect_of, fits_of, push, rubbing, stopping, tried

from dr_lab.diagnosis.evidence.bench import FittedModel, fit_and_score
from dr_lab.diagnosis.fit.fit import Fit
from dr_lab.diagnosis.fit.levenberg_marquardt import Fitter
from dr_lab.diagnosis.search import rank
from dr_lab.diagnosis.search.as_special_case import taking_over
from dr_lab.diagnosis.search.candidate import Candidate
from dr_lab.diagnosis.search.candidate_fits import CandidateFits
from dr_lab.diagnosis.search.refits import Begun, Refits
from dr_lab.diagnosis.search.screen import FirstLook
from dr_lab.diagnosis.search.waves import Waves
from dr_lab.effects.effect import PlacedEffect
from dr_lab.trajectory import Array


@cache
def refitted(fits: CandidateFits, name: str) -> Candidate:
    """The same, fitted to all windows."""
    refits, candidate = Refits(fits), tried(fits, name)
    return refits.refitted(candidate, refits.begun(candidate))


@pytest.mark.slow
def test_an_effect_stands_beside_its_limit_if_it_explains_more() -> None:
    fits = fits_of(creeping)
    limit, soft = refitted(fits, "coulomb_friction"), tried(fits, "presliding_friction")
    assert limit.final
    found, alone = Refits(fits).refitted_beyond(soft, limit), refitted(fits, "presliding_friction")
    assert found.final
    assert found.fitted_model.fit.converged
    assert found.fitted_model.fit.cost < 0.8 * limit.fitted_model.fit.cost
    assert found.fitted_model.fit.cost == pytest.approx(alone.fitted_model.fit.cost, rel=1e-3)


@pytest.mark.slow
def test_an_effect_that_stays_above_its_limit_is_not_fitted_to_the_end() -> None:
    fits = fits_of(creeping)
    soft, limit = tried(fits, "presliding_friction"), refitted(fits, "coulomb_friction")
    low = replace(limit.fitted_model.fit, cost=0.5 * limit.fitted_model.fit.cost)
    beaten = replace(limit, fitted_model=replace(limit.fitted_model, fit=low))
    assert Refits(fits).refitted_beyond(soft, beaten) is soft
    untried = replace(limit, final=False)
    assert Refits(fits).refitted_beyond(soft, untried).final


@pytest.mark.slow
def test_a_richer_kind_is_asked_on_all_windows_what_few_do_not_show() -> None:
    fits = fits_of(creeping)
    soft, limit = tried(fits, "presliding_friction"), refitted(fits, "coulomb_friction")
    found = Refits(fits).refitted_if_promising(soft, limit)
    assert found.final
    assert found.fitted_model.fit.cost < 0.8 * limit.fitted_model.fit.cost


@pytest.mark.slow
def test_a_richer_kind_that_adds_nothing_on_all_windows_is_left() -> None:
    fits = fits_of(rubbing)
    soft, limit = tried(fits, "presliding_friction"), refitted(fits, "coulomb_friction")
    assert limit.final
    assert Refits(fits).refitted_if_promising(soft, limit) is soft


@pytest.mark.slow
def test_the_ranking_asks_richer_kinds_of_the_best_one(monkeypatch: pytest.MonkeyPatch) -> None:
    """As where the few windows that screen do not show what the richer kind adds."""
    monkeypatch.setattr(rank._Contest, "_needless", lambda *_: True)
    fits = fits_of(creeping)
    effects = [effect_of(name) for name in ("coulomb_friction", "presliding_friction")]
    best, other = rank.rank(fits.bench, fits.base, effects, lambda _: None).candidates
    assert (best.effect.effect.name, other.effect.effect.name) == ("presliding_friction", "coulomb_friction")
    assert best.final
    assert other.final


@pytest.mark.slow
@pytest.mark.parametrize(("friction", "moved"), [(creeping, True), (rubbing, False)])
def test_the_best_one_goes_on_beyond_a_bound_on_all_windows_unless_its_special_case_explains_as_much(
    friction: Callable[[mujoco.MjData], None], monkeypatch: pytest.MonkeyPatch, *, moved: bool
) -> None:
    """Friction that creeps more slowly than is looked for at first; few windows do not move the bound here."""
    monkeypatch.setattr(Waves, "_widen", lambda *_: None)
    fits, soft = fits_of(friction), effect_of("smooth_friction")
    torque, creep = soft.parameters
    low = 2 * CREEP if moved else creep.low
    starts = tuple({**start, creep.name: 3 * low} for start in soft.starts)
    found = soft.bounded((torque, replace(creep, low=low, nominal=3 * low, high=20 * CREEP)))
    effects = [effect_of("coulomb_friction"), replace(found, starts=starts)]
    ranking = rank.rank(fits.bench, fits.base, effects, lambda _: None).candidates
    (best,) = (c for c in ranking if c.effect.effect.name == "smooth_friction")
    assert bool(best.effect.looked) is moved
    if moved:
        assert best.final
        assert best.fitted_model.values()[creep.name] == pytest.approx(CREEP, rel=0.3)


@pytest.mark.slow
def test_the_best_one_stays_within_its_bounds_where_its_special_case_leaves_noise(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """What it adds beyond them decides nothing."""
    fits = fits_of(creeping)
    widened = list[str]()
    monkeypatch.setattr(rank, "at_floor", lambda *_: True)
    monkeypatch.setattr(CandidateFits, "farther", lambda _, candidate, *__: widened.append(candidate.effect.label))
    monkeypatch.setattr(Waves, "_widen", lambda *_: None)
    effects = [effect_of(name) for name in ("coulomb_friction", "smooth_friction")]
    ranking = rank.rank(fits.bench, fits.base, effects, lambda _: None).candidates
    assert all(candidate.final for candidate in ranking)
    assert not widened


@pytest.mark.slow
def test_an_effect_that_begins_in_the_place_of_another_one_is_asked_there_on_all_windows(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    fits, asked = fits_of(creeping), list[Array]()
    base = fitted_with(fits, "coulomb_friction")
    beside = CandidateFits(fits.bench.beside(base), base)
    soft = taking_over(effect_of("smooth_friction"), base.model, base.values())
    first, outlooks = beside.look(soft), Fitter.outlooks

    def noted(self: Fitter, z: Array, *known: Any) -> list[Fit]:  # noqa: ANN401 (passed on)
        asked.extend(z)
        return outlooks(self, z, *known)

    monkeypatch.setattr(Fitter, "outlooks", noted)
    beside.promise_of_all(soft, first)
    (z,) = asked
    found, values = beside.fitter(beside.bench, soft).space.mapping(z), base.values()
    torque = values.pop("coulomb_friction@hinge.torque")
    assert torque > 0
    assert found.pop("coulomb_friction@hinge.torque") == 0
    assert found.pop("smooth_friction@hinge.torque") == pytest.approx(torque)
    assert {name: found[name] for name in values} == values


def fitted_with(fits: CandidateFits, name: str) -> FittedModel:
    """The model of some fits with one effect, calibrated."""
    model = fits.base.model.with_effect(effect_of(name))
    return fit_and_score(fits.bench, model, model.space.nominal)


@pytest.mark.slow
def test_what_gained_nothing_on_few_windows_is_not_fitted_to_all(monkeypatch: pytest.MonkeyPatch) -> None:
    def fit(self: CandidateFits, effect: PlacedEffect, first: FirstLook, *_: float, **__: int) -> Candidate:
        found = fitted(self, effect, first)
        lost = effect.effect.name == "coulomb_friction"
        return replace(found, fitted_model=replace(found.fitted_model, fit=self.start)) if lost else found

    fitted = CandidateFits.fitted
    monkeypatch.setattr(CandidateFits, "fitted", fit)
    fits = fits_of(creeping)
    effects = [effect_of(name) for name in ("coulomb_friction", "presliding_friction")]
    best, other = rank.rank(fits.bench, fits.base, effects, lambda _: None).candidates
    assert (best.effect.effect.name, best.final) == ("presliding_friction", True)
    assert (other.effect.effect.name, other.final) == ("coulomb_friction", False)


@pytest.fixture(scope="module")
def begun() -> tuple[Refits, Candidate, Begun]:
    fits = fits_of(push)
    candidate, refits = tried(fits, "constant_offset"), Refits(fits)
    return refits, candidate, refits.begun(candidate)


def test_a_start_on_all_windows_is_nearly_as_good_as_its_end(begun: tuple[Refits, Candidate, Begun]) -> None:
    refits, candidate, start = begun
    assert not candidate.final
    done = refits.refitted(candidate, start)
    assert done.final
    assert done.fitted_model.fit.z[-1] == pytest.approx(OFFSET, rel=0.02)
    assert len(candidate.fitted_model.fit.delta) < len(done.fitted_model.fit.delta) == len(start.start.delta)
    assert done.fitted_model.fit.cost <= start.start.cost < 1.1 * done.fitted_model.fit.cost
    assert refits.beaten_by(done) > done.fitted_model.fit.cost
    assert refits.beaten_by(candidate) == np.inf


def test_a_candidate_that_another_one_beats_is_left_as_it_is(begun: tuple[Refits, Candidate, Begun]) -> None:
    refits, candidate, start = begun
    cost = refits.refitted(candidate, start).fitted_model.fit.cost
    assert refits.refitted(candidate, start, beaten=0.9 * cost) is candidate
    assert refits.refitted(candidate, start, beaten=1.1 * cost).fitted_model.fit.cost == cost


def test_a_fit_to_all_windows_begins_at_absent_where_the_end_of_few_is_worse(
    begun: tuple[Refits, Candidate, Begun],
) -> None:
    refits, candidate, start = begun
    assert start.start.z[-1] == pytest.approx(OFFSET, rel=0.1)
    fit = candidate.fitted_model.fit
    astray = replace(fit, z=np.append(fit.z[:-1], -10 * OFFSET))
    elsewhere = replace(candidate, fitted_model=replace(candidate.fitted_model, fit=astray))
    assert refits.begun(elsewhere).start.z[-1] == 0.0
    done = refits.refitted(elsewhere, refits.begun(elsewhere))
    assert done.fitted_model.fit.z[-1] == pytest.approx(OFFSET, rel=0.02)


def test_others_have_their_turn_where_the_best_of_few_windows_gains_nothing_in_all(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def refit(self: Refits, candidate: Candidate, begun: Begun, *_: float, **__: int) -> Candidate:
        del begun
        if candidate.effect.effect.name == "spring":
            return self._fits.at_absent(candidate.effect, candidate.fitted_model.fit, candidate.identifiability, 0.0)
        return refitted_to_all(self, candidate, self.begun(candidate))

    def leading(self: rank._Contest, tried: dict[int, Candidate]) -> tuple[list[int], list[int]]:
        return [k for k in tried if self.placed[k].effect.name == "spring"] or list(tried), []

    refitted_to_all = Refits.refitted
    monkeypatch.setattr(Refits, "refitted", refit)
    monkeypatch.setattr(rank._Contest, "_standing", leading)
    fits = fits_of(push)
    effects = [effect_of(name) for name in ("spring", "constant_offset")]
    best, other = rank.rank(fits.bench, fits.base, effects, lambda _: None).candidates
    assert (best.effect.effect.name, best.final) == ("constant_offset", True)
    assert (other.effect.effect.name, other.fitted) == ("spring", False)


def test_what_explains_as_much_on_few_windows_with_more_parameters_is_called_needless() -> None:
    fits = fits_of(push)
    effects = [effect_of(name) for name in ("constant_offset", "spring", "viscous_friction")]
    contest = rank._Contest(fits.bench, fits.base, effects, lambda _: None)
    found = {k: tried(fits, effect.effect.name) for k, effect in enumerate(contest.placed)}
    standing, needless = contest._standing(found)
    assert [contest.placed[k].effect.name for k in standing] == ["constant_offset"]
    assert [contest.placed[k].effect.name for k in needless] == ["spring"]


def test_more_threads_change_no_fit(begun: tuple[Refits, Candidate, Begun]) -> None:
    refits, candidate, start = begun
    one, two = (refits.refitted(candidate, start, threads=count).fitted_model.fit for count in (1, 2))
    assert one.cost == two.cost
    np.testing.assert_array_equal(one.z, two.z)


def test_what_few_windows_leave_absent_is_begun_anew_in_all() -> None:
    fits = fits_of(stopping)
    found = tried(fits, "end_stop")
    space, low = fits.fitter(fits.thin, found.effect).space, "end_stop@hinge.lower"
    place, fit = space.index(low), found.fitted_model.fit
    assert fit.z[place] > space.nominal[place]  # the lower stop acts in these windows
    one_sided = fit.z.copy()
    one_sided[place] = space.nominal[place]
    upper_alone = replace(found, fitted_model=replace(found.fitted_model, fit=replace(fit, z=one_sided)))
    begun = Refits(fits).begun(upper_alone)
    start = next(s[low] for s in found.effect.starts if s[low] != space.nominal[place])
    assert begun.start.z[place] == start
    for name, value, ended, absent in zip(space.names, begun.start.z, one_sided, space.nominal, strict=True):
        others = {other.get(name, ended) for other in found.effect.starts} if ended == absent else set[float]()
        assert value in {ended, *others}
