"""Fits of candidates beside the model of a pendulum on which a hidden force acts; few of the windows screen."""

from collections.abc import Callable
from functools import cache

import mujoco
import numpy as np
from diagnosis_machines import evidence_settings, pendulum, solver_settings, swinging, windows_of
from effect_machines import catalogue_effect, scales_of

from dr_lab.diagnosis.evidence.bench import Bench, fit_and_score
from dr_lab.diagnosis.search.candidate import Candidate
from dr_lab.diagnosis.search.candidate_fits import CandidateFits
from dr_lab.effects.effect import PlacedEffect, place

TORQUE = 0.1  # N·m
OFFSET = 0.03  # N·m
CREEP = 1.0  # rad/s


def creeping(data: mujoco.MjData) -> None:
    data.qfrc_applied[0] = -TORQUE * np.tanh(data.qvel[0] / CREEP)


def rubbing(data: mujoco.MjData) -> None:
    data.qfrc_applied[0] = -TORQUE * np.tanh(data.qvel[0] / 0.005)


def push(data: mujoco.MjData) -> None:
    data.qfrc_applied[0] = OFFSET


def stopping(data: mujoco.MjData) -> None:
    place = float(data.qpos[0])
    data.qfrc_applied[0] = -20.0 * (place - np.clip(place, -0.4, 0.4))


def effect_of(name: str) -> PlacedEffect:
    model = pendulum()
    return place(
        catalogue_effect(name), model.nominal(), "hinge", scales_of(model, torque=0.5, position=1.0, speed=5.0)
    )


@cache
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


@cache
def tried(fits: CandidateFits, name: str) -> Candidate:
    """An effect as it is fitted to the windows that screen."""
    effect = effect_of(name)
    return fits.fitted(effect, fits.look(effect))
