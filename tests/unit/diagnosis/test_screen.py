from dataclasses import replace

import numpy as np
import pytest
from diagnosis_machines import PENDULUM, PENDULUM_PARAMETERS, model_of, pendulum, solver_settings
from effect_machines import catalogue_effect, scales_of
from screened_pendulum import OFFSET, bench_of, drive, lopsided, placed_of

from dr_lab.diagnosis.evidence.bench import Bench, FittedModel, fit_and_score, fitted_to_the_end
from dr_lab.diagnosis.evidence.paired_gain import paired_gain
from dr_lab.diagnosis.evidence.support import supported
from dr_lab.diagnosis.evidence.typical import deviance
from dr_lab.diagnosis.fit.levenberg_marquardt import Fitter
from dr_lab.diagnosis.fit.replay import Replay
from dr_lab.diagnosis.search.rank import rank
from dr_lab.diagnosis.search.screen import FirstLook, linear_gain, look, own_step
from dr_lab.effects.effect import place


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
    beside = Fitter(Replay(model.with_effect(effect), bench.fit, 1), bench.solver)
    return look(beside, effect, base.fit, own_step(base.fit, model.space))


def test_a_linear_effect_gains_what_was_predicted() -> None:
    bench, base = bench_of()
    first, model = looked(bench, base, "constant_offset", "hinge"), pendulum()
    effect = place(catalogue_effect("constant_offset"), model.nominal(), "hinge", scales_of(model, torque=0.5))
    fitter = Fitter(Replay(model.with_effect(effect), bench.fit, 1), bench.solver)
    fit = fitter.run(first.absent.z, first.absent.delta)
    assert first.gain == pytest.approx(base.fit.cost - fit.cost, rel=0.02)
    before, after = (deviance(each.window_costs, fitter.replay.fitted.sum(1)).sum() for each in (base.fit, fit))
    assert first.evidence == pytest.approx(before - after, rel=0.02)
    assert fit.z[-1] == pytest.approx(OFFSET, rel=0.02)


def test_an_effect_that_would_have_to_be_negative_promises_nothing() -> None:
    bench, base = bench_of(drive)
    assert base.held_out.chi2 > 2
    assert looked(bench, base, "coulomb_friction", "hinge").gain < 0.05 * base.fit.cost


def test_what_the_base_alone_would_gain_is_no_effects_merit() -> None:
    """Beside a fit that stands where it began an effect promises what it does beside one that converged."""
    bench, base = bench_of()
    model = pendulum()
    fitter = Fitter(Replay(model, bench.fit, 1), bench.solver)
    begun = fitter.run(model.space.nominal, iterations=0)
    assert begun.cost - base.fit.cost > 0.5 * looked(bench, base, "constant_offset", "hinge").gain
    effect = place(catalogue_effect("constant_offset"), model.nominal(), "hinge", scales_of(model, torque=0.5))
    beside = Fitter(Replay(model.with_effect(effect), bench.fit, 1), bench.solver)
    first = look(beside, effect, begun, own_step(begun, model.space))
    done = looked(bench, base, "constant_offset", "hinge")
    assert first.gain == pytest.approx(done.gain, rel=0.2)
    assert first.evidence == pytest.approx(done.evidence, rel=0.2)
    space = model.space
    assert linear_gain(beside, first.absent, begun, space) == pytest.approx(first.gain, rel=1e-6)


@pytest.mark.slow
def test_the_best_with_fewer_parameters_is_fitted_to_all_windows_although_another_leads() -> None:
    bench, base = bench_of(lopsided, screen_seconds=1.0, screen_windows=6)
    placed = placed_of(("asymmetric_friction", "constant_offset"))
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


def test_what_others_are_compared_with_ends_where_exact_slopes_lead() -> None:
    bench, base = bench_of()
    end = fitted_to_the_end(bench, base).fit
    assert end.converged
    assert end.cost <= base.fit.cost
    replay = Replay(base.model, bench.fit, 1).exact()
    exact = Fitter(replay, bench.solver).run(end.z, end.delta, iterations=0).slopes
    for found, known in ((end.slopes.state, exact.state), (end.slopes.parameter, exact.parameter)):
        assert np.linalg.norm(found - known) < 1e-3 * np.linalg.norm(known)


def test_candidates_that_go_no_farther_keep_no_slopes() -> None:
    bench, base = bench_of(screen_seconds=1.0, screen_windows=3)
    ranking = rank(bench, base, placed_of(("constant_offset", "viscous_friction", "actuator_delay")), lambda _: None)
    kept = {c.effect.effect.name: len(c.fitted_model.fit.slopes.state) for c in ranking.candidates}
    final = {c.effect.effect.name for c in ranking.candidates if c.final}
    assert final == {"constant_offset"}
    assert {name for name, windows in kept.items() if windows} == final
    assert kept["constant_offset"] == len(bench.fit)


def test_a_base_that_cannot_go_on_within_its_bounds_takes_no_credit() -> None:
    """Its damping ends a hair beside the bound that holds it back: what an effect adds is asked for all the same."""
    model = pendulum()
    held = {**PENDULUM_PARAMETERS, "hinge.damping": {**PENDULUM_PARAMETERS["hinge.damping"], "high": 0.02}}
    bench, _ = bench_of()
    bound = model_of(PENDULUM.replace('damping="0.05"', 'damping="0.01"'), held)
    base = fit_and_score(bench, bound, bound.space.nominal)
    assert base.fit.z[1] == pytest.approx(0.02)
    effect = place(catalogue_effect("viscous_friction"), model.nominal(), "hinge", scales_of(model, torque=0.5))
    beside = Fitter(Replay(bound.with_effect(effect), bench.fit, 1), bench.solver)
    near = replace(base.fit, z=base.fit.z - np.array([0.0, 1e-12]))
    there, hair = (look(beside, effect, each, own_step(each, bound.space)) for each in (base.fit, near))
    assert there.gain > 100.0
    assert hair.gain == pytest.approx(there.gain, rel=0.05)
