"""What the time step does to dry friction, beside what a richer law changes."""

import mujoco
import numpy as np
import pytest
from diagnosis_machines import evidence_settings, pendulum, solver_settings, swinging, windows_of
from effect_machines import catalogue_effect

from dr_lab.diagnosis.checks.numerical_floor import in_parts
from dr_lab.diagnosis.evidence.bench import Bench, FittedModel, fit_and_score
from dr_lab.diagnosis.fit.scales import machine_scales
from dr_lab.diagnosis.search.hidden_by_step import hidden_by_step
from dr_lab.effects.effect import place
from dr_lab.trajectory import Log

NOISE = 2e-6  # rad; the step of 2 ms moves the pendulum by a hundred times as much
TORQUE = 0.1  # N·m


def rubbing(asymmetry: float) -> list[Log]:
    """Logs of a pendulum at a sixteenth of its model's step, with friction that hardly creeps."""
    spec = in_parts(pendulum(), 16).spec

    def push(data: mujoco.MjData) -> None:
        way = np.tanh(data.qvel[0] / 1e-4)
        data.qfrc_applied[0] = -TORQUE * way * (1 + asymmetry * way)

    return [swinging(f"log_{k}", spec.compile(), k, force=push, seconds=1.2, noise=NOISE) for k in range(3)]


@pytest.mark.slow
@pytest.mark.parametrize(("asymmetry", "hidden"), [(0.0, True), (0.3, False)])
def test_a_richer_law_that_changes_no_more_than_the_time_step_does_is_told(asymmetry: float, *, hidden: bool) -> None:
    model, logs = pendulum(), rubbing(asymmetry)
    seen, unseen = (windows_of(model, part, noise=NOISE) for part in (logs[:2], logs[2:]))
    bench = Bench(seen, unseen, solver_settings(tolerance=1e-3), evidence_settings(), 1)
    scales = machine_scales(model.nominal(), logs[:2], 0.03)

    def fitted(name: str) -> FittedModel:
        effect = place(catalogue_effect(name), model.nominal(), "hinge", scales)
        return fit_and_score(bench, model.with_effect(effect), model.with_effect(effect).space.nominal)

    poorer, richer = fitted("coulomb_friction"), fitted("asymmetric_friction")
    assert richer.held_out.chi2 < poorer.held_out.chi2
    assert hidden_by_step(bench, poorer, richer) == hidden
