"""Fits of candidates to all windows where the inertia of bodies is free, which few windows bend to what is left."""

from dataclasses import replace

import mujoco
import numpy as np
from diagnosis_machines import PENDULUM, evidence_settings, solver_settings, swinging, windows_of
from effect_machines import catalogue_effect, scales_of

from dr_lab.diagnosis.evidence.bench import Bench, fit_and_score
from dr_lab.diagnosis.search.candidate_fits import CandidateFits
from dr_lab.diagnosis.search.refits import Refits
from dr_lab.effects.effect import place
from dr_lab.physics.model import from_spec

OFFSET = 0.03  # N·m


def push(data: mujoco.MjData) -> None:
    data.qfrc_applied[0] = OFFSET


def test_a_fit_to_all_windows_begins_with_the_bodies_that_explain_them_better() -> None:
    model = from_spec("pendulum", mujoco.MjSpec.from_string(PENDULUM), "inertial")
    logs = (swinging(name, model.nominal(), seed, force=push) for name, seed in (("a", 0), ("b", 1)))
    fit, held_out = (windows_of(model, [log]) for log in logs)
    bench = Bench(fit, held_out, solver_settings(), evidence_settings(screen_seconds=1.5), threads=1)
    base = fit_and_score(bench, model, model.space.nominal)
    fits = CandidateFits(bench.beside(base), base)
    effect = place(catalogue_effect("constant_offset"), model.nominal(), "hinge", scales_of(model, torque=0.5))
    effect = replace(effect, starts=({name.name: 0.5 * OFFSET for name in effect.parameters},))
    candidate = fits.fitted(effect, fits.look(effect))
    known, begun = len(base.fit.z), Refits(fits).begun(candidate)
    there, near = candidate.fitted_model.fit.z, begun.start.z
    assert any(np.array_equal(near[:known], z[:known]) for z in (there, base.fit.z))
    # Bodies that only few windows ask for: the start is the base's.
    bent = there.copy()
    bent[:known] = model.space.from_unit(np.full(known, 0.7))
    wrong = replace(candidate.fitted_model, fit=replace(candidate.fitted_model.fit, z=bent))
    begun = Refits(fits).begun(replace(candidate, fitted_model=wrong))
    np.testing.assert_array_equal(begun.start.z[:known], base.fit.z)
    np.testing.assert_array_equal(begun.start.z[known:], there[known:])
