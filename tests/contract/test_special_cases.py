"""That effects hold the special cases that they name: with some values they act as these."""

from collections.abc import Iterator

import numpy as np
import pytest
from effect_machines import CONF, NAMES, block, catalogue_effect, hanging, placed, replayed, scales_of

from dr_lab.effects.catalogue import SpecialCases
from dr_lab.effects.effect import PlacedEffect
from dr_lab.physics.model import Model, load
from dr_lab.trajectory import Array

SECONDS = 0.4
CLOSE = 0.05  # of what the poorer effect does; hysteresis, dry friction in its limit alone, is 0.033 off, the others 0
ELSEWHERE = (
    ("planar_payload", "payload"),
    ("rigid_payload", "payload"),
    ("lugre_friction", "stribeck_friction"),
    ("presliding_friction", "smooth_friction"),
)
RANGE = 0.1  # rad, which bounds how near to the limit it comes


def pairs() -> Iterator[tuple[str, str]]:
    for name in NAMES:
        for poorer in catalogue_effect(name).holds:
            yield name, poorer


def moved(model: Model, effect: PlacedEffect, **values: float) -> Array:
    """Positions under a command that reverses several times, with the effect at these values."""
    extended = model.with_effect(effect)
    z = extended.space.vector({f"{effect.label}.{name}": value for name, value in values.items()})
    time = 0.002 * np.arange(-30, round(SECONDS / 0.002))
    wave = 12.0 * np.sin(20.0 * time)[None, :, None]
    return replayed(extended, z[None], wave[:, 30:], wave[:, :30])[0]


def machine(richer: str) -> Model:
    """One that has a site for the effect."""
    elsewhere = {"planar_payload": "furuta.xml", "rigid_payload": "strangers/seven.xml"}
    return load("machine", CONF / "model" / elsewhere[richer], {}) if richer in elsewhere else hanging()


def site_of(model: Model, name: str) -> str:
    return catalogue_effect(name).sites(model.nominal())[0]


def limits(effect: PlacedEffect, poorer: str) -> dict[str, float]:
    """The further parameters at zero, or as near to it as their bounds let them."""
    bounds = {p.name.removeprefix(f"{effect.label}."): p for p in effect.parameters}
    further = effect.effect.holds[poorer].further
    return {name: float(np.clip(0.0, bounds[name].low, bounds[name].high)) for name in further}


def test_what_an_effect_holds_is_in_the_catalogue_and_poorer() -> None:
    assert set(pairs()) == {
        ("asymmetric_friction", "coulomb_friction"),
        ("flexible_mode", "armature"),
        ("friction_drift", "coulomb_friction"),
        ("friction_drift", "viscous_friction"),
        ("hysteresis", "coulomb_friction"),
        ("lugre_friction", "coulomb_friction"),
        ("lugre_friction", "stribeck_friction"),
        ("planar_payload", "payload"),
        ("position_dependent_friction", "coulomb_friction"),
        ("presliding_friction", "coulomb_friction"),
        ("presliding_friction", "smooth_friction"),
        ("rigid_payload", "payload"),
        ("smooth_friction", "coulomb_friction"),
        ("soft_friction", "coulomb_friction"),
        ("stribeck_friction", "coulomb_friction"),
        ("torque_speed_limit", "saturation"),
    }
    assert all(poorer in NAMES for _, poorer in pairs())


@pytest.mark.parametrize(("richer", "poorer"), list(pairs()))
def test_names_are_parameters(richer: str, poorer: str) -> None:
    model, case = machine(richer), catalogue_effect(richer).holds[poorer]
    ours, theirs = (placed(model, name, site_of(model, richer)) for name in (richer, poorer))
    names, special = ({p.name.rpartition(".")[2] for p in effect.parameters} for effect in (ours, theirs))
    assert set(case.further) | set(case.same) <= names
    assert set(case.same.values()) <= special
    assert set(case.further).isdisjoint(case.same)
    assert len(names) > len(special)


@pytest.mark.parametrize(("richer", "poorer"), [pair for pair in pairs() if pair not in ELSEWHERE])
def test_without_its_further_parameters_an_effect_acts_as_the_poorer_one(richer: str, poorer: str) -> None:
    """The one that is left is the same quantity, or so where an actuator gives 1 N·m for a command of 1.

    Where the poorer one has several parameters, tests of the richer one compare them.
    """
    model, case = hanging(), catalogue_effect(richer).holds[poorer]
    scales = scales_of(model, position=RANGE)
    ours, theirs = (placed(model, name, site_of(model, name), scales) for name in (richer, poorer))
    (parameter,) = theirs.parameters
    to = parameter.name.rpartition(".")[2]
    value = 0.1 * parameter.high
    truth, without = (moved(model, theirs, **{to: each}) for each in (value, 0.0))
    (name,) = (n for n in (p.rpartition(".")[2] for p in ours.absent) if n not in case.further)

    assert case.same in ({name: to}, {})
    found = moved(model, ours, **{name: value, **limits(ours, poorer)})
    assert np.abs(truth - without).max() > 1e-3
    assert np.abs(found - truth).max() < CLOSE * np.abs(truth - without).max()


def test_special_cases_sit_at_the_same_site_of_a_model_that_lacks_them() -> None:
    model = block()
    effects = {name: catalogue_effect(name) for name in ("coulomb_friction", "viscous_friction")}
    richer, friction = (placed(model, name, "rail") for name in ("asymmetric_friction", "coulomb_friction"))
    cases = SpecialCases(effects, scales_of(model), model.nominal())
    assert [poorer.label for poorer in cases.of(richer, model.with_effect(richer))] == ["coulomb_friction@rail"]
    assert cases.of(richer, model.with_effect(friction).with_effect(richer)) == ()
    assert cases.of(friction, model.with_effect(friction)) == ()
