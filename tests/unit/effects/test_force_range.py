"""A joint's range of actuator forces bounds its drive, and not the passive forces that effects add."""

import numpy as np
import pytest
from effect_machines import acceleration, block, placed, with_effect

from dr_lab.errors import ModelError

MASS = 2.0  # kg, of the block
EFFECTS = [
    ("constant_offset", {"torque": 4.0}),
    ("asymmetric_friction", {"mean": 2.0, "asymmetry": -1.0}),
    ("stribeck_friction", {"kinetic": 1.0, "excess": 4.0, "speed": 1.0}),
    ("cogging", {"sine": 4.0, "periods": 30.0}),
]
RANGE = 'actuatorfrcrange="-10 8"'


@pytest.mark.parametrize(("name", "values"), EFFECTS)
@pytest.mark.parametrize("gear", [1.0, 2.5, -2.0])
def test_the_range_bounds_the_drive_alone(name: str, values: dict[str, float], gear: float) -> None:
    motor = f'<motor name="drive" joint="rail" gear="{gear}"/>'
    bounded, free = (with_effect(block(motor, joint), name, "rail", **values) for joint in (RANGE, ""))
    for force in (-30.0, -10.0, 3.0, 8.0, 20.0):
        moved = {"qpos": np.pi / 60, "qvel": 5.0}
        expected = acceleration(free, ctrl=np.clip(force, -10.0, 8.0) / gear, **moved)
        assert acceleration(bounded, ctrl=force / gear, **moved) == pytest.approx(expected)


@pytest.mark.parametrize("name", [name for name, _ in EFFECTS])
def test_absent_leaves_the_range(name: str) -> None:
    plain, absent = block(joint=RANGE).nominal(), with_effect(block(joint=RANGE), name, "rail")
    for force in (-30.0, 3.0, 30.0):
        assert acceleration(absent, ctrl=force) == acceleration(plain, ctrl=force)
    assert acceleration(plain, ctrl=30.0) == pytest.approx(8.0 / MASS)


@pytest.mark.parametrize(("own", "most"), [("-20 6", 6.0), ("-6 20", 8.0)])
def test_the_narrower_of_two_ranges_counts(own: str, most: float) -> None:
    motor = f'<motor name="drive" joint="rail" forcerange="{own}"/>'
    both = block(motor, RANGE).with_effect(placed(block(motor, RANGE), "cogging", "rail"))
    both = both.with_effect(placed(both, "constant_offset", "rail"))
    model = both.compile(both.space.vector({"constant_offset@rail.torque": 4.0}))
    assert acceleration(model, ctrl=30.0) == pytest.approx((most + 4.0) / MASS)


def test_a_joint_without_a_drive_has_nothing_to_bound() -> None:
    model = with_effect(block("", RANGE), "constant_offset", "rail", torque=12.0)
    assert acceleration(model) == pytest.approx(12.0 / MASS)


TWO = '<motor name="drive" joint="rail"/><motor name="other" joint="rail"/>'
CARRIED = f'{RANGE} actuatorgravcomp="true"'


@pytest.mark.parametrize(("motors", "joint"), [(TWO, RANGE), (TWO.replace("joint=", "jointinparent="), RANGE)])
def test_a_range_that_several_actuators_share_is_refused(motors: str, joint: str) -> None:
    with pytest.raises(ModelError, match=r"actuatorfrcrange \[-10, 8\].*Give each actuator of the joint a forcerange"):
        with_effect(block(motors, joint), "constant_offset", "rail")
    with_effect(block(motors), "constant_offset", "rail")  # without a range they may


def test_a_range_that_bounds_a_carried_weight_too_is_refused() -> None:
    with pytest.raises(ModelError, match="sum of several forces"):
        with_effect(block(joint=CARRIED), "constant_offset", "rail")


def test_ranges_with_nothing_in_common_are_refused() -> None:
    motor = '<motor name="drive" joint="rail" forcerange="9 12"/>'
    with pytest.raises(ModelError, match="expected ranges that overlap"):
        with_effect(block(motor, RANGE), "constant_offset", "rail")


def test_a_range_that_is_not_heeded_stays_so() -> None:
    model = with_effect(block(joint=f'{RANGE} actuatorfrclimited="false"'), "constant_offset", "rail", torque=4.0)
    assert acceleration(model, ctrl=30.0) == pytest.approx(34.0 / MASS)
