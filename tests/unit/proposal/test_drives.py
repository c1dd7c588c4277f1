import mujoco
import numpy as np
import pytest

from dr_lab.proposal.drives import drives_of

MACHINE = """<mujoco><worldbody>
  <body><joint name="turn" axis="0 1 0"/><geom size="0.1"/></body>
  <body pos="1 0 0"><joint name="slide" type="slide"/><geom size="0.1"/></body>
</worldbody><actuator>{}</actuator></mujoco>"""


@pytest.mark.parametrize(
    ("actuator", "units"),
    [
        ('<motor joint="{}"/>', ("N·m", "N")),
        ('<position joint="{}" kp="20" kv="1"/>', ("rad", "m")),
        ('<velocity joint="{}" kv="3"/>', ("rad/s", "m/s")),
        ('<general joint="{}" gainprm="7"/>', ("1", "1")),
        ('<general joint="{}" gainprm="3" biastype="affine" biasprm="0 0 -2"/>', ("1", "1")),
    ],
)
def test_the_unit_of_a_control_is_that_of_what_the_actuator_holds(actuator: str, units: tuple[str, str]) -> None:
    xml = MACHINE.format("".join(actuator.format(joint) for joint in ("turn", "slide")))
    found = drives_of(mujoco.MjModel.from_xml_string(xml), np.eye(2))
    assert tuple(drive.unit for drive in found) == units
    assert all(drive.servo == ("position" in actuator) for drive in found)
