import mujoco
import numpy as np
import pytest

from dr_lab.proposal.command_units import factors
from dr_lab.proposal.drives import drives_of

MACHINE = """<mujoco><worldbody>
  <body><joint name="turn" axis="0 1 0"/><geom size="0.1"/></body>
  <body pos="1 0 0"><joint name="slide" type="slide"/><geom size="0.1"/></body>
</worldbody><actuator>{}</actuator></mujoco>"""


@pytest.mark.parametrize(
    ("actuator", "units"),
    [
        ('<motor joint="{}"/>', ("N·m", "N")),
        ('<motor joint="{}" gear="-1"/>', ("N·m", "N")),
        ('<motor joint="{}" gear="3"/>', ("1", "1")),  # a current, a duty cycle, …
        ('<position joint="{}" kp="20" kv="1"/>', ("rad", "m")),
        ('<velocity joint="{}" kv="3"/>', ("rad/s", "m/s")),
        ('<intvelocity joint="{}" kp="20" kv="1" actrange="-1 1"/>', ("rad/s", "m/s")),
        ('<general joint="{}" gainprm="7"/>', ("1", "1")),
        ('<general joint="{}" gainprm="3" biastype="affine" biasprm="0 0 -2"/>', ("1", "1")),
    ],
)
def test_the_unit_of_a_control_is_that_of_what_the_actuator_holds(actuator: str, units: tuple[str, str]) -> None:
    xml = MACHINE.format("".join(actuator.format(joint) for joint in ("turn", "slide")))
    found = drives_of(mujoco.MjModel.from_xml_string(xml), np.eye(2))
    assert tuple(drive.unit for drive in found) == units
    assert all(drive.servo == ("position" in actuator) for drive in found)


def test_an_actuator_that_takes_no_command_is_none_of_them() -> None:
    """As in the files that dr-lab close writes, where it adds a force."""
    force = """<general joint="turn" gaintype="dcmotor" dyntype="dcmotor" actearly="true" input="none" biastype="affine"
      biasprm="1"/>"""
    motors = "".join(f'<motor name="{joint}_motor" joint="{joint}"/>' for joint in ("slide", "turn"))
    found = drives_of(mujoco.MjModel.from_xml_string(MACHINE.format(force + motors)), np.eye(2)[::-1])
    assert [(drive.name, drive.joint) for drive in found] == [("slide_motor", "slide"), ("turn_motor", "turn")]


def test_what_a_control_without_a_unit_gives_is_told_in_the_unit_of_its_joint() -> None:
    xml = MACHINE.format("".join(f'<motor joint="{joint}" gear="3"/>' for joint in ("turn", "slide")))
    turn, slide = drives_of(mujoco.MjModel.from_xml_string(xml), 3 * np.eye(2))
    assert (turn.told, slide.told) == ("; 1 of ctrl is 3 N·m", "; 1 of ctrl is 3 N")
    plain = drives_of(mujoco.MjModel.from_xml_string(MACHINE.format('<motor joint="turn"/>')), np.eye(2)[:1])
    assert plain[0].told == ""


def test_a_control_without_a_unit_takes_that_of_its_column() -> None:
    assert factors("1", "mA") == {"1": 1.0, "percent": 0.01, "mA": 1e-3}
    assert "mA" not in factors("N", "mA")


@pytest.mark.parametrize(("gear", "unit"), [("0 0 1 0 0 0.02", "N"), ("0 0 0 0 0 1", "N"), ("0 0 8 0 0 0.02", "1")])
def test_a_propeller_is_commanded_by_its_thrust_where_its_gear_leaves_that_as_it_is(gear: str, unit: str) -> None:
    """The drag of a propeller is no gear."""
    machine = f"""<mujoco><worldbody><body><freejoint/><geom size="0.1"/><site name="p"/></body></worldbody>
      <actuator><motor site="p" gear="{gear}"/></actuator></mujoco>"""
    assert drives_of(mujoco.MjModel.from_xml_string(machine), np.eye(6)[2:3])[0].unit == unit
