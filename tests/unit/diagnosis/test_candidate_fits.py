from collections.abc import Callable
from dataclasses import replace

import mujoco
import numpy as np
import pytest
from diagnosis_machines import evidence_settings, pendulum, solver_settings, swinging, windows_of
from effect_machines import catalogue_effect, scales_of

from dr_lab.diagnosis.evidence.bench import Bench, fit_and_score
from dr_lab.diagnosis.search.candidate import Candidate
from dr_lab.diagnosis.search.candidate_fits import CandidateFits
from dr_lab.effects.effect import PlacedEffect, place

TORQUE = 0.1  # N·m


def creeping(data: mujoco.MjData) -> None:
    data.qfrc_applied[0] = -TORQUE * np.tanh(data.qvel[0] / 1.0)


def effect_of(name: str) -> PlacedEffect:
    model = pendulum()
    return place(
        catalogue_effect(name), model.nominal(), "hinge", scales_of(model, torque=0.5, position=1.0, speed=5.0)
    )


def fits_of(force: Callable[[mujoco.MjData], None]) -> CandidateFits:
    """Fits beside the calibrated model of a pendulum that a hidden force acts on; few of the windows screen."""
    model = pendulum()
    fit, held_out = (
        windows_of(model, [swinging(n, model.nominal(), seed, force=force)]) for n, seed in (("a", 0), ("b", 1))
    )
    bench = Bench(fit, held_out, solver_settings(), evidence_settings(screen_seconds=1.5), threads=1)
    base = fit_and_score(bench, model, model.space.nominal)
    fits = CandidateFits(bench.beside(base), base)
    assert not fits.whole
    return fits


def tried(fits: CandidateFits, name: str) -> Candidate:
    """An effect as it is fitted to the windows that screen."""
    effect = effect_of(name)
    return fits.fitted(effect, fits.look(effect))


def test_an_effect_stands_beside_its_limit_if_it_explains_more() -> None:
    fits = fits_of(creeping)
    limit, soft = fits.refitted(tried(fits, "coulomb_friction")), tried(fits, "presliding_friction")
    assert limit.final
    found, alone = fits.refitted_beyond(soft, limit), fits.refitted(soft)
    assert found.final
    assert found.fitted_model.fit.converged
    assert found.fitted_model.fit.cost < 0.8 * limit.fitted_model.fit.cost
    assert found.fitted_model.fit.cost == pytest.approx(alone.fitted_model.fit.cost, rel=1e-3)


def test_an_effect_that_stays_above_its_limit_is_not_fitted_to_the_end() -> None:
    fits = fits_of(creeping)
    soft, limit = tried(fits, "presliding_friction"), fits.refitted(tried(fits, "coulomb_friction"))
    low = replace(limit.fitted_model.fit, cost=0.5 * limit.fitted_model.fit.cost)
    beaten = replace(limit, fitted_model=replace(limit.fitted_model, fit=low))
    assert fits.refitted_beyond(soft, beaten) is soft
    untried = replace(limit, final=False)
    assert fits.refitted_beyond(soft, untried).final
