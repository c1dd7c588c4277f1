"""What the names of channels tell."""

import pytest

from dr_lab.channel_names import is_sensor, joint_of, quantity


@pytest.mark.parametrize(
    ("name", "measured"),
    [
        ("arm.position", "position"),
        ("left.arm.velocity", "velocity"),
        ("sensor.position", ""),
        ("sensor.velocity", ""),
        ("sensor.velocity.x", ""),
        ("motor", ""),
    ],
)
def test_a_sensor_of_whatever_name_is_no_joint(name: str, measured: str) -> None:
    assert quantity(name) == measured
    assert is_sensor(name) == name.startswith("sensor.")


def test_a_joint_may_have_dots_in_its_name() -> None:
    assert joint_of("left.arm.velocity") == "left.arm"
