"""What the names of channels tell."""

import pytest

from dr_lab.channel_names import is_sensor, joint_of, quantity, sensor_of


@pytest.mark.parametrize(
    ("name", "measured", "sensed"),
    [
        ("arm.position", "position", False),
        ("left.arm.velocity", "velocity", False),
        ("sensorless.position", "position", False),
        ("sensor.position", "", True),
        ("sensor.velocity", "", True),
        ("sensor.velocity.x", "", True),
        ("motor", "", False),
    ],
)
def test_a_sensor_of_whatever_name_is_no_joint(name: str, measured: str, sensed: bool) -> None:
    assert quantity(name) == measured
    assert is_sensor(name) == sensed


def test_a_sensor_keeps_its_axis() -> None:
    assert sensor_of("sensor.velocity.x") == "velocity.x"


def test_a_joint_may_have_dots_in_its_name() -> None:
    assert joint_of("left.arm.velocity") == "left.arm"
