import numpy as np
import pytest
from diagnosis_machines import pendulum, solver_settings, swinging, windows_of
from effect_machines import catalogue_effect, scales_of

from dr_lab.diagnosis.fit.levenberg_marquardt import Fitter
from dr_lab.diagnosis.fit.replay import Replay
from dr_lab.diagnosis.search.as_special_case import further, special_case
from dr_lab.effects.effect import PlacedEffect, place

NAMES = ("coulomb_friction", "asymmetric_friction", "position_dependent_friction", "hysteresis")
TORQUE, ASYMMETRY = 0.03, 0.3  # N·m, share


def placed() -> dict[str, PlacedEffect]:
    model = pendulum()
    compiled, scales = model.nominal(), scales_of(model, torque=0.5)
    return {name: place(catalogue_effect(name), compiled, "hinge", scales) for name in NAMES}


@pytest.mark.parametrize(
    ("richer", "found"), [("asymmetric_friction", 1), ("coulomb_friction", None), ("hysteresis", None)]
)
def test_a_special_case_is_one_that_the_effect_can_act_as_exactly(richer: str, found: int | None) -> None:
    every = placed()
    among = [every["position_dependent_friction"], every["coulomb_friction"]]
    assert special_case(every[richer], among) == found


@pytest.mark.parametrize(("asymmetry", "worth"), [(0.0, False), (ASYMMETRY, True)])
def test_a_richer_effect_gains_beyond_its_special_case_where_it_acts(asymmetry: float, worth: bool) -> None:
    model, every = pendulum(), placed()

    def rub(data: object) -> None:
        speed = data.qvel[0]  # pyright: ignore[reportAttributeAccessIssue]
        share = 1.0 + asymmetry * np.sign(speed)
        data.qfrc_applied[0] = -TORQUE * share * np.tanh(speed / 0.005)  # pyright: ignore[reportAttributeAccessIssue]

    windows = windows_of(model, [swinging(n, model.nominal(), k, force=rub) for k, n in enumerate("ab")])
    case, richer = every["coulomb_friction"], every["asymmetric_friction"]
    simple = Fitter(Replay(model.with_effect(case), windows, 1), solver_settings())
    fit = simple.run(np.append(model.space.nominal, TORQUE))
    fitter = Fitter(Replay(model.with_effect(richer), windows, 1), solver_settings())
    there = further(fitter, richer, case, fit, simple.space.mapping(fit.z))
    assert there.fit.cost == pytest.approx(fit.cost, rel=1e-3)
    assert (there.gain > 0.1 * fit.cost) == worth
