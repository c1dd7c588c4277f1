from collections.abc import Callable
from dataclasses import replace

import mujoco
import numpy as np
import pytest
from diagnosis_machines import pendulum, solver_settings, swinging, windows_of
from effect_machines import catalogue_effect, scales_of

from dr_lab.diagnosis.fit.levenberg_marquardt import Fitter
from dr_lab.diagnosis.fit.replay import Replay
from dr_lab.diagnosis.search.as_special_case import (
    further,
    in_the_limit,
    limits,
    reaching,
    special_case,
    taking_over,
)
from dr_lab.effects.effect import PlacedEffect, place

NAMES = ("coulomb_friction", "asymmetric_friction", "position_dependent_friction", "hysteresis")
TORQUE, ASYMMETRY = 0.03, 0.3  # N·m, share


def placed() -> dict[str, PlacedEffect]:
    model = pendulum()
    compiled, scales = model.nominal(), scales_of(model, torque=0.5)
    return {name: place(catalogue_effect(name), compiled, "hinge", scales) for name in NAMES}


def rubbing(asymmetry: float) -> Callable[[mujoco.MjData], None]:
    """Friction that differs between the directions."""

    def rub(data: mujoco.MjData) -> None:
        speed = data.qvel[0]
        data.qfrc_applied[0] = -TORQUE * (1.0 + asymmetry * np.sign(speed)) * np.tanh(speed / 0.005)

    return rub


@pytest.mark.parametrize(
    ("richer", "found"), [("asymmetric_friction", 1), ("coulomb_friction", None), ("hysteresis", None)]
)
def test_a_special_case_is_one_that_the_effect_can_act_as_exactly(richer: str, found: int | None) -> None:
    every = placed()
    among = [every["position_dependent_friction"], every["coulomb_friction"]]
    assert special_case(every[richer], among) == found


def test_effects_wait_for_the_plainest_one_that_they_are_like_in_a_limit() -> None:
    model = pendulum()
    names = ("presliding_friction", "smooth_friction", "soft_friction", "coulomb_friction", "viscous_friction")
    every = [place(catalogue_effect(name), model.nominal(), "hinge", scales_of(model)) for name in names]
    assert limits(every, range(5), range(5)) == {0: 3, 1: 3, 2: 3}
    assert limits(every, [0, 2], [0, 1, 2]) == {0: 1}  # smooth friction has fewer parameters than presliding friction


def test_a_limit_without_a_quantity_in_common_is_no_beginning() -> None:
    model = pendulum()
    names = ("torque_speed_limit", "saturation")
    every = [place(catalogue_effect(name), model.nominal(), "drive", scales_of(model)) for name in names]
    assert limits(every, [0], [1]) == {}


@pytest.mark.parametrize(("asymmetry", "worth"), [(0.0, False), (ASYMMETRY, True)])
def test_a_richer_effect_gains_beyond_its_special_case_where_it_acts(asymmetry: float, worth: bool) -> None:
    model, every = pendulum(), placed()
    windows = windows_of(model, [swinging(n, model.nominal(), k, force=rubbing(asymmetry)) for k, n in enumerate("ab")])
    case, richer = every["coulomb_friction"], every["asymmetric_friction"]
    simple = Fitter(Replay(model.with_effect(case), windows, 1), solver_settings())
    fit = simple.run(np.append(model.space.nominal, TORQUE))
    fitter = Fitter(Replay(model.with_effect(richer), windows, 1), solver_settings())
    there = further(fitter, richer, case, fit, simple.space.mapping(fit.z))
    assert there.fit.cost == pytest.approx(fit.cost, rel=1e-3)
    assert (there.gain > 0.1 * fit.cost) == worth


def test_a_richer_effect_acts_as_a_special_case_whose_bound_was_moved() -> None:
    """Hard friction as large as half of what is looked for at first, in a model that looks for a tenth of it."""
    model, every = pendulum(), placed()
    case, richer = every["coulomb_friction"], every["asymmetric_friction"]
    near = replace(case.parameters[0], high=0.1 * TORQUE)
    small, richer = (
        one.bounded((replace(near, name=one.parameters[0].name), *one.parameters[1:])) for one in (case, richer)
    )
    assert reaching(richer, small) == richer
    wide = small.moved((replace(near, high=2 * TORQUE),))
    windows = windows_of(model, [swinging(n, model.nominal(), k, force=rubbing(0.0)) for k, n in enumerate("ab")])
    simple = Fitter(Replay(model.with_effect(wide), windows, 1), solver_settings())
    fit = simple.run(np.append(model.space.nominal, TORQUE))
    assert fit.z[-1] == pytest.approx(TORQUE, rel=0.1)
    reached = reaching(richer, wide)
    assert reached.looked == (("asymmetric_friction@hinge.mean", 0.0, 0.1 * TORQUE),)
    assert reaching(small, reached).parameters == wide.parameters
    fitter = Fitter(Replay(model.with_effect(reached), windows, 1), solver_settings())
    there = further(fitter, reached, wide, fit, simple.space.mapping(fit.z))
    assert there.fit.cost == pytest.approx(fit.cost, rel=1e-3)


def test_in_the_limit_an_effect_keeps_its_further_parameters_and_takes_over_the_others() -> None:
    model, every = pendulum(), placed()
    limit, richer = every["coulomb_friction"], every["hysteresis"]
    space = model.with_effect(richer).space
    own = space.mapping(space.low + 0.25 * space.span)
    values = {"rod.mass": 0.6, "hinge.damping": 0.07, "coulomb_friction@hinge.torque": TORQUE}
    found = space.mapping(in_the_limit(richer, limit, space, own, values))
    assert found["hysteresis@hinge.torque"] == TORQUE
    assert found["hysteresis@hinge.displacement"] == own["hysteresis@hinge.displacement"]
    assert (found["rod.mass"], found["hinge.damping"]) == (0.6, 0.07)


def test_a_richer_effect_begins_in_the_place_of_its_special_case_in_the_model() -> None:
    model, every = pendulum(), placed()
    case, other = every["coulomb_friction"], every["asymmetric_friction"]
    richer = place(catalogue_effect("smooth_friction"), model.nominal(), "hinge", scales_of(model, torque=0.5))
    rubbed = model.with_effect(case)
    begun = taking_over(richer, rubbed, {f"{case.label}.torque": TORQUE})
    assert len(begun.starts) == len(richer.starts)
    for before, after in zip(richer.starts, begun.starts, strict=True):
        assert before[f"{richer.label}.torque"] != TORQUE
        assert after == {**before, f"{richer.label}.torque": TORQUE, f"{case.label}.torque": 0.0}
    high = richer.parameters[0].high
    far = taking_over(richer, rubbed, {f"{case.label}.torque": 2 * high})
    assert {start[f"{richer.label}.torque"] for start in far.starts} == {high}
    assert taking_over(richer, model, {}) is richer
    assert taking_over(richer, rubbed, {f"{case.label}.torque": 0.0}) is richer  # else it would begin at absent
    both = {f"{case.label}.torque": 0.02, f"{richer.label}.torque": 0.01, f"{richer.label}.creep": 0.05}
    bristles = place(catalogue_effect("presliding_friction"), model.nominal(), "hinge", scales_of(model, torque=0.5))
    starts = taking_over(bristles, rubbed.with_effect(richer), both).starts
    assert {start[f"{bristles.label}.torque"] for start in starts} == {0.03}
    assert {start[f"{bristles.label}.creep"] for start in starts} == {0.05}
    falling, lugre = (
        place(catalogue_effect(name), model.nominal(), "hinge", scales_of(model, torque=0.5))
        for name in ("stribeck_friction", "lugre_friction")
    )
    known = {p.name: 0.7 * p.high for p in falling.parameters}
    assert len(lugre.starts) == 2
    assert len(taking_over(lugre, model.with_effect(falling), known).starts) == 1  # what they differ in is taken over
    assert taking_over(case, model.with_effect(other), {}) is case  # the poorer one of the two stands beside it
