"""A command whose unit is a torque for a slide, or a force for a hinge, is refused where the model says which it is."""

import mujoco
import numpy as np
import pytest

from dr_lab.diagnosis.checks.control_units import require_control_units
from dr_lab.errors import DataError
from dr_lab.trajectory import Log, Signal

MACHINE = """<mujoco><worldbody><body name="cart"><joint name="rail" type="slide"/><geom size="0.1"/>
  <body name="pole"><joint name="pivot"/><geom size="0.1"/></body></body></worldbody>
  <tendon><fixed name="cable"><joint joint="rail" coef="1"/></fixed></tendon>
  <actuator>{}</actuator></mujoco>"""


def check(actuator: str, unit: str) -> None:
    time = np.arange(3.0)
    log = Log("log", {}, {"motor": Signal("motor", unit, time, 0 * time)})
    require_control_units(mujoco.MjModel.from_xml_string(MACHINE.format(actuator)), [log])


@pytest.mark.parametrize(
    ("actuator", "unit", "words"),
    [
        ('<motor name="motor" joint="rail"/>', "N·m", "declared in N·m, but it is the force of joint rail, a slide"),
        ('<motor name="motor" joint="rail" gear="-1"/>', "N·m", "expected a force, such as N. Correct the unit of"),
        ('<motor name="motor" joint="pivot"/>', "N", "a hinge: expected a torque, such as N·m"),
        ('<general name="motor" joint="pivot" dyntype="filter" dynprm="0.1"/>', "N", "write its ratio (m) as gear"),
    ],
)
def test_a_unit_of_the_other_kind_of_joint_is_refused(actuator: str, unit: str, words: str) -> None:
    with pytest.raises(DataError) as told:
        check(actuator, unit)
    assert words in str(told.value)


@pytest.mark.parametrize(
    ("actuator", "unit"),
    [
        ('<motor name="motor" joint="rail"/>', "N"),
        ('<motor name="motor" joint="pivot"/>', "N·m"),
        ('<motor name="motor" joint="rail"/>', "V"),
        ('<motor name="motor" joint="rail" gear="40"/>', "N·m"),  # a drum of 25 mm
        ('<motor name="motor" joint="pivot" gear="0.1"/>', "N"),  # a lever of 0.1 m
        ('<motor name="motor" tendon="cable"/>', "N·m"),
        ('<general name="motor" joint="rail" gainprm="3"/>', "N·m"),
        ('<position name="motor" joint="rail" kp="1"/>', "N·m"),
    ],
)
def test_what_may_be_right_is_let_through(actuator: str, unit: str) -> None:
    check(actuator, unit)
