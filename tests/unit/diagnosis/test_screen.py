from collections.abc import Callable
from dataclasses import replace

import mujoco
import numpy as np
import pytest
from diagnosis_machines import evidence_settings, pendulum, solver_settings, swinging, windows_of
from effect_machines import catalogue_effect, scales_of

from dr_lab.diagnosis.evidence.bench import Bench, FittedModel, fit_and_score, fitted_to_the_end
from dr_lab.diagnosis.evidence.paired_gain import paired_gain, supported
from dr_lab.diagnosis.fit.levenberg_marquardt import Fitter
from dr_lab.diagnosis.fit.replay import Replay
from dr_lab.diagnosis.search.rank import rank
from dr_lab.diagnosis.search.screen import FirstLook, look
from dr_lab.effects.catalogue import candidates
from dr_lab.effects.effect import place
from dr_lab.effects.presliding_friction import PreslidingFriction

NAMES = ("quadratic_drag", "viscous_friction", "constant_offset", "spring", "torque_scale", "actuator_delay")
DRY_FRICTIONS = ("coulomb_friction", "stribeck_friction", "asymmetric_friction", "position_dependent_friction")
OFFSET = 0.03  # N·m


def push(data: mujoco.MjData) -> None:
    data.qfrc_applied[0] = OFFSET


def rub(data: mujoco.MjData) -> None:
    data.qfrc_applied[0] = -OFFSET * np.tanh(data.qvel[0] / 0.005)


def creep(data: mujoco.MjData) -> None:
    data.qfrc_applied[0] = -OFFSET * np.tanh(data.qvel[0] / 0.3)


def lopsided(data: mujoco.MjData) -> None:
    rub(data)
    data.qfrc_applied[0] *= 1.5 if data.qvel[0] > 0 else 0.5


def drive(data: mujoco.MjData) -> None:
    """The opposite of dry friction."""
    data.qfrc_applied[0] = OFFSET * np.tanh(data.qvel[0] / 0.05)


def bench_of(force: Callable[[mujoco.MjData], None] = push, **evidence: float) -> tuple[Bench, FittedModel]:
    """A pendulum that a hidden force acts on, and the fit of the model without it."""
    model = pendulum()
    fit, held_out = (
        windows_of(model, [swinging(n, model.nominal(), seed, force=force)]) for n, seed in (("a", 0), ("b", 1))
    )
    bench = Bench(fit, held_out, solver_settings(), evidence_settings(**evidence), threads=1)
    return bench, fit_and_score(bench, model, model.space.nominal)


def test_a_window_in_which_the_model_fails_is_looked_at() -> None:
    """As one is in which a joint runs into a stop."""
    bench, base = bench_of(screen_seconds=1.0, screen_windows=3)
    missed = next(k for k in range(len(bench.fit)) if k not in bench.screened())
    costs = np.ones(len(bench.fit))
    costs[missed] = 1e6
    rows = bench.screened(replace(base.fit, window_costs=costs))
    assert missed in rows
    assert len(rows) == len(bench.screened()) < len(bench.fit)
    diverges = np.arange(len(bench.fit)) == missed
    cost = np.where(diverges, 0.0, np.arange(len(bench.fit)))  # of a window that diverges none is known
    rows = bench.screened(replace(base.fit, window_costs=cost, infeasible=diverges))
    assert {0, len(bench.fit) - 1} <= set(rows.tolist())  # the best and the worst of those that are


def looked(bench: Bench, base: FittedModel, name: str, site: str) -> FirstLook:
    model = pendulum()
    effect = place(catalogue_effect(name), model.nominal(), site, scales_of(model, torque=0.5))
    return look(Fitter(Replay(model.with_effect(effect), bench.fit, 1), bench.solver), effect, base.fit)


def test_a_linear_effect_gains_what_was_predicted() -> None:
    bench, base = bench_of()
    first, model = looked(bench, base, "constant_offset", "hinge"), pendulum()
    effect = place(catalogue_effect("constant_offset"), model.nominal(), "hinge", scales_of(model, torque=0.5))
    fitter = Fitter(Replay(model.with_effect(effect), bench.fit, 1), bench.solver)
    fit = fitter.run(first.absent.z, first.absent.delta)
    assert first.gain == pytest.approx(base.fit.cost - fit.cost, rel=0.02)
    assert fit.z[-1] == pytest.approx(OFFSET, rel=0.02)


def test_an_effect_that_would_have_to_be_negative_promises_nothing() -> None:
    bench, base = bench_of(drive)
    assert base.held_out.chi2 > 2
    assert looked(bench, base, "coulomb_friction", "hinge").gain < 0.05 * base.fit.cost


@pytest.mark.parametrize(("most_fits", "least_promise"), [(9, 0.5), (3, 0.0)])
def test_only_what_promises_enough_is_fitted(most_fits: int, least_promise: float) -> None:
    bench, base = bench_of(most_fits=most_fits, least_promise=least_promise)
    model, told = pendulum(), list[str]()
    catalogue = {name: catalogue_effect(name) for name in NAMES}
    placed = candidates(model, catalogue, scales_of(model, torque=0.5), model.nominal()).placed
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
def test_what_holds_a_simpler_effect_does_not_take_its_place() -> None:
    bench, base = bench_of(rub, most_fits=2, least_promise=0.0)
    model, catalogue = pendulum(), {name: catalogue_effect(name) for name in DRY_FRICTIONS}
    placed = candidates(model, catalogue, scales_of(model, torque=0.5), model.nominal()).placed
    ranking = rank(bench, base, placed, lambda _: None).candidates
    promised = {c.effect.effect.name: c.predicted for c in ranking}
    assert sum(promise > promised["coulomb_friction"] for promise in promised.values()) >= 2
    assert "coulomb_friction" in {c.effect.effect.name for c in ranking if c.fitted}


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


def test_what_is_confused_with_the_best_one_is_fitted_although_no_place_is_left() -> None:
    bench, base = bench_of(creep, most_fits=1, least_promise=0.0)
    model, names = pendulum(), ("coulomb_friction", "load_dependent_friction", "spring")
    catalogue = {name: catalogue_effect(name) for name in names}
    placed = candidates(model, catalogue, scales_of(model, torque=0.5), model.nominal()).placed
    ranking = rank(bench, base, placed, lambda _: None).candidates
    assert min(c.predicted for c in ranking) > 0.01  # each is worth a fit
    assert {c.effect.effect.name for c in ranking if c.fitted} == {"coulomb_friction", "load_dependent_friction"}


def test_the_best_with_fewer_parameters_is_fitted_to_all_windows_although_another_leads() -> None:
    bench, base = bench_of(lopsided, screen_seconds=1.0, screen_windows=6)
    model = pendulum()
    catalogue = {name: catalogue_effect(name) for name in ("asymmetric_friction", "constant_offset")}
    placed = candidates(model, catalogue, scales_of(model, torque=0.5), model.nominal()).placed
    ranking = rank(bench, base, placed, lambda _: None).candidates
    assert [len(c.effect.parameters) for c in ranking] == [2, 1]
    leader, leaner = ranking
    assert leaner.final
    gain = paired_gain(leaner.fitted_model.held_out, leader.fitted_model.held_out, bench.evidence)
    assert supported(gain, 1, bench.evidence)


def test_a_fit_that_ended_early_goes_on_to_its_end() -> None:
    """One that ended after its first step, however much that gained."""
    bench, base = bench_of()
    hasty = replace(bench, solver=solver_settings(crawl=1, crawl_tolerance=1e9, restarts=0))
    early = fit_and_score(hasty, base.model, base.model.space.nominal)
    assert not early.fit.converged
    assert early.fit.cost > 1.01 * base.fit.cost
    late = fitted_to_the_end(hasty, early)
    assert late.fit.converged
    assert late.fit.cost == pytest.approx(base.fit.cost, rel=1e-3)
    assert late.held_out.chi2 == pytest.approx(base.held_out.chi2, rel=1e-2)
    assert fitted_to_the_end(bench, base) is base
