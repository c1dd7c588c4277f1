"""What a report says of the models before and after calibration."""

from diagnosis_machines import measured, pendulum, short_comparison, swinging
from effect_machines import placed

from dr_lab.comparison.calibrated import as_given
from dr_lab.comparison.study import prepare
from dr_lab.physics.model import Model
from dr_lab.reports.gap_entries import Labels


def effects_as_given(model: Model) -> Labels:
    logs = [swinging(f"log_{k}", pendulum().nominal(), k) for k in range(2)]
    _, rung = as_given(prepare(short_comparison(model, measured(logs[:1], logs[1:]))))
    return rung.effects


def test_a_model_as_given_has_the_effects_that_it_came_with() -> None:
    assert effects_as_given(pendulum()) == ()
    rubbing = pendulum().with_effect(placed(pendulum(), "coulomb_friction", "hinge"))
    assert effects_as_given(rubbing) == ("coulomb_friction@hinge",)
