"""Where a fit begins once one of two frictions of a joint is gone, of which the logs tell the sum alone."""

import mujoco
import numpy as np
import pytest
from diagnosis_machines import pendulum, solver_settings, swinging, windows_of
from effect_machines import catalogue_effect, scales_of

from dr_lab.diagnosis.evidence.bench import fitted_alone
from dr_lab.diagnosis.fit.levenberg_marquardt import Fitter
from dr_lab.diagnosis.fit.replay import Replay
from dr_lab.diagnosis.search.taken_away import taken_away
from dr_lab.effects.effect import place

HARD, SMOOTH, CREEP = 0.02, 0.03, 0.02  # N·m, N·m, rad/s
VALUES = {
    "coulomb_friction@hinge.torque": HARD,
    "smooth_friction@hinge.torque": SMOOTH,
    "smooth_friction@hinge.creep": CREEP,
}


def rub(data: mujoco.MjData) -> None:
    data.qfrc_applied[0] = -(HARD + SMOOTH) * np.tanh(data.qvel[0] / CREEP)


@pytest.mark.parametrize("stays", ["smooth_friction", "coulomb_friction"])
def test_friction_that_stays_takes_over_from_the_other_kind_beside_it(stays: str) -> None:
    model, scales = pendulum(), scales_of(pendulum(), torque=0.5)
    windows = windows_of(model, [swinging(name, model.nominal(), k, force=rub) for k, name in enumerate("ab")])
    kinds = ("coulomb_friction", "smooth_friction")
    hard, smooth = (place(catalogue_effect(name), model.nominal(), "hinge", scales) for name in kinds)
    both = model.with_effect(hard).with_effect(smooth)
    values = dict(zip(both.space.names, both.space.nominal, strict=True)) | VALUES
    replay = Replay(both, windows, 1)
    whole = Fitter(replay, solver_settings()).run(both.space.vector(values), iterations=0)
    kept = hard if stays == hard.effect.name else smooth
    fitter = Fitter(Replay(model.with_effect(kept), windows, 1), solver_settings())
    as_was, _, over = taken_away(fitter, fitted_alone(replay, whole))
    found = fitter.space.mapping(over.z)
    assert found.pop(f"{stays}@hinge.torque") == pytest.approx(HARD + SMOOTH)
    assert found == {name: values[name] for name in found}
    assert over.cost < 0.2 * as_was.cost  # of what is left the start states take up the most


def test_of_two_kinds_that_stay_each_takes_over_alone() -> None:
    model, scales = pendulum(), scales_of(pendulum(), torque=0.5)
    windows = windows_of(model, [swinging("a", model.nominal(), 0)])
    kinds = ("coulomb_friction", "smooth_friction", "asymmetric_friction")
    hard, *stay = (place(catalogue_effect(name), model.nominal(), "hinge", scales) for name in kinds)
    both = model.with_effect(stay[0]).with_effect(stay[1])
    whole = both.with_effect(hard)
    sizes = {f"{hard.label}.torque": 0.1, f"{stay[0].label}.torque": 0.05, f"{stay[1].label}.mean": 0.02}
    values = dict(zip(whole.space.names, whole.space.nominal, strict=True)) | sizes
    replay = Replay(whole, windows, 1)
    fitted = fitted_alone(replay, Fitter(replay, solver_settings()).run(whole.space.vector(values), iterations=0))
    fitter = Fitter(Replay(both, windows, 1), solver_settings())
    *_, first, second = (fitter.space.mapping(start.z) for start in taken_away(fitter, fitted))
    found = [(each[f"{stay[0].label}.torque"], each[f"{stay[1].label}.mean"]) for each in (first, second)]
    assert found == [pytest.approx((0.15, 0.02)), pytest.approx((0.05, 0.12))]


def test_nothing_takes_over_from_an_effect_of_another_kind() -> None:
    model, scales = pendulum(), scales_of(pendulum(), torque=0.5)
    windows = windows_of(model, [swinging("a", model.nominal(), 0)])
    kinds = ("coulomb_friction", "constant_offset")
    hard, push = (place(catalogue_effect(name), model.nominal(), "hinge", scales) for name in kinds)
    replay = Replay(model.with_effect(hard).with_effect(push), windows, 1)
    whole = Fitter(replay, solver_settings()).run(replay.model.space.nominal, iterations=0)
    fitter = Fitter(Replay(model.with_effect(push), windows, 1), solver_settings())
    assert len(taken_away(fitter, fitted_alone(replay, whole))) == 2
