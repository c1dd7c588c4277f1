"""A pendulum that a hidden force acts on, for the tests of how candidates are looked at and fitted."""

from collections.abc import Callable, Iterable

import mujoco
import numpy as np
from diagnosis_machines import evidence_settings, pendulum, solver_settings, swinging, windows_of
from effect_machines import catalogue_effect, scales_of

from dr_lab.diagnosis.evidence.bench import Bench, FittedModel, fit_and_score
from dr_lab.effects.catalogue import candidates
from dr_lab.effects.effect import PlacedEffect

NAMES = ("quadratic_drag", "viscous_friction", "constant_offset", "spring", "torque_scale", "actuator_delay")
DRY_FRICTIONS = ("coulomb_friction", "stribeck_friction", "asymmetric_friction", "position_dependent_friction")
OFFSET = 0.03  # N·m; of the hidden forces


def push(data: mujoco.MjData) -> None:
    data.qfrc_applied[0] = OFFSET


def rub(data: mujoco.MjData) -> None:
    data.qfrc_applied[0] = -OFFSET * np.tanh(data.qvel[0] / 0.005)


def creep(data: mujoco.MjData) -> None:
    data.qfrc_applied[0] = -OFFSET * np.tanh(data.qvel[0] / 0.3)


def bear(data: mujoco.MjData) -> None:
    """Friction of a tenth of what the bearing carries."""
    data.qfrc_applied[0] = -0.1 * abs(data.qfrc_bias[0]) * np.tanh(data.qvel[0] / 0.005)


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


def placed_of(names: Iterable[str]) -> tuple[PlacedEffect, ...]:
    """Effects of the catalogue wherever the pendulum has a place for them."""
    model = pendulum()
    catalogue = {name: catalogue_effect(name) for name in names}
    return candidates(model, catalogue, scales_of(model, torque=0.5), model.nominal()).placed
