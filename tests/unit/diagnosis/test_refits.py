"""Fits of candidates to all windows, a constant torque on a pendulum being the truth."""

import mujoco
import numpy as np
import pytest
from diagnosis_machines import evidence_settings, pendulum, solver_settings, swinging, windows_of
from effect_machines import catalogue_effect, scales_of

from dr_lab.diagnosis.evidence.bench import Bench, fit_and_score
from dr_lab.diagnosis.search.candidate import Candidate
from dr_lab.diagnosis.search.candidate_fits import CandidateFits
from dr_lab.diagnosis.search.refits import Begun, Refits
from dr_lab.effects.effect import place

OFFSET = 0.03  # N·m


def push(data: mujoco.MjData) -> None:
    data.qfrc_applied[0] = OFFSET


@pytest.fixture(scope="module")
def begun() -> tuple[Refits, Candidate, Begun]:
    model = pendulum()
    fit, held_out = (
        windows_of(model, [swinging(n, model.nominal(), seed, force=push)]) for n, seed in (("a", 0), ("b", 1))
    )
    settings = evidence_settings(screen_seconds=1.0, screen_windows=6)
    bench = Bench(fit, held_out, solver_settings(), settings, threads=1)
    fits = CandidateFits(bench, fit_and_score(bench, model, model.space.nominal))
    effect = place(catalogue_effect("constant_offset"), model.nominal(), "hinge", scales_of(model, torque=0.5))
    candidate, refits = fits.fitted(effect, fits.look(effect)), Refits(fits)
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


def test_more_threads_change_no_fit(begun: tuple[Refits, Candidate, Begun]) -> None:
    refits, candidate, start = begun
    one, two = (refits.refitted(candidate, start, threads=count).fitted_model.fit for count in (1, 2))
    assert one.cost == two.cost
    np.testing.assert_array_equal(one.z, two.z)
