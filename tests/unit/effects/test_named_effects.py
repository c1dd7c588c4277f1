"""Effects put into a model by the names of their parameters."""

import pytest
from effect_machines import block, catalogue_effect, placed

from dr_lab.effects.named import require_possible, with_named_effects
from dr_lab.errors import ConfigError, UnknownNameError

EFFECTS = {name: catalogue_effect(name) for name in ("viscous_friction", "spring", "sensor_time_offset")}


def test_effects_come_in_the_order_of_their_names_and_once() -> None:
    names = ["spring@rail.reference", "viscous_friction@rail.coefficient", "spring@rail.stiffness"]
    model = with_named_effects(block(), EFFECTS, names)
    assert [effect.label for effect in model.effects] == ["spring@rail", "viscous_friction@rail"]
    assert with_named_effects(model, EFFECTS, names) == model


def test_the_value_acts() -> None:
    model = with_named_effects(block(), EFFECTS, ["viscous_friction@rail.coefficient"])
    assert model.compile(model.space.vector({"viscous_friction@rail.coefficient": 0.7})).dof_damping[0] == 0.7


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("friction@rail.coefficient", "no effect 'friction' in the catalogue"),
        ("spring@ral.stiffness", "Available: rail"),
    ],
)
def test_mistakes_are_named(name: str, text: str) -> None:
    with pytest.raises(UnknownNameError, match=text):
        with_named_effects(block(), EFFECTS, [name])


def test_what_only_logs_tell_must_be_given() -> None:
    power = {"command_power": catalogue_effect("command_power")}
    with pytest.raises(ConfigError, match=r"without command_power@drive\.full, whose .* Give it as well"):
        with_named_effects(block(), power, ["command_power@drive.exponent"])
    named = ["command_power@drive.exponent", "command_power@drive.full"]
    assert with_named_effects(block(), power, named).effects[0].label == "command_power@drive"


@pytest.mark.parametrize("name", ["smooth_friction@rail.creep", "stribeck_friction@rail.speed"])
def test_what_a_law_divides_by_is_not_zero(name: str) -> None:
    label, _, short = name.rpartition(".")
    kind, _, site = label.partition("@")
    model = block().with_effect(placed(block(), kind, site))
    with pytest.raises(ConfigError, match=rf"context has {name} 0, expected above 0, for the law divides by it"):
        require_possible(model, model.space.vector({name: 0.0}), "context")
    assert short in catalogue_effect(kind).divisors
